"""`two-block` against the SciPy oracle, which shares no formula with it, and against limits.

Oracle and engine integrate to some 1e-12 rad between impacts; every impact of two blocks multiplies
what is left, on an average by less than two, so that a hundred of them leave nothing to compare.
Histories are held to 1e-7 rad while the impacts are few enough for that.
"""

import dataclasses
import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared import closed_forms
from tests.shared.blocks import at_rest, make_lanes, sines, velocity_steps
from tests.shared.marks import first
from warprock.engines import engine_class
from warprock.model.lanes import Lanes
from warprock.model.motion import (
    Control,
    GroundMotions,
    HarmonicMotions,
    Waveform,
)
from warprock.model.response import LANE_FIELDS, Outcome, Response, SampleTimes, Status
from warprock.model.scene import scene_kind
from warprock.oracle.pair import TwoBlockResponse, rock_two_blocks
from warprock.oracle.pair_mechanics import Pattern, StackMechanics, TwoBlocks
from warprock.recordings import Record, record_motions
from warprock.running.batch import run_batch
from warprock.settings.engines import TwoBlockSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

AGREEMENT = 1e-7
"""Between engine and oracle while impacts are few [rad]."""
PAIR = TwoBlocks(width=(0.2, 0.15), height=(0.6, 0.6), density=(128.16 / 0.12, 132.165 / 0.09))
"""Masses of 128.16 kg and 132.165 kg."""
CHAMFERED = TwoBlocks(width=(0.2, 0.15), height=(0.6, 0.6), chamfer=(0.005, 0.005))
HEAVY_BASE = TwoBlocks(width=(50.0, 0.15), height=(0.02, 0.6), density=(1e6, 1e3))
"""A lower block that nothing moves, a velocity step of the base by 1e-12 rad."""
STARTS = np.array([(0.01, 0.01), (0.0, 0.03), (0.03, -0.05), (0.05, 0.1), (-0.02, 0.04)])
"""Rotations from which every pattern and every kind of impact comes up [rad]."""
PULSES = [(4.0, 4.0), (4.0, 5.0), (5.0, 3.0), (5.0, 4.0), (6.5, 2.0)]
"""Frequencies [Hz] and amplitudes [mm] of displacement whose accelerations lift the stack."""


def stacks(blocks: TwoBlocks, starts: npt.ArrayLike = ((0.0, 0.0),)) -> Lanes:
    """Lanes of one stack, one a pair of rotations at the start [rad]."""
    start = np.array(starts, dtype=np.float64)

    def every(pair: tuple[float, float]) -> Array:
        return np.tile(np.asarray(pair, dtype=np.float64), (len(start), 1))

    return Lanes(
        width=every(blocks.width),
        height=every(blocks.height),
        depth=every(blocks.depth),
        density=every(blocks.density),
        friction=every((100.0, 100.0)),
        chamfer=every(blocks.chamfer),
        offset=every((0.0, 0.0)),
        rotation_start=start,
        angular_restitution=np.ones(len(start)),
    )


def run(lanes: Lanes, motions: GroundMotions, times: SampleTimes, **options: Any) -> Response:
    return run_batch("two-block", lanes, motions, times, **options)


def pulses(control: Control, picks: list[tuple[float, float]]) -> HarmonicMotions:
    """One-cycle sines of some displacements, by the displacement itself or by acceleration."""
    frequency, millimetres = np.array(picks).T
    rate = 2.0 * np.pi * frequency
    size = 1e-3 * millimetres * (1.0 if control is Control.DISPLACEMENT else rate**2)
    return sines(control, size, frequency, 1.0)


def assert_follows(
    response: Response, lane: int, oracle: TwoBlockResponse, limit: float = AGREEMENT
) -> None:
    """A lane is the oracle's, and flagged where the oracle saw a contact pull."""
    np.testing.assert_allclose(response["rotation"][lane], oracle.rotation, rtol=0.0, atol=limit)
    np.testing.assert_allclose(response["peak_rotation"][lane], oracle.peak_rotation, atol=limit)
    pulled = math.isfinite(oracle.pull_time) or oracle.odd_choice_count > 0
    assert response["status"][lane] == (Status.OUTSIDE_MODEL if pulled else Status.OK)
    assert response["outcome"][lane] == oracle.outcome
    np.testing.assert_allclose(response["energy_lost"][lane], oracle.energy_lost, rtol=1e-5)


