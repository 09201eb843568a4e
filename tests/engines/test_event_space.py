"""`event` in space: the plane, a SciPy box on a corner, order, cones, drops, the contract."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import (
    Array,
    at_rest,
    free_lanes,
    make_lanes,
    ramp,
    sines,
    velocity_steps,
)
from tests.shared.corner_roll import rolled, tumbled
from tests.shared.spatial_blocks import along, in_space, mirrored, spatial_lanes, unmoved
from warprock.engines.bodies import box_bodies
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import (
    Control,
    GroundMotions,
    HarmonicMotions,
    PlanarMotions,
    StillBase,
    no_motion,
)
from warprock.model.pose import start_poses
from warprock.model.response import SOUND, Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

STEPS = np.array([1e-2, 5e-3, 2e-3, 1e-3])
ANGLES = ("rotation", "rotation_across", "yaw")


def respond(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, step: float = 5e-3
) -> Response:
    """Response of `event` at a time step [s], every lane sound."""
    response = run_batch("event", lanes, motions, times, settings=EventSettings(time_step=step))
    assert np.all(np.isin(response["status"], SOUND))
    return response


def apart(one: Response, other: Response) -> Array:
    """Largest difference of the three turns of lanes [rad], shape [lane]."""
    return np.max([np.abs(one[name] - other[name]).max(axis=1) for name in ANGLES], axis=0)


def order(errors: Array, steps: Array = STEPS) -> float:
    """Slope of log(error) over log(step)."""
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def planar_scenes() -> dict[str, tuple[Lanes, PlanarMotions]]:
    """Scenes of the plane: free rocking, pulses, impacts that slide, sliding and rocking."""
    frequency = np.linspace(2.6, 4.4, 6)
    swing = 0.37 * GRAVITY / (2.0 * np.pi * frequency) ** 2
    slim = make_lanes(np.full(6, 0.17), 1.0, friction=10.0)
    slick = make_lanes(np.full(6, 0.3), 1.0, friction=[0.1, 0.2, 0.25, 0.31, 0.35, 0.5])
    slippery = make_lanes(np.full(3, 0.5), 1.0, 0.5, [0.2, 0.3, 0.4])
    return {
        "free": (free_lanes(), at_rest(9)),
        "slippery": (slippery, at_rest(3)),
        "slippery, still base": (slippery, StillBase(3)),
        "displacement": (slim, sines(Control.DISPLACEMENT, swing, frequency, 1.0, start=0.1)),
        "acceleration": (slim, sines(Control.ACCELERATION, 0.37 * GRAVITY, frequency, 1.0)),
        "sliding": (slick, sines(Control.ACCELERATION, 0.5 * GRAVITY, frequency, 2.0, start=0.1)),
    }


SCENES = [
    pytest.param(
        name, marks=() if name in ("free", "sliding", "displacement") else pytest.mark.thorough
    )
    for name in planar_scenes()
]


@pytest.mark.parametrize("scene", SCENES)
def test_planar_scenes_are_those_of_the_planar_engine(scene: str) -> None:
    lanes, motions = planar_scenes()[scene]
    times = SampleTimes(2.0, 0.01)
    # Boxes follow polynomials in the plane; as bodies their steps are those of space.
    flat = dataclasses.replace(lanes, body=box_bodies(lanes))
    plane = respond(flat, motions, times)
    space = respond(in_space(lanes), along(motions), times)
    fine_plane = respond(flat, motions, times, 1e-4)
    fine_space = respond(in_space(lanes), along(motions), times, 1e-4)
    angle = lanes.slenderness_angle

    def gap(one: Response, other: Response) -> Array:
        return np.asarray(np.abs(one["rotation"] - other["rotation"]).max(axis=1) / angle)

    # Events inside a step are located by either kernel in its own way. So they differ by part of
    # the error of the step, here a quarter, and at a short one by as little as events are missed.
    error = gap(plane, fine_plane)
    assert np.all(gap(space, plane) <= 1e-6 + 0.25 * error)
    assert np.all(gap(fine_space, fine_plane) <= 1e-7)
    # Of order 2 likewise: 7e-5 s and 1e-4 of the energy at 5e-3 s, where a slip follows an uplift.
    pairs = ((space, plane, 1e-4, 2e-4), (fine_space, fine_plane, 1e-7, 1e-6))
    for one, other, late, lost in pairs:
        np.testing.assert_array_equal(one["outcome"], other["outcome"])
        np.testing.assert_allclose(one["uplift_time"], other["uplift_time"], atol=late)
        np.testing.assert_allclose(one["energy_lost"], other["energy_lost"], rtol=lost)
        # The plane's rest rule looks ahead: it leaves out one impact more, and what that slides.
        np.testing.assert_allclose(one["residual_slide"], other["residual_slide"], atol=1e-5)
    # Round-off, magnified by impacts.
    assert np.all(np.abs(space["rotation_across"]) <= 1e-9)
    assert np.all(space["peak_yaw"] <= 1e-9)


def test_planar_scenes_come_to_housner() -> None:
    lanes, times = free_lanes(), SampleTimes(2.0, 0.01)
    reference = run_batch("housner", lanes, StillBase(9), times)["rotation"]
    space = respond(in_space(lanes), unmoved(9), times, 2e-4)["rotation"]
    # 9e-5 at 5e-3 s, of second order: 1.5e-7.
    assert np.all(np.abs(space - reference).max(axis=1) <= 1e-6 * lanes.slenderness_angle)


def test_a_turned_block_does_the_same_in_another_direction() -> None:
    lanes = make_lanes(np.full(3, 0.2), 1.0, friction=2.0)
    motions = sines(Control.ACCELERATION, 0.3 * GRAVITY, np.array([1.0, 2.0, 3.0]), 1.0)
    times = SampleTimes(1.5, 0.01)
    first = respond(in_space(lanes), along(motions), times)
    still_x = dataclasses.replace(motions, acceleration_amplitude=np.zeros(3))
    still_x = dataclasses.replace(still_x, velocity_offset=np.zeros(3))
    other = respond(in_space(lanes, yaw_start=0.5 * np.pi), along(still_x, motions), times)
    assert np.max(first["peak_rotation"]) > 0.05
    # Round-off, magnified by impacts, and the tolerance of their times.
    np.testing.assert_allclose(other["rotation_across"], first["rotation"], atol=1e-7)


SIZE, LEAN, YAW = (0.5, 0.4, 1.0), (0.2, 0.12), 0.3


def leaning(friction: float = 5.0) -> SpatialLanes:
    """A turned box that leans on one corner."""
    lanes = spatial_lanes([SIZE[0]], SIZE[2], friction, rotation_across_start=LEAN[1])
    return dataclasses.replace(
        lanes,
        depth=np.full(1, SIZE[1]),
        rotation_start=np.full(1, LEAN[0]),
        yaw_start=np.full(1, YAW),
    )


def shaking(start: float = 0.0) -> tuple[HarmonicMotions, HarmonicMotions, HarmonicMotions]:
    """Sines of acceleration along x, y and z."""
    x, y, z = (
        sines(Control.ACCELERATION, size * GRAVITY, frequency, 3.0, start=start)
        for size, frequency in ((0.15, 2.0), (0.1, 3.0), (0.2, 5.0))
    )
    return x, y, z


@pytest.mark.parametrize("shaken", [False, True])
def test_rolling_on_a_corner_follows_the_oracle(shaken: bool) -> None:
    times = SampleTimes(0.25, 0.01)
    base = shaking()

    def acceleration(time: float) -> Array:
        return np.array([float(part.acceleration_inside(np.array(time), 0)) for part in base])

    more = {"base": acceleration} if shaken else {}
    motion = rolled(SIZE, (1, 1), LEAN, times.times, yaw=YAW, **more)
    # The other corners stay above the base, and energy is kept where nothing moves.
    assert np.all(motion.gaps((1, 1)) >= -1e-12)
    if not shaken:
        energy = motion.energy((1, 1))
        np.testing.assert_allclose(energy, energy[0], rtol=1e-11)
    errors = []
    for step in STEPS:
        found = respond(leaning(20.0), along(*base) if shaken else unmoved(1), times, float(step))
        gap = [found[name][0] - told for name, told in zip(ANGLES, motion.rotations, strict=False)]
        errors.append(np.max(np.abs(gap)))
        assert found["impact_count"][0] == 0
    # Second order: some (p dt)^2 / 12 of the way.
    assert errors[0] <= 2e-4
    assert errors[3] <= 2e-6
    assert order(np.array(errors)) >= 1.9


def test_a_box_thrown_up_tumbles_as_the_oracle_says() -> None:
    # The base drops away at 3 m/s under a box that rolls: it flies, its angular momentum kept.
    parting = 0.2
    before, after = np.linspace(0.0, parting, 21), np.linspace(parting, 0.6, 41)
    motion = tumbled(rolled(SIZE, (1, 1), LEAN, before, yaw=YAW), after)
    up = velocity_steps(np.array([-3.0]), np.zeros(1), np.full(1, 10.0))
    start = np.full(1, parting)
    up = dataclasses.replace(up, start=start, stop=start + 10.0)
    errors = []
    for step in STEPS:
        motions = along(no_motion(up), None, up)
        found = respond(leaning(20.0), motions, SampleTimes(0.6, 0.01), float(step))
        gap = [
            found[name][0][20:] - told for name, told in zip(ANGLES, motion.rotations, strict=False)
        ]
        errors.append(np.max(np.abs(gap)))
        # Nothing touches: nothing is lost but to the drift before.
        assert found["impact_count"][0] == 0
        assert abs(found["energy_lost"][0]) <= 1e-9
    assert order(np.array(errors)) >= 1.8
    assert errors[3] <= 1e-5


def test_rocking_and_rolling_are_second_order_through_impacts() -> None:
    # From one corner over edges to other corners.
    times = SampleTimes(1.5, 0.01)
    reference = respond(leaning(), unmoved(1), times, 5e-5)
    assert reference["impact_count"][0] >= 8
    errors = np.array(
        [apart(respond(leaning(), unmoved(1), times, s), reference)[0] for s in STEPS]
    )
    assert errors[3] <= 2e-6
    assert order(errors) >= 1.8


def test_biaxial_pulses_are_second_order() -> None:
    rng = np.random.default_rng(1)
    count = 8
    lanes = spatial_lanes(np.full(count, 0.3), 1.0, 5.0, yaw_start=rng.uniform(-0.5, 0.5, count))
    lanes = dataclasses.replace(lanes, depth=np.full(count, 0.25))
    x = sines(Control.ACCELERATION, rng.uniform(0.35, 0.6, count) * GRAVITY, 2.0, 1.0, start=0.1)
    y = sines(Control.ACCELERATION, rng.uniform(0.3, 0.5, count) * GRAVITY, 1.5, 1.0, start=0.05)
    times = SampleTimes(1.0, 0.01)
    reference = respond(lanes, along(x, y), times, 1e-4)
    assert np.all(reference["impact_count"] >= 1)
    errors = np.array([apart(respond(lanes, along(x, y), times, s), reference) for s in STEPS])
    # Single lanes' impacts fall differently in their steps; the mean of eight shows the order.
    assert order(errors.mean(axis=1)) >= 1.8
    assert np.max(errors[3]) <= 2e-5


@pytest.mark.parametrize("yaw", [0.0, 0.4, 1.2])
def test_a_turned_block_lifts_where_the_pressure_leaves_its_face(yaw: float) -> None:
    width, depth, height = 0.2, 0.3, 1.0
    # Where the resultant leaves the rectangle, over whichever edge comes first.
    threshold = GRAVITY * min(width / abs(np.cos(yaw)), depth / max(np.sin(yaw), 1e-9)) / height
    lanes = spatial_lanes(np.full(2, width), height, 10.0, yaw_start=yaw)
    lanes = dataclasses.replace(lanes, depth=np.full(2, depth))
    motions = sines(Control.ACCELERATION, np.array([0.99, 1.01]) * threshold, 0.25, 1.0)
    response = respond(lanes, along(motions), SampleTimes(1.2))
    assert np.isnan(response["uplift_time"][0])
    expected = np.arcsin(1.0 / 1.01) / (0.5 * np.pi)
    assert response["uplift_time"][1] == pytest.approx(expected, abs=1e-4)


def test_blocks_slide_alike_in_every_direction() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 7)
    friction, speed = np.linspace(0.05, 0.2, 7), 0.4
    lanes = in_space(make_lanes(np.full(7, 1.0), 1.0, friction=friction), yaw_start=0.3 * angle)
    zero, stop = np.zeros(7), np.full(7, 10.0)
    x, y = (velocity_steps(speed * part, zero, stop) for part in (np.cos(angle), np.sin(angle)))
    response = respond(lanes, along(x, y), SampleTimes(3.0))
    way = speed**2 / (2.0 * friction * GRAVITY)
    # Even deceleration against the motion: steps are exact, so is the time at which sliding stops.
    np.testing.assert_allclose(response["residual_slide"], -way * np.cos(angle), atol=1e-9)
    np.testing.assert_allclose(response["residual_slide_across"], -way * np.sin(angle), atol=1e-9)
    np.testing.assert_allclose(response["peak_slide"], way, rtol=1e-9)
    np.testing.assert_allclose(response["rest_time"], speed / (friction * GRAVITY), rtol=1e-9)
    np.testing.assert_allclose(response["energy_lost"], 0.5 * lanes.mass * speed**2, rtol=1e-9)
    assert np.all(response["outcome"] == Outcome.AT_REST)


def test_sliding_on_curved_ways_is_second_order() -> None:
    # Under sines in three directions, the load on the base changing with the vertical one.
    lanes = spatial_lanes(np.full(2, 0.4), 1.0, [0.3, 0.4], yaw_start=0.2)
    x, y, z = (
        sines(Control.ACCELERATION, size * GRAVITY, np.full(2, frequency), 2.0)
        for size, frequency in ((0.5, 2.0), (0.3, 3.0), (0.3, 5.0))
    )
    names = ("residual_slide", "residual_slide_across", "peak_slide")
    steps, found = (2e-5, 5e-3, 2e-3, 1e-3, 5e-4), []
    for step in steps:
        response = respond(lanes, along(x, y, z), SampleTimes(0.4), step)
        found.append(np.array([response[name] for name in names]))
    errors = np.array([np.abs(each - found[0]).max() for each in found[1:]])
    assert np.all(found[0][2] >= 1e-2)
    assert errors[2] <= 5e-6
    assert order(errors, np.array(steps[1:])) >= 1.8


def dropped(count: int) -> SpatialLanes:
    """Squat blocks that start in the air or on a corner, an edge or the face, turned anyhow."""
    rng = np.random.default_rng(5)
    width, depth = rng.uniform(0.6, 1.5, (2, count))
    height = rng.uniform(0.2, 0.6, count)
    friction = 10.0 ** rng.uniform(-1.5, 1.0, count)
    kind = np.arange(count) % 4
    lean = 0.5 * rng.choice([-1.0, 1.0], (2, count)) * rng.uniform(0.2, 1.0, (2, count))
    lanes = spatial_lanes(
        width, height, friction,
        rotation_across_start=lean[1] * np.arctan2(depth, height) * (kind >= 2),
        yaw_start=rng.uniform(-3.0, 3.0, count), gap_start=rng.uniform(0.0, 0.3, count),
        centre_offset_x=0.1 * width * (kind == 3), centre_offset_y=-0.1 * depth * (kind == 3),
    )  # fmt: skip
    return dataclasses.replace(
        lanes, depth=depth, rotation_start=lean[0] * np.arctan2(width, height) * (kind % 2)
    )


def test_dropped_blocks_come_to_rest_flat_and_have_lost_their_energy() -> None:
    count = 48
    lanes = dropped(count)
    rise = start_poses(lanes)[0][:, 2] - 0.5 * lanes.height
    held = lanes.mass * GRAVITY * rise
    for step in (1e-2, 2e-3):
        response = respond(lanes, unmoved(count), SampleTimes(8.0, 0.05), step)
        assert np.all(response["outcome"] == Outcome.AT_REST)
        assert np.max(np.abs(response["rotation"][:, -1])) <= 1e-12
        assert np.max(np.abs(response["rotation_across"][:, -1])) <= 1e-12
        # What the steps miss is of second order.
        np.testing.assert_allclose(response["energy_lost"], held, rtol=100.0 * step**2)
    for duration in (0.1, 0.3, 0.6):
        lost = respond(lanes, unmoved(count), SampleTimes(duration), 2e-3)["energy_lost"]
        assert np.all(lost >= -1e-9 * held)


def test_a_face_that_falls_flat_loses_all_at_once() -> None:
    lanes = spatial_lanes([0.5], 1.0, yaw_start=0.7, gap_start=0.2)
    response = respond(lanes, unmoved(1), SampleTimes(1.0))
    assert response["impact_count"][0] == 1
    # Free fall is exact: s = g t^2 / 2.
    assert response["rest_time"][0] == pytest.approx(np.sqrt(0.4 / GRAVITY), abs=1e-9)
    assert response["energy_lost"][0] == pytest.approx(lanes.mass[0] * GRAVITY * 0.2, rel=1e-8)


def test_corners_that_are_nearly_level_land_as_an_edge_does() -> None:
    lean = np.array([0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3])
    lanes = in_space(make_lanes(np.full(9, 0.5), 1.0, 0.5), rotation_across_start=lean)
    response = respond(lanes, unmoved(9), SampleTimes(2.0, 0.01), 1e-3)
    gap = np.abs(response["rotation"] - response["rotation"][0]).max(axis=1)
    # Together within the tolerance of an impact, else one after the other, to the same end: what
    # the lean does to the motion goes to nothing with it.
    assert np.all(gap <= 1e-9 + lean)
    # A start within that tolerance is on the edge.
    np.testing.assert_allclose(response["peak_rotation_across"], lean, rtol=0.2, atol=2e-7)
    # An impact takes some four steps; each decade adds a few small ones.
    assert np.all(response["step_count"] <= response["step_count"][0] + 60)


def test_mirrored_scenes_have_mirrored_answers() -> None:
    lanes, motions, times = scenes()
    found = respond(lanes, motions, times)
    for x, y in ((True, False), (False, True)):
        sx, sy = (-1.0 if x else 1.0), (-1.0 if y else 1.0)
        parts = (reversed_motion(motions.x, sx), reversed_motion(motions.y, sy), motions.z)
        other = respond(mirrored(lanes, x=x, y=y), along(*parts), times)
        # Round-off, magnified by some tens of impacts, of which it may bring the last forward.
        np.testing.assert_allclose(sx * other["rotation"], found["rotation"], atol=1e-5)
        np.testing.assert_allclose(
            sy * other["rotation_across"], found["rotation_across"], atol=1e-5
        )
        np.testing.assert_allclose(sx * sy * other["yaw"], found["yaw"], atol=1e-5)


def reversed_motion(motion: HarmonicMotions, sign: float) -> HarmonicMotions:
    """A motion, or its opposite."""
    names = ("velocity_step_start", "velocity_step_stop", "velocity_final")
    names = (*names, "acceleration_amplitude", "velocity_offset")
    return dataclasses.replace(motion, **{name: sign * getattr(motion, name) for name in names})


def scenes() -> tuple[SpatialLanes, GroundMotions, SampleTimes]:
    """Seven blocks that rock, roll, slide and fall under sines in three directions."""
    rng = np.random.default_rng(3)
    lanes = spatial_lanes(
        rng.uniform(0.2, 0.5, 7), rng.uniform(0.5, 1.2, 7), rng.uniform(0.2, 1.0, 7),
        yaw_start=rng.uniform(-1.0, 1.0, 7), rotation_across_start=rng.uniform(-0.1, 0.1, 7),
    )  # fmt: skip
    x, y, z = (
        sines(
            Control.ACCELERATION, rng.uniform(0.1, 0.5, 7) * GRAVITY, rng.uniform(1.0, 4.0, 7), 3.0
        )
        for _ in range(3)
    )
    return lanes, along(x, y, z), SampleTimes(1.0, 0.02)


@pytest.mark.parametrize("friction", [1.0, 1.8])
def test_a_velocity_step_of_the_base_is_the_limit_of_a_steep_ramp(friction: float) -> None:
    """Where the block slides, and where a corner sticks.

    Without the ramp one of these blocks slid on an edge at 1.8, by steps of 1.2 ms and less.
    """
    rng, count = np.random.default_rng(5), 24
    speed = rng.uniform(0.1, 0.5, count) * rng.choice([-1.0, 1.0], count)
    yaw = rng.uniform(-0.3, 0.3, count)
    width = rng.uniform(0.15, 0.3, count)
    lanes = spatial_lanes(width, 0.6, friction=friction, depth=0.4, yaw_start=yaw)
    times, one = SampleTimes(0.2, 0.02), np.ones(count)
    step, way = velocity_steps(speed, 0.0 * one, 10.0 * one), ramp(speed, 2.5e-4)
    steep = respond(lanes, along(way, way.scaled(0.3 * one)), times, 1.25e-5)
    found = [
        respond(lanes, along(step, step.scaled(0.3 * one)), times, length)
        for length in (2.5e-3, 3e-4)
    ]
    rotations = [each["rotation"] for each in (steep, *found)]
    peak = np.abs(rotations[0]).max(axis=1)
    # A ramp of 1 ms differs from one of .25 ms by less than a twentieth.
    assert np.all(np.abs(rotations[2] - rotations[0]).max(axis=1) <= 0.1 * peak)
    assert np.all(np.abs(rotations[2] - rotations[1]).max(axis=1) <= 0.02 * peak)


def test_lanes_do_not_depend_on_the_batch_and_a_broken_lane_harms_nobody(unjudged: None) -> None:
    lanes, motions, times = scenes()
    together = run_batch("event", lanes, motions, times, workers=1)
    split = run_batch("event", lanes, motions, times, workers=2, chunk_size=2)
    reverse = np.arange(7)[::-1]
    turned = run_batch("event", lanes.take(reverse), motions.take(reverse), times)
    height = lanes.height.copy()
    height[2] = np.nan
    broken = run_batch("event", dataclasses.replace(lanes, height=height), motions, times)
    unseen = run_batch("event", lanes, motions, SampleTimes(1.0))
    sound = np.arange(7) != 2
    for name, values in together.fields.items():
        np.testing.assert_array_equal(split[name], values)
        np.testing.assert_array_equal(turned[name][reverse], values)
        np.testing.assert_array_equal(broken[name][sound], values[sound])
        if name in unseen.fields:
            np.testing.assert_array_equal(unseen[name], values)
    assert broken["status"][2] == Status.NONFINITE
    assert np.max(np.abs(together["yaw"] - together["yaw"][:, :1])) > 1e-2
