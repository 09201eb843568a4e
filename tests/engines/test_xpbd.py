"""`xpbd`: convergence to rigid contact, the two-block oracle, statics, sliding, energy, speed."""

from __future__ import annotations

import dataclasses
import time

import numpy as np
import pytest

from tests.shared.blocks import (
    Array,
    at_rest,
    every_height_of_stack,
    free_lanes,
    make_lanes,
    make_stacks,
    sines,
    velocity_steps,
)
from tests.shared.speed import require_gain
from warprock.engines.launching import Form
from warprock.model import rocking
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import Control, GroundMotions, StillBase
from warprock.model.response import LANE_FIELDS, SOUND, Outcome, Response, SampleTimes, Status
from warprock.oracle.pair import rock_two_blocks
from warprock.oracle.pair_mechanics import TwoBlocks
from warprock.running.batch import run_batch
from warprock.running.machine import cpu_vector_flags
from warprock.settings.engines import XpbdSettings
from warprock.units import GRAVITY

STICKING = 10.0
"""A friction at which nothing slides."""
COARSE = XpbdSettings(substeps=1)
"""480 steps a second, for what does not hang on the step."""


def random_pairs(count: int) -> Lanes:
    """Pairs of blocks, the upper one narrower or wider, released from rotations to either side."""
    rng = np.random.default_rng(1)
    return make_stacks(
        rng.uniform(0.15, 0.3, (count, 2)),
        rng.uniform(0.4, 0.8, (count, 2)),
        density=rng.uniform(800.0, 2000.0, (count, 2)),
        rotation=np.stack([rng.uniform(-0.06, 0.06, count), rng.uniform(-0.1, 0.1, count)], axis=1),
    )


def mixed(count: int = 64) -> tuple[Lanes, GroundMotions]:
    """Stacks of three that rest, rock, slide and fall."""
    rng = np.random.default_rng(2)
    rotation = np.where(rng.random((count, 1)) < 0.3, rng.uniform(-0.05, 0.05, (count, 3)), 0.0)
    lanes = make_stacks(
        rng.uniform(0.2, 0.4, (count, 3)),
        rng.uniform(0.2, 0.5, (count, 3)),
        friction=rng.uniform(0.1, 1.0, (count, 3)),
        offset=rng.uniform(-0.02, 0.02, (count, 3)),
        rotation=rotation,
    )
    size = rng.uniform(0.05, 1.5, count) * GRAVITY
    return lanes, sines(Control.ACCELERATION, size, rng.uniform(1.0, 4.0, count), 1.5)


MIXED_TIMES = SampleTimes(1.2, 0.1)


def run(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, settings: XpbdSettings | None = None
) -> Response:
    """A run in which no lane fails."""
    response = run_batch("xpbd", lanes, motions, times, settings=settings)
    assert np.all(np.isin(response["status"], SOUND))
    return response


def held_energy(lanes: Lanes) -> Array:
    """Energy of a pair at the start over that of the rest [J], shape [lane].

    Each block stands on its lower corner, or on the lower block's, whichever lies further in.
    """
    found = np.zeros(lanes.lane_count)
    for lane in range(lanes.lane_count):
        foot, below, face, flat = 0.0j, 0.0, np.inf, 0.0
        for block in range(lanes.block_count):
            turn, height = lanes.rotation_start[lane, block], lanes.height[lane, block]
            half = 0.5 * lanes.face_width[lane, block]
            side = 1.0 if turn >= below else -1.0
            touch = side * min(half, face)
            low = foot + touch * np.exp(-1j * below) - touch * np.exp(-1j * turn)
            centre = low + 0.5j * height * np.exp(-1j * turn)
            found[lane] += lanes.mass[lane, block] * GRAVITY * (centre.imag - flat - 0.5 * height)
            foot, below, face = low + 1j * height * np.exp(-1j * turn), turn, half
            flat += height
    return found


def test_before_the_first_impact_the_order_is_two() -> None:
    lanes = make_lanes(np.full(3, 0.5), np.array([0.75, 1.0, 1.25]), 0.9)
    quarter = rocking.quarter_period(lanes.width, lanes.height, lanes.rotation_start)
    times = SampleTimes(0.95 * float(np.min(quarter)), 0.01)
    reference = run_batch("housner", lanes, StillBase(3), times)["rotation"]
    coarse, fine = (
        np.abs(run(lanes, StillBase(3), times, settings)["rotation"] - reference).max()
        for settings in (XpbdSettings(substeps=4), XpbdSettings(substeps=9))
    )
    assert coarse < 1e-4
    # Half of the step, a quarter of the error.
    assert 3.5 <= coarse / fine <= 4.5


