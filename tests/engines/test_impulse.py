"""`impulse`: convergence to Housner, friction, closed forms within its order, and its speed."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared import closed_forms
from tests.shared.blocks import Array, free_lanes, make_lanes, sines, velocity_steps
from tests.shared.speed import require_gain
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines.launching import Form
from warprock.measure import bench
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, StillBase, Waveform, ricker_motions
from warprock.model.response import Outcome, SampleTimes, Status
from warprock.records import load_record, record_motions
from warprock.running.batch import run_batch
from warprock.running.machine import core_count, cpu_vector_flags
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY


def errors(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, settings: ImpulseSettings
) -> Array:
    """Largest |rotation - housner| / slenderness angle of each lane."""
    reference = run_batch("housner", lanes, motions, times)
    response = run_batch("impulse", lanes, motions, times, settings=settings)
    assert np.all(response["status"] == Status.OK)
    gap = np.abs(response["rotation"] - reference["rotation"]).max(axis=1)
    return np.asarray(gap / lanes.slenderness_angle)


def test_free_rocking_converges_to_housner_at_first_order() -> None:
    lanes, times = free_lanes(), SampleTimes(5.0, 0.01)
    substeps = np.array([6, 20, 63, 200])
    found = [errors(lanes, StillBase(9), times, ImpulseSettings(substeps=int(n))) for n in substeps]
    assert np.max(found[1]) <= 4e-3
    assert np.max(found[3]) <= 1e-3
    # Each impact falls somewhere inside its step, so one lane's error scatters about its trend;
    # the mean of nine lanes over a factor of 30 in the step shows the order.
    step = 1.0 / (240.0 * (substeps + 1.0))
    slope = np.polyfit(np.log(step), np.log(np.mean(found, axis=1)), 1)[0]
    assert 0.8 <= slope <= 1.3


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
        found.append(errors(lanes, motions, times, settings))
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
    assert np.max(errors(lanes, motions, times, ImpulseSettings(substeps=200))) <= 1e-2


@pytest.mark.thorough
def test_record_is_followed_in_time_and_size() -> None:
    record = load_record("ridgecrest-2019-ccc-090")
    lanes = make_lanes(np.full(2, 0.4), 2.0, friction=2.0)
    motions = record_motions(
        [record], index=np.zeros(2, np.int64), scale=np.array([0.6, 0.6]), start=np.zeros(2)
    )
    times = SampleTimes(22.0, 0.01)
    found = errors(lanes, motions, times, ImpulseSettings(substeps=200))
    response = run_batch("housner", lanes, motions, times)
    assert np.all(response["peak_rotation"] > 0.02 * lanes.slenderness_angle)
    # First order through some twenty impacts: a few per cent of the largest swing.
    assert np.max(found) <= 0.05 * np.max(response["peak_rotation"] / lanes.slenderness_angle)


def test_block_slides_by_the_closed_form() -> None:
    # Friction below tan(alpha): the block slides and does not rock. Under a velocity step v it
    # slides v^2 / (2 mu g), against the step of the base.
    friction = np.array([0.05, 0.1, 0.2])
    speed = np.array([0.3, -0.2, 0.4])
    lanes = make_lanes(np.full(3, 1.0), 1.0, friction=friction)
    motions = velocity_steps(speed, np.zeros(3), np.full(3, 10.0))
    response = run_batch("impulse", lanes, motions, SampleTimes(2.0))
    expected = -np.sign(speed) * speed**2 / (2.0 * friction * GRAVITY)
    # First order: the last step may be off by v dt.
    atol = np.abs(speed) / (240.0 * 21.0)
    assert np.all(np.abs(response["residual_slide"] - expected) <= atol)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    # The rotation stays below what the collision margin hides.
    assert np.all(response["peak_rotation"] < 2e-6 / lanes.width)
    np.testing.assert_allclose(
        response["energy_lost"],
        0.5 * lanes.density * lanes.depth * speed**2,
        rtol=2e-3,
    )


def test_sticking_block_does_not_slide() -> None:
    lanes = make_lanes(np.full(1, 0.2), 1.0, friction=1.0)
    motions = sines(Control.ACCELERATION, 0.25 * GRAVITY, 3.0, 1.0)
    response = run_batch("impulse", lanes, motions, SampleTimes(3.0))
    assert response["outcome"][0] != Outcome.OVERTURNED
    assert response["peak_rotation"][0] > 0.05 * lanes.slenderness_angle[0]
    # The pivot moves on an arc that the step follows along its tangent: (omega dt)^2 R a step.
    assert response["peak_slide"][0] < 1e-4


def test_quarter_period_within_a_step() -> None:
    lanes = make_lanes(np.full(3, 0.5), np.array([0.75, 1.0, 1.25]), 0.5)
    quarter = rocking.quarter_period(lanes.width, lanes.height, lanes.rotation_start)
    step = ImpulseSettings().time_step
    # The landing shows in the step that reaches the base, or in the one after.
    times = SampleTimes(1.0, step)
    response = run_batch("impulse", lanes, StillBase(3), times)
    below = np.argmax(response["rotation"] <= 1e-6, axis=1) * step
    assert np.all(np.abs(below - quarter) <= 2.0 * step)


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


def test_overturning_velocity_step_at_its_limit() -> None:
    limit = float(closed_forms.overturning_velocity_step(0.3, 1.0))
    settings = ImpulseSettings(substeps=200)
    # The step is felt over half a time step: the limit moves by about p dt = 1e-4 of itself.
    speed = limit * np.array([1.0 - 5e-4, 1.0 + 5e-4])
    lanes = make_lanes(np.full(2, 0.3), 1.0, friction=10.0)
    motions = velocity_steps(speed, np.zeros(2), np.full(2, 30.0))
    response = run_batch("impulse", lanes, motions, SampleTimes(5.0), settings=settings)
    np.testing.assert_array_equal(response["outcome"] == Outcome.OVERTURNED, [False, True])


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
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_packed_kernel_is_vectorised(precision: str) -> None:
    # A ratio within one run: without vector code the packed form is no faster than the plain one.
    expected = (
        {"float64": 8.0, "float32": 8.0} if _has_avx512() else {"float64": 3.0, "float32": 4.0}
    )

    def cost(form: Form) -> float:
        measured = bench.measure("impulse", 0.6, precision=precision, form=form)
        return measured.cpu_s_per_simulated_s

    require_gain(lambda: cost(Form.PLAIN), lambda: cost(Form.PACKED), expected[precision])


def _has_avx512() -> bool:
    return any(flag.startswith("avx512f") for flag in cpu_vector_flags())


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
