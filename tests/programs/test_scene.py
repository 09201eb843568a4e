"""What programs of others are given of a lane, and what is read off their poses."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import quad

from tests.shared.blocks import free_lanes, make_lanes, sines
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import DeclinedError
from warprock.model.base_path import base_path, integrated_path
from warprock.model.lanes import SpatialLanes
from warprock.model.motion import (
    Control,
    Segment,
    SpatialMotions,
    StillBase,
    Waveform,
    no_motion,
    ricker_motions,
)
from warprock.model.pose import product, quaternion, start_poses
from warprock.model.response import LANE_FIELDS, SPATIAL_FIELDS, Outcome, SampleTimes, Status
from warprock.model.turning import rotate
from warprock.programs.response import FLAT_RATIO, REST_TIME, peer_response
from warprock.programs.scene import PeerRun, multiplied_frictions, peer_scenes
from warprock.programs.table import require_scenes, run_program
from warprock.running.batch import run_batch

TIMES = SampleTimes(2.0, 0.01)


def in_space(lanes: Any, **more: npt.ArrayLike) -> SpatialLanes:
    """The lanes as lanes in space."""
    names = {f.name for f in dataclasses.fields(SpatialLanes)} - vars(lanes).keys()
    given = {name: np.broadcast_to(more.get(name, 0.0), lanes.width.shape) for name in names}
    return SpatialLanes(**vars(lanes), **{k: np.array(v, dtype=float) for k, v in given.items()})


@pytest.mark.parametrize("ratio", [0.5, -0.5, 0.0])
def test_a_block_starts_on_the_corner_to_its_side(ratio: float) -> None:
    lanes = make_lanes(0.5, 0.75, ratio)
    (block,) = peer_scenes(lanes, StillBase(1), TIMES)[0].blocks
    corners = np.array([(x, 0.0, -0.375) for x in (-0.25, 0.25)])
    seen = block.position + rotate(np.array(block.attitude), corners)
    standing = int(ratio > 0.0)
    np.testing.assert_allclose(seen[standing], (0.25 * (2 * standing - 1), 0.0, 0.0), atol=1e-15)
    rise = 0.5 * np.sin(abs(lanes.rotation_start[0]))
    assert seen[1 - standing, 2] == pytest.approx(rise, abs=1e-15)
    assert block.mass == pytest.approx(2000 * 0.5 * 0.75 * 0.5)
    assert block.inertia[1] == pytest.approx(block.mass * (0.5**2 + 0.75**2) / 12)


def test_stacks_in_the_plane_start_with_their_corners_on_the_faces_below() -> None:
    """Against places found by hand: the upper block leans on the right end of the lower one's."""
    case = load_case(
        "stack-sine-pulse",
        ["block.1.rotation=0.02 rad", "block.2.rotation=0.05 rad", "block.2.offset=0.01 m"],
    )
    lane_set = expand_lanes(case)
    scene = peer_scenes(lane_set.lanes, lane_set.motions, TIMES)[0]
    low, high = scene.blocks
    first, second = quaternion(np.array([[0.0, 0.02, 0.0], [0.0, 0.05, 0.0]]))
    np.testing.assert_allclose([low.attitude, high.attitude], [first, second], atol=1e-15)
    corner = low.position + rotate(first, np.array([0.095, 0.0, -0.3]))
    np.testing.assert_allclose(corner, [0.095, 0.0, 0.0], atol=1e-15)
    # The upper face is 0.14 m wide about 0.01 m beside the middle of the lower one's 0.19 m.
    touched = low.position + rotate(first, np.array([0.08, 0.0, 0.3]))
    touching = high.position + rotate(second, np.array([0.07, 0.0, -0.3]))
    np.testing.assert_allclose(touched, touching, atol=1e-15)
    assert low.chamfered
    np.testing.assert_allclose(low.touching_size, (0.19, 0.4, 0.6))
    np.testing.assert_allclose(high.stands, (0.01, 0.0))


def test_blocks_in_space_start_where_our_engines_let_them() -> None:
    lanes = in_space(
        make_lanes(0.5, 0.75, 0.3),
        yaw_start=0.4,
        rotation_across_start=0.1,
        gap_start=0.02,
        centre_offset_x=0.03,
    )
    still = StillBase(1)
    (block,) = peer_scenes(lanes, SpatialMotions(still, still, still), TIMES)[0].blocks
    position, attitude = start_poses(lanes)
    np.testing.assert_allclose(block.position, position[0], atol=1e-15)
    np.testing.assert_allclose(block.attitude, attitude[0], atol=1e-15)
    np.testing.assert_allclose(block.middle, (-0.03, 0.0, 0.0))
    assert block.yaw == pytest.approx(0.4)