def test_free_stacks_follow_the_oracle() -> None:
    times = SampleTimes(0.8, 0.01)
    motions = at_rest(len(STARTS))
    response = run(stacks(CHAMFERED, STARTS), motions, times)
    assert np.all(response["impact_count"] >= 4)
    for lane, start in enumerate(STARTS):
        first, second = start.tolist()
        oracle = rock_two_blocks(
            CHAMFERED, motions.segments(lane), times, rotation_start=(first, second)
        )
        assert_follows(response, lane, oracle)
        # Their rest rules end rows of impacts at thresholds of the chamfered and the full width.
        count = len(oracle.impact_times)
        assert abs(int(response["impact_count"][lane]) - count) <= 0.02 * count


@pytest.mark.parametrize(
    ("control", "picks"),
    # By displacement the base starts and ends with velocity steps.
    first(1, [(Control.DISPLACEMENT, [(4.0, 4.0), (5.0, 4.0)]), (Control.ACCELERATION, PULSES)]),
)
def test_pulses_follow_the_oracle(control: Control, picks: list[tuple[float, float]]) -> None:
    times = SampleTimes(0.8, 0.01)
    motions = pulses(control, picks)
    response = run(stacks(CHAMFERED, np.zeros((len(picks), 2))), motions, times)
    assert np.all(response["impact_count"] > 0)
    for lane in range(len(picks)):
        oracle = rock_two_blocks(CHAMFERED, motions.segments(lane), times)
        assert_follows(response, lane, oracle)
        np.testing.assert_allclose(response["peak_time"][lane], oracle.peak_time, atol=1e-6)
        # The oracle oversteps a smooth transition by 1e-9 s, as the engine does.
        assert response["uplift_time"][lane] == pytest.approx(oracle.pattern_times[1], abs=1e-9)


def some_record() -> GroundMotions:
    """A short velocity record, which the acceleration follows in straight lines."""
    time = 0.02 * np.arange(41)
    record = Record(
        name="made",
        interval=0.02,
        samples=0.25 * np.sin(8.0 * np.pi * time) * np.sin(np.pi * time / 0.8),
        quantity=Control.VELOCITY,
        source="made here",
        licence="none",
        sha256="",
        file="made here",
    )
    return record_motions(
        [record], index=np.zeros(1, np.int64), scale=np.ones(1), start=np.array([0.05])
    )


@pytest.mark.thorough
def test_a_record_follows_the_oracle() -> None:
    motions, times = some_record(), SampleTimes(1.0, 0.01)
    response = run(stacks(CHAMFERED), motions, times)
    assert response["peak_rotation"].min() > 1e-3
    assert_follows(response, 0, rock_two_blocks(CHAMFERED, motions.segments(0), times))


def test_histories_end_at_rest_and_lose_what_they_had() -> None:
    lanes = stacks(CHAMFERED, STARTS)
    response = run(lanes, at_rest(len(STARTS)), SampleTimes(12.0, 0.05))
    oracle = StackMechanics(CHAMFERED)
    flat = oracle.potential_energy(Pattern(0, 0), np.zeros(2))
    for lane, start in enumerate(STARTS):
        pattern = Pattern(int(np.sign(start[0])), int(np.sign(start[1] - start[0])))
        had = oracle.potential_energy(pattern, start) - flat
        # A thousand swings, each to 1e-12 rad, and gravity's round-off on 10 N m.
        assert response["energy_lost"][lane] == pytest.approx(had, rel=1e-8)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    assert np.all(response["status"] == Status.OK)
    assert np.all(response["rotation"][:, :, -1] == 0.0)
    assert np.all(response["rest_time"] < 5.0)
    assert not response["residual_slide"].any()


def limits(control_free: float, blocks: TwoBlocks, block: int) -> list[tuple[Lanes, GroundMotions]]:
    """Scenes of one stack: released with one or both blocks turned, pushed, and stepped."""
    turned = (control_free, control_free) if block == 0 else (0.0, control_free)
    return [
        (stacks(blocks, [turned]), at_rest(1)),
        (stacks(blocks), sines(Control.ACCELERATION, 5.0, 3.0, 2.0)),
        (stacks(blocks), velocity_steps(np.array([0.2]), np.zeros(1), np.ones(1))),
    ]


