"""`impulse`: convergence to Housner, friction, closed forms within its order, and its speed."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.blocks import errors_to_housner, free_lanes, make_lanes, sines
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines.launching import Form
from warprock.measure import bench
from warprock.model.motion import Control, GroundMotions, StillBase, Waveform, ricker_motions
from warprock.model.response import Outcome, SampleTimes
from warprock.running.batch import run_batch
from warprock.running.machine import core_count
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY


@pytest.mark.parametrize("control", list(Control))
def test_pulses_converge_to_housner_where_housner_holds(control: Control) -> None:
    # Sixteen pulses, so that the scatter of the impacts within their steps averages out. Under
    # displacement control they start and stop with a velocity step. Friction carries it; where the
    # pivot would have to pull the block down at the stop, the block hops and Housner does not hold.
    frequency = np.linspace(2.6, 4.4, 16)
    swing = 0.37 / (2.0 * np.pi * frequency) * GRAVITY
    size = {
        Control.DISPLACEMENT: swing / (2.0 * np.pi * frequency),
        Control.VELOCITY: swing,
        Control.ACCELERATION: swing * 2.0 * np.pi * frequency,
    }[control]
    lanes = make_lanes(np.full(16, 0.17), 1.0, friction=10.0)
    motions = sines(control, size, frequency, 1.0, start=0.1)
    times = SampleTimes(1.0, 0.01)
    found = []
    holds = np.ones(16, dtype=bool)
    for substeps in (20, 200):
        settings = ImpulseSettings(substeps=substeps)
        response = run_batch("impulse", lanes, motions, times, settings=settings)
        holds &= response["peak_slide"] < 1e-5
        found.append(errors_to_housner("impulse", lanes, motions, times, substeps=substeps))
    assert np.count_nonzero(holds) >= 6
    coarse, fine = (float(np.mean(error[holds])) for error in found)
    assert coarse <= 4e-3
    # A tenth of the step, a tenth of the error.
    assert fine <= coarse / 5.0


@pytest.mark.thorough
@pytest.mark.parametrize("waveform", [Waveform.COSINE, Waveform.RICKER])
def test_other_waveforms_are_followed(waveform: Waveform) -> None:
    lanes = make_lanes(np.full(2, 0.2), 1.0, friction=10.0)
    size, frequency = np.array([0.35, 0.4]) * GRAVITY, np.array([2.0, 2.2])
    control = [Control.ACCELERATION] * 2
    motions: GroundMotions = ricker_motions(control, size, frequency, np.array([0.0, 0.2]))
    if waveform is Waveform.COSINE:
        motions = sines(Control.ACCELERATION, size, frequency, 1.0, waveform, start=0.2)
    times = SampleTimes(6.0, 0.01)
    response = run_batch("housner", lanes, motions, times)
    assert np.all(response["peak_rotation"] > 0.02 * lanes.slenderness_angle)
    assert np.all(response["outcome"] != Outcome.OVERTURNED)
    # First order through some twenty impacts, as for sines.
    assert np.max(errors_to_housner("impulse", lanes, motions, times, substeps=200)) <= 1e-2


def test_rest_comes_when_housner_says() -> None:
    lanes, times = free_lanes(), SampleTimes(8.0)
    expected = run_batch("housner", lanes, StillBase(9), times)["rest_time"]
    late = []
    for substeps in (20, 200):
        settings = ImpulseSettings(substeps=substeps)
        response = run_batch("impulse", lanes, StillBase(9), times, settings=settings)
        assert np.all(response["outcome"] == Outcome.AT_REST)
        late.append(np.max(np.abs(response["rest_time"] - expected)))
    # The last swings that a step resolves have the speed g dt; they take a few hundred steps.
    assert late[0] <= 150.0 / (240.0 * 21.0)
    assert late[1] <= late[0] / 4.0


@pytest.mark.thorough
def test_more_sweeps_than_unrolled_give_the_same_physics() -> None:
    pulse = expand_lanes(load_case("single-sine-pulse"))
    times = SampleTimes(0.5)
    few, many = (
        run_batch(
            "impulse",
            pulse.lanes,
            pulse.motions,
            times,
            settings=ImpulseSettings(iterations=sweeps),
        )
        for sweeps in (10, 30)
    )
    # The paper, too, found no effect of the sweeps (Fig. 4.c).
    np.testing.assert_allclose(few["peak_rotation"], many["peak_rotation"], rtol=5e-3)


def test_collision_margin_and_erp_are_felt() -> None:
    lanes, times = free_lanes(), SampleTimes(2.0, 0.01)
    base = run_batch("impulse", lanes, StillBase(9), times)
    for other in (ImpulseSettings(collision_margin=1e-3), ImpulseSettings(erp=0.9)):
        response = run_batch("impulse", lanes, StillBase(9), times, settings=other)
        gap = np.abs(response["rotation"] - base["rotation"]).max(axis=1)
        assert np.all(gap / lanes.slenderness_angle <= 2e-2)
        assert np.max(gap) > 0.0


@pytest.mark.speed
@pytest.mark.skipif(core_count() < 2, reason="one core has no second worker to gain from")
def test_two_workers_share_the_work() -> None:
    found = 0.0
    for _ in range(10):
        one = bench.measure("impulse", 0.8, form=Form.PACKED, workers=1)
        two = bench.measure("impulse", 0.8, form=Form.PACKED, workers=2)
        found = max(found, two.block_steps_per_s / one.block_steps_per_s)
        # 1.7 on idle cores (warprock bench); a test machine may be busy with other work.
        if found >= 1.5:
            return
    pytest.fail(f"two workers / one = {found:.2f}")