def test_products_of_the_coefficients_are_the_frictions() -> None:
    lane_set = expand_lanes(load_case("stack-sine-pulse", ["block.2.friction=0.3"]))
    scene = peer_scenes(lane_set.lanes, lane_set.motions, TIMES)[0]
    found = multiplied_frictions(scene)
    assert found[0] * found[1] == pytest.approx(1.0)
    assert found[1] * found[2] == pytest.approx(0.3)


def motions() -> dict[str, Any]:
    """One motion of every kind, with velocity steps and late starts; most end before 2 s."""
    one, start = np.array([1.0]), np.array([0.1])

    def ricker(control: Control, amplitude: float) -> Any:
        return ricker_motions([control], amplitude * one, 3.0 * one, start)

    record = expand_lanes(load_case("record-ridgecrest", ["run.duration=2 s"])).motions
    return {
        "displacement": sines(Control.DISPLACEMENT, 8e-3, 3.0, 1.25, start=0.1),
        "velocity": sines(Control.VELOCITY, 0.2, 2.0, 0.75, Waveform.COSINE, start=0.1),
        "acceleration": sines(Control.ACCELERATION, 3.0, 2.0, 1.3, start=0.1),
        "ricker under displacement": ricker(Control.DISPLACEMENT, 0.02),
        "ricker under velocity": ricker(Control.VELOCITY, 0.2),
        "ricker under acceleration": ricker(Control.ACCELERATION, 1.0),
        "record": record,
    }


def gains(segment: Segment, start: float, stop: float) -> tuple[float, float]:
    """What a segment adds to the velocity, and to the place beyond that of its first velocity."""
    gained, _ = quad(segment.acceleration, start, stop, epsabs=1e-13)
    levered, _ = quad(lambda t: (stop - t) * segment.acceleration(t), start, stop, epsabs=1e-13)
    return gained, levered


