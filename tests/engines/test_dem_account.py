"""`dem` below g tan(alpha): what springs lend a block, by a closed form; what it may not gain."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from tests.shared.blocks import make_lanes, sines, two_equal
from tests.shared.spatial_blocks import in_space, unmoved
from warprock.engines.dem import Dem
from warprock.engines.soundness import Account, unstable
from warprock.errors import InputError
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import Control, StillBase, Waveform
from warprock.model.response import Outcome, SampleTimes, Status
from warprock.model.stacking import uplift_ratio
from warprock.running.batch import run_batch
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY


def lent(height: float, stiffness: float, points: int) -> float:
    """Part b / h - a / g by which springs lower the acceleration that overturns at once [-].

    The least energy of a block that stands on the spring at one end, turned by a small angle t, is
    that of a rigid one, m g (b t - h t^2 / 2), less what the springs give: flat they hold
    m g d / 2, d = m g / (k A) their depth, on the end alone m g d / 2 x A / A_end, by which the
    centre lies deeper than over the rigid corner. A base that accelerates by a at once adds
    m a h t. No barrier is left once (b / h - a / g)^2 = (A / A_end - 1) d / h.
    """
    end = 0.5 / (points - 1)
    depth = 2000.0 * GRAVITY * height / stiffness
    return math.sqrt((1.0 / end - 1.0) * depth / (0.5 * height))


@pytest.mark.parametrize(
    ("width", "height", "stiffness"), [(0.2, 1.0, 1e8), (0.1, 0.7, 1e9), (1.0, 10.0, 1e9)]
)
def test_springs_overturn_a_block_below_g_tan_alpha_by_what_they_lend_it(
    width: float, height: float, stiffness: float
):
    settings = DemSettings(
        normal_stiffness=stiffness,
        shear_stiffness=30.0 * stiffness,
        subcontacts=2,
        stiffness_damping=0.0,
    )
    part = np.array([0.0, 0.5, 0.92, 1.08, 1.5, 2.0])
    lanes = make_lanes(np.full(6, width), height, friction=1.0)
    pull = GRAVITY * (width / height - part * lent(height, stiffness, 2))
    # Of so slow a cosine a run sees the sudden start alone.
    motions = sines(Control.ACCELERATION, pull, 0.005, 1.0, Waveform.COSINE)
    times = SampleTimes(2.0 * math.sqrt(height) + 3.0)
    response = run_batch("dem", lanes, motions, times, settings=settings)
    np.testing.assert_array_equal(response["status"], Status.OK)
    fell = response["outcome"] == Outcome.OVERTURNED
    # Small angles and a centre that follows at once: a twentieth of what is lent.
    np.testing.assert_array_equal(fell, [True, True, True, False, False, False])


def test_the_default_springs_lend_no_more_than_the_closed_form():
    part = np.linspace(0.0, 2.0, 41)
    lanes = make_lanes(np.full(41, 0.2), 1.0)
    pull = GRAVITY * (0.2 - part * lent(1.0, 1e9, 5))
    motions = sines(Control.ACCELERATION, pull, 0.005, 1.0, Waveform.COSINE)
    response = run_batch("dem", lanes, motions, SampleTimes(5.0))
    fell = response["outcome"] == Outcome.OVERTURNED
    # Dashpots and a centre that lags take some of it, never more than the half.
    assert 0.5 <= part[fell].max() <= 1.0
    np.testing.assert_array_equal(response["status"], Status.OK)


@pytest.mark.parametrize("stacked", [False, pytest.param(True, marks=pytest.mark.thorough)])
def test_what_overturns_below_g_tan_alpha_is_no_error_of_the_step(stacked: bool):
    # Three cycles of a sine of 0.8 to 0.99 of what lifts rigid blocks. What falls does so at a
    # quarter of the step, and the account, which knows what springs hold, finds nothing gained.
    rng = np.random.default_rng(5)
    height = rng.uniform(0.5, 2.0, 40)
    width = height / rng.uniform(3.0, 10.0, 40)
    lanes = make_lanes(width, height)
    lanes = two_equal(lanes) if stacked else lanes
    pull = rng.uniform(0.8, 0.99, 40) * GRAVITY * uplift_ratio(as_stacks(lanes)).min(axis=1)
    motions = sines(Control.ACCELERATION, pull, rng.uniform(0.3, 2.0, 40), 3.0)
    coarse, fine = (
        run_batch("dem", lanes, motions, SampleTimes(6.0), settings=DemSettings(step_safety=safety))
        for safety in (0.2, 0.05)
    )
    np.testing.assert_array_equal(coarse["status"], Status.OK)
    fell = coarse["outcome"] == Outcome.OVERTURNED
    assert fell.sum() >= 2
    assert (fell != (fine["outcome"] == Outcome.OVERTURNED)).sum() <= 1


def account(lanes: Lanes, supplied: float, returned: float) -> Account:
    """An account in parts of what overturns single blocks."""
    rise = 0.5 * (np.hypot(lanes.width, lanes.height) - lanes.height)
    barrier = GRAVITY * lanes.mass * rise
    return Account(
        np.full(1, 1e9), supplied * barrier, np.zeros(1), returned * barrier, np.zeros(1)
    )


def test_a_lane_that_overturns_on_less_than_it_takes_is_unstable():
    # The base supplied 0.8 of it and the contacts gave the rest: less than once what there was,
    # which the account of rigid contacts lets pass, as it does not know what springs hold.
    lanes = make_lanes(0.2, 1.0)
    peak = np.full(1, 0.5 * np.pi)
    for supplied, returned, expected in ((0.8, 0.2, True), (3.0, 0.2, False), (0.8, 0.05, False)):
        given = account(lanes, supplied, returned)
        found = unstable(lanes, given, peak, rigid=False, complete=True)
        assert found[0] == expected
        assert not unstable(lanes, given, peak, rigid=False)[0]


@pytest.mark.parametrize("density", [0.001, 0.024])
def test_a_lane_of_too_many_steps_is_refused(density: float):
    lanes = dataclasses.replace(make_lanes(np.full(3, 0.2), 1.0), density=np.full(3, 2000.0))
    lanes.density[1] = density
    times = SampleTimes(20.0)
    with pytest.raises(InputError, match=r"lane 1: got .* steps, must be at most 1e\+08 steps"):
        run_batch("dem", lanes, StillBase(3), times)


@pytest.mark.parametrize("spatial", [False, True])
def test_blocks_that_buckle_on_their_springs_are_refused(spatial: bool):
    # k A b^2 times 3/8 (five points) against m g h: 0.3 m x 100 m has 0.086 of it.
    width = 0.3
    lanes = make_lanes(np.full(2, width), np.array([1.0, 100.0]))
    lanes = in_space(lanes) if spatial else lanes
    stiffness = 0.375 * 1e9 * (0.5 * width) ** 2 / (2000.0 * 100.0 * GRAVITY * 50.0)
    reserve, _ = Dem().reserve(lanes)
    assert reserve[1] == pytest.approx(stiffness, rel=1e-9)
    motions = unmoved(2) if spatial else StillBase(2)
    with pytest.raises(InputError, match=r"lane 1: got 0\.086.*must be above 1: in dem"):
        run_batch("dem", lanes, motions, SampleTimes(1.0))
    # Where it just can stand it is not refused.
    height = math.sqrt(0.375 * 1e9 * (0.5 * width) ** 2 / (1000.0 * GRAVITY))
    tall = make_lanes(np.full(2, width), height * np.array([0.99, 1.01]))
    np.testing.assert_array_equal(Dem().reserve(tall)[0] > 1.0, [True, False])
