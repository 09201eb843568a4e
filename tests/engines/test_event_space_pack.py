"""Packed kernels of `event` in space: they are the plain ones to round-off, and vector code."""

from __future__ import annotations

import dataclasses
import time

import numpy as np
import pytest

from tests.shared.blocks import sines
from tests.shared.spatial_blocks import along, spatial_lanes
from tests.shared.speed import require_gain
from warprock.engines.event import Event
from warprock.engines.launching import Form, Target
from warprock.model.lanes import SpatialLanes
from warprock.model.motion import Control, SpatialMotions
from warprock.model.response import SOUND, SampleTimes
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

LEAST_GAIN = 3.3
"""Packed over plain rate of slow rocking below which a pack is no vector code: midway, as a ratio,
between 2.1 to 2.5 without and 4.7 to 5.1 with 256-bit vectors; 7.2 to 7.5 with 512-bit ones."""


def crooked_lanes(count: int, friction: tuple[float, ...] = (5.0,)) -> SpatialLanes:
    """Blocks flat, on an edge and on a corner, turned, some with a centre beside the middle."""
    rng = np.random.default_rng(7)
    kind = np.arange(count) % 4
    lanes = spatial_lanes(
        np.full(count, 0.3), 1.0, np.resize(friction, count),
        depth=rng.uniform(0.25, 0.4, count),
        rotation_start=0.06 * (kind >= 1) * rng.choice([-1.0, 1.0], count),
        rotation_across_start=rng.uniform(0.01, 0.05, count) * (kind >= 2),
        yaw_start=rng.uniform(-1.5, 1.5, count),
    )  # fmt: skip
    return dataclasses.replace(lanes, centre_offset_x=0.02 * (kind == 3))


def shaken(count: int) -> SpatialMotions:
    """Pulses of sine in all three directions, others for every lane."""
    spread = np.linspace(0.6, 1.4, count)
    return along(
        sines(Control.ACCELERATION, 0.30 * GRAVITY * spread, 2.0, 1.0, start=0.1),
        sines(Control.ACCELERATION, 0.25 * GRAVITY, 2.5 * spread, 1.0, start=0.05),
        sines(Control.ACCELERATION, 0.10 * GRAVITY * spread, 3.0 * spread, 1.0),
    )


def test_what_round_off_leaves_before_a_knot_is_no_step() -> None:
    # Ten steps of 0.01 s add up to less than 0.1 s, by a unit in the last place.
    motions = along(sines(Control.ACCELERATION, np.full(1, 0.5), 10.0, 1.0))
    lanes, step = spatial_lanes([0.4], 1.0), EventSettings(time_step=0.01)
    found = run_batch("event", lanes, motions, SampleTimes(1.0), settings=step)
    # One to the knot at the beginning, ten in the pulse, and one that waits for the end.
    assert found["step_count"][0] == 12


@pytest.mark.thorough
@pytest.mark.parametrize(("friction", "duration"), [((5.0,), 1.2), ((0.3, 0.5, 5.0), 0.3)])
def test_packed_and_plain_are_the_same_to_round_off(
    friction: tuple[float, ...], duration: float
) -> None:
    lanes, motions, times = crooked_lanes(48, friction), shaken(48), SampleTimes(duration, 0.01)
    packed, plain = (
        run_batch("event", lanes, motions, times, form=form) for form in (Form.PACKED, Form.PLAIN)
    )
    # Friction of 5 is above the limit of these blocks.
    assert np.all(np.isin(plain["status"], SOUND))
    assert np.sum(plain["impact_count"] >= 1) >= 30
    assert np.sum(plain["peak_slide"] >= 1e-4) >= (24 if min(friction) < 1.0 else 0)
    np.testing.assert_array_equal(packed["outcome"], plain["outcome"])
    # Round-off decides whether a corner that hardly leaves the base lands once more.
    for name in ("impact_count", "step_count"):
        assert np.max(np.abs(packed[name] - plain[name])) <= 5
    for name in packed.fields:
        if name not in ("outcome", "impact_count", "step_count"):
            # Round-off, magnified by some ten impacts, or by the onset of sliding: 2e-11 measured.
            np.testing.assert_allclose(
                packed[name], plain[name], rtol=0.0, atol=1e-10, err_msg=name
            )


def test_a_lane_does_not_depend_on_what_runs_beside_it() -> None:
    # More lanes than places side by side: they take each other's place.
    lanes, motions, times = crooked_lanes(41), shaken(41), SampleTimes(0.8, 0.02)
    together = run_batch("event", lanes, motions, times, workers=1)
    split = run_batch("event", lanes, motions, times, workers=2, chunk_size=13)
    reverse = np.arange(41)[::-1]
    turned = run_batch("event", lanes.take(reverse), motions.take(reverse), times)
    unseen = run_batch("event", lanes, motions, SampleTimes(0.8))
    assert np.ptp(together["step_count"]) >= 20
    for name, values in together.fields.items():
        np.testing.assert_array_equal(split[name], values, err_msg=name)
        np.testing.assert_array_equal(turned[name][reverse], values, err_msg=name)
        if name in unseen.fields:
            np.testing.assert_array_equal(unseen[name], values, err_msg=name)


def step_cost(form: Form, count: int) -> float:
    """CPU time of a step [s] of high blocks that rock slowly, on one worker."""
    rng = np.random.default_rng(1)
    lanes = spatial_lanes(
        np.full(count, 1.0), 5.0,
        depth=0.8,
        rotation_start=0.1,
        rotation_across_start=rng.uniform(0.04, 0.08, count),
        yaw_start=rng.uniform(-1.0, 1.0, count),
    )  # fmt: skip
    wave = sines(Control.ACCELERATION, 0.02 * GRAVITY, rng.uniform(0.8, 1.2, count), 4.0)
    started = time.process_time()
    response = run_batch(
        "event", lanes, along(wave, wave, wave), SampleTimes(1.0), form=form, workers=1
    )
    return (time.process_time() - started) / float(np.sum(response["step_count"]))


@pytest.mark.speed
def test_packed_kernel_is_vectorised() -> None:
    for form in (Form.PLAIN, Form.PACKED):
        step_cost(form, 16)
    require_gain(
        lambda: step_cost(Form.PLAIN, 256), lambda: step_cost(Form.PACKED, 2048), LEAST_GAIN
    )


def test_only_the_cone_is_packed() -> None:
    for box, form, file in (
        (False, Form.PACKED, "event_space/block_pack_run"),
        (False, Form.PLAIN, "event_space/block_run"),
        (True, Form.PACKED, "event_space/block_run"),
    ):
        engine = Event(EventSettings(friction_box=box), Target(form=form))
        assert engine.kernel_of(crooked_lanes(1)).file == file
        assert engine.module_of(crooked_lanes(1), shaken(1)).__name__.startswith(
            f"warprock.kernels.{file.replace('/', '.')}__"
        )
