"""`impulse` on blocks in space: contract, symmetry, closed forms, planar scenes, order, stacks."""

from __future__ import annotations

import dataclasses
import time

import numpy as np
import pytest

from tests.shared.blocks import Array, free_lanes, make_lanes, sines, velocity_steps
from tests.shared.spatial_blocks import (
    along,
    in_space,
    mirrored,
    spatial_lanes,
    spatial_stack,
    unmoved,
)
from tests.shared.speed import require_gain
from warprock.engines.impulse import Impulse
from warprock.engines.launching import Form
from warprock.model.lanes import SpatialLanes
from warprock.model.motion import Control, HarmonicMotions, SpatialMotions, StillBase
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.model.scene import scene_kind
from warprock.running.batch import run_batch
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY

LEAST_GAIN = 3.0
"""Packed over plain rate below which a pack is no vector code; 5 with 512-bit vectors."""


def run(
    lanes: SpatialLanes, motions: SpatialMotions, times: SampleTimes, **settings: float
) -> Response:
    chosen = dataclasses.replace(ImpulseSettings(), **settings)  # type: ignore[arg-type]
    return run_batch("impulse", lanes, motions, times, settings=chosen)


def shaken_sideways(count: int) -> SpatialMotions:
    """Cycles of sine in all three directions, others for every lane."""
    one = np.ones(count)
    spread = np.linspace(0.8, 1.2, count)
    return along(
        sines(Control.ACCELERATION, 0.40 * GRAVITY * spread, 2.0 * one, 1.0),
        sines(Control.DISPLACEMENT, 0.02 * spread, 2.5 * one, 1.0),
        sines(Control.ACCELERATION, 0.10 * GRAVITY * one, 3.0 * spread, 1.0),
    )


def crooked_lanes(count: int) -> SpatialLanes:
    """Blocks that start on a corner or flat, turned, some with a centre beside the middle."""
    random = np.random.default_rng(11)
    flat = np.arange(count) % 3 == 0
    return spatial_lanes(
        np.full(count, 0.3),
        1.0,
        friction=0.6,
        depth=random.uniform(0.25, 0.4, count),
        rotation_start=np.where(flat, 0.0, random.uniform(-0.1, 0.1, count)),
        rotation_across_start=np.where(flat, 0.0, random.uniform(-0.05, 0.05, count)),
        yaw_start=random.uniform(-0.4, 0.4, count),
        centre_offset_x=np.where(flat, 0.01, 0.0),
    )


def same(a: Response, b: Response) -> None:
    for name, values in a.fields.items():
        np.testing.assert_array_equal(values, b[name], err_msg=name)


def test_a_lane_does_not_depend_on_its_neighbours() -> None:
    lanes, motions, times = crooked_lanes(70), shaken_sideways(70), SampleTimes(0.5, 0.05)
    whole = run_batch("impulse", lanes, motions, times, chunk_size=70, workers=1)
    same(run_batch("impulse", lanes, motions, times, chunk_size=32, workers=2), whole)
    some = np.array([69, 3, 40])
    part = run_batch("impulse", lanes.take(some), motions.take(some), times)
    for name, values in part.fields.items():
        np.testing.assert_array_equal(values, whole[name][some], err_msg=name)


def test_a_bad_lane_harms_no_other(unjudged: None) -> None:
    lanes, motions, times = crooked_lanes(5), shaken_sideways(5), SampleTimes(0.5, 0.05)
    broken = dataclasses.replace(lanes, height=np.where(np.arange(5) == 2, np.nan, 1.0))
    found = run_batch("impulse", broken, motions, times)
    good = np.arange(5) != 2
    assert found["status"][2] == Status.NONFINITE
    sound = run_batch("impulse", lanes, motions, times)
    for name, values in sound.fields.items():
        np.testing.assert_array_equal(found[name][good], values[good], err_msg=name)


