"""Blocks in the plane on a base that moves upwards, too: closed forms, the oracle, and space."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import free_lanes, make_lanes, sines
from tests.shared.planar_bodies import STEPPED, body_lanes
from tests.shared.spatial_blocks import in_space
from tests.shared.vertical_motion import Array, sampled, shaken, steady
from warprock.engines import engine_class
from warprock.model.lanes import Lanes
from warprock.model.motion import (
    Control,
    GroundMotions,
    SpatialMotions,
    StillBase,
    UprightMotions,
    no_motion,
)
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.oracle.block import oracle_response
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

RISES = np.array([-0.5, -0.2, 0.3, 0.8, 1.5, 0.1, -0.7, 0.6, 2.0])
"""Steady accelerations of the base upwards over g."""


def ramp(upwards: Array, rate: Array, duration: float) -> UprightMotions:
    """Along x the base's acceleration grows at a rate [m/s^3]; upwards it is steady [m/s^2]."""
    time = 0.02 * np.arange(round(duration / 0.02) + 1)
    along = np.multiply.outer(rate, time)
    return UprightMotions(sampled(along, 0.02), sampled(upwards[:, None] + 0.0 * along, 0.02))


def test_a_steady_rise_is_another_gravity() -> None:
    # Free rocking knows no time but 1 / p, so with n g for g it runs sqrt(n) times as fast.
    lanes, faster = free_lanes(), np.sqrt(1.0 + RISES)
    engine = engine_class("housner")()
    still = StillBase(lanes.lane_count)
    for lane, fast in enumerate(faster):
        one = np.array([lane])
        rises = steady(GRAVITY * RISES[one], 3.0)
        found = engine.run(lanes.take(one), rises, SampleTimes(2.0, 0.02))
        like = engine.run(lanes.take(one), still.take(one), SampleTimes(2.0 * fast, 0.02 * fast))
        # Round-off, which events let grow; the rest rule leaves swings of 1e-9 out.
        np.testing.assert_allclose(found["rotation"], like["rotation"], atol=1e-9)
        np.testing.assert_allclose(found["energy_lost"], like["energy_lost"] * fast**2, rtol=1e-6)
        assert found["impact_count"] == like["impact_count"]


def test_a_block_lifts_where_the_weight_that_it_has_then_lets_it() -> None:
    lanes = make_lanes(np.full(9, 0.3), np.linspace(1.0, 2.0, 9), friction=3.0)
    rate = np.where(np.arange(9) % 2 == 0, 6.0, -9.0)
    found = engine_class("housner")().run(
        lanes, ramp(GRAVITY * RISES, rate, 4.0), SampleTimes(4.0, None)
    )
    lifts = GRAVITY * (1.0 + RISES) * lanes.width / lanes.height / np.abs(rate)
    np.testing.assert_allclose(found["uplift_time"], lifts, rtol=1e-9)


def test_housner_and_the_oracle_agree() -> None:
    count = 6
    lanes = make_lanes(
        np.linspace(0.2, 0.5, count),
        np.linspace(1.2, 2.2, count)[::-1],
        rotation_ratio=np.where(np.arange(count) % 3 == 0, 0.4, 0.0),
        friction=5.0,
    )
    motions, times = shaken(count, 12.0, 3.0), SampleTimes(3.5, 0.02)
    found = engine_class("housner")().run(lanes, motions, times)
    oracle = oracle_response(lanes, motions, times)
    # Both are events to round-off; what they differ by grows with every impact.
    np.testing.assert_allclose(found["rotation"], oracle["rotation"], atol=1e-8)
    for name in ("status", "outcome", "impact_count"):
        np.testing.assert_array_equal(found[name], oracle[name], err_msg=name)
    assert (oracle["impact_count"] > 0).sum() >= count // 2
    np.testing.assert_allclose(found["uplift_time"], oracle["uplift_time"], atol=1e-10)


def test_a_block_that_its_base_leaves_is_outside_the_model_of_housner() -> None:
    lanes = make_lanes(np.full(3, 0.4), 1.2, friction=3.0)
    time = 0.01 * np.arange(101)
    lobes = np.array([0.95, 1.05, 1.6])[:, None] * np.sin(2.0 * np.pi * time)
    motions = UprightMotions(sampled(0.0 * lobes, 0.01), sampled(-GRAVITY * lobes, 0.01))
    found = engine_class("housner")().run(lanes, motions, SampleTimes(1.5, None))
    assert found["status"].tolist() == [Status.OK, Status.OUTSIDE_MODEL, Status.OUTSIDE_MODEL]
    assert np.isinf(found["friction_needed"]).tolist() == [False, True, True]
    assert found["outcome"][0] == Outcome.AT_REST