def test_impacts_are_housners() -> None:
    # Between the first impact and the second a block has lost 1 - eta^2 of what it had.
    lanes = make_lanes(np.linspace(0.2, 0.6, 5), 1.0, 0.6)
    eta = rocking.angular_restitution(lanes.slenderness_angle)
    quarter = rocking.quarter_period(lanes.width, lanes.height, lanes.rotation_start)
    held = rocking.energy(
        lanes.width, lanes.height, lanes.depth, lanes.density, lanes.rotation_start, 0.0
    )
    errors = []
    for substeps in (20, 200):
        lost = np.zeros(5)
        for lane in range(5):
            some = slice(lane, lane + 1)
            times = SampleTimes(1.25 * float(quarter[lane]))
            response = run(lanes.take(some), StillBase(1), times, XpbdSettings(substeps=substeps))
            lost[lane] = response["energy_lost"][0] / held[lane]
        errors.append(np.abs(lost - (1.0 - eta**2)))
    # Gravity acts on the wrong side for up to a step: it turns g dt, against a speed of 1 m/s.
    assert np.max(errors[0]) <= 2.0 * GRAVITY * XpbdSettings().time_step
    assert np.mean(errors[1]) <= np.mean(errors[0]) / 5.0


def test_compliance_vanishes_at_first_order() -> None:
    lanes, times = free_lanes(), SampleTimes(2.5, 0.01)
    fine = XpbdSettings(substeps=100)
    rigid = run(lanes, StillBase(9), times, fine)
    compliance = np.array([1e-8, 1e-9, 3e-10])
    found = []
    for value in compliance:
        soft = run(lanes, StillBase(9), times, dataclasses.replace(fine, compliance=float(value)))
        gap = np.abs(soft["rotation"] - rigid["rotation"]).max(axis=1)
        found.append(np.mean(gap / lanes.slenderness_angle))
        # Impacts are plastic at any compliance: nothing is given back.
        assert np.all(soft["energy_lost"] >= rigid["energy_lost"] * (1.0 - 1e-3))
    slope = np.polyfit(np.log(compliance), np.log(found), 1)[0]
    assert 0.75 <= slope <= 1.2
    assert found[2] <= 3e-4


@pytest.mark.thorough
@pytest.mark.parametrize("substeps", [1, 20])
def test_a_compliant_stack_sinks_by_the_force_on_each_end(substeps: int) -> None:
    # The upper block is offset by 0.1 m: on 0.5 m of ground, twice its weight at 0.05 m; between
    # the blocks, 0.4 m of overlap, its weight at 0.1 m, which is 0.25 m from the far end.
    compliance = np.array([1e-9, 1e-8])
    lanes = make_stacks(0.5, 0.5, offset=[[0.0, 0.1]])
    force = GRAVITY * lanes.mass[0, 0]
    lower = 2.0 * force * 0.05 / 0.25 / 0.5
    upper = lower + force * (2.0 * 0.25 / 0.4 - 1.0) / 0.4
    for value in compliance:
        settings = XpbdSettings(substeps=substeps, compliance=float(value))
        response = run(lanes, at_rest(1), SampleTimes(4.0, 2.0), settings)
        tilt = response["rotation"][0, :, -1] / value
        # The levers of the forces move with the tilt, by its ratio to the slenderness angle.
        np.testing.assert_allclose(tilt, [lower, upper], rtol=1e-3)
        assert response["outcome"][0] == Outcome.AT_REST


@every_height_of_stack
def test_a_stack_that_nothing_lifts_rests(count: int) -> None:
    height = np.array([[0.25], [0.5], [1.0]])
    lanes = make_stacks(np.full((3, count), 0.5), height)
    response = run(lanes, at_rest(3), SampleTimes(60.0), COARSE)
    assert np.all(response["peak_rotation"] < 1e-11)
    assert np.all(response["peak_slide"] < 1e-11)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    assert np.all(np.isnan(response["uplift_time"]))
    assert np.all(response["impact_count"] == 0)


def test_a_stack_of_one_is_the_single_block() -> None:
    single = free_lanes()
    alone = as_stacks(single)
    times = SampleTimes(1.0, 0.01)
    one, other = (run(lanes, StillBase(9), times, COARSE) for lanes in (single, alone))
    np.testing.assert_array_equal(other["rotation"][:, 0], one["rotation"])
    np.testing.assert_array_equal(other["peak_slide"][:, 0], one["peak_slide"])
    np.testing.assert_array_equal(other["energy_lost"], one["energy_lost"])