@pytest.mark.thorough
def test_packed_and_plain_are_the_same_to_round_off() -> None:
    # Impacts make more of round-off: a short run, in which every block has landed a few times.
    lanes, motions, times = crooked_lanes(9), shaken_sideways(9), SampleTimes(0.3, 0.05)
    packed, plain = (
        run_batch("impulse", lanes, motions, times, form=form) for form in (Form.PACKED, Form.PLAIN)
    )
    for name in ("rotation", "rotation_across", "yaw", "residual_slide", "peak_tilt"):
        np.testing.assert_allclose(packed[name], plain[name], rtol=0.0, atol=1e-9, err_msg=name)


def image_of(motions: SpatialMotions, *, x: bool, y: bool) -> SpatialMotions:
    """Motions of a base seen in a mirror."""
    odd = ("velocity_step_start", "velocity_step_stop", "velocity_final")
    odd += ("acceleration_amplitude", "velocity_offset")

    def turned(part: HarmonicMotions, turns: bool) -> HarmonicMotions:
        sign = -1.0 if turns else 1.0
        return dataclasses.replace(part, **{name: sign * getattr(part, name) for name in odd})

    parts = motions.components
    assert all(isinstance(part, HarmonicMotions) for part in parts)
    return SpatialMotions(turned(parts[0], x), turned(parts[1], y), parts[2])  # type: ignore[arg-type]


@pytest.mark.parametrize(("x", "y"), [(True, False), (False, True), (True, True)])
def test_a_mirrored_scene_has_the_mirrored_answer(x: bool, y: bool) -> None:
    single = spatial_lanes(
        np.full(4, 0.3),
        1.0,
        friction=0.6,
        rotation_start=np.array([0.0, 0.1, 0.0, -0.06]),
        rotation_across_start=np.array([0.0, 0.02, 0.0, 0.04]),
        yaw_start=np.array([0.1, 0.2, 0.0, -0.3]),
        centre_offset_x=np.array([0.0, 0.0, 0.01, 0.0]),
    )
    # Numbers that halve without round-off, so that the starts, too, are mirrored to the last bit.
    stack = spatial_stack(
        [0.5, 0.375], [0.5, 0.625], offset=[[0.0, 0.015625]], offset_across=[[0.0, 0.03125]]
    )
    sx, sy = (-1.0 if x else 1.0), (-1.0 if y else 1.0)
    signs = {"rotation": sx, "rotation_across": sy, "yaw": sx * sy, "residual_slide": sx}
    signs |= {"residual_slide_across": sy, "energy_lost": 1.0, "impact_count": 1.0}
    for lanes in (single, stack):
        motions, times = shaken_sideways(lanes.lane_count), SampleTimes(1.0, 0.05)
        found = run(lanes, motions, times)
        image = run(mirrored(lanes, x=x, y=y), image_of(motions, x=x, y=y), times)
        # To the last bit: corners of a mirrored scene are visited in mirrored order.
        for name, sign in signs.items():
            np.testing.assert_array_equal(image[name], sign * found[name], err_msg=name)
        assert np.max(np.abs(found["rotation"])) > 1e-4


def test_blocks_dropped_on_a_corner_an_edge_and_a_face_come_to_rest_flat() -> None:
    lanes = spatial_lanes(
        [0.6, 0.6, 0.6, 0.6],
        0.3,
        friction=0.7,
        rotation_start=np.array([0.0, 0.25, 0.2, 0.3]),
        rotation_across_start=np.array([0.0, 0.0, 0.15, -0.2]),
        yaw_start=np.array([0.0, 0.3, 0.5, 0.0]),
        gap_start=np.array([0.02, 0.02, 0.03, 0.05]),
    )
    times = SampleTimes(2.0, 0.01)
    found = run(lanes, unmoved(4), times)
    np.testing.assert_array_equal(found["outcome"], Outcome.AT_REST)
    np.testing.assert_array_equal(found["status"], Status.OK)
    # Flat within what one step of falling makes, 2 g dt^2, over the face.
    step = ImpulseSettings().time_step
    flat = 2.0 * 2.0 * GRAVITY * step**2 / 0.5
    assert np.max(np.abs(found["rotation"][:, -1])) <= flat
    assert np.max(np.abs(found["rotation_across"][:, -1])) <= flat
    # In free flight nothing turns, and the fall lasts sqrt(2 gap / g).
    flight = np.sqrt(2.0 * lanes.gap_start / GRAVITY)
    for lane in range(4):
        before = times.times < flight[lane] - step
        np.testing.assert_allclose(
            found["rotation"][lane, before], found["rotation"][lane, 0], rtol=0.0, atol=1e-14
        )
    # All energy that there was above the flat state has gone, but for the last sinking.
    held = GRAVITY * lanes.mass * height_above_flat(lanes)
    np.testing.assert_allclose(found["energy_lost"], held, rtol=1e-4)


