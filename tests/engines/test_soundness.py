"""Lanes whose numbers may not be used say so: energy from nowhere, numbers that are not finite."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from tests.shared.blocks import Array, at_rest, make_lanes, two_equal
from tests.shared.marks import first
from warprock.engines.decoding import respond
from warprock.engines.energy import stack_energy_held
from warprock.engines.soundness import BARRIER_SHARE, find_toppled_from_nothing
from warprock.measure.atlas_lanes import AtlasSize, stack_energy, stack_pairs
from warprock.measure.atlas_maps import at_step, at_stiffness
from warprock.model import rocking
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.response import (
    FIELDS,
    LANE_FIELDS,
    SOUND,
    USABLE,
    Outcome,
    Response,
    SampleTimes,
    Status,
)
from warprock.running.batch import run_batch
from warprock.settings.engines import DirectSettings, XpbdSettings, build_settings
from warprock.units import GRAVITY


def free(
    engine: str, lanes: Lanes, times: SampleTimes, settings: Any, precision: str = "float64"
) -> Response:
    motions = at_rest(lanes.lane_count)
    return run_batch(engine, lanes, motions, times, settings=settings, precision=precision)


def block(height: float, slenderness: float, start: float) -> Lanes:
    """A block that friction holds, let go from a part of its slenderness angle."""
    return make_lanes(height / slenderness, height, start, friction=10.0)


def two_blocks(height: float, mass_ratio: float, start: float, turned: str = "both") -> Lanes:
    """A stack of the atlas, let go from a part of the slenderness angle of its blocks."""
    lanes = stack_pairs(AtlasSize(points=2)).lanes.take(slice(0, 1))
    factor = math.sqrt(mass_ratio)
    turn = {"both": [1.0, 1.0], "upper": [0.0, 1.0], "against": [1.0, -1.0]}[turned]
    return dataclasses.replace(
        lanes,
        width=np.full((1, 2), height / 3.0),
        height=np.full((1, 2), height),
        density=2000.0 * np.array([[1.0 / factor, factor]]),
        rotation_start=start * np.array([turn]) / 3.0,
    )


@pytest.mark.parametrize(
    "precision", ["float64", pytest.param("float32", marks=pytest.mark.thorough)]
)
@pytest.mark.parametrize(
    ("height", "slenderness", "start"), [(0.05, 11.42, 0.03), (0.5, 20.0, 0.9999)]
)
def test_an_overturned_block_stays_at_a_right_angle(
    precision: str, height: float, slenderness: float, start: float
):
    # Long after, when what it would do has long left the numbers that there are.
    lanes, times = block(height, slenderness, start), SampleTimes(400.0, 0.07)
    response = free("xpbd", lanes, times, at_step(XpbdSettings(), 0.1), precision)
    assert response["outcome"][0] == Outcome.OVERTURNED
    rotation = np.abs(response["rotation"][0])
    fallen = int(np.argmax(rotation >= 0.5 * np.pi))
    np.testing.assert_array_equal(rotation[fallen:], 0.5 * np.pi)
    assert np.all(rotation[:fallen] < 0.5 * np.pi)
    # What it is let go from nearly overturns the second, which may well fall.
    # Its friction of 10 may slip in the fall, where the law of contact has several solutions.
    assert response["status"][0] in ((Status.UNSTABLE,) if start < 0.9 else SOUND)


@pytest.mark.parametrize("engine", ["impulse", "xpbd"])
@pytest.mark.parametrize("start", [1e-6, 0.03])
def test_a_step_of_a_tenth_of_a_second_throws_a_small_block_over_and_says_so(
    engine: str, start: float
):
    lanes = block(0.05, 20.0, start)
    settings = at_step(build_settings(engine, {}, "test"), 0.1)
    response = free(engine, lanes, SampleTimes(5.0), settings)
    assert response["status"][0] == Status.UNSTABLE
    fine = free(engine, lanes, SampleTimes(0.2), at_step(settings, 1e-4))
    assert fine["status"][0] == Status.OK


@pytest.mark.parametrize(
    ("engine", "mass_ratio", "start", "turned"),
    [
        pytest.param("xpbd", 720.0, 0.01, "against", marks=pytest.mark.thorough),
        pytest.param("xpbd", 1e4, 0.1, "upper", marks=pytest.mark.thorough),
        ("impulse", 720.0, 0.1, "both"),
        ("impulse", 1e4, 0.1, "both"),
        ("impulse", 1e4, 0.01, "upper"),
        pytest.param("impulse", 1e4, 0.01, "against", marks=pytest.mark.thorough),
    ],
)
def test_a_heavy_block_on_a_light_one_is_not_thrown_over_unnoticed(
    engine: str, mass_ratio: float, start: float, turned: str
):
    lanes = two_blocks(0.05, mass_ratio, start, turned)
    settings = at_step(build_settings(engine, {}, "test"), 1e-3)
    if turned == "against":
        settings = dataclasses.replace(settings, iterations=1)
    response = free(engine, lanes, SampleTimes(1.0), settings)
    assert response["status"][0] == Status.UNSTABLE
    even = free(engine, two_blocks(0.5, 1.0, start, turned), SampleTimes(1.0), settings)
    assert even["status"][0] == Status.OK


@pytest.mark.thorough
def test_round_off_that_adds_up_to_energy_is_seen():
    # Poses of a few metres have steps of 4e-7 m in float32, which a motion of 1e-6 s is below.
    lanes = make_lanes(0.5, 4.31736, np.array([1e-3, 0.03]), friction=10.0)
    settings = at_stiffness(at_step(XpbdSettings(), 1e-6), 1e6)
    response = free("xpbd", lanes, SampleTimes(0.208), settings, "float32")
    np.testing.assert_array_equal(response["status"], Status.UNSTABLE)
    exact = free("xpbd", lanes, SampleTimes(0.02), settings)
    np.testing.assert_array_equal(exact["status"], Status.OK)


@pytest.mark.parametrize("start", [1e-6, 0.03, 0.5])
@pytest.mark.parametrize("step", [0.1, 1e-3])
def test_the_account_of_direct_is_bounded_by_what_was_held(start: float, step: float):
    lanes = block(0.05, 20.0, start)
    response = free("direct", lanes, SampleTimes(5.0), at_step(DirectSettings(), step))
    held = rocking.energy(lanes.width, 0.05, lanes.depth, 2000.0, lanes.rotation_start, 0.0)
    lost = response["energy_lost"] / held
    if response["outcome"][0] == Outcome.AT_REST:
        # All of it, but for the way of a step, which may be longer than the way down.
        # Where it slips its friction of 10 leaves the law of contact several solutions.
        assert response["status"][0] in SOUND
        assert abs(lost[0] - 1.0) < (0.02 if step < 0.01 and start > 0.01 else 0.6)
    else:
        assert response["status"][0] == Status.UNSTABLE


def test_a_moment_of_direct_loses_nothing():
    # No impact yet; the step before the start once counted m (g step)^2 / 8, here 300 times this.
    lanes = make_lanes(0.5, 1.0, np.array([0.1, 0.5, -0.5]), friction=10.0)
    settings = at_step(DirectSettings(), 1e-3)
    lost = free("direct", lanes, SampleTimes(0.02), settings)["energy_lost"]
    before = lanes.mass * (GRAVITY * 1e-3) ** 2 / 8.0
    assert np.all(np.abs(lost) < before / 300.0)


@pytest.mark.thorough
def test_a_block_of_direct_at_rest_in_float32_gains_nothing():
    # Heights of 0.5 m have steps of 6e-8 m, a motion of 1e-4 m/s at the step of the settings: what
    # it won was once counted in every step, in all more than overturns the block.
    lanes = make_lanes(np.full(3, 0.05), 1.0, np.array([0.0, 0.01, 0.5]), friction=1.0)
    response = free("direct", lanes, SampleTimes(20.0), DirectSettings(), "float32")
    exact = free("direct", lanes, SampleTimes(20.0), DirectSettings())
    np.testing.assert_array_equal(response["status"], Status.OK)
    rise = 0.5 * (math.hypot(0.05, 1.0) - 1.0)
    weight = GRAVITY * lanes.mass
    gap = np.abs(response["energy_lost"] - exact["energy_lost"])
    assert np.all(gap < 0.02 * weight * rise)


def test_dem_beyond_its_stable_step_says_so():
    lanes = block(10.0, 20.0, 1e-3)
    settings = at_stiffness(at_step(build_settings("dem", {}, "test"), 0.1), 1e8)
    wild, calm = (
        free("dem", lanes, SampleTimes(2.0), dataclasses.replace(settings, step_safety=safety))
        for safety in (2.0, 0.2)
    )
    assert wild["status"][0] == Status.UNSTABLE
    assert calm["status"][0] == Status.OK
    assert calm["outcome"][0] != Outcome.OVERTURNED


def test_what_a_stack_holds_is_what_statics_says():
    lanes = stack_pairs(AtlasSize(points=3)).lanes
    expected = stack_energy(lanes)
    # Differences of heights, of which 1e-16 is round-off and 1e-4 what is left.
    np.testing.assert_allclose(stack_energy_held(lanes), expected, rtol=1e-9)
    one = block(1.0, 3.0, 0.4)
    single = rocking.energy(one.width, 1.0, one.depth, 2000.0, one.rotation_start, 0.0)
    np.testing.assert_allclose(stack_energy_held(as_stacks(one)), single, rtol=1e-12)


def barrier_on_a_grid(lanes: Lanes) -> float:
    """Least energy that takes a stack of two out of its well [J]: a path over a grid of states."""
    angles = np.linspace(-0.4, 0.4, 161)
    lower, upper = (each.ravel() for each in np.meshgrid(angles, angles, indexing="ij"))
    many = Lanes(
        **{name: np.repeat(each, len(lower), axis=0) for name, each in lanes.arrays.items()}
    )
    states = dataclasses.replace(many, rotation_start=np.stack([lower, upper], axis=1))
    energy = stack_energy_held(states).reshape(len(angles), -1)
    low, high = 0.0, float(energy.max())
    for _ in range(30):
        level = 0.5 * (low + high)
        low, high = (low, level) if _reaches_the_rim(energy <= level) else (level, high)
    return high


def _reaches_the_rim(open_states: np.ndarray) -> bool:
    """Whether a way over open states leads from the middle to the rim."""
    middle = open_states.shape[0] // 2
    wet = np.zeros_like(open_states)
    wet[middle, middle] = True
    while True:
        grown = wet.copy()
        grown[1:] |= wet[:-1]
        grown[:-1] |= wet[1:]
        grown[:, 1:] |= grown[:, :-1]
        grown[:, :-1] |= grown[:, 1:]
        grown &= open_states
        if np.array_equal(grown, wet):
            return bool(wet[0].any() or wet[-1].any() or wet[:, 0].any() or wet[:, -1].any())
        wet = grown


@pytest.mark.parametrize("mass_ratio", first(1, [20.0, 1.0, 0.05]))
@pytest.mark.parametrize(("offset", "upper_width"), [(0.0, 1.0), (0.15, 1.0), (-0.1, 0.6)])
def test_a_stack_needs_what_a_path_over_all_states_needs(
    mass_ratio: float, offset: float, upper_width: float
):
    lanes = two_blocks(1.0, mass_ratio, 0.0)
    width = lanes.width * [[1.0, upper_width]]
    lanes = dataclasses.replace(lanes, width=width, offset=lanes.width * [[0.0, offset]])
    least = barrier_on_a_grid(lanes)
    peak = np.array([[0.5 * np.pi, 0.0]])
    # A grid of 5 mrad finds the saddle to some hundredths of it.
    below, above = ((1.0 - BARRIER_SHARE) * least * f for f in (0.96, 1.04))
    assert find_toppled_from_nothing(lanes, np.array([below]), peak)[0]
    assert not find_toppled_from_nothing(lanes, np.array([above]), peak)[0]
    assert not find_toppled_from_nothing(lanes, np.array([below]), np.full((1, 2), 0.01))[0]
    slippery = dataclasses.replace(lanes, friction=np.array([[10.0, 0.01]]))
    assert not find_toppled_from_nothing(slippery, np.array([below]), peak)[0]


def test_a_stack_that_starts_beyond_its_well_may_fall():
    lanes = two_blocks(1.0, 1.0, 0.6)
    peak = np.full((1, 2), 0.5 * np.pi)
    # As one, two blocks overturn from half of the slenderness angle of each.
    assert not find_toppled_from_nothing(lanes, np.array([-1.0]), peak)[0]
    inside = dataclasses.replace(lanes, rotation_start=0.5 * lanes.rotation_start)
    assert find_toppled_from_nothing(inside, np.array([-1.0]), peak)[0]


def columns(count: int, blocks: int = 1) -> dict[str, Array]:
    """Lane fields as engines hand them on: those of blocks with a block axis."""
    return {
        name: np.zeros((count, blocks) if FIELDS[name].per_block else count) for name in LANE_FIELDS
    }


@pytest.mark.parametrize(
    "name", ["peak_rotation", "residual_slide", "peak_slide", "energy_lost", "rotation"]
)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_no_engine_answers_a_number_that_is_none(name: str, bad: float):
    single = make_lanes(np.full(5, 0.2), 1.0)
    for lanes, blocks in ((single, 1), (as_stacks(single), 1), (two_equal(single), 2)):
        given = columns(5, blocks)
        given["status"] = np.array([0, 0, Status.ITERATION_LIMIT, Status.OUTSIDE_MODEL, 0])
        given["rotation"] = np.zeros((5, blocks, 3))
        given[name][1:4] = bad
        found = respond("event", lanes, given, SampleTimes(1.0, 0.5))
        expected = [0, Status.NONFINITE, Status.ITERATION_LIMIT, Status.NONFINITE, 0]
        np.testing.assert_array_equal(found["status"], expected)
        assert np.isfinite(found[name][np.isin(found["status"], USABLE)]).all()


def test_times_that_never_came_are_no_fault():
    given = columns(2)
    given["rest_time"] = np.full(2, math.nan)
    found = respond("event", make_lanes(np.full(2, 0.2), 1.0), given, SampleTimes(1.0))
    np.testing.assert_array_equal(found["status"], Status.OK)