def test_free_pairs_converge_to_the_oracle_at_first_order() -> None:
    lanes, motions, times = random_pairs(12), at_rest(12), SampleTimes(0.5, 0.01)
    expected = []
    for lane in range(12):
        low, high = lanes.width[lane].tolist(), lanes.height[lane].tolist()
        blocks = TwoBlocks(tuple(low), tuple(high), (0.5, 0.5), tuple(lanes.density[lane].tolist()))
        start = tuple(lanes.rotation_start[lane].tolist())
        answer = rock_two_blocks(
            blocks, motions.segments(lane), times, rotation_start=start, rtol=1e-9
        )
        assert answer.odd_choice_count == 0
        assert np.isnan(answer.pull_time)
        assert len(answer.impact_times) >= 2
        expected.append(answer.rotation)
    substeps = np.array([6, 20, 63, 200])
    errors = []
    for count in substeps:
        response = run(lanes, motions, times, XpbdSettings(substeps=int(count)))
        errors.append(np.abs(response["rotation"] - np.array(expected)).max(axis=(1, 2)))
    # As for single blocks; some stacks magnify the scatter, hence the geometric mean over twelve.
    typical = np.exp(np.log(errors).mean(axis=1))
    slope = np.polyfit(np.log(1.0 / (substeps + 1.0)), np.log(typical), 1)[0]
    assert 0.8 <= slope <= 1.2
    assert typical[1] <= 3e-4
    assert typical[3] <= 4e-5


def test_energy_is_lost_and_never_won() -> None:
    lanes = random_pairs(12)
    held = held_energy(lanes)
    for substeps in (20, 40):
        settings = XpbdSettings(substeps=substeps)
        lost = [np.zeros(12)]
        for duration in (0.05, 0.1, 0.2, 0.4, 4.0):
            response = run(lanes, at_rest(12), SampleTimes(duration), settings)
            lost.append(response["energy_lost"] / held)
        # The loss is what kinetic and potential energy lack, to the end: what is left is that
        # rests have a velocity of half a step, and what an interval without impacts wins is that
        # of a second-order step, (p dt)^2.
        assert np.min(np.diff(lost, axis=0)) >= -((5.0 * settings.time_step) ** 2)
        still = response["outcome"] == Outcome.AT_REST
        assert np.count_nonzero(still) >= 4
        assert np.all(np.abs(lost[-1][still] - 1.0) <= 2e-2 * settings.time_step)


def test_a_sticking_block_does_not_creep() -> None:
    # Through uplift and some twenty impacts: an end that sticks keeps its anchor.
    lanes = make_lanes(np.full(2, 0.2), 1.0, friction=1.0)
    motions = sines(Control.ACCELERATION, np.array([0.25, 0.15]) * GRAVITY, 3.0, 2.0)
    response = run(lanes, motions, SampleTimes(3.0))
    assert response["peak_rotation"][0] > 0.05 * lanes.slenderness_angle[0]
    assert response["peak_slide"][0] < 1e-5
    # The other one is not lifted; what the sweeps leave of a changing load is given back.
    assert response["peak_rotation"][1] < 1e-9
    assert response["peak_slide"][1] < 1e-9


def test_slides_of_a_pair_add_up_to_the_closed_form() -> None:
    friction = np.array([[0.5, 0.05], [0.5, 0.1], [0.1, 0.5], [0.5, 0.2]])
    speed = np.array([0.3, -0.2, 0.3, 0.4])
    lanes = make_stacks(1.0, 0.5, friction=friction)
    motions = velocity_steps(speed, np.zeros(4), np.full(4, 10.0))
    response = run(lanes, motions, SampleTimes(2.0))
    slide = response["residual_slide"]
    expected = -np.sign(speed) * speed**2 / (2.0 * friction.min(axis=1) * GRAVITY)
    # Each of the two faces may stick a step late, at |v| dt.
    step = XpbdSettings().time_step
    assert np.all(np.abs(slide.sum(axis=1) - expected) <= 2.0 * np.abs(speed) * step)
    # On the rougher ground the lower block is braked by mu_1 (m_1 + m_2) and driven by mu_2 m_2.
    braking = (2.0 * friction[:, 0] - friction[:, 1]) * GRAVITY
    lower = -np.sign(speed) * speed**2 / (2.0 * braking)
    rough = friction[:, 0] > friction[:, 1]
    assert np.all(np.abs(slide[:, 0] - lower)[rough] <= np.abs(speed[rough]) * step)
    np.testing.assert_allclose(slide[~rough, 1], 0.0, atol=1e-9)


def test_a_fast_base_takes_the_lower_block_away() -> None:
    speed = np.array([3.0, -3.0])
    lanes = make_stacks(np.full((2, 2), 0.5), 0.25, friction=[0.6, 0.02])
    motions = velocity_steps(speed, np.zeros(2), np.full(2, 10.0))
    response = run(lanes, motions, SampleTimes(2.0, 0.05))
    assert np.all(response["outcome"] == Outcome.SLID_OFF)
    slide = response["peak_slide"][:, 1]
    assert np.all((slide > 0.5) & (slide < 0.502))
    assert np.all(response["step_count"] < 2.0 / XpbdSettings().time_step)


