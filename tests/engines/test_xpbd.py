"""`xpbd`: its order before an impact, its impacts, compliance, sticking, sweeps."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import at_rest, free_lanes, make_lanes, make_stacks, sines
from warprock.engines.energy import energy_held
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, StillBase
from warprock.model.response import SOUND, Outcome, Response, SampleTimes
from warprock.running.batch import run_batch
from warprock.settings.engines import XpbdSettings
from warprock.units import GRAVITY


def run(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, settings: XpbdSettings | None = None
) -> Response:
    """A run in which no lane fails."""
    response = run_batch("xpbd", lanes, motions, times, settings=settings)
    assert np.all(np.isin(response["status"], SOUND))
    return response


def test_before_the_first_impact_the_order_is_two() -> None:
    lanes = make_lanes(np.full(3, 0.5), np.array([0.75, 1.0, 1.25]), 0.9)
    quarter = rocking.quarter_period(lanes.width, lanes.height, lanes.rotation_start)
    times = SampleTimes(0.95 * float(np.min(quarter)), 0.01)
    reference = run_batch("housner", lanes, StillBase(3), times)["rotation"]
    coarse, fine = (
        np.abs(run(lanes, at_rest(3), times, settings)["rotation"] - reference).max()
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
    held = energy_held(lanes, lanes.rotation_start)
    errors = []
    for substeps in (20, 200):
        lost = np.zeros(5)
        for lane in range(5):
            some = slice(lane, lane + 1)
            times = SampleTimes(1.25 * float(quarter[lane]))
            response = run(lanes.take(some), at_rest(1), times, XpbdSettings(substeps=substeps))
            lost[lane] = response["energy_lost"][0] / held[lane]
        errors.append(np.abs(lost - (1.0 - eta**2)))
    # Gravity acts on the wrong side for up to a step: it turns g dt, against a speed of 1 m/s.
    assert np.max(errors[0]) <= 2.0 * GRAVITY * XpbdSettings().time_step
    assert np.mean(errors[1]) <= np.mean(errors[0]) / 5.0


def test_compliance_vanishes_at_first_order() -> None:
    lanes, times = free_lanes(), SampleTimes(2.5, 0.01)
    fine = XpbdSettings(substeps=100)
    rigid = run(lanes, at_rest(9), times, fine)
    compliance = np.array([1e-8, 1e-9, 3e-10])
    found = []
    for value in compliance:
        soft = run(lanes, at_rest(9), times, dataclasses.replace(fine, compliance=float(value)))
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


@pytest.mark.thorough
def test_more_sweeps_than_unrolled_give_the_same_physics() -> None:
    lanes, times = free_lanes(), SampleTimes(1.0, 0.01)
    few, many = (
        run(lanes, at_rest(9), times, XpbdSettings(substeps=6, iterations=sweeps))["rotation"]
        for sweeps in (8, 34)
    )
    # Of a single block 8 sweeps leave 0.36^8 of an impulse.
    assert np.max(np.abs(few - many)) <= 1e-4
    assert np.max(np.abs(few - many)) > 0.0