def event_at(step: float, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
    return engine_class("event")(EventSettings(time_step=step)).run(lanes, motions, times)


@pytest.mark.thorough
def test_event_follows_a_rising_base_at_second_order() -> None:
    count = 8
    lanes = make_lanes(np.linspace(0.2, 0.5, count), 1.6, rotation_ratio=0.4, friction=5.0)
    motions, times = shaken(count, 8.0, 1.5), SampleTimes(1.5, 0.01)
    housner = engine_class("housner")().run(lanes, motions, times)
    errors = [
        np.median(np.abs(event_at(step, lanes, motions, times)["rotation"] - housner["rotation"]))
        for step in (4e-3, 2e-3, 1e-3)
    ]
    # Steps of a record are cut at its samples, every 0.01 s here: 3, 5 and 10 in each.
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all(orders > 1.7), orders
    assert housner["impact_count"].min() > 0


@pytest.mark.thorough
def test_bodies_follow_it_as_boxes_do() -> None:
    lanes = body_lanes(STEPPED, [0.15, -0.15, 0.1, -0.1], radius=0.01)
    motions, times = shaken(4, 8.0, 1.0, along=5.0), SampleTimes(1.0, 0.01)
    housner = engine_class("housner")().run(lanes, motions, times)
    errors = [
        np.median(np.abs(event_at(step, lanes, motions, times)["rotation"] - housner["rotation"]))
        for step in (2e-3, 1e-3)
    ]
    assert np.log2(errors[0] / errors[1]) > 1.7
    assert housner["impact_count"].min() > 0
    assert (housner["status"] == Status.OK).all()


@pytest.mark.thorough
def test_a_table_that_follows_displacements_kicks_upwards_too() -> None:
    # A sine of the displacement starts and ends with a step of the velocity.
    lanes = make_lanes(np.linspace(0.3, 0.5, 6), 1.5, rotation_ratio=0.5, friction=9.0)
    along = sines(Control.DISPLACEMENT, np.full(6, 0.03), 1.3, cycles=2.0)
    upwards = sines(Control.DISPLACEMENT, np.linspace(0.002, 0.008, 6), 3.0, cycles=3.5)
    motions, times = UprightMotions(along, upwards), SampleTimes(2.0, 0.01)
    housner = engine_class("housner")().run(lanes, motions, times)
    oracle = oracle_response(lanes, motions, times)
    np.testing.assert_allclose(housner["rotation"], oracle["rotation"], atol=1e-8)
    np.testing.assert_array_equal(housner["status"], oracle["status"])
    held = housner["status"] == Status.OK
    assert held.sum() >= 3
    event = event_at(1e-3, lanes, motions, times)
    # Second order: 1e-3 s of 1 / p of 0.4 s, squared, times some impacts.
    gap = np.abs(event["rotation"] - housner["rotation"])[held]
    assert gap.max() < 1e-4


@pytest.mark.thorough
def test_a_base_that_falls_leaves_its_blocks_as_it_does_in_space() -> None:
    # Flat, the block flies while a_z + g < 0 and until it lands; at a ramp along x it slides.
    count = 6
    lanes = make_lanes(np.full(count, 0.5), 1.0, friction=np.linspace(0.2, 0.4, count))
    motions, times = shaken(count, 26.0, 1.5, along=8.0), SampleTimes(1.5, 0.01)
    still = no_motion(motions.x)
    spatial = SpatialMotions(motions.x, still, motions.z)
    plane = event_at(1e-3, lanes, motions, times)
    space = event_at(1e-3, in_space(lanes), spatial, times)
    assert (motions.z.acceleration_bound() > 1.2 * GRAVITY).all()
    assert (plane["status"] == Status.OK).all()
    assert plane["peak_slide"].min() > 5e-3
    # Both are second order, in space first where a corner slides: step^2 to step of a swing.
    np.testing.assert_allclose(plane["peak_slide"], space["peak_slide"], rtol=2e-3, atol=1e-5)
    np.testing.assert_allclose(plane["rotation"], space["rotation"], atol=1e-4)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("engine", "error"),
    # Of 0.3 s of flight a step of 2e-4 s of `impulse` is 1e-3. In `event` a step d of 5e-3 s misses
    # jerk d^3 / 12 of the height, 1e-6 m of 0.4 m, and the flight has 60.
    [("event", 5e-4), ("impulse", 5e-3)],
)
def test_a_landing_takes_what_the_base_has_given(engine: str, error: float) -> None:
    lanes = make_lanes(np.full(3, 0.5), 1.0)
    time = 0.02 * np.arange(51)
    pull = np.multiply.outer([0.5, 0.8, 1.0], np.sin(2.0 * np.pi * time))
    pull[:, time > 0.5] = 0.0
    upwards = -GRAVITY * 1.8 * pull
    motions = UprightMotions(sampled(0.0 * upwards, 0.02), sampled(upwards, 0.02))
    found = engine_class(engine)().run(lanes, motions, SampleTimes(1.0, None))
    # Seen from the base the block falls by g + a_z, a line between two samples.
    fine = np.linspace(0.0, 1.0, 1_000_001)
    for lane, lost in enumerate(found["energy_lost"]):
        fall = GRAVITY + np.interp(fine, time, upwards[lane])
        leaves = np.argmax(fall < 0.0) if fall.min() < 0.0 else None
        expected = 0.0
        if leaves is not None:
            speed = -np.cumsum(np.where(np.arange(len(fine)) >= leaves, fall, 0.0)) * 1e-6
            height = np.cumsum(speed) * 1e-6
            lands = leaves + 1 + np.argmax(height[leaves + 1 :] <= 0.0)
            expected = 0.5 * lanes.mass[lane] * speed[lands] ** 2
        # What it takes to lift the block by 1e-6 m is nothing.
        nothing = 1e-6 * GRAVITY * lanes.mass[lane]
        assert lost == pytest.approx(expected, rel=error, abs=nothing)
    if engine == "event":
        assert found["impact_count"].tolist() == [0, 1, 1]
    assert (found["outcome"] == Outcome.AT_REST).all()
    assert (found["status"] == Status.OK).all()


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ["impulse", "dem"])
def test_stepped_engines_do_in_the_plane_what_they_do_in_space(engine: str) -> None:
    count = 6
    lanes = make_lanes(np.linspace(0.3, 0.5, count), 1.2, rotation_ratio=0.3, friction=2.0)
    motions, times = shaken(count, 8.0, 1.0), SampleTimes(1.0, 0.01)
    spatial = SpatialMotions(motions.x, no_motion(motions.x), motions.z)
    plane = engine_class(engine)().run(lanes, motions, times)
    space = engine_class(engine)().run(in_space(lanes), spatial, times)
    # Of the order of a step of 2e-4 s, times a swing of 1 rad/s; both solve alike to less.
    np.testing.assert_allclose(plane["rotation"], space["rotation"], atol=2e-4)
    for found in (plane, space):
        assert (found["status"] == Status.OK).all()


