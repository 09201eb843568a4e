"""`dem` in space: planar scenes, the contract, drops on corners and edges, flight, slide, order."""

from __future__ import annotations

import dataclasses
import functools
import time

import numpy as np
import pytest

from tests.shared.blocks import Array, free_lanes, make_lanes, make_stacks, sines, velocity_steps
from tests.shared.spatial_blocks import along, in_space, sound_run, spatial_stack, unmoved
from tests.shared.speed import require_gain
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines import base
from warprock.engines.dem import Dem
from warprock.engines.launching import Form
from warprock.model.lanes import SpatialLanes
from warprock.model.motion import Control, HarmonicMotions, SpatialMotions, StillBase, no_motion
from warprock.model.pose import product
from warprock.model.response import LANE_FIELDS, SPATIAL_FIELDS, Outcome, SampleTimes, Status
from warprock.model.turning import inverse, rotate
from warprock.running.batch import run_batch
from warprock.running.machine import cpu_vector_flags
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

run = functools.partial(sound_run, "dem")

LANES = 40
"""A pack of 32 and a part of one."""
DAMPED = DemSettings(stiffness_damping=2e-3)
"""Dashpots near critical for blocks of 1 m on springs of 1e9 N/m^3: a drop does not rebound."""


def negated(motions: HarmonicMotions) -> HarmonicMotions:
    """The same motions the other way."""
    names = ("acceleration_amplitude", "velocity_offset", "velocity_step_start",
             "velocity_step_stop", "velocity_final")  # fmt: skip
    return dataclasses.replace(motions, **{name: -getattr(motions, name) for name in names})


def mixed_batch() -> tuple[SpatialLanes, SpatialMotions]:
    """Blocks with all imperfections under pulses of three directions; some fall."""
    k = np.arange(LANES)
    lanes = in_space(
        make_lanes(0.17 + 0.003 * k, 1.0 + 0.01 * (k % 7), np.where(k % 5 == 0, 0.3, 0.0)),
        depth=0.15 + 0.01 * (k % 9),
        rotation_across_start=np.where(k % 4 == 1, 0.02, 0.0),
        yaw_start=0.05 * (k % 3),
        centre_offset_x=np.where(k % 3 == 1, 2e-3, 0.0),
        centre_offset_y=np.where(k % 3 == 2, -3e-3, 0.0),
        gap_start=np.where(k % 10 == 9, 0.01, 0.0),
    )
    size = np.where(k % 11 == 3, 0.3, 0.002 + 0.0002 * k)
    x, y, z = (
        sines(Control.DISPLACEMENT, part * size, 2.0 + 0.04 * k, cycles=1.5)
        for part in (1.0, 0.6, 0.1)
    )
    return lanes, SpatialMotions(x, y, z)


