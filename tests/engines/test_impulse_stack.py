"""`impulse` on stacks: one block, the two-block oracle, statics, sliding, what is conserved."""

from __future__ import annotations

import dataclasses
import time

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.blocks import (
    Array,
    at_rest,
    every_height_of_stack,
    free_lanes,
    sines,
    velocity_steps,
)
from tests.shared.kinds import lanes_of, planar_motions
from tests.shared.speed import require_gain
from warprock.engines.launching import Form
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import Control, GroundMotions, MotionKind
from warprock.model.response import LANE_FIELDS, Outcome, Response, SampleTimes, Status
from warprock.oracle.pair import rock_two_blocks
from warprock.oracle.pair_mechanics import TwoBlocks
from warprock.running.batch import run_batch
from warprock.running.machine import cpu_vector_flags
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY

STICKING = 10.0
"""A friction at which nothing slides."""
COARSE = ImpulseSettings(substeps=1)
"""480 steps a second, for what does not hang on the step."""


def stacks(
    width: npt.ArrayLike,
    height: npt.ArrayLike,
    *,
    rotation: npt.ArrayLike = 0.0,
    friction: npt.ArrayLike = STICKING,
    density: npt.ArrayLike = 2000.0,
    chamfer: npt.ArrayLike = 0.0,
    offset: npt.ArrayLike = 0.0,
) -> Lanes:
    """Stacks from values that broadcast to [lane, block]."""
    parts = np.broadcast_arrays(
        *(np.atleast_2d(v) for v in (width, height, 0.5, density, friction, chamfer, offset)),
        np.atleast_2d(rotation),
    )
    arrays = [np.array(part, dtype=np.float64) for part in parts]
    return Lanes(*arrays, angular_restitution=np.ones(len(arrays[0])))


def run(lanes: Lanes, motions: GroundMotions, times: SampleTimes, substeps: int = 20) -> Response:
    """A run in which no lane fails."""
    response = run_batch(
        "impulse", lanes, motions, times, settings=ImpulseSettings(substeps=substeps)
    )
    assert np.all(response["status"] == Status.OK)
    return response


def random_pairs(count: int) -> Lanes:
    """Pairs of blocks, the upper one narrower or wider, released from rotations to either side."""
    rng = np.random.default_rng(1)
    return stacks(
        rng.uniform(0.15, 0.3, (count, 2)),
        rng.uniform(0.4, 0.8, (count, 2)),
        density=rng.uniform(800.0, 2000.0, (count, 2)),
        rotation=np.stack([rng.uniform(-0.06, 0.06, count), rng.uniform(-0.1, 0.1, count)], axis=1),
    )