@pytest.mark.parametrize("engine", ["housner", pytest.param("event", marks=pytest.mark.thorough)])
def test_lanes_keep_to_themselves_and_to_their_mirror_images(engine: str) -> None:
    count = 5
    lanes = make_lanes(np.linspace(0.3, 0.6, count), 1.2, rotation_ratio=0.3, friction=0.9)
    motions, times = shaken(count, 12.0, 1.0), SampleTimes(1.0, 0.05)
    run = engine_class(engine)().run
    together = run(lanes, motions, times)
    mirrored = dataclasses.replace(lanes, rotation_start=-lanes.rotation_start)
    back = UprightMotions(motions.x.scaled(np.full(count, -1.0)), motions.z)
    np.testing.assert_array_equal(run(mirrored, back, times)["rotation"], -together["rotation"])
    order = np.array([3, 0, 4])
    some = run(lanes.take(order), motions.take(order).compact(), times)
    for name, values in some.fields.items():
        np.testing.assert_array_equal(values, together[name][order], err_msg=name)


def flights(side: float) -> tuple[Lanes, UprightMotions]:
    """Random blocks that their base throws up while it pulls them aside, or their mirror images."""
    draw, count = np.random.default_rng(7), 150
    starts = np.where(draw.random(count) < 0.3, draw.uniform(-0.5, 0.5, count), 0.0)
    lanes = make_lanes(
        draw.uniform(0.3, 1.5, count),
        draw.uniform(0.5, 6.0, count),
        side * starts,
        draw.uniform(0.1, 1.2, count),
    )
    pulls, rates = draw.uniform(-9.0, 9.0, count), draw.uniform(0.5, 5.0, count)
    falls, rises = draw.uniform(-16.0, -9.0, count), draw.uniform(1.0, 5.0, count)
    along = sines(Control.ACCELERATION, side * pulls, rates, 2.0, start=0.13)
    return lanes, UprightMotions(along, sines(Control.ACCELERATION, falls, rises, 3.0))