@pytest.mark.parametrize("kind", motions())
def test_a_base_is_where_its_acceleration_and_its_velocity_steps_bring_it(kind: str) -> None:
    """Against the segments that our engines follow, integrated twice by a quadrature."""
    motion = motions()[kind]
    path = base_path(motion, 0)
    assert path is not None
    velocity = place = 0.0
    for segment in motion.segments(0):
        start, stop = segment.start, min(segment.stop, 2.0)
        if start >= 2.0:
            break
        velocity += segment.velocity_step
        at = np.array([start])
        scale = max(1e-3, abs(velocity))
        np.testing.assert_allclose(path.velocity(at)[0, 0], velocity, atol=1e-9 * scale)
        np.testing.assert_allclose(path.displacement(at)[0, 0], place, atol=1e-9)
        gained, levered = gains(segment, start, stop)
        place += velocity * (stop - start) + levered
        velocity += gained
    np.testing.assert_allclose(path.displacement(np.array([2.0]))[0], (place, 0.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(path.displacement(np.array([0.0])), 0.0, atol=1e-15)


@pytest.mark.parametrize("kind", [kind for kind in motions() if kind != "record"])
def test_a_waveform_without_a_closed_form_is_integrated(kind: str) -> None:
    """Simpson's rule on NODES nodes: of the fourth order, twice."""
    motion = motions()[kind]
    times = np.linspace(motion.start[0], motion.stop[0] - 1e-9, 301)
    closed = base_path(motion, 0)
    assert closed is not None
    place, velocity = integrated_path(motion, 0)(times)
    size = np.abs(closed.displacement(times)).max()
    np.testing.assert_allclose(place, closed.displacement(times)[:, 0], atol=1e-9 * size)
    speed = np.abs(closed.velocity(times)).max()
    np.testing.assert_allclose(velocity, closed.velocity(times)[:, 0], atol=1e-8 * speed)


def test_a_table_meets_the_base_at_every_step_and_carries_the_velocity_step() -> None:
    motion = sines(Control.DISPLACEMENT, 8e-3, 3.0, 1.0)
    scene = peer_scenes(make_lanes(0.17, 1.0), motion, TIMES)[0]
    places, velocities = scene.base_steps(48)
    step = 0.01 / 48
    np.testing.assert_allclose(places[1:], places[:-1] + step * velocities[:-1], atol=1e-16)
    # The mean velocity of the first step: that of the velocity step, to second order.
    swing = 8e-3 * 2 * np.pi * 3.0
    assert velocities[0, 0] == pytest.approx(swing, rel=(2 * np.pi * 3.0 * step) ** 2 / 6)
    assert not velocities[-1].any()
    assert base_path(StillBase(1), 0) is None
    spatial = SpatialMotions(no_motion(motion), motion, no_motion(motion))
    path = base_path(spatial, 0)
    assert path is not None
    moved = path.displacement(np.array([0.05]))[0]
    assert moved[1] == pytest.approx(8e-3 * np.sin(2 * np.pi * 3.0 * 0.05))
    assert not moved[[0, 2]].any()


@pytest.mark.parametrize(("interval", "duration"), [(0.01, 1.0), (0.05, 1.0), (None, 0.333)])
def test_frames_are_samples_or_lie_between_them(interval: float | None, duration: float) -> None:
    times = SampleTimes(duration, interval)
    scene = peer_scenes(make_lanes(0.5, 1.0, 0.5), StillBase(1), times)[0]
    assert scene.frame <= 0.01 * (1 + 1e-12)
    assert scene.times[-1] == pytest.approx(duration)
    assert scene.steps_per_frame(4800) >= 4800 * scene.frame * (1 - 1e-9)
    found = np.min(np.abs(scene.times[:, None] - times.times), axis=0)
    np.testing.assert_allclose(found, 0.0, atol=1e-12)


def replayed(lanes: Any, motion: Any, times: SampleTimes) -> tuple[Any, Any]:
    """Response read off the poses of Housner's block, and Housner's response."""
    reference = run_batch("housner", lanes, motion, times)
    scenes = peer_scenes(lanes, motion, times)
    runs = []
    for lane, scene in enumerate(scenes):
        turn = reference["rotation"][lane]
        attitude = quaternion(np.stack([0 * turn, turn, 0 * turn], axis=-1))
        foot = np.where(turn < 0.0, -0.5, 0.5) * lanes.width[lane]
        corner = np.stack([foot, 0 * turn, np.full_like(turn, -0.5 * lanes.height[lane])], axis=-1)
        position = -rotate(attitude, corner)
        position[:, 0] += foot
        if scene.base is not None:
            position += scene.base.displacement(scene.times)
        runs.append(PeerRun(position[:, None], attitude[:, None], 1.0, 7))
    return peer_response("other", lanes, scenes, runs, times), reference


def test_what_is_read_off_housners_poses_is_housners_response() -> None:
    lanes = free_lanes()
    times = SampleTimes(4.0, 0.01)
    found, reference = replayed(lanes, StillBase(9), times)
    assert set(found.fields) == {*LANE_FIELDS, "rotation"}
    np.testing.assert_allclose(found["rotation"], reference["rotation"], atol=1e-15)
    np.testing.assert_allclose(found["peak_rotation"], lanes.rotation_start, rtol=1e-12)
    np.testing.assert_allclose(found["peak_slide"], 0.0, atol=1e-14)
    np.testing.assert_allclose(found["peak_penetration"], 0.0, atol=1e-14)
    assert (found["status"] == Status.OK).all()
    assert (found["step_count"] == 7).all()
    assert np.isnan(found["energy_lost"]).all()
    # Flat is less than a thousandth of the slenderness angle; below it Housner's block goes on.
    ended = reference["rest_time"] + REST_TIME < 4.0
    assert (found["outcome"][ended] == Outcome.AT_REST).all()
    assert 0 < ended.sum() < 9
    assert (found["rest_time"][ended] < reference["rest_time"][ended] + 0.01).all()
    assert (found["impact_count"][ended] < reference["impact_count"][ended]).all()
    swings = np.abs(reference["rotation"]) > FLAT_RATIO * lanes.slenderness_angle[:, None]
    last = 0.01 * (swings.shape[1] - np.argmax(swings[:, ::-1], axis=1))
    np.testing.assert_allclose(found["rest_time"][ended], last[ended])


def test_peaks_between_frames_and_a_moving_base() -> None:
    """A parabola through frames 10 ms apart: off by less than a thousandth of the peak."""
    lanes = make_lanes([0.17, 0.17], 1.0)
    motion = sines(Control.DISPLACEMENT, [4e-3, 6e-3], 5.0, 1.0)
    found, reference = replayed(lanes, motion, TIMES)
    np.testing.assert_allclose(found["peak_rotation"], reference["peak_rotation"], rtol=1e-3)
    np.testing.assert_allclose(found["peak_time"], reference["peak_time"], atol=0.01)
    np.testing.assert_allclose(found["peak_slide"], 0.0, atol=1e-14)
    assert (found["uplift_time"] <= 0.01).all()
    assert (np.isnan(found["rest_time"])).all()
    sampled = np.abs(found["rotation"]).max(axis=1)
    assert (found["peak_rotation"] >= sampled).all()


def test_a_block_that_falls_lies_on_its_side_and_one_that_is_lost_says_so() -> None:
    lanes = make_lanes(0.5, 0.75, np.array([-1.02, 0.5]))
    found, reference = replayed(lanes, StillBase(2), TIMES)
    assert found["outcome"][0] == Outcome.OVERTURNED
    assert found["rotation"][0, -1] == -np.pi / 2
    assert found["peak_rotation"][0] == pytest.approx(np.pi / 2)
    assert reference["outcome"][0] == Outcome.OVERTURNED
    scenes = peer_scenes(lanes, StillBase(2), TIMES)
    poses = np.full((201, 1, 3), np.nan), np.full((201, 1, 4), np.nan)
    lost = peer_response("other", lanes, scenes, [PeerRun(*poses, 1.0, 7)] * 2, TIMES)
    assert (lost["status"] == Status.NONFINITE).all()


def test_slides_and_turns_of_a_block_in_space_are_seen_from_the_base() -> None:
    """A block that moves 3 mm along x and 4 mm along y of its base and turns by 0.2 rad."""
    lanes = in_space(make_lanes(0.5, 0.75), yaw_start=0.1)
    motion = sines(Control.ACCELERATION, 1.0, 2.0, 1.0)
    scene = peer_scenes(lanes, SpatialMotions(motion, motion, no_motion(motion)), TIMES)[0]
    assert scene.base is not None
    part = np.linspace(0.0, 1.0, 201)[:, None]
    position = scene.blocks[0].position + scene.base.displacement(scene.times)
    moved = position + part * np.array([3e-3, 4e-3, 0.0])
    twisted = quaternion(np.array([0.0, 0.0, 0.1]) + part * np.array([0.0, 0.0, 0.2]))
    straight = quaternion(np.array([0.0, 0.0, 0.1]) + 0.0 * part)
    for attitude, yaw in ((straight, 0.0), (twisted, 0.2)):
        run = PeerRun(moved[:, None], attitude[:, None], 1.0, 1)
        found = peer_response("other", lanes, [scene], [run], TIMES)
        assert set(SPATIAL_FIELDS) <= set(found.fields)
        np.testing.assert_allclose(found["residual_yaw"], yaw, atol=1e-12)
        np.testing.assert_allclose(found["peak_yaw"], yaw, atol=1e-12)
        np.testing.assert_allclose(found["yaw"][0, [0, -1]], (0.1, 0.1 + yaw), atol=1e-12)
        np.testing.assert_allclose(found["peak_tilt"], 0.0, atol=1e-12)
        if yaw == 0.0:
            np.testing.assert_allclose(found["residual_slide"], 3e-3, atol=1e-12)
            np.testing.assert_allclose(found["residual_slide_across"], 4e-3, atol=1e-12)
            np.testing.assert_allclose(found["peak_slide"], 5e-3, atol=1e-12)


@pytest.mark.extra
@pytest.mark.parametrize("program", ["mujoco", "bullet"])
def test_programs_start_a_block_with_the_velocities_of_the_case(program):
    """A thrown cube flies on a parabola and turns evenly, to a step of 1/4800 s at 2 m/s."""
    pytest.importorskip({"mujoco": "mujoco", "bullet": "pybullet"}[program])
    case = load_case("cube-tosses", ["sweep=[]", *THROW])
    lane_set = expand_lanes(case)
    times = SampleTimes(0.2, 0.05, places=True)
    settings = case.peer_settings(program)
    answer = run_program(program, lane_set.lanes, lane_set.motions, times, settings)
    response = answer.response
    t = response.times
    for axis, speed, pull in (("x", 1.0, 0.0), ("y", -0.5, 0.0), ("z", 1.0, 9.81)):
        away = response[axis][0] - (2.0 if axis == "z" else 0.0)
        np.testing.assert_allclose(away, speed * t - 0.5 * pull * t**2, atol=5e-4)
    # About x of the base, after a turn about z: the axes of the block must not matter.
    half = 0.5 * 9.0 * t
    wanted = product(np.stack([np.sin(half), 0 * t, 0 * t, np.cos(half)], axis=-1), QUARTER)
    found = np.stack([response[f"attitude_{part}"][0] for part in "xyzw"], axis=-1)
    assert np.all(np.abs(np.sum(found * wanted, axis=-1)) > np.cos(0.5 * 5e-3))


QUARTER = np.array([0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)])
THROW = [
    "start.height=2 m", "start.velocity_x=1 m/s", "start.velocity_y=-0.5 m/s",
    "start.velocity_z=1 m/s", "start.angular_velocity_x=9 rad/s", "start.attitude_w=0.70711",
    "start.attitude_x=0", "start.attitude_y=0", "start.attitude_z=0.70711",
]  # fmt: skip


def test_programs_that_start_from_rest_decline_a_throw():
    lane_set = expand_lanes(load_case("cube-tosses"))
    case = load_case("cube-tosses")
    batch = (lane_set.lanes, lane_set.motions, lane_set.times)
    with pytest.raises(DeclinedError, match="throws its blocks"):
        require_scenes("newton-xpbd", *batch, case.peer_settings("newton-xpbd"))