def height_above_flat(lanes: SpatialLanes) -> Array:
    """Height of the centre of mass above that of the flat block [m]."""
    half_width, half_depth, half_height = (
        0.5 * d for d in (lanes.width, lanes.depth, lanes.height)
    )
    lean = np.hypot(lanes.rotation_start, lanes.rotation_across_start)
    part = np.divide(np.sin(lean), lean, out=np.ones_like(lean), where=lean > 0.0)
    along_edges = half_width * np.abs(lanes.rotation_start)
    along_edges = along_edges + half_depth * np.abs(lanes.rotation_across_start)
    return lanes.gap_start + half_height * (np.cos(lean) - 1.0) + along_edges * part


def test_energy_never_grows_on_a_still_base() -> None:
    lanes = dataclasses.replace(crooked_lanes(12), friction=np.full(12, 0.4))
    lost = np.array(
        [run(lanes, unmoved(12), SampleTimes(t))["energy_lost"] for t in (0.2, 0.5, 1.0, 2.0)]
    )
    held = GRAVITY * lanes.mass * height_above_flat(lanes)
    # What erp lifts, and what a block sinks into it, is the weight times 2 g dt^2 at most.
    sunk = GRAVITY * lanes.mass * 4.0 * GRAVITY * ImpulseSettings().time_step ** 2
    assert np.all(np.diff(lost, axis=0) >= -sunk)
    assert np.all(lost[-1] <= held + sunk)


@pytest.mark.parametrize("box", [0, pytest.param(1, marks=pytest.mark.thorough)])
def test_a_block_slides_by_the_closed_form_in_every_direction(box: int) -> None:
    direction = np.linspace(0.0, np.pi, 9)
    speed, friction = 0.4, 0.2
    zero, long = np.zeros(9), np.full(9, 10.0)
    lanes = spatial_lanes(np.full(9, 1.0), 0.5, friction=friction, depth=0.8)
    motions = along(
        velocity_steps(speed * np.cos(direction), zero, long),
        velocity_steps(speed * np.sin(direction), zero, long),
    )
    found = run(lanes, motions, SampleTimes(2.0), friction_box=box)
    slide = -np.stack([found["residual_slide"], found["residual_slide_across"]])
    part = speed * np.stack([np.cos(direction), np.sin(direction)])
    # The cone stops the block along its way; the box stops each component by itself.
    way = np.abs(part) if box else speed
    expected = part * way / (2.0 * friction * GRAVITY)
    # First order: the last step may be off by v dt.
    np.testing.assert_allclose(slide, expected, rtol=0.0, atol=speed * ImpulseSettings().time_step)
    np.testing.assert_array_equal(found["outcome"], Outcome.AT_REST)
    assert np.max(np.abs(found["residual_yaw"])) <= 1e-9