@pytest.mark.parametrize(
    ("blocks", "block", "size", "limit"),
    [
        # A thin plate that stays glued, so that the stack is one block.
        (TwoBlocks(width=(0.3, 0.3), height=(1.05, 0.05)), 0, (0.3, 1.1), 1e-9),
        # A plate of 1e-7 of the mass, at the top; a few impacts make 1e-5 of it.
        (TwoBlocks(width=(0.3, 0.3), height=(1.0, 1e-7)), 0, (0.3, 1.0), 2e-6),
        # A lower block that nothing moves.
        (HEAVY_BASE, 1, (0.15, 0.6), 1e-9),
    ],
)
def test_limits_are_single_blocks(
    blocks: TwoBlocks, block: int, size: tuple[float, float], limit: float
) -> None:
    times = SampleTimes(5.0, 0.01)
    for lanes, motions in limits(0.1, blocks, block):
        response = run(lanes, motions, times)
        angle = math.atan2(*size)
        single = make_lanes(*size, lanes.rotation_start[0, block] / angle)
        wanted = run_batch("housner", single, motions, times)
        history = response["rotation"][0, block]
        np.testing.assert_allclose(history, wanted["rotation"][0], rtol=0.0, atol=limit)
        assert np.abs(history).max() > 0.005
        peak_time = response["peak_time"][0, block]
        assert peak_time == pytest.approx(wanted["peak_time"][0], abs=1e-5)


def test_the_upper_block_falls_like_a_single_one() -> None:
    motions, times = sines(Control.ACCELERATION, 8.0, 1.0, 1.0), SampleTimes(1.5, 0.01)
    response = run(stacks(HEAVY_BASE), motions, times)
    single = run_batch("housner", make_lanes(0.15, 0.6), motions, times)
    assert response["outcome"][0] == single["outcome"][0] == Outcome.OVERTURNED
    assert response["peak_rotation"][0, 1] == pytest.approx(0.5 * math.pi, rel=1e-15)
    assert response["peak_time"][0, 1] == pytest.approx(single["peak_time"][0], abs=1e-8)
    assert abs(response["rotation"][0, 1, -1]) == pytest.approx(0.5 * math.pi, rel=1e-15)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_accelerations_that_lift(side: float) -> None:
    (m1, m2), (h1, h2) = CHAMFERED.mass, (0.5 * h for h in CHAMFERED.height)
    arm = CHAMFERED.ground_half_width * (m1 + m2)
    whole = arm / (m1 * h1 + m2 * (2 * h1 + h2))
    # Just above the limit a block lands before it has turned by more than round-off.
    factor = np.array([1.0 - 1e-9, 1.0 + 1e-9, 1.01])
    for blocks, ratio, block in ((CHAMFERED, whole, 0), (HEAVY_BASE, 0.25, 1)):
        # A cosine is largest where it starts.
        size = side * factor * ratio * GRAVITY
        motions = sines(Control.ACCELERATION, size, 0.5, 0.1, Waveform.COSINE)
        response = run(stacks(blocks, np.zeros((3, 2))), motions, SampleTimes(0.1))
        assert response["outcome"][0] == Outcome.AT_REST
        assert math.isnan(response["uplift_time"][0])
        assert list(response["uplift_time"][1:]) == [0.0, 0.0]
        turned = response["peak_rotation"][2] > 1e-5
        assert list(turned) == [block == 0, True]


def mixed(count: int = 67) -> tuple[Lanes, HarmonicMotions]:
    """Stacks of many sizes, some released, that rest, rock and fall under pulses."""
    chance = np.random.default_rng(5)
    blocks = chance.uniform(0.1, 0.5, (count, 2)), chance.uniform(0.2, 1.0, (count, 2))
    start = np.where(chance.random((count, 1)) < 0.5, chance.uniform(-0.1, 0.1, (count, 2)), 0.0)
    lanes = dataclasses.replace(
        stacks(CHAMFERED, start),
        width=blocks[0],
        height=blocks[1],
        density=chance.uniform(500.0, 3000.0, (count, 2)),
    )
    size, frequency = chance.uniform(1.0, 8.0, count), chance.uniform(1.0, 6.0, count)
    return lanes, sines(Control.ACCELERATION, size, frequency, 1.5, start=0.1)