def test_planar_scenes_are_those_of_the_planar_engine() -> None:
    pulse = expand_lanes(load_case("single-sine-pulse"))
    six, motions = pulse.lanes.take(slice(0, 6)), pulse.motions.take(slice(0, 6))
    free = free_lanes()
    for lanes, planar, spatial in (
        (free, StillBase(9), unmoved(9)),
        (six, motions, along(motions)),
    ):
        times = SampleTimes(2.0, 0.01)
        there, here = run(lanes, planar, times), run(in_space(lanes), spatial, times)
        gap = np.abs(here["rotation"] - there["rotation"]).max(axis=1) / lanes.slenderness_angle
        # One model, other sums: round-off, which every opening of a spring magnifies.
        assert np.all(gap < 1e-8)
        np.testing.assert_array_equal(here["step_count"], there["step_count"])
        np.testing.assert_array_equal(here["impact_count"], there["impact_count"])
        np.testing.assert_allclose(here["energy_lost"], there["energy_lost"], rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(here["peak_penetration"], there["peak_penetration"], rtol=1e-6)
        assert np.all(here["peak_rotation_across"] == 0.0)
        assert np.all(here["peak_yaw"] == 0.0)


@pytest.mark.thorough
def test_planar_stacks_are_those_of_the_planar_engine() -> None:
    lanes = make_stacks(np.array([[0.4, 0.3], [0.3, 0.4], [0.3, 0.3]]), 0.6)
    motions = sines(Control.ACCELERATION, np.full(3, 5.0), 2.0, cycles=1.0)
    times = SampleTimes(0.8, 0.01)
    there, here = run(lanes, motions, times), run(in_space(lanes), along(motions), times)
    gap = np.abs(here["rotation"] - there["rotation"]).max(axis=(1, 2))
    assert np.all(np.abs(there["rotation"]).max(axis=(1, 2)) > 0.1)
    # A corner of the upper block on the lower face: the same springs, to round-off.
    assert gap[0] <= 1e-12
    # A corner of the lower block: in space the points are spread along the upper face there, too,
    # in the plane along the lower one, which is longer by one over the cosine of what parts them.
    assert np.all(gap[1:] <= 2e-4 * np.abs(there["rotation"][1:]).max(axis=(1, 2)))


@pytest.mark.thorough
def test_a_tilted_block_slides_over_the_edge_below_it_as_in_the_plane() -> None:
    """With springs that pressed along the lower normal these pairs were .007 to .15 rad off."""
    tilts = np.array([0.05, 0.1, 0.3, -0.1, -0.2])
    pair = make_stacks([0.3, 0.4], [0.5, 0.5], friction=0.3, offset=[0.0, 0.01])
    flat = dataclasses.replace(
        pair.take(np.zeros(5, np.intp)), rotation_start=tilts[:, None] * np.array([0.0, 1.0])
    )
    springs = dataclasses.replace(DAMPED, subcontacts=2, subcontacts_across=2)
    times, motions, errors = SampleTimes(0.35, 0.01), unmoved(5), []
    # The lower block as deep as the upper one, deeper and less deep: edges that cross, and corners.
    for depth in ([1.0, 1.0], [1.0, 0.5], [0.5, 1.0]):
        plane = dataclasses.replace(flat, depth=0.0 * flat.width + depth)
        there = run(plane, motions.components[0], times, springs)
        here = run(in_space(plane), motions, times, springs)
        assert np.max(there["peak_slide"]) > 0.01
        errors.append(np.abs(here["rotation"] - there["rotation"]).max())
    # Springs differ by the area that points stand for, 4 % at .3 rad, and impacts magnify that.
    assert np.all(np.array(errors) < 5e-4)


@pytest.mark.thorough
def test_springs_without_friction_and_damping_keep_the_energy_of_tilted_blocks() -> None:
    """A pair that falls in its plane on its corners: each spring is a potential but for its area.

    The area that a spring stands for changes as faces slide: less the stiffer they are.
    """
    rng = np.random.default_rng(7)
    upper = np.array([0.0, 1.0])
    lanes = in_space(
        make_stacks(
            rng.uniform(0.25, 0.6, (40, 2)), rng.uniform(0.2, 0.6, (40, 2)), friction=1e-12
        ),
        depth=rng.uniform(0.25, 0.6, (40, 2)),
        rotation_start=upper * rng.uniform(-0.15, 0.15, (40, 1)),
        gap_start=upper * rng.uniform(0.0, 0.02, (40, 1)),
    )
    held = lanes.mass.sum(axis=1) * GRAVITY * 0.1
    lost = []
    for stiffness in (1e9, 1e11):
        springs = DemSettings(
            normal_stiffness=stiffness, shear_stiffness=stiffness, stiffness_damping=0.0,
            step_safety=0.05,
        )  # fmt: skip
        found = run(lanes, unmoved(40), SampleTimes(0.15), springs)
        lost.append(np.max(np.abs(found["energy_lost"]) / held))
    # Along the lower normal everywhere it was up to 3 %, whatever the stiffness.
    assert lost[0] < 3e-3
    assert lost[1] < 0.3 * lost[0]


def test_lane_does_not_depend_on_batch_chunk_workers_or_place(unjudged: None) -> None:
    lanes, motions = mixed_batch()
    times = SampleTimes(0.6, 0.05)
    whole = run_batch("dem", lanes, motions, times, workers=1, chunk_size=LANES)
    assert set(whole["outcome"]) >= {Outcome.ROCKING, Outcome.OVERTURNED}
    for workers, chunk_size in ((2, 32), (2, 7)):
        again = run_batch("dem", lanes, motions, times, workers=workers, chunk_size=chunk_size)
        for name, values in whole.fields.items():
            np.testing.assert_array_equal(values, again[name], err_msg=name)
    order = np.random.default_rng(0).permutation(LANES)
    height = lanes.height.copy()
    height[order[5]] = np.nan
    broken = dataclasses.replace(lanes, height=height)
    shuffled = run_batch("dem", broken.take(order), motions.take(order), times)
    assert shuffled["status"][5] == Status.NONFINITE
    good = np.arange(LANES) != 5
    for name in (*LANE_FIELDS, *SPATIAL_FIELDS, "rotation", "rotation_across", "yaw"):
        np.testing.assert_array_equal(whole[name][order][good], shuffled[name][good], err_msg=name)


@pytest.mark.thorough
def test_packed_and_plain_kernels_agree() -> None:
    lanes, motions = mixed_batch()
    packed, plain = (
        run_batch("dem", lanes, motions, SampleTimes(0.6, 0.05), form=form) for form in Form
    )
    for name in packed.fields:
        np.testing.assert_array_equal(packed[name], plain[name], err_msg=name)


@pytest.mark.speed
def test_packed_kernel_is_vectorised() -> None:
    # A ratio within one run: scalar code gives 1 or less, 512-bit vectors 2.5 to 3.6.
    expected = 2.0 if any(flag.startswith("avx512f") for flag in cpu_vector_flags()) else 1.5
    many = np.arange(96) % 9
    free, x = in_space(free_lanes().take(many)), sines(Control.ACCELERATION, np.ones(96), 2.0, 4.0)

    def cost(form: Form) -> float:
        started = time.process_time()
        run_batch("dem", free, along(x), SampleTimes(1.0), form=form, workers=1)
        return time.process_time() - started

    for form in Form:
        cost(form)
    require_gain(lambda: cost(Form.PLAIN), lambda: cost(Form.PACKED), expected)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_mirrored_scene_gives_mirrored_response(axis: str) -> None:
    lanes, motions = mixed_batch()
    times = SampleTimes(0.6, 0.05)
    there = run_batch("dem", lanes, motions, times)
    lean = "rotation_start" if axis == "x" else "rotation_across_start"
    flipped = (lean, f"centre_offset_{axis}", "yaw_start")
    mirrored = dataclasses.replace(lanes, **{name: -getattr(lanes, name) for name in flipped})
    other = dataclasses.replace(motions, **{axis: negated(getattr(motions, axis))})
    back = run_batch("dem", mirrored, other, times)
    sign_x, sign_y = (-1.0, 1.0) if axis == "x" else (1.0, -1.0)
    np.testing.assert_array_equal(there["outcome"], back["outcome"])
    # Within round-off, which a lane that falls magnifies.
    stands = there["outcome"] != Outcome.OVERTURNED
    for name, sign in (("rotation", sign_x), ("rotation_across", sign_y), ("yaw", -1.0)):
        np.testing.assert_allclose(there[name][stands], sign * back[name][stands], atol=1e-11)


def test_box_dropped_on_a_corner_an_edge_and_a_face_comes_to_rest_flat() -> None:
    lanes = in_space(
        make_lanes(np.full(4, 1.0), 0.6), depth=0.8, gap_start=[0.02, 0.02, 0.02, 1e-3],
        rotation_start=[0.2, 0.25, 0.0, 0.15], rotation_across_start=[0.15, 0.0, 0.0, -0.2],
        yaw_start=[0.4, 0.0, 0.1, -0.3],
    )  # fmt: skip
    early = run(lanes, unmoved(4), SampleTimes(0.3), DAMPED)["energy_lost"]
    response = run(lanes, unmoved(4), SampleTimes(4.0, 0.05), DAMPED)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    assert np.all(np.abs(response["rotation"][:, -1]) < 1e-6)
    assert np.all(np.abs(response["rotation_across"][:, -1]) < 1e-6)
    # What it held is gone: the rise of its centre, but for what it sinks (1e-5 m of 2 cm and more).
    half = np.array([0.5, 0.4, 0.3])
    lean = np.hypot(lanes.rotation_start, lanes.rotation_across_start)
    part = np.sin(lean) / np.where(lean > 0.0, lean, 1.0)
    rise = part * (
        half[0] * np.abs(lanes.rotation_start) + half[1] * np.abs(lanes.rotation_across_start)
    )
    rise += lanes.gap_start - half[2] * (1.0 - np.cos(lean))
    held = lanes.mass * GRAVITY * rise
    np.testing.assert_allclose(response["energy_lost"], held, rtol=1e-3)
    # A central difference wins at most (w dt)^2 / 24 of what swings.
    assert np.all(early >= -1e-3 * held)
    assert np.all(response["energy_lost"] >= early - 1e-3 * held)


def test_free_fall_is_exact() -> None:
    lanes = in_space(make_lanes(np.full(2, 0.5), 0.5), gap_start=[0.5, 0.1], rotation_start=0.1,
                     yaw_start=0.3)  # fmt: skip
    lands = np.sqrt(2.0 * lanes.gap_start / GRAVITY)
    for lane in range(2):
        one = lanes.take(slice(lane, lane + 1))
        # Half a step at the start makes the fall exact; a step is 2e-4 s.
        before = run(one, unmoved(1), SampleTimes(float(lands[lane]) - 5e-4, 0.01))
        after = run(one, unmoved(1), SampleTimes(float(lands[lane]) + 5e-4))
        assert before["peak_penetration"][0] == 0.0 < after["peak_penetration"][0]
        leans = np.arctan(np.tan(0.1) * np.cos(0.3))
        np.testing.assert_allclose(before["rotation"][0], leans, rtol=1e-12)
        assert abs(before["energy_lost"][0]) <= 1e-9


def test_rotation_in_flight_keeps_angular_momentum_and_energy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # The base falls away, at 20 m/s, from below a block that turns over a corner and spins on.
    lanes = in_space(
        make_lanes(0.5, 0.6),
        depth=0.3,
        rotation_start=0.3,
        rotation_across_start=0.2,
        yaw_start=0.4,
    )
    count, away = np.ones(1), np.full(1, 0.12)
    drop = velocity_steps(-20.0 * count, 0.0 * count, 10.0 * count)
    drop = dataclasses.replace(drop, start=away, stop=away + 10.0)
    taken = []
    shown = base.histories
    monkeypatch.setattr(
        base,
        "histories",
        lambda lanes, seen, *more, **options: (
            taken.append(seen.history) or shown(lanes, seen, *more, **options)
        ),
    )
    still_along = no_motion(drop)
    interval = 1e-3
    run(lanes, SpatialMotions(still_along, still_along, drop), SampleTimes(0.6, interval))
    attitude = taken[0][0, 0, 130:]
    # Mean angular velocity between two samples, and the attitude half way.
    first, then = attitude[:-1], attitude[1:]
    back = inverse(first)
    apart = product(then, back)
    turn = 2.0 * np.arcsin(np.linalg.norm(apart[:, :3], axis=1))
    rate = turn[:, None] / interval * apart[:, :3] / np.linalg.norm(apart[:, :3], axis=1)[:, None]
    middle = (first + then) / np.linalg.norm(first + then, axis=1)[:, None]
    own = rotate(inverse(middle), rate)
    inertia = np.array([0.3**2 + 0.6**2, 0.5**2 + 0.6**2, 0.5**2 + 0.3**2]) / 12.0
    momentum, energy = rotate(middle, inertia * own), (inertia * own**2).sum(axis=1)
    assert np.linalg.norm(rate, axis=1).max() > 0.5
    # A mean over 1 ms for the value in its middle, and the split's own second order in the step:
    # (w dt)^2 of some rad/s in 1 ms.
    size = np.linalg.norm(momentum[0])
    assert np.abs(momentum - momentum[0]).max() <= 1e-5 * size
    assert np.ptp(energy) <= 1e-5 * energy[0]


@pytest.mark.thorough
def test_blocks_that_press_on_one_another_in_the_air_keep_their_momentum() -> None:
    """Edges that cross, 3 mm deep in one another at the start, push two falling blocks apart."""
    upper = np.array([0.0, 1.0])
    lanes = spatial_stack(
        [0.3, 0.4], [0.5, 0.4], depth=[[0.35, 0.3]], friction=0.4, yaw_start=0.3,
        rotation_start=0.15 * upper, rotation_across_start=-0.1 * upper, offset=0.12 * upper,
        offset_across=-0.08 * upper, gap_start=[[1.0, -3e-3]],
    )  # fmt: skip
    interval = 2e-4
    # A gap below zero, which others refuse; two steps a sample.
    springs = DemSettings(time_step=0.5 * interval)
    found = Dem(springs).run(lanes, unmoved(1), SampleTimes(0.02, interval, places=True))
    place = np.stack([found[name][0] for name in "xyz"], axis=-1)
    turn = np.stack([found[f"attitude_{name}"][0] for name in "xyzw"], axis=-1)
    mass, apart = lanes.mass[0][:, None, None], product(turn[:, 1:], inverse(turn[:, :-1]))
    velocity, middle = np.diff(place, axis=1) / interval, 0.5 * (place[:, 1:] + place[:, :-1])
    falls = GRAVITY * interval * np.arange(100)[:, None] * (0.0, 0.0, 1.0)
    momentum = mass * (velocity + falls)
    sizes = np.array([[0.3, 0.35, 0.5], [0.4, 0.3, 0.4]]) ** 2
    inertia = mass * (sizes.sum(axis=1, keepdims=True) - sizes)[:, None] / 12.0
    half = turn[:, 1:] + turn[:, :-1]
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    # Small turns: twice the imaginary part.
    spin = rotate(half, inertia * rotate(inverse(half), 2.0 * apart[..., :3] / interval))
    angular = spin + np.cross(middle - middle.mean(axis=0), momentum)
    for each, round_off in ((momentum, 1e-9), (angular, 1e-5)):
        # Central differences of turns and arms are off by the squares of steps.
        assert np.max(np.abs(each[0, -1] - each[0, 1])) > 1.0
        total = each.sum(axis=0)[1:]
        assert np.max(np.abs(total - total[0])) < round_off


def test_block_slides_alike_in_every_direction() -> None:
    angle = np.array([0.0, 0.6, 2.0, 4.0])
    speed, friction = 0.3, 0.1
    lanes = in_space(make_lanes(np.full(4, 1.0), 0.5, friction=friction), depth=1.0)
    zero, long = np.zeros(4), np.full(4, 10.0)
    x = velocity_steps(speed * np.cos(angle), zero, long)
    y = velocity_steps(speed * np.sin(angle), zero, long)
    response = run(lanes, SpatialMotions(x, y, no_motion(x)), SampleTimes(1.0, 0.01), DAMPED)
    slide = speed**2 / (2.0 * GRAVITY * friction)
    # The springs carry the block back by mu m g / k and it rings on them for a while: 1 %.
    np.testing.assert_allclose(
        response["residual_slide"], -slide * np.cos(angle), atol=0.01 * slide
    )
    np.testing.assert_allclose(
        response["residual_slide_across"], -slide * np.sin(angle), atol=0.01 * slide
    )
    np.testing.assert_allclose(response["peak_slide"], slide, rtol=0.01)
    assert np.all(response["peak_yaw"] < 1e-3)
    lost = 0.5 * lanes.mass * speed**2
    np.testing.assert_allclose(response["energy_lost"], lost, rtol=0.01)


def test_error_is_of_first_order_in_the_step() -> None:
    k = np.arange(4)
    lanes = in_space(
        make_lanes(np.full(4, 0.5), 1.0, np.array([0.3, 0.5, 0.0, 0.0])), depth=0.45,
        rotation_across_start=[0.1, 0.05, 0.0, 0.0], yaw_start=[0.5, -0.2, 0.2, 0.4],
    )  # fmt: skip
    size = np.where(k > 1, 1.0, 0.0)
    x = sines(Control.ACCELERATION, 6.0 * size, 2.0, cycles=1.0)
    y = sines(Control.ACCELERATION, 4.5 * size, 2.0, cycles=1.0)
    motions = SpatialMotions(x, y, no_motion(x))

    def rotations(safety: float) -> Array:
        # The paper's dashpots let a corner chatter, whose order no step tells; these do not.
        settings = dataclasses.replace(DAMPED, step_safety=safety, time_step=0.1)
        response = run(lanes, motions, SampleTimes(0.24, 0.01), settings)
        return np.stack([response[name] for name in ("rotation", "rotation_across", "yaw")])

    safety = np.array([0.4, 0.2, 0.1, 0.05])
    exact = rotations(0.006)
    error = [np.abs(rotations(value) - exact).max(axis=(0, 2)) for value in safety]
    slope = np.polyfit(np.log(safety), np.log(error).mean(axis=1), 1)[0]
    assert 0.75 <= slope <= 1.3
    assert np.max(error[-1]) < 1e-4