@pytest.mark.thorough
def test_more_sweeps_than_unrolled_give_the_same_physics() -> None:
    lanes, times = free_lanes(), SampleTimes(1.0, 0.01)
    few, many = (
        run(lanes, StillBase(9), times, XpbdSettings(substeps=6, iterations=sweeps))["rotation"]
        for sweeps in (8, 34)
    )
    # Of a single block 8 sweeps leave 0.36^8 of an impulse.
    assert np.max(np.abs(few - many)) <= 1e-4
    assert np.max(np.abs(few - many)) > 0.0


@pytest.mark.thorough
def test_a_mirrored_stack_responds_mirrored() -> None:
    lanes, motions = mixed()
    mirrored = dataclasses.replace(
        lanes, rotation_start=-lanes.rotation_start, offset=-lanes.offset
    )
    names = (
        *("acceleration_amplitude", "velocity_offset", "velocity_final"),
        *("velocity_step_start", "velocity_step_stop"),
    )
    back = dataclasses.replace(motions, **{name: -getattr(motions, name) for name in names})
    there = run_batch("xpbd", lanes, motions, MIXED_TIMES)
    response = run_batch("xpbd", mirrored, back, MIXED_TIMES)
    assert set(np.unique(there["outcome"])) >= {0, 1, Outcome.OVERTURNED}
    np.testing.assert_array_equal(there["rotation"], -response["rotation"])
    np.testing.assert_array_equal(there["residual_slide"], -response["residual_slide"])
    np.testing.assert_array_equal(there["outcome"], response["outcome"])


@pytest.mark.thorough
def test_a_stack_depends_on_no_other(unjudged: None) -> None:
    lanes, motions = mixed()
    whole = run_batch("xpbd", lanes, motions, MIXED_TIMES, workers=1, chunk_size=64)
    order = np.random.default_rng(0).permutation(64)
    height = lanes.height.copy()
    height[5, 1] = np.nan
    broken = dataclasses.replace(lanes, height=height)
    response = run_batch("xpbd", broken.take(order), motions.take(order), MIXED_TIMES, chunk_size=7)
    assert response["status"][order == 5] == Status.NONFINITE
    others = order != 5
    for name in LANE_FIELDS:
        np.testing.assert_array_equal(
            response[name][others], whole[name][order][others], err_msg=name
        )


def in_forms(blocks: int) -> tuple[Lanes, GroundMotions]:
    """Two packs of single blocks, or of stacks of three."""
    lanes, motions = mixed()
    if blocks == 1:
        lanes = make_lanes(np.linspace(0.2, 0.4, 64), 1.0)
    return lanes, motions


@pytest.mark.thorough
@pytest.mark.parametrize("blocks", [1, 3])
def test_forms_agree(blocks: int) -> None:
    lanes, motions = in_forms(blocks)
    packed = run_batch("xpbd", lanes, motions, MIXED_TIMES, form=Form.PACKED, workers=1)
    few, base = lanes.take(slice(0, 8)), motions.take(slice(0, 8))
    plain = run_batch("xpbd", few, base, MIXED_TIMES, form=Form.PLAIN, workers=1)
    # The compiler may fuse multiply-adds differently, and impacts magnify that.
    np.testing.assert_array_equal(packed["outcome"][:8], plain["outcome"])
    np.testing.assert_allclose(packed["peak_rotation"][:8], plain["peak_rotation"], atol=1e-6)


@pytest.mark.speed
@pytest.mark.parametrize("blocks", [1, 3])
def test_packed_kernel_is_vectorised(blocks: int) -> None:
    lanes, motions = in_forms(blocks)

    def cost(form: Form) -> float:
        part = slice(0, 64 if form is Form.PACKED else 8)
        few, base = lanes.take(part), motions.take(part)
        start = time.process_time()
        response = run_batch("xpbd", few, base, MIXED_TIMES, form=form, workers=1)
        return (time.process_time() - start) / float(response["step_count"].sum())

    for form in Form:
        cost(form)
    # A ratio within one run: without vector code the packed form is no faster.
    wide = any(flag.startswith("avx512f") for flag in cpu_vector_flags())
    require_gain(lambda: cost(Form.PLAIN), lambda: cost(Form.PACKED), 4.0 if wide else 2.5)


@pytest.mark.thorough
def test_single_precision_is_near_double() -> None:
    lanes, times = random_pairs(12), SampleTimes(0.3, 0.01)
    double, single = (
        run_batch("xpbd", lanes, at_rest(12), times, precision=p)["rotation"]
        for p in ("float64", "float32")
    )
    error = np.abs(single - double).max(axis=(1, 2))
    # float32 has 6e-8 of a metre in a gap; over a step of 2e-4 s that is 3e-4 m/s.
    assert np.all(error < 5e-3)
    assert np.all(error > 0.0)