MIXED_TIMES = SampleTimes(1.0, 0.05)


def test_lane_does_not_depend_on_batch_chunk_workers_or_place() -> None:
    lanes, motions = mixed()
    whole = run(lanes, motions, MIXED_TIMES, workers=1, chunk_size=lanes.lane_count)
    assert set(whole["outcome"]) == {Outcome.AT_REST, Outcome.ROCKING, Outcome.OVERTURNED}
    assert whole["rotation"].shape == (lanes.lane_count, 2, len(MIXED_TIMES.times))
    order = np.random.default_rng(0).permutation(lanes.lane_count)
    others = [
        run(lanes, motions, MIXED_TIMES, workers=2, chunk_size=7),
        run(lanes.take(order), motions.take(order), MIXED_TIMES),
    ]
    for name, values in whole.fields.items():
        np.testing.assert_array_equal(values, others[0][name], err_msg=name)
        np.testing.assert_array_equal(values[order], others[1][name], err_msg=name)
    alone = run(lanes, motions, SampleTimes(MIXED_TIMES.duration))
    for name in LANE_FIELDS:
        np.testing.assert_array_equal(whole[name], alone[name], err_msg=name)


def test_mirrored_scene_gives_mirrored_response() -> None:
    lanes, motions = mixed()
    mirrored = dataclasses.replace(lanes, rotation_start=-lanes.rotation_start)
    names = ("acceleration_amplitude", "velocity_offset", "velocity_final")
    back = dataclasses.replace(motions, **{name: -getattr(motions, name) for name in names})
    response, there = run(mirrored, back, MIXED_TIMES), run(lanes, motions, MIXED_TIMES)
    np.testing.assert_array_equal(response["rotation"], -there["rotation"])
    for name in LANE_FIELDS:
        np.testing.assert_array_equal(response[name], there[name], err_msg=name)


def test_bad_lane_harms_no_neighbour(unjudged: None) -> None:
    lanes, motions = mixed()
    good = run(lanes, motions, MIXED_TIMES)
    bad = np.array([3, 20, 41])
    height, start = lanes.height.copy(), lanes.rotation_start.copy()
    height[3, 1], height[20, 0] = math.nan, math.inf
    start[41, 0] = math.nan
    broken = dataclasses.replace(lanes, height=height, rotation_start=start)
    response = run(broken, motions, MIXED_TIMES)
    assert np.all(response["status"][bad] == Status.NONFINITE)
    others = ~np.isin(np.arange(lanes.lane_count), bad)
    for name in LANE_FIELDS:
        np.testing.assert_array_equal(response[name][others], good[name][others], err_msg=name)


def extremes(count: int) -> Lanes:
    """Stacks from 3 cm to 10 m, slabs to columns, light on heavy and heavy on light, released."""
    chance = np.random.default_rng(11)
    height = 10.0 ** chance.uniform(-1.5, 1.0, (count, 2))
    width = height / 10.0 ** chance.uniform(-0.5, 1.0, (count, 2))
    least = np.arctan2(width, height).min(axis=1)[:, None]
    return dataclasses.replace(
        stacks(CHAMFERED, chance.uniform(-0.9, 0.9, (count, 2)) * least),
        width=width,
        height=height,
        density=10.0 ** chance.uniform(2.0, 4.0, (count, 2)),
        chamfer=np.zeros((count, 2)),
    )


