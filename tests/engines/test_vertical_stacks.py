"""Stacks in the plane on a base that moves upwards, too: closed forms, orders, mirror images."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest

from tests.shared.blocks import at_rest, make_stacks, sines
from tests.shared.stack_bodies import as_bodies, with_body
from tests.shared.vertical_motion import Array, sampled, shaken, steady
from warprock.engines import engine_class
from warprock.engines.launching import Form, Target
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, UprightMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.model.stacking import uplift_ratio
from warprock.settings.engines import EventSettings, ImpulseSettings
from warprock.units import GRAVITY

pytestmark = pytest.mark.thorough

RISES = np.array([-0.5, 0.3, 1.5, 3.0])
"""Steady accelerations of the base upwards over g."""
PLAIN = Target(form=Form.PLAIN)
"""Compiled in a third of the time of the packed form."""


def stacks(count: int, friction: float = 10.0) -> Lanes:
    """Pairs of unlike blocks, the upper one turned against the lower one."""
    lean = np.where(np.arange(count)[:, None] % 2 == 0, 1.0, -1.0) * np.array([0.04, 0.1])
    width = np.linspace(0.35, 0.5, count)[:, None] * np.array([1.0, 0.8])
    height = np.linspace(0.8, 1.1, count)[:, None]
    return make_stacks(width, height, rotation=lean, friction=friction)


def event_at(step: float, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
    return engine_class("event")(EventSettings(time_step=step)).run(lanes, motions, times)


def impulse_at(
    step: float, lanes: Lanes, motions: GroundMotions, times: SampleTimes, target: Target = PLAIN
) -> Response:
    """With sweeps enough for impacts between blocks; few of them leave more than the step does."""
    settings = ImpulseSettings(substeps=20, frames_per_second=1.0 / (21.0 * step), iterations=100)
    return engine_class("impulse")(settings, target).run(lanes, motions, times)


def order(found: list[Response]) -> float:
    """Order of the error of three runs, each with half the step of the one before."""
    coarse, fine = (
        np.median(np.abs(one["rotation"] - two["rotation"]).max(axis=(1, 2)))
        for one, two in itertools.pairwise(found)
    )
    return float(np.log2(coarse / fine))


@pytest.mark.parametrize("engine", ["event", "impulse"])
def test_a_steady_rise_is_another_gravity(engine: str) -> None:
    # Free rocking knows no time but the root of length over gravity: with n g for g, and a step
    # as much shorter, it runs sqrt(n) times as fast.
    run, step = {"event": (event_at, 1e-3), "impulse": (impulse_at, 2e-4)}[engine]
    lanes = stacks(len(RISES))
    # What `impulse` lets stand sunk in is by g dt^2 of a base that falls, too.
    for lane in range(engine == "impulse", len(RISES)):
        one, fast = np.array([lane]), np.sqrt(1.0 + RISES[lane])
        rises = steady(GRAVITY * RISES[one], 3.0)
        found = run(step, lanes.take(one), rises, SampleTimes(1.0, 0.02))
        like = run(step * fast, lanes.take(one), at_rest(1), SampleTimes(fast, 0.02 * fast))
        # Round-off, which impacts let grow; of `impulse` also what its sweeps leave.
        np.testing.assert_allclose(found["rotation"], like["rotation"], atol=1e-9)
        assert found["status"] == like["status"] == Status.OK
        assert like["impact_count"] > 0
        # What erp lifts is booked at g: first order in the step.
        error = 1e-9 if engine == "event" else 0.05
        lost = like["energy_lost"] * fast**2
        np.testing.assert_allclose(found["energy_lost"], lost, rtol=error)


def test_a_pair_lifts_where_the_weight_that_it_has_then_lets_it() -> None:
    lanes = make_stacks([0.4, 0.3], 0.8, rotation=np.zeros((4, 2)))
    rate = np.array([6.0, -9.0, 7.0, -5.0])
    time = 0.02 * np.arange(401)
    along = np.multiply.outer(rate, time)
    level = GRAVITY * RISES[:, None] + 0.0 * along
    motions = UprightMotions(sampled(along, 0.02), sampled(level, 0.02))
    found = event_at(1e-3, lanes, motions, SampleTimes(8.0, None))
    lifts = GRAVITY * (1.0 + RISES) * uplift_ratio(lanes).min(axis=1) / np.abs(rate)
    np.testing.assert_allclose(found["uplift_time"], lifts, rtol=1e-13)


def test_event_follows_a_rising_base_at_second_order() -> None:
    lanes, motions = stacks(6), shaken(6, 8.0, 0.8)
    times = SampleTimes(0.8, 0.01)
    found = [event_at(step, lanes, motions, times) for step in (2e-3, 1e-3, 5e-4)]
    assert found[0]["impact_count"].min() > 0
    assert order(found) > 1.7
    # `impulse` is of first order: some steps of 1e-4 s at 1 rad/s, more after chattering impacts.
    other = impulse_at(1e-4, lanes, motions, times)
    assert np.median(np.abs(other["rotation"] - found[-1]["rotation"]).max(axis=(1, 2))) < 1e-3
    assert np.median(np.abs(other["energy_lost"] / found[-1]["energy_lost"] - 1.0)) < 0.01
    for response in (*found, other):
        assert (response["status"] == Status.OK).all()


@pytest.mark.parametrize(("engine", "error"), [("event", 5e-4), ("impulse", 5e-3)])
def test_a_pair_flies_as_one_and_its_landing_takes_what_the_base_has_given(
    engine: str, error: float
) -> None:
    lanes = make_stacks([0.5, 0.5], 0.8, rotation=np.zeros((3, 2)))
    time = 0.02 * np.arange(51)
    pull = np.multiply.outer([0.5, 0.8, 1.0], np.sin(2.0 * np.pi * time))
    pull[:, time > 0.5] = 0.0
    upwards = -GRAVITY * 1.8 * pull
    motions = UprightMotions(sampled(0.0 * upwards, 0.02), sampled(upwards, 0.02))
    run, step = {"event": (event_at, 5e-3), "impulse": (impulse_at, 2e-4)}[engine]
    found = run(step, lanes, motions, SampleTimes(1.0, None))
    leaves, speeds = np.transpose([flight(each, time) for each in upwards])
    expected = 0.5 * lanes.mass.sum(axis=1) * speeds**2
    # What it takes to lift the pair by 1e-6 m is nothing.
    nothing = 1e-6 * GRAVITY * lanes.mass.sum(axis=1)
    assert (np.abs(found["energy_lost"] - expected) <= error * expected + nothing).all()
    assert (found["status"] == Status.OK).all()
    if engine == "event":
        assert found["impact_count"].tolist() == [0, 1, 1]
        assert (found["outcome"] == Outcome.AT_REST).all()
        assert found["peak_rotation"].max() == 0.0
        # The instants of `flight` lie 5e-6 s apart.
        np.testing.assert_allclose(found["uplift_time"][1:], leaves[1:], atol=1.1e-5)


def flight(upwards: Array, time: Array) -> tuple[float, float]:
    """When a mass leaves its base [s], and the speed at which it lands [m/s]; 0 if it stays."""
    fine = np.linspace(0.0, 1.0, 200_001)
    fall = GRAVITY + np.interp(fine, time, upwards)
    if fall.min() >= 0.0:
        return 0.0, 0.0
    leaves = int(np.argmax(fall < 0.0))
    speed = -np.cumsum(np.where(np.arange(len(fine)) >= leaves, fall, 0.0)) * fine[1]
    height = np.cumsum(speed) * fine[1]
    lands = leaves + 1 + np.argmax(height[leaves + 1 :] <= 0.0)
    return float(fine[leaves]), float(speed[lands])


def test_lanes_keep_to_themselves_and_to_their_mirror_images() -> None:
    # Swings of the weight beyond g: with flights, slides and landings.
    lanes, motions = stacks(5, friction=0.6), shaken(5, 20.0, 0.8, along=5.0)
    times = SampleTimes(0.8, 0.05)
    mirrored = dataclasses.replace(lanes, rotation_start=-lanes.rotation_start)
    back = UprightMotions(motions.x.scaled(np.full(5, -1.0)), motions.z)
    order = np.array([3, 0, 4])
    for run, step in ((event_at, 1e-3), (impulse_at, 2e-4)):
        together = run(step, lanes, motions, times)
        assert np.abs(together["peak_slide"]).max() > 1e-3
        other = run(step, mirrored, back, times)
        # Round-off, which impacts let grow.
        np.testing.assert_allclose(other["rotation"], -together["rotation"], atol=1e-10)
        some = run(step, lanes.take(order), motions.take(order).compact(), times)
        for name, values in some.fields.items():
            np.testing.assert_array_equal(values, together[name][order], err_msg=name)


def test_packs_do_what_single_lanes_do_and_bodies_what_boxes_do() -> None:
    lanes, motions = stacks(5, friction=0.6), shaken(5, 16.0, 0.8, along=5.0)
    times = SampleTimes(0.8, 0.05)
    plain = impulse_at(2e-4, lanes, motions, times)
    packed = impulse_at(2e-4, lanes, motions, times, Target(form=Form.PACKED))
    for name, values in plain.fields.items():
        np.testing.assert_array_equal(packed[name], values, err_msg=name)
    bodies = impulse_at(2e-4, as_bodies(lanes), motions, times)
    # Round-off, which impacts let grow.
    np.testing.assert_allclose(bodies["rotation"], plain["rotation"], atol=1e-8)
    boxes, bodies = (event_at(1e-3, each, motions, times) for each in (lanes, as_bodies(lanes)))
    np.testing.assert_allclose(bodies["rotation"], boxes["rotation"], atol=1e-10)
    np.testing.assert_array_equal(bodies["impact_count"], boxes["impact_count"])


def test_event_follows_a_rising_base_under_a_body_on_a_box() -> None:
    lanes = with_body(stacks(len(RISES)), 1)
    for lane, rise in enumerate(RISES):
        one, fast = np.array([lane]), np.sqrt(1.0 + rise)
        rises = steady(GRAVITY * RISES[one], 3.0)
        found = event_at(1e-3, lanes.take(one), rises, SampleTimes(1.0, 0.02))
        like = SampleTimes(1.0 * fast, 0.02 * fast)
        still = event_at(1e-3 * fast, lanes.take(one), at_rest(1), like)
        np.testing.assert_allclose(found["rotation"], still["rotation"], atol=1e-9)
        assert still["impact_count"] > 0
    lanes, motions = with_body(stacks(6), 1), shaken(6, 8.0, 0.8)
    runs = [event_at(step, lanes, motions, SampleTimes(0.8, 0.01)) for step in (2e-3, 1e-3, 5e-4)]
    assert order(runs) > 1.7


def test_a_table_that_follows_displacements_kicks_upwards_too() -> None:
    # A sine of the displacement starts and ends with a step of the velocity.
    lanes, times = stacks(6), SampleTimes(1.5, 0.01)
    along = sines(Control.DISPLACEMENT, np.full(6, 0.03), 1.3, cycles=2.0)
    upwards = sines(Control.DISPLACEMENT, np.linspace(0.002, 0.012, 6), 3.0, cycles=3.5)
    motions = UprightMotions(along, upwards)
    found = [event_at(step, lanes, motions, times) for step in (2e-3, 1e-3, 5e-4)]
    assert order(found) > 1.7
    other = impulse_at(1e-4, lanes, motions, times)
    # First order, a step at a velocity step of 0.2 m/s and 30 impacts.
    assert np.median(np.abs(other["rotation"] - found[-1]["rotation"]).max(axis=(1, 2))) < 5e-3
    np.testing.assert_allclose(other["energy_lost"], found[-1]["energy_lost"], rtol=0.03)
