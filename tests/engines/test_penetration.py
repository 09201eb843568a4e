"""How deep corners go into what they stand on: at rest by statics, rocking by the step."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import at_rest, free_lanes, make_lanes, two_equal
from warprock.engines.bodies import box_bodies
from warprock.engines.energy import energy_held
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.response import USABLE, SampleTimes
from warprock.running.batch import run_batch
from warprock.settings.engines import DemSettings, DirectSettings, EventSettings, build_settings
from warprock.units import GRAVITY

FIRST_ORDER = ("impulse", "direct", "xpbd")


def settled(engine: str, lanes: Lanes) -> np.ndarray:
    """Penetration at rest by statics [m], shape [lane]: of the lowest interface, the most loaded.

    Springs give way by what they carry, half of it a corner for `direct`.
    """
    load = GRAVITY * lanes.mass.reshape(lanes.lane_count, -1).sum(axis=1)
    area = (lanes.width * lanes.depth).reshape(lanes.lane_count, -1)[:, 0]
    if engine == "dem":
        return np.asarray(load / (DemSettings().normal_stiffness * area))
    if engine == "direct":
        return np.asarray(load / (2.0 * DirectSettings().contact_stiffness))
    return np.zeros(lanes.lane_count)


@pytest.mark.parametrize(
    ("engine", "stacked"),
    [
        pytest.param(
            engine,
            stacked,
            marks=pytest.mark.thorough if stacked and engine in ("direct", "xpbd") else (),
        )
        for engine in ("housner", "event", "impulse", "direct", "xpbd", "dem")
        for stacked in (False, True)
    ],
)
def test_a_block_at_rest_sinks_by_its_weight_over_the_springs(engine: str, stacked: bool):
    lanes = make_lanes(np.array([0.5, 0.2]), 1.0)
    if stacked and engine == "housner":
        engine = "two-block"
    lanes = two_equal(lanes) if stacked else lanes
    found = run_batch(engine, lanes, at_rest(2), SampleTimes(0.5))["peak_penetration"]
    assert found.shape == (2,)
    # Round-off of heights, and for the sweeps of impulse what a step's fall may leave, 2 g dt^2;
    # dashpots and sweeps settle to some thousandths.
    slack = 1e-12
    if engine == "impulse":
        slack += 2.0 * GRAVITY * build_settings(engine, {}, "test").time_step ** 2
    np.testing.assert_allclose(found, settled(engine, lanes), rtol=1e-2, atol=slack)


@pytest.mark.parametrize("engine", FIRST_ORDER)
def test_a_landing_corner_is_through_by_no_more_than_a_step_of_its_way(engine: str):
    lanes = free_lanes()
    settings = build_settings(engine, {}, "test")
    step = settings.time_step
    found = run_batch(engine, lanes, at_rest(9), SampleTimes(2.0))["peak_penetration"]
    # A corner is a contact from the step after it has passed the face. The energy at the start
    # bounds its speed; gravity adds one step's fall, the pose that is corrected another.
    held = energy_held(lanes, lanes.rotation_start)
    radius = rocking.half_diagonal(lanes.width, lanes.height)
    speed = lanes.width * np.sqrt(2.0 * held / (4.0 / 3.0 * lanes.mass * radius**2))
    assert np.all(found > 0.0)
    assert np.all(found <= speed * step + 2.0 * GRAVITY * step**2)


@pytest.mark.thorough
def test_what_event_puts_back_is_of_third_order_in_the_step():
    lanes, found = free_lanes(), []
    # Steps of a box whose corner sticks put nothing back; those of bodies do.
    assert np.all(
        run_batch("event", lanes, at_rest(9), SampleTimes(2.0))["peak_penetration"] < 1e-12
    )
    lanes = dataclasses.replace(lanes, body=box_bodies(lanes))
    for step in (1e-2, 2.5e-3):
        settings = EventSettings(time_step=step)
        response = run_batch("event", lanes, at_rest(9), SampleTimes(2.0), settings=settings)
        found.append(response["peak_penetration"])
    assert np.all(found[0] < 1e-5)
    # 4^3 = 64, less where an impact is met a part of a step late, which is of first order.
    assert np.median(found[0] / found[1]) > 30.0


@pytest.mark.parametrize(
    ("engine", "stiffness"), [("dem", "normal_stiffness"), ("direct", "contact_stiffness")]
)
def test_softer_springs_sink_deeper(engine: str, stiffness: str):
    settings = build_settings(engine, {}, "test")
    soft = dataclasses.replace(settings, **{stiffness: 0.01 * getattr(settings, stiffness)})
    one, other = (
        run_batch(engine, make_lanes(0.5, 1.0), at_rest(1), SampleTimes(0.1), settings=each)
        for each in (settings, soft)
    )
    ratio = other["peak_penetration"] / one["peak_penetration"]
    np.testing.assert_allclose(ratio, 100.0, rtol=2e-2)


def test_a_corner_that_goes_through_the_ground_is_no_answer():
    """At a step of 0.1 s a block of 5 cm falls by more than its half size within a step."""
    engine = "impulse"
    lanes = make_lanes(np.full(8, 0.05), 0.05 * np.linspace(1.0, 8.0, 8))
    lanes = dataclasses.replace(lanes, rotation_start=0.9 * lanes.slenderness_angle)
    settings = build_settings(engine, {"frames_per_second": 10.0, "substeps": 0}, "test")
    found = run_batch(engine, lanes, at_rest(8), SampleTimes(3.0), settings=settings)
    deep = found["peak_penetration"] > 0.5 * np.minimum(lanes.width, lanes.height)
    assert deep.any()
    assert not np.isin(found["status"][deep], USABLE).any()
