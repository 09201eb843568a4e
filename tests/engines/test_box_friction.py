"""Friction as a box along x and y: closed forms, plane, other engines, order, energy, stacks."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import Array, free_lanes, make_lanes, sines, velocity_steps
from tests.shared.spatial_blocks import (
    along,
    in_space,
    mirrored,
    sound_run,
    spatial_lanes,
    spatial_stack,
)
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import Control, GroundMotions, HarmonicMotions, SpatialMotions
from warprock.model.pose import start_poses
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import DemSettings, EventSettings, ImpulseSettings
from warprock.units import GRAVITY

pytestmark = pytest.mark.thorough

ANGLES = ("rotation", "rotation_across", "yaw")
SLIDES = ("residual_slide", "residual_slide_across")
STIFFEST = 1e11


def event(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, step: float = 5e-3, box: int = 1
) -> Response:
    """Response of `event` at a time step [s], every lane sound."""
    settings = EventSettings(time_step=step, friction_box=box)
    return sound_run("event", lanes, motions, times, settings)


def springs(stiffness: float, box: int = 1) -> DemSettings:
    """Settings of `dem` at a stiffness [N/m^3], its dashpots near critical for blocks of 1 m."""
    damping = 2e-3 * np.sqrt(1e9 / stiffness)
    return DemSettings(
        normal_stiffness=stiffness, shear_stiffness=stiffness, stiffness_damping=damping,
        friction_box=box,
    )  # fmt: skip


def at_rest(count: int) -> SpatialMotions:
    """A base that does not move, of the kind of motion that the other tests here have compiled."""
    return along(sines(Control.ACCELERATION, np.zeros(count), 1.0, 1.0))


def pushed(speed_x: Array, speed_y: Array) -> SpatialMotions:
    """A base that steps its velocity at once and keeps it."""
    zero, long = np.zeros_like(speed_x), np.full_like(speed_x, 50.0)
    return along(velocity_steps(speed_x, zero, long), velocity_steps(speed_y, zero, long))


def shaken(x: Array, y: Array, rate_x: float = 2.0, rate_y: float = 3.0) -> SpatialMotions:
    """One sine of acceleration [g] along x, another along y."""
    return along(
        sines(Control.ACCELERATION, x * GRAVITY, rate_x, 1.0),
        sines(Control.ACCELERATION, y * GRAVITY, rate_y, 1.0),
    )


def apart(one: Response, other: Response, names: tuple[str, ...] = ANGLES) -> Array:
    """Largest difference in some fields, shape [lane]."""
    lanes = len(one["status"])
    gaps = [np.abs(one[name] - other[name]).reshape(lanes, -1).max(axis=1) for name in names]
    return np.max(gaps, axis=0)


def way_of(speed: Array, friction: float, time: float) -> Array:
    """How far something slides in a time [m], friction taking its speed [m/s]."""
    brake = friction * GRAVITY
    lasts = np.minimum(time, np.abs(speed) / brake)
    return speed * lasts - 0.5 * np.sign(speed) * brake * lasts**2


@pytest.mark.parametrize("box", [0, 1])
def test_each_component_of_a_slide_is_braked_by_itself(box: int) -> None:
    angle, speed, friction = np.linspace(0.0, np.pi, 9), 0.4, 0.2
    lanes = spatial_lanes(np.full(9, 1.0), 0.5, friction, depth=0.8, yaw_start=0.2 * angle)
    parts = speed * np.cos(angle), speed * np.sin(angle)
    for time in (0.05, 0.12, 2.0):
        found = event(lanes, pushed(*parts), SampleTimes(time), box=box)
        part = 1.0 if box else way_of(np.full(9, speed), friction, time) / speed
        for name, component in zip(SLIDES, parts, strict=True):
            way = way_of(component, friction, time) if box else component * part
            # Even deceleration: a step is exact, and so is where it is cut.
            np.testing.assert_allclose(found[name], -way, atol=1e-9)
    lasts = np.maximum(*np.abs(parts)) if box else np.full(9, speed)
    np.testing.assert_allclose(found["rest_time"], lasts / (friction * GRAVITY), rtol=1e-8)
    np.testing.assert_allclose(found["energy_lost"], 0.5 * lanes.mass * speed**2, rtol=1e-9)
    assert np.all(found["peak_yaw"] <= 1e-12)


def test_springs_brake_each_component_by_itself() -> None:
    angle, speed, friction = np.linspace(0.0, np.pi, 5), 0.3, 0.1
    lanes = spatial_lanes(np.full(5, 1.0), 0.5, friction, depth=1.0)
    parts = speed * np.cos(angle), speed * np.sin(angle)
    found = run_batch(
        "dem", lanes, pushed(*parts), SampleTimes(0.6), settings=springs(1e9)
    )  # fmt: skip
    # They carry the block back by mu m g / k and it rings on them for a while: 1 %.
    longest = speed**2 / (2.0 * friction * GRAVITY)
    for name, component in zip(SLIDES, parts, strict=True):
        way = way_of(component, friction, 10.0)
        np.testing.assert_allclose(found[name], -way, atol=0.01 * longest)
    np.testing.assert_allclose(found["energy_lost"], 0.5 * lanes.mass * speed**2, rtol=0.01)


@pytest.mark.parametrize("engine", ["event", "dem"])
def test_a_block_sticks_where_the_box_holds_and_the_cone_does_not(engine: str) -> None:
    # Along the diagonal the box holds sqrt(2) times what it holds along x.
    friction = 0.3
    ratio_x, ratio_y = np.array([0.9, 1.1, 0.9]), np.array([0.9, 0.0, 0.0])
    lanes = spatial_lanes(np.full(3, 1.0), 0.4, friction, depth=1.0, yaw_start=0.3)
    motions = shaken(friction * ratio_x, friction * ratio_y, 1.0, 1.0)
    slides = {}
    for box in (0, 1):
        settings = EventSettings(friction_box=box) if engine == "event" else springs(1e9, box)
        found = run_batch(engine, lanes, motions, SampleTimes(0.5), settings=settings)
        slides[box] = found["peak_slide"] >= 1e-3
        # The springs give by mu m g / k, 1e-6 m; the rigid contact does not.
        assert np.all(found["peak_slide"][~slides[box]] <= (0.0 if engine == "event" else 1e-5))
    np.testing.assert_array_equal(slides[0], [True, True, False])
    np.testing.assert_array_equal(slides[1], [False, True, False])


@pytest.mark.parametrize("engine", ["event", "dem"])
def test_planar_scenes_know_no_difference(engine: str) -> None:
    frequency = np.linspace(2.6, 4.4, 6)
    pulse = sines(Control.ACCELERATION, 0.5 * GRAVITY, frequency, 1.0)
    scenes = (
        (free_lanes(), at_rest(9)),
        (make_lanes(np.full(6, 0.17), 1.0, friction=10.0), along(pulse)),
        (
            make_lanes(np.full(6, 0.3), 1.0, friction=[0.1, 0.2, 0.25, 0.31, 0.35, 0.5]),
            along(pulse),
        ),
    )
    for lanes, motions in scenes:
        found = [
            run_batch(engine, in_space(lanes), motions, SampleTimes(1.0, 0.01), settings=settings)
            for settings in (
                (EventSettings(), EventSettings(friction_box=1))
                if engine == "event"
                else (DemSettings(), DemSettings(friction_box=1))
            )
        ]
        # Round-off, and how closely the end of a slide is located.
        assert np.all(apart(*found) <= 1e-6 * lanes.slenderness_angle)
        assert np.all(apart(*found, SLIDES) <= 1e-6)
        np.testing.assert_array_equal(found[0]["outcome"], found[1]["outcome"])


def test_impulse_and_springs_come_to_event_as_they_grow_fine() -> None:
    count = 8
    lanes = spatial_lanes(
        np.full(count, 0.6), 1.0, np.linspace(0.2, 0.5, count), depth=0.5,
        yaw_start=np.linspace(0.0, 0.6, count),
    )  # fmt: skip
    motions = shaken(np.linspace(0.3, 0.6, count), np.linspace(0.5, 0.3, count))
    times = SampleTimes(0.6, 0.02)
    exact = event(lanes, motions, times, 2e-4)
    gaps = {}
    for substeps in (9, 39, 159):
        settings = ImpulseSettings(substeps=substeps, iterations=100, friction_box=1)
        found = run_batch("impulse", lanes, motions, times, settings=settings)
        gaps[substeps] = np.max(apart(found, exact, SLIDES))
    # First order: a quarter of the step leaves a quarter, by and large.
    assert gaps[9] <= 2e-4
    assert gaps[159] <= gaps[9] / 8.0
    for stiffness in (1e9, STIFFEST):
        found = run_batch("dem", lanes, motions, times, settings=springs(stiffness))
        gaps[stiffness] = np.max(apart(found, exact, (*SLIDES, "yaw")))
    # What springs give on the way, by the root of their softness: a tenth of a hundredth.
    assert gaps[1e9] <= 3e-3
    assert gaps[STIFFEST] <= gaps[1e9] / 5.0
    # The cone is another law.
    cone = event(lanes, motions, times, box=0)
    assert np.max(apart(cone, exact, SLIDES)) >= 1e-2


def leaning(count: int, friction: float) -> SpatialLanes:
    """Turned boxes that lean on a corner or, one in two, on an edge."""
    odd = np.arange(count) % 2
    return spatial_lanes(
        np.full(count, 0.5), 1.0, friction, depth=0.4, rotation_start=0.2 + 0.01 * odd,
        rotation_across_start=0.12 * odd, yaw_start=np.linspace(-0.4, 0.5, count),
    )  # fmt: skip


def test_rocking_blocks_that_slide_are_those_of_impulse() -> None:
    lanes, times = leaning(6, 0.25), SampleTimes(0.4, 0.02)
    exact = event(lanes, at_rest(6), times, 1e-3)
    assert np.all(exact["peak_slide"] >= 1e-3)
    gaps = []
    for substeps in (19, 79, 319):
        settings = ImpulseSettings(substeps=substeps, iterations=100, friction_box=1)
        found = run_batch("impulse", lanes, at_rest(6), times, settings=settings)
        gaps.append(apart(found, exact, (*ANGLES, *SLIDES)).mean())
    # First order: a sixteenth, by and large.
    assert gaps[2] <= gaps[0] / 8.0
    assert gaps[2] <= 3e-5


def errors_of(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, names: tuple[str, ...], steps: Array
) -> Array:
    """Mean error over the lanes at steps [s] from a step a tenth of the least, shape [step]."""
    exact = event(lanes, motions, times, 0.1 * float(steps[-1]))
    found = [event(lanes, motions, times, float(step)) for step in steps]
    return np.array([apart(each, exact, names).mean() for each in found])


def order(errors: Array, steps: Array) -> float:
    """Slope of log(error) over log(step)."""
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def test_sliding_is_second_order_through_its_reversals() -> None:
    # Flat, under sines that turn the slip along x and along y round at times of their own.
    lanes = spatial_lanes(np.full(8, 1.0), 0.4, np.linspace(0.1, 0.3, 8), yaw_start=0.5)
    motions = shaken(np.full(8, 0.5), np.full(8, 0.4))
    steps = np.array([1e-2, 5e-3, 2e-3, 1e-3])
    errors = errors_of(lanes, motions, SampleTimes(0.9), (*SLIDES, "peak_slide"), steps)
    assert errors[-1] <= 1e-5
    assert order(errors, steps) >= 1.8


def test_rocking_that_slides_is_between_first_and_second_order() -> None:
    turn = np.random.default_rng(1).uniform(-0.5, 0.5, 8)
    lanes = spatial_lanes(np.full(8, 0.3), 1.0, 0.45, depth=0.25, yaw_start=turn)
    motions = shaken(np.linspace(0.35, 0.6, 8), np.linspace(0.5, 0.3, 8), 2.0, 1.5)
    steps = np.array([1e-2, 5e-3, 2e-3, 1e-3])
    errors = errors_of(lanes, motions, SampleTimes(0.9, 0.02), ANGLES, steps)
    assert errors[-1] <= 2e-4
    assert order(errors, steps) >= 1.0


def dropped(count: int) -> SpatialLanes:
    """Squat blocks that start in the air or on a corner, an edge or the face, turned anyhow."""
    rng = np.random.default_rng(7)
    width, depth = rng.uniform(0.6, 1.5, (2, count))
    kind, side = np.arange(count) % 4, rng.choice([-1.0, 1.0], (2, count))
    lean = side * rng.uniform(0.05, 0.3, (2, count))
    return spatial_lanes(
        width, rng.uniform(0.2, 0.6, count), 10.0 ** rng.uniform(-1.5, 0.5, count), depth=depth,
        rotation_start=lean[0] * (kind % 2), rotation_across_start=lean[1] * (kind >= 2),
        yaw_start=rng.uniform(-3.0, 3.0, count), gap_start=rng.uniform(0.0, 0.2, count),
        centre_offset_x=0.1 * width * (kind == 3),
    )  # fmt: skip


def test_dropped_blocks_come_to_rest_and_energy_never_grows() -> None:
    count = 48
    lanes = dropped(count)
    held = lanes.mass * GRAVITY * (start_poses(lanes)[0][:, 2] - 0.5 * lanes.height)
    before = np.zeros(count)
    for duration in (0.05, 0.1, 0.2, 0.4, 6.0):
        found = event(lanes, at_rest(count), SampleTimes(duration), 2e-3)
        # A step's own error of the energy is of its third order.
        assert np.all(found["energy_lost"] >= before - 1e-8 * held)
        before = found["energy_lost"]
    assert np.all(found["outcome"] == Outcome.AT_REST)
    # What the steps miss is of second order.
    np.testing.assert_allclose(before, held, rtol=100.0 * 2e-3**2)


def reversed_in(motion: HarmonicMotions, sign: float) -> HarmonicMotions:
    """A motion of acceleration, or its opposite."""
    names = ("acceleration_amplitude", "velocity_offset", "velocity_final")
    return dataclasses.replace(motion, **{name: sign * getattr(motion, name) for name in names})


def test_mirror_images_and_quarter_turns_have_the_same_answer() -> None:
    # The box has the symmetries of a square.
    lanes, times = leaning(4, 0.35), SampleTimes(0.4, 0.02)
    motions = shaken(np.full(4, 0.3), np.full(4, 0.2))
    found = event(lanes, motions, times)
    image = event(
        mirrored(lanes, x=True, y=False),
        along(reversed_in(motions.x, -1.0), motions.y),
        times,
    )
    turned = event(
        dataclasses.replace(lanes, yaw_start=lanes.yaw_start + 0.5 * np.pi),
        along(reversed_in(motions.y, -1.0), motions.x),
        times,
    )
    # Round-off, magnified by impacts.
    np.testing.assert_allclose(image["rotation"], -found["rotation"], atol=1e-7)
    np.testing.assert_allclose(image["residual_slide"], -found["residual_slide"], atol=1e-7)
    np.testing.assert_allclose(turned["peak_tilt"], found["peak_tilt"], atol=1e-7)
    np.testing.assert_allclose(turned[SLIDES[1]], found[SLIDES[0]], atol=1e-7)
    np.testing.assert_allclose(turned[SLIDES[0]], -found[SLIDES[1]], atol=1e-7)


@pytest.mark.parametrize("engine", ["event", "dem"])
def test_lanes_do_not_depend_on_the_batch_and_a_broken_lane_harms_nobody(
    engine: str, unjudged: None
) -> None:
    lanes, times = leaning(5, 0.3), SampleTimes(0.3, 0.05)
    motions = shaken(np.linspace(0.2, 0.6, 5), np.linspace(0.5, 0.3, 5))
    settings = EventSettings(friction_box=1) if engine == "event" else springs(1e9)

    def run(lanes: Lanes, motions: GroundMotions, **more: int) -> Response:
        return run_batch(engine, lanes, motions, times, settings=settings, **more)

    together, split = run(lanes, motions), run(lanes, motions, chunk_size=2, workers=2)
    bad = dataclasses.replace(lanes, height=np.where(np.arange(5) == 2, np.nan, lanes.height))
    broken, sound = run(bad, motions), np.arange(5) != 2
    for name, values in together.fields.items():
        np.testing.assert_array_equal(split[name], values, err_msg=name)
        np.testing.assert_array_equal(broken[name][sound], values[sound], err_msg=name)
    assert broken["status"][2] == Status.NONFINITE


def test_a_stack_slides_as_one_and_each_component_by_itself() -> None:
    lanes = spatial_stack([0.5, 0.4], [0.2, 0.2], friction=0.3, depth=0.5)
    found = event(lanes, pushed(np.full(1, 0.6), np.full(1, 0.8)), SampleTimes(1.0))
    # Where it stops inside a step is missed by what friction does in one.
    missed = 0.3 * GRAVITY * 5e-3**2
    for name, speed in zip(SLIDES, (0.6, 0.8), strict=True):
        way = way_of(np.full(1, speed), 0.3, 10.0)[0]
        np.testing.assert_allclose(found[name][0], [-way, 0.0], atol=missed)
    assert found["outcome"][0] == Outcome.AT_REST
    expected = 0.5 * lanes.mass.sum() * (0.6**2 + 0.8**2)
    # The last weight of the velocity step is a few millionths of it.
    np.testing.assert_allclose(found["energy_lost"], expected, rtol=5e-6)


def test_blocks_of_a_stack_slide_on_one_another_as_in_impulse() -> None:
    # The box of the upper block is turned with the face of the lower one.
    lanes = spatial_stack([0.4, 0.35], [0.6, 0.5], depth=0.4, yaw_start=[[0.1, 0.3]], friction=0.35)
    motions = shaken(np.full(1, 0.5), np.full(1, 0.3), 3.0, 4.0)
    times = SampleTimes(0.5, 0.02)
    settings = ImpulseSettings(substeps=79, iterations=60, friction_box=1)
    other = run_batch("impulse", lanes, motions, times, settings=settings)
    runs = [event(lanes, motions, times, step) for step in (4e-3, 1e-3)]
    assert np.all(runs[1]["peak_slide"] >= 1e-3)
    gaps = [np.max(apart(found, other, (*ANGLES, *SLIDES))) for found in runs]
    # At least first order: a quarter of the step leaves a quarter at most.
    assert gaps[1] <= gaps[0] / 4.0
    assert gaps[1] <= 3e-6
    # On a base that stays as it is, energy only goes.
    lost = [
        event(lanes, pushed(np.full(1, 0.5), np.full(1, 0.3)), SampleTimes(until))["energy_lost"][0]
        for until in (0.02, 0.06, 0.12, 0.5)
    ]
    assert np.all(np.diff(lost) >= -1e-5 * lost[-1])