@pytest.mark.thorough
def test_flights_land_alike_on_both_sides_and_at_every_step() -> None:
    times = SampleTimes(2.0, 0.02)
    found, other = (event_at(2e-3, *flights(side), times) for side in (1.0, -1.0))
    np.testing.assert_array_equal(other["rotation"], -found["rotation"])
    np.testing.assert_array_equal(other["peak_slide"], found["peak_slide"])
    assert (found["status"] == Status.OK).all()
    assert (found["impact_count"] > 0).mean() > 0.8
    fine = event_at(5e-4, *flights(1.0), times)
    # Second order; what a swing of 1 s lets grow of it.
    gap = np.abs(found["rotation"] - fine["rotation"]).max(axis=1)
    assert np.quantile(gap, 0.9) < 1e-3
    assert gap.max() < 1e-2


@pytest.mark.thorough
def test_a_level_landing_turns_the_block_about_the_corner_ahead() -> None:
    # Angular momentum about that corner: m (h v - b w) / 2 before, of v aside and w down.
    count = 6
    side = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
    width, height = np.repeat([0.2, 0.25, 0.3], 2), np.repeat([1.0, 1.2, 1.1], 2)
    lanes = make_lanes(width, height, friction=1.2)
    # The base falls at 2 g for 0.2 s: the block flies, and comes down at 2 sqrt(2) 0.1 s g.
    time = 0.001 * np.arange(701)
    fall = np.where(time <= 0.2, -2.0 * GRAVITY, 0.0) * np.ones((count, 1))
    aside = side[:, None] * np.where((time >= 0.05) & (time <= 0.2), -13.0, 0.0)
    motions = UprightMotions(sampled(aside, 0.001), sampled(fall, 0.001))
    speed = np.sqrt(2.0) * 0.2 * GRAVITY
    lands = 0.2 + (0.2 * GRAVITY + speed) / GRAVITY
    found = event_at(1e-3, lanes, motions, SampleTimes(lands + 0.02, None))
    drift = 13.0 * 0.151
    inertia = (width**2 + height**2) / 3.0
    turn = 0.5 * (height * drift - width * speed) / inertia
    assert np.all(turn > 0.5)
    lost = 0.5 * lanes.mass * (drift**2 + speed**2 - inertia * turn**2)
    # A sample of 1 ms more or less of the base's pull: 0.5 % of both speeds.
    np.testing.assert_allclose(found["energy_lost"], lost, rtol=1e-2)
    assert found["impact_count"].tolist() == [1] * count
    np.testing.assert_array_equal(found["energy_lost"][::2], found["energy_lost"][1::2])


@pytest.mark.thorough
@pytest.mark.parametrize("step", [1e-3, 4e-3])
@pytest.mark.parametrize("shape", ["block", "body"])
def test_a_flight_begins_where_the_base_falls_faster_than_gravity(shape: str, step: float) -> None:
    draw, count = np.random.default_rng(5), 12
    rate = draw.uniform(60.0, 400.0, count)
    boxes = make_lanes(
        draw.uniform(0.2, 0.8, count),
        draw.uniform(0.5, 2.0, count),
        friction=draw.uniform(0.3, 3.0, count),
    )
    lanes = boxes if shape == "block" else body_lanes(STEPPED, np.zeros(count))
    down = -np.multiply.outer(rate, 0.02 * np.arange(13))
    motions = UprightMotions(sampled(0.0 * down, 0.02), sampled(down, 0.02))
    found = event_at(step, lanes, motions, SampleTimes(0.24, None))
    # A ramp is linear in every step, as the search for the flight has it: only round-off is left.
    np.testing.assert_allclose(found["uplift_time"], GRAVITY / rate, rtol=1e-12)
    assert (found["status"] == Status.OK).all()


@pytest.mark.thorough
@pytest.mark.parametrize("step", [1e-3, 4e-3])
def test_a_flight_off_a_sine_begins_within_a_small_part_of_a_step(step: float) -> None:
    draw, count = np.random.default_rng(6), 12
    size = GRAVITY * draw.uniform(1.2, 2.0, count)
    frequency = 3.0
    along = sines(Control.ACCELERATION, np.zeros(count), frequency, cycles=2.0)
    upwards = sines(Control.ACCELERATION, -size, frequency, cycles=2.0)
    lanes = make_lanes(np.full(count, 0.5), 1.0)
    found = event_at(step, lanes, UprightMotions(along, upwards), SampleTimes(0.2, None))
    w = 2.0 * np.pi * frequency
    phase = np.arcsin(GRAVITY / size)
    # Taken as linear in a step, the acceleration is off by (w d)^2 / 8 of it by the chord, and by
    # / 6 by the start that the velocity gives. A pull may miss zero by 1e-3 of what it began with.
    bound = (1.0 / 8.0 + 1.0 / 6.0) * (w * step) ** 2 * np.tan(phase) / w + 1e-3 * step
    assert np.all(np.abs(found["uplift_time"] - phase / w) < bound)