@pytest.mark.parametrize(
    "precision", ["float64", pytest.param("float32", marks=pytest.mark.thorough)]
)
@pytest.mark.parametrize("control", [Control.ACCELERATION, Control.DISPLACEMENT])
def test_no_lane_stalls_at_the_extremes(control: Control, precision: str) -> None:
    # Pushes from 0.01 to 5 g, 0.3 to 30 Hz; every second lane starts flat.
    count = 400
    chance = np.random.default_rng(12)
    frequency = 10.0 ** chance.uniform(-0.5, 1.5, count)
    size = 10.0 ** chance.uniform(-1.0, 1.7, count)
    if control is Control.DISPLACEMENT:
        size = size / (2.0 * np.pi * frequency) ** 2
    lanes = extremes(count)
    flat = np.where(np.arange(count)[:, None] % 2 == 0, 0.0, lanes.rotation_start)
    response = run(
        dataclasses.replace(lanes, rotation_start=flat),
        sines(control, size, frequency, 3.0, start=0.2),
        SampleTimes(3.0),
        precision=precision,
    )
    assert np.all(np.isin(response["status"], [Status.OK, Status.OUTSIDE_MODEL]))
    assert np.all(np.isfinite(response["peak_rotation"]))


def test_no_energy_from_nothing() -> None:
    count = 300
    lanes = extremes(count)
    response = run(lanes, at_rest(count), SampleTimes(2.0))
    assert np.all(np.isin(response["status"], [Status.OK, Status.OUTSIDE_MODEL]))
    for lane in range(count):
        pairs = [tuple(getattr(lanes, key)[lane]) for key in ("width", "height", "depth")]
        oracle = StackMechanics(TwoBlocks(*pairs, tuple(lanes.density[lane])))
        start = lanes.rotation_start[lane]
        pattern = Pattern(int(np.sign(start[0])), int(np.sign(start[1] - start[0])))
        had = oracle.potential_energy(pattern, start)
        lost = response["energy_lost"][lane]
        assert lost >= 0.0
        if response["outcome"][lane] == Outcome.AT_REST:
            flat = oracle.potential_energy(Pattern(0, 0), np.zeros(2))
            # Round-off of m g z, and a thousand swings.
            assert lost == pytest.approx(had - flat, rel=1e-6, abs=1e-9 * had)
    assert np.count_nonzero(response["outcome"] == Outcome.AT_REST) > 30


def test_rest_rule_is_the_stated_one() -> None:
    # Left out are swings below the ratio times the slenderness angle: a hundredth of the first
    # swing has lost all but 1e-4 of the energy, and its impacts are the greater number.
    lanes, times = stacks(HEAVY_BASE, [(0.0, 0.1)]), SampleTimes(6.0)
    fine = run(lanes, at_rest(1), times)
    ratio = 1e-2
    coarse = run(lanes, at_rest(1), times, settings=TwoBlockSettings(ratio))
    single = closed_forms.peak_decay(0.15, 0.6, 0.1, 200)
    small = np.ravel(single) < ratio * math.atan2(0.15, 0.6)
    # The rule takes the deceleration of the upright block; the swing that of sin(alpha - theta).
    assert abs(int(coarse["impact_count"][0]) - int(np.argmax(small))) <= 1
    assert fine["impact_count"][0] > coarse["impact_count"][0]
    assert fine["outcome"][0] == coarse["outcome"][0] == Outcome.AT_REST


@pytest.mark.thorough
def test_single_precision_is_near_double() -> None:
    lanes, times = stacks(CHAMFERED, STARTS), SampleTimes(0.2, 0.01)
    double = run(lanes, at_rest(len(STARTS)), times)
    single = run(lanes, at_rest(len(STARTS)), times, precision="float32")
    gap = np.abs(single["rotation"] - double["rotation"]).max()
    # 1e-7 a step, of rates of 10 /s, and up to seven impacts.
    assert 0.0 < gap < 1e-4


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"offset": np.array([[0.0, 0.01]])}, "offset"),
        ({"friction": np.array([[0.1, 1.0]])}, "slides"),
    ],
)
def test_scenes_that_it_declines(change: dict[str, Array], words: str) -> None:
    engine = engine_class("two-block")
    lanes, motions = stacks(CHAMFERED), at_rest(1)
    assert engine.supports(scene_kind(lanes, motions, restitution_given=False)) is None
    other = dataclasses.replace(lanes, **change)
    reason = engine.supports(scene_kind(other, motions, restitution_given=False))
    assert reason is not None
    assert words in reason
    single = scene_kind(make_lanes(0.2, 1.0), motions, restitution_given=False)
    assert "single blocks" in str(engine.supports(single))