def oracle(lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Array:
    """Rotations of two-block stacks by the oracle, shape [lane, block, sample]."""
    found = []
    for lane in range(lanes.lane_count):
        low, high = lanes.width[lane].tolist(), lanes.height[lane].tolist()
        blocks = TwoBlocks(tuple(low), tuple(high), (0.5, 0.5), tuple(lanes.density[lane].tolist()))
        start = tuple(lanes.rotation_start[lane].tolist())
        answer = rock_two_blocks(
            blocks, motions.segments(lane), times, rotation_start=start, rtol=1e-9
        )
        assert answer.odd_choice_count == 0
        assert np.isnan(answer.pull_time)
        assert len(answer.impact_times) >= 2
        found.append(answer.rotation)
    return np.array(found)


@pytest.mark.thorough
def test_a_stack_of_one_is_the_single_block() -> None:
    single = free_lanes()
    alone = as_stacks(single)
    times = SampleTimes(2.0, 0.01)
    one, other = (run(lanes, at_rest(9), times) for lanes in (single, alone))
    # The starts differ by what the sweeps leave (0.36^10 of a step's fall); the rest is round-off.
    np.testing.assert_allclose(other["rotation"][:, 0], one["rotation"], rtol=0.0, atol=1e-8)
    np.testing.assert_array_equal(other["outcome"], one["outcome"])
    np.testing.assert_array_equal(other["impact_count"], one["impact_count"])
    np.testing.assert_allclose(other["peak_slide"][:, 0], one["peak_slide"], atol=1e-8)
    np.testing.assert_allclose(other["energy_lost"], one["energy_lost"], rtol=1e-4)


def test_free_pairs_converge_to_the_oracle_at_first_order() -> None:
    lanes, motions, times = random_pairs(8), at_rest(8), SampleTimes(0.5, 0.01)
    expected = oracle(lanes, motions, times)
    substeps = np.array([6, 20, 63, 200])
    errors = []
    for count in substeps:
        response = run(lanes, motions, times, int(count))
        errors.append(np.abs(response["rotation"] - expected).max(axis=(1, 2)))
    # Each impact falls somewhere inside its step, and some stacks magnify that; the geometric mean
    # over eight of them shows the order.
    typical = np.exp(np.log(errors).mean(axis=1))
    slope = np.polyfit(np.log(1.0 / (substeps + 1.0)), np.log(typical), 1)[0]
    assert 0.8 <= slope <= 1.2
    assert typical[1] <= 5e-4
    assert typical[3] <= 6e-5


def test_driven_pairs_follow_the_oracle() -> None:
    size = np.array([0.35, 0.4, 0.45, 0.5]) * GRAVITY
    lanes = stacks(np.tile([0.2, 0.15], (4, 1)), 0.6, density=[1068.0, 1468.5])
    motions = sines(Control.ACCELERATION, size, np.array([4.0, 4.0, 5.0, 5.0]), 1.0)
    times = SampleTimes(0.6, 0.01)
    expected = oracle(lanes, motions, times)
    assert np.all(np.abs(expected).max(axis=2) > 2e-3)
    coarse, fine = (
        np.abs(run(lanes, motions, times, count)["rotation"] - expected).max(axis=(1, 2))
        for count in (20, 200)
    )
    assert np.mean(coarse) <= 2e-3
    # A tenth of the step, a tenth of the error.
    assert np.mean(fine) <= np.mean(coarse) / 5.0


@every_height_of_stack
def test_a_stack_that_nothing_lifts_rests(count: int) -> None:
    height = np.array([[0.25], [0.5], [1.0]])
    lanes = stacks(np.full((3, count), 0.5), height)
    response = run_batch("impulse", lanes, at_rest(3), SampleTimes(60.0), settings=COARSE)
    assert np.all(response["peak_rotation"] < 1e-9)
    assert np.all(response["peak_slide"] < 1e-9)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    assert np.all(np.isnan(response["uplift_time"]))
    assert np.all(response["impact_count"] == 0)


def test_energy_is_lost_and_never_won() -> None:
    lanes = random_pairs(12)
    held = potential(lanes)
    for substeps in (10, 40):
        lost = [np.zeros(12)]
        for duration in (0.05, 0.1, 0.2, 0.4, 4.0):
            response = run(lanes, at_rest(12), SampleTimes(duration), substeps)
            lost.append(response["energy_lost"] / held)
        # First order: three hundred times the part of a second that a step lasts, 0.11 at 10
        # sub-steps, is what penetrations give back until the rest; a thousandth of it what a swing
        # without impacts wins.
        bound = 300.0 * ImpulseSettings(substeps=substeps).time_step
        assert np.min(np.diff(lost, axis=0)) >= -2e-2 * bound
        still = response["outcome"] == Outcome.AT_REST
        assert np.count_nonzero(still) >= 4
        assert np.all(np.abs(lost[-1][still] - 1.0) <= bound)


def potential(lanes: Lanes) -> Array:
    """Energy of the start over that of the rest [J], shape [lane]."""
    _, z = centres(lanes, lanes.rotation_start, np.zeros_like(lanes.width))
    flat = np.cumsum(lanes.height, axis=1) - 0.5 * lanes.height
    return np.asarray((lanes.mass * GRAVITY * (z - flat)).sum(axis=1))


def centres(lanes: Lanes, rotation: Array, slide: Array) -> tuple[Array, Array]:
    """Centres of blocks that stand on their lower corners [m], shape [lane, block].

    The corner is the upper block's or the lower one's, whichever lies further in; placed one by
    one, in another way than the engine does it.
    """
    x, z = np.zeros_like(rotation), np.zeros_like(rotation)
    for lane in range(len(rotation)):
        foot, turn, face = 0.0 + 0.0j, 0.0, np.inf
        for block in range(rotation.shape[1]):
            # A clockwise turn of the lever x + i z.
            now = rotation[lane, block]
            spin, under = np.exp(-1j * now), np.exp(-1j * turn)
            half = 0.5 * lanes.face_width[lane, block]
            shift = lanes.offset[lane, block] + slide[lane, block]
            side = 1.0 if now >= turn else -1.0
            touch = side * min(half + side * shift, face)
            corner = foot + touch * under
            low = corner - (touch - shift) * spin
            centre = low + 0.5j * lanes.height[lane, block] * spin
            x[lane, block], z[lane, block] = centre.real, centre.imag
            foot, turn, face = low + 1j * lanes.height[lane, block] * spin, now, half
    return x, z


def test_momentum_is_kept_on_a_base_without_friction() -> None:
    lanes = random_pairs(12)
    lanes = dataclasses.replace(lanes, friction=np.tile([0.0, STICKING], (12, 1)))
    times = SampleTimes(0.5, 0.1)
    before, _ = centres(lanes, lanes.rotation_start, np.zeros((12, 2)))
    for substeps in (20, 200):
        response = run(lanes, at_rest(12), times, substeps)
        after, _ = centres(lanes, response["rotation"][:, :, -1], response["residual_slide"])
        drift = ((after - before) * lanes.mass).sum(axis=1) / lanes.mass.sum(axis=1)
        assert np.all(response["impact_count"] >= 5)
        assert np.all(np.abs(response["residual_slide"][:, 0]) > 1e-3)
        # What an inclined interface gives back of a penetration shifts the block on it sideways.
        assert np.max(np.abs(drift)) <= 5e-3 * ImpulseSettings(substeps=substeps).time_step


def mixed(count: int = 75) -> tuple[Lanes, GroundMotions]:
    """Stacks of three that rest, rock, slide, slide off and fall."""
    rng = np.random.default_rng(2)
    rotation = np.where(rng.random((count, 1)) < 0.3, rng.uniform(-0.05, 0.05, (count, 3)), 0.0)
    lanes = stacks(
        rng.uniform(0.2, 0.4, (count, 3)),
        rng.uniform(0.2, 0.5, (count, 3)),
        friction=rng.uniform(0.1, 1.0, (count, 3)),
        chamfer=rng.uniform(0.0, 0.01, (count, 3)),
        offset=rng.uniform(-0.02, 0.02, (count, 3)),
        rotation=rotation,
    )
    size = rng.uniform(0.05, 1.5, count) * GRAVITY
    return lanes, sines(Control.ACCELERATION, size, rng.uniform(1.0, 4.0, count), 1.5)


MIXED_TIMES = SampleTimes(1.2, 0.1)


def assert_same(one: Response, other: Response) -> None:
    """Bitwise equality of every field, histories and NaN among them."""
    for name, values in one.fields.items():
        np.testing.assert_array_equal(values, other.fields[name], err_msg=name)


@pytest.mark.thorough
def test_a_stack_does_not_depend_on_batch_chunk_workers_or_place() -> None:
    lanes, motions = mixed()
    whole = run_batch("impulse", lanes, motions, MIXED_TIMES, workers=1, chunk_size=75)
    assert set(np.unique(whole["outcome"])) >= {0, 1, Outcome.OVERTURNED}
    assert whole["rotation"].shape == (75, 3, len(MIXED_TIMES.times))
    for workers, chunk_size in ((2, 32), (2, 7)):
        assert_same(
            whole,
            run_batch(
                "impulse", lanes, motions, MIXED_TIMES, workers=workers, chunk_size=chunk_size
            ),
        )
    order = np.random.default_rng(0).permutation(75)
    shuffled = run_batch("impulse", lanes.take(order), motions.take(order), MIXED_TIMES)
    for name, values in whole.fields.items():
        np.testing.assert_array_equal(values[order], shuffled[name], err_msg=name)


@pytest.mark.thorough
def test_a_bad_stack_harms_no_neighbour(unjudged: None) -> None:
    lanes, motions = mixed()
    good = run_batch("impulse", lanes, motions, MIXED_TIMES)
    height = lanes.height.copy()
    height[5, 1] = np.nan
    response = run_batch("impulse", dataclasses.replace(lanes, height=height), motions, MIXED_TIMES)
    others = np.arange(75) != 5
    assert response["status"][5] == Status.NONFINITE
    assert np.all(response["status"][others] == Status.OK)
    for name in LANE_FIELDS:
        np.testing.assert_array_equal(response[name][others], good[name][others], err_msg=name)


@pytest.mark.thorough
def test_a_mirrored_stack_responds_mirrored() -> None:
    lanes, motions = mixed()
    mirrored = dataclasses.replace(
        lanes, rotation_start=-lanes.rotation_start, offset=-lanes.offset
    )
    names = ("acceleration_amplitude", "velocity_offset", "velocity_final")
    names += ("velocity_step_start", "velocity_step_stop")
    back = dataclasses.replace(motions, **{name: -getattr(motions, name) for name in names})
    there = run_batch("impulse", lanes, motions, MIXED_TIMES)
    response = run_batch("impulse", mirrored, back, MIXED_TIMES)
    np.testing.assert_array_equal(there["rotation"], -response["rotation"])
    np.testing.assert_array_equal(there["residual_slide"], -response["residual_slide"])
    np.testing.assert_array_equal(there["outcome"], response["outcome"])


def test_round_off_chooses_no_side() -> None:
    # A stack that stands straight, on a base that begins with a jump of its velocity.
    again = np.full(8, 2)
    straight = lanes_of("stack").take(again)
    sizes = 1.0 + np.spacing(1.0) * np.random.default_rng(0).integers(-8, 9, straight.width.shape)
    lanes = dataclasses.replace(straight, height=straight.height * sizes)
    motions = planar_motions(MotionKind.HARMONIC, 4).take(again)
    found = run_batch("impulse", lanes, motions, SampleTimes(1.0, 0.05))["rotation"]
    # Round-off, magnified by fourteen landings; the two sides differ by 1e-3 rad.
    np.testing.assert_allclose(found, found[:1].repeat(8, axis=0), rtol=0.0, atol=1e-9)


@pytest.mark.thorough
def test_packed_and_plain_forms_agree() -> None:
    lanes, motions = mixed(64)
    packed = run_batch("impulse", lanes, motions, MIXED_TIMES, form=Form.PACKED, workers=1)
    few, base = lanes.take(slice(0, 8)), motions.take(slice(0, 8))
    plain = run_batch("impulse", few, base, MIXED_TIMES, form=Form.PLAIN, workers=1)
    # The compiler may fuse multiply-adds differently, and impacts magnify that.
    np.testing.assert_array_equal(packed["outcome"][:8], plain["outcome"])
    np.testing.assert_allclose(packed["peak_rotation"][:8], plain["peak_rotation"], atol=1e-6)


@pytest.mark.speed
def test_packed_kernel_is_vectorised() -> None:
    lanes, motions = mixed(64)

    def cost(form: Form) -> float:
        part = slice(0, 64 if form is Form.PACKED else 8)
        few, base = lanes.take(part), motions.take(part)
        start = time.process_time()
        response = run_batch("impulse", few, base, MIXED_TIMES, form=form, workers=1)
        return (time.process_time() - start) / float(response["step_count"].sum())

    for form in Form:
        cost(form)
    # A ratio within one run: without vector code the packed form is no faster.
    wide = any(flag.startswith("avx512f") for flag in cpu_vector_flags())
    require_gain(lambda: cost(Form.PLAIN), lambda: cost(Form.PACKED), 4.0 if wide else 2.0)


@pytest.mark.thorough
def test_single_precision_is_near_double() -> None:
    lanes, times = random_pairs(12), SampleTimes(0.3, 0.01)
    double, single = (
        run_batch("impulse", lanes, at_rest(12), times, precision=p) for p in ("float64", "float32")
    )
    error = np.abs(single["rotation"] - double["rotation"]).max(axis=(1, 2))
    # float32 has 1.2e-7 of a metre; six impacts and 1500 steps magnify that a hundredfold.
    assert np.all(error < 1e-3)
    assert np.all(error > 0.0)


def test_slides_add_up_to_the_closed_form() -> None:
    # Under a velocity step v a face of friction mu slides v^2 / (2 mu g) in all: of the ground
    # where it is the smoothest, else of the ground and of the interface together.
    friction = np.array([[0.5, 0.05], [0.5, 0.1], [0.1, 0.5], [0.5, 0.2]])
    speed = np.array([0.3, -0.2, 0.3, 0.4])
    lanes = stacks(1.0, 0.5, friction=friction)
    motions = velocity_steps(speed, np.zeros(4), np.full(4, 10.0))
    slides = []
    for substeps in (20, 200):
        response = run(lanes, motions, SampleTimes(1.2), substeps)
        slide = response["residual_slide"]
        expected = -np.sign(speed) * speed**2 / (2.0 * friction.min(axis=1) * GRAVITY)
        # First order: each of the two faces may stick a step late, at |v| dt.
        step = ImpulseSettings(substeps=substeps).time_step
        assert np.all(np.abs(slide.sum(axis=1) - expected) <= 2.0 * np.abs(speed) * step)
        assert np.all(response["outcome"] == Outcome.AT_REST)
        slides.append(slide)
    # On the rougher ground the lower block is braked by mu_1 (m_1 + m_2) and driven by mu_2 m_2.
    braking = (2.0 * friction[:, 0] - friction[:, 1]) * GRAVITY
    lower = -np.sign(speed) * speed**2 / (2.0 * braking)
    rough = friction[:, 0] > friction[:, 1]
    np.testing.assert_allclose(slides[1][rough, 0], lower[rough], rtol=2e-3)
    np.testing.assert_allclose(slides[1][~rough, 1], 0.0, atol=1e-9)


def test_a_fast_base_takes_the_lower_block_away() -> None:
    # The upper block, left behind by nearly the whole of the step in velocity, has no overlap left
    # once it has slid over one width; it falls off when its centre has lost its support.
    speed = np.array([3.0, -3.0])
    lanes = stacks(np.full((2, 2), 0.5), 0.25, friction=[0.6, 0.02])
    motions = velocity_steps(speed, np.zeros(2), np.full(2, 10.0))
    response = run(lanes, motions, SampleTimes(2.0, 0.05))
    assert np.all(response["outcome"] == Outcome.SLID_OFF)
    slide = response["peak_slide"][:, 1]
    assert np.all((slide > 0.5) & (slide < 0.502))
    # The run ends there, and the rotations stay.
    assert np.all(response["step_count"] < 2.0 / ImpulseSettings().time_step)
    assert np.all(response["rotation"][:, :, -1] == response["rotation"][:, :, -2])


def test_blocks_overturn() -> None:
    # On a face so wide that the block stays on it wherever its corner slips.
    lanes = stacks(np.tile([4.0, 0.15], (2, 1)), [0.3, 0.9], friction=1.0)
    motions = sines(Control.ACCELERATION, np.array([0.9, -0.9]) * GRAVITY, 1.0, 0.5)
    response = run(lanes, motions, SampleTimes(3.0, 0.1))
    assert np.all(response["outcome"] == Outcome.OVERTURNED)
    np.testing.assert_allclose(response["peak_rotation"][:, 1], 0.5 * np.pi, rtol=1e-12)
    assert response["rotation"][0, 1, -1] < 0.0 < response["rotation"][1, 1, -1]


@pytest.mark.thorough
def test_a_tower_stands_while_its_centres_of_mass_are_supported() -> None:
    # Equal blocks of width w stand while what is above a face has its centre within w / 2: two
    # blocks up to an offset of w / 2, and with that, below them, up to w / 4.
    width = 0.4
    ratio = np.array([[0.0, 0.0, 0.49], [0.0, 0.0, 0.51], [0.0, 0.24, 0.49], [0.0, 0.26, 0.49]])
    offset = width * np.concatenate([ratio, -ratio])
    lanes = stacks(width, 0.1, offset=offset, friction=1.0)
    response = run_batch("impulse", lanes, at_rest(8), SampleTimes(2.0, 0.5), settings=COARSE)
    falls = np.array([False, True] * 4)
    np.testing.assert_array_equal(response["outcome"] == Outcome.AT_REST, ~falls)
    assert np.all(response["peak_rotation"][~falls] < 1e-9)
    assert np.all(response["peak_rotation"][falls, 2] > 1.0)


def test_a_chamfer_makes_a_block_lift_earlier() -> None:
    # A block on a wide one lifts at |a| / g = (width / 2 - chamfer) / (height / 2).
    chamfer = np.repeat([0.0, 0.01], 2)
    limit = GRAVITY * (0.1 - 2.0 * chamfer) / 0.5
    lanes = stacks(
        np.tile([1.0, 0.1], (4, 1)), [0.2, 0.5], chamfer=np.stack([0.0 * chamfer, chamfer], 1)
    )
    motions = sines(Control.ACCELERATION, limit * np.tile([0.98, 1.02], 2), 2.0, 1.0)
    response = run(lanes, motions, SampleTimes(0.5))
    np.testing.assert_array_equal(np.isfinite(response["uplift_time"]), [False, True] * 2)