def test_planar_scenes_in_space_agree_with_the_plane() -> None:
    lanes, times = free_lanes(), SampleTimes(2.0, 0.01)
    angle = lanes.slenderness_angle
    planar = {
        sweeps: run_batch(
            "impulse", lanes, StillBase(9), times, settings=ImpulseSettings(iterations=sweeps)
        )["rotation"]
        for sweeps in (10, 100)
    }
    # Four corners share what two do in the plane, where the sweeps take long to find it; contacts
    # that hold are found at once here, whatever the sweeps, so that ten are as good as a hundred.
    for sweeps in (10, 100):
        found = run(in_space(lanes), unmoved(9), times, iterations=sweeps)
        out = max(np.max(np.abs(found[name])) for name in ("rotation_across", "yaw"))
        assert out <= 1e-8
        # To what round-off makes of 2 s, and at impacts of corners that leave late.
        gaps = np.abs(found["rotation"] - planar[100]).max(axis=1) / angle
        assert np.max(gaps) <= 1e-8
        assert np.max(np.abs(planar[10] - planar[100]).max(axis=1) / angle) <= 1e-6


def test_errors_in_space_shrink_as_the_step_does() -> None:
    # Onto the corner and from there: no symmetry is left. Sixteen blocks, so that the scatter of
    # the impacts within their steps averages out.
    random = np.random.default_rng(5)
    lanes = spatial_lanes(
        np.full(16, 0.5),
        1.0,
        friction=2.0,
        depth=0.6,
        rotation_start=random.uniform(0.1, 0.3, 16),
        rotation_across_start=random.uniform(0.05, 0.25, 16) * random.choice([-1.0, 1.0], 16),
        yaw_start=random.uniform(-1.0, 1.0, 16),
    )
    times = SampleTimes(1.0, 0.02)
    finest = run(lanes, unmoved(16), times, substeps=639)
    assert np.all(finest["impact_count"] >= 2)
    assert np.all(finest["peak_yaw"] > 1e-3)
    substeps = np.array([7, 15, 31, 63])
    errors = []
    for count in substeps:
        found = run(lanes, unmoved(16), times, substeps=int(count))
        gaps = [found[name] - finest[name] for name in ("rotation", "rotation_across")]
        errors.append(np.mean(np.abs(gaps).max(axis=(0, 2)) / lanes.slenderness_angle))
    slope = np.polyfit(np.log(substeps + 1.0), np.log(errors), 1)[0]
    # First order; the finest run has a tenth of the last one's error.
    assert -1.4 <= slope <= -0.8
    assert errors[-1] <= 2e-3


@pytest.mark.speed
def test_packed_kernel_in_space_is_vectorised() -> None:
    lanes = in_space(free_lanes()).take(np.arange(576) % 9)
    times, settings = SampleTimes(0.25), ImpulseSettings()

    def cost(form: Form) -> float:
        count = 64 if form is Form.PLAIN else 576
        some = lanes.take(np.arange(count))
        run_batch("impulse", some, unmoved(count), SampleTimes(0.01), form=form, workers=1)
        started = time.process_time()
        run_batch("impulse", some, unmoved(count), times, settings=settings, form=form, workers=1)
        return (time.process_time() - started) / count

    require_gain(lambda: cost(Form.PLAIN), lambda: cost(Form.PACKED), LEAST_GAIN)


def test_a_block_that_tips_over_its_corner_has_overturned() -> None:
    lanes = spatial_lanes(
        [0.3, 0.3], 1.0, depth=0.3, yaw_start=0.7,
        rotation_start=np.array([0.2, 0.4]), rotation_across_start=np.array([0.2, 0.3]),
    )  # fmt: skip
    found = run(lanes, unmoved(2), SampleTimes(4.0))
    np.testing.assert_array_equal(found["outcome"] == Outcome.OVERTURNED, [False, True])
    assert found["peak_tilt"][1] == pytest.approx(0.5 * np.pi, abs=1e-12)
    assert found["peak_tilt"][0] == pytest.approx(np.hypot(0.2, 0.2), abs=1e-12)


@pytest.mark.thorough
def test_a_tall_stack_stands() -> None:
    # Six blocks, each beside and turned against the one below; a millisecond a step.
    lanes = spatial_stack(
        np.full(6, 0.4), 0.4, depth=0.5,
        offset=[[0.0, 0.01, -0.02, 0.01, 0.0, 0.01]],
        offset_across=[[0.0, -0.01, 0.01, 0.02, -0.01, 0.0]],
        yaw_start=[[0.02, -0.03, 0.1, 0.0, 0.05, -0.2]],
    )  # fmt: skip
    found = run(lanes, unmoved(1), SampleTimes(60.0), substeps=3)
    assert found["status"][0] == Status.OK
    assert found["outcome"][0] == Outcome.AT_REST
    # It sinks and shifts by what the sweeps of one step leave, not by more.
    assert np.max(found["peak_slide"]) <= 1e-3
    assert np.max(found["peak_tilt"]) <= 1e-3


@pytest.mark.thorough
def test_a_planar_stack_in_space_follows_the_planar_one() -> None:
    stack = spatial_stack([0.3, 0.3], [0.5, 0.5], friction=0.8)
    flat = {f.name: getattr(stack, f.name) for f in dataclasses.fields(make_lanes(1.0, 1.0))}
    x = sines(Control.ACCELERATION, 0.5 * GRAVITY, 2.0, 1.0)
    times, settings = SampleTimes(1.0, 0.02), ImpulseSettings(iterations=100)
    planar = run_batch("impulse", type(make_lanes(1.0, 1.0))(**flat), x, times, settings=settings)
    found = run_batch("impulse", stack, along(x), times, settings=settings)
    gap = np.abs(found["rotation"] - planar["rotation"]).max()
    # A corner on a face touches along the lower face's normal here, there along the face's whose
    # side it lies on: the same but for the square of a rotation between two faces.
    assert planar["peak_rotation"].max() > 0.1
    assert gap <= 1e-4


def test_round_off_chooses_no_side_of_a_stack() -> None:
    """Stacks that stand straight, shaken along x, of which the sweeps make a little yaw."""
    count = 8
    straight = spatial_stack([0.3, 0.3], [0.5, 0.5], friction=0.8).take(np.zeros(count, np.intp))
    units = np.random.default_rng(0).integers(-8, 9, size=(2, *straight.width.shape))
    sizes = 1.0 + np.spacing(1.0) * units
    lanes = dataclasses.replace(
        straight, width=straight.width * sizes[0], height=straight.height * sizes[1]
    )
    x = along(sines(Control.ACCELERATION, np.full(count, 0.5 * GRAVITY), 2.0, 1.0))
    found = run(lanes, x, SampleTimes(0.5, 0.02))
    assert np.all(found["impact_count"] > 0)
    assert np.all(np.abs(found["peak_yaw"]) > 1e-6)
    # Its sense is that of the order in which corners are visited, and so are 2e-4 rad of rotation
    # after the first landing. What is left here is round-off that the landing has made larger.
    for name in ("rotation", "rotation_across", "yaw"):
        np.testing.assert_allclose(
            found[name], found[name][:1].repeat(count, axis=0), rtol=0.0, atol=1e-11
        )


def test_a_stack_slides_off() -> None:
    lanes = spatial_stack([0.6, 0.2], [0.2, 0.1], friction=[[5.0, 0.02]])
    zero, long = np.zeros(1), np.full(1, 50.0)
    speed = np.full(1, 0.9)
    motions = along(
        velocity_steps(0.6 * speed, zero, long), velocity_steps(0.8 * speed, zero, long)
    )
    found = run(lanes, motions, SampleTimes(3.0))
    assert found["outcome"][0] == Outcome.SLID_OFF
    # Against the way of the base in both directions, until no part of the faces is left.
    assert found["residual_slide"][0, 1] < 0.0
    assert found["residual_slide_across"][0, 1] < 0.0
    assert found["peak_slide"][0, 1] >= 0.5 * (0.6 + 0.2)


def test_what_impulse_supports_in_space() -> None:
    lanes = crooked_lanes(2)
    kind = scene_kind(lanes, shaken_sideways(2), restitution_given=False)
    assert Impulse.supports(kind) is None
    assert "restitution" in (
        Impulse.supports(dataclasses.replace(kind, restitution_given=True)) or ""
    )
