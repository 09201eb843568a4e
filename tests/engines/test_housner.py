"""`housner` against the SciPy oracle and against closed forms.

The oracle integrates to a relative tolerance of 1e-12 between events, `housner` to about the
same; a hundred events and the growth of a difference near the critical angle leave 1e-9.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared import closed_forms
from tests.shared.blocks import Array, free_lanes, make_lanes, sines, velocity_steps
from tests.shared.marks import first
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, StillBase, Waveform, ricker_motions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.oracle.block import OracleResponse, rock
from warprock.recordings import Record, record_motions
from warprock.running.batch import run_batch
from warprock.settings.engines import HousnerSettings
from warprock.units import GRAVITY

AGREEMENT = 1e-9
"""What is left between `housner` and the oracle, in slenderness angles."""

NEVER_SLIDES = 1e9
"""Friction of the slender blocks of closed forms, which leave sliding out."""

CLOSED_FORM = 1e-6
"""What `housner` promises against closed forms."""


def assert_follows_oracle(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, response: Response, limit: float
) -> list[OracleResponse]:
    """Every lane within `limit` of the oracle, relative to the slenderness angle.

    Returns:
        What the oracle answers, lane by lane.
    """
    oracles = [rock(lanes, motions, lane, times) for lane in range(lanes.lane_count)]
    for lane, oracle in enumerate(oracles):
        angle = lanes.slenderness_angle[lane]
        gap = np.max(np.abs(response["rotation"][lane] - oracle.rotation)) / angle
        assert gap <= limit, f"lane {lane}: {gap:.3g} of the slenderness angle"
        assert response["outcome"][lane] == oracle.outcome
        np.testing.assert_allclose(
            response["peak_rotation"][lane], oracle.peak_rotation, rtol=1e-6, atol=1e-12
        )
        np.testing.assert_allclose(response["peak_time"][lane], oracle.peak_time, atol=1e-6)
    return oracles


def test_nine_free_cases_follow_the_oracle() -> None:
    lanes = free_lanes()
    times = SampleTimes(5.0, 0.01)
    response = run_batch("housner", lanes, StillBase(9), times)
    assert np.all(response["status"] == Status.OK)
    oracles = assert_follows_oracle(lanes, StillBase(9), times, response, AGREEMENT)
    for lane, oracle in enumerate(oracles):
        # Both add the geometric series of the impacts that they leave out.
        np.testing.assert_allclose(response["rest_time"][lane], oracle.rest_time, atol=1e-8)
        np.testing.assert_allclose(response["energy_lost"][lane], oracle.energy_lost, rtol=1e-6)


def test_all_inputs_of_table_4_follow_the_oracle() -> None:
    pulse = expand_lanes(load_case("single-sine-pulse"))
    times = SampleTimes(2.0, 0.01)
    response = run_batch("housner", pulse.lanes, pulse.motions, times)
    assert_follows_oracle(pulse.lanes, pulse.motions, times, response, AGREEMENT)


def test_continuous_sines_follow_the_oracle() -> None:
    sine = expand_lanes(load_case("single-continuous-sine"))
    part = slice(0, None, 6)
    lanes, motions = sine.lanes.take(part), sine.motions.take(part)
    times = SampleTimes(5.0, 0.01)
    response = run_batch("housner", lanes, motions, times)
    assert_follows_oracle(lanes, motions, times, response, AGREEMENT)


@pytest.mark.thorough
@pytest.mark.parametrize("control", list(Control))
def test_ricker_pulses_follow_the_oracle(control: Control) -> None:
    frequency = np.array([1.0, 1.5])
    size = {
        Control.DISPLACEMENT: 0.25 * GRAVITY / (np.pi * frequency) ** 2,
        Control.VELOCITY: 0.25 * GRAVITY / (np.pi * frequency),
        Control.ACCELERATION: np.full(2, 0.35 * GRAVITY),
    }[control]
    motions = ricker_motions([control] * 2, size, frequency, np.array([0.0, 0.3]))
    lanes = make_lanes(np.full(2, 0.2), 1.0)
    # Long enough to leave the pulse far behind.
    times = SampleTimes(12.0, 0.02)
    response = run_batch("housner", lanes, motions, times)
    # The base would have to pull the block that overturns.
    pulled = control is Control.DISPLACEMENT
    first = Status.OUTSIDE_MODEL if pulled else Status.OK
    assert response["status"].tolist() == [first, Status.OK]
    assert np.all(response["peak_rotation"] > 0.01 * lanes.slenderness_angle)
    assert_follows_oracle(lanes, motions, times, response, AGREEMENT)


@pytest.mark.parametrize("control", [Control.VELOCITY, Control.ACCELERATION])
def test_cosine_pulses_follow_the_oracle(control: Control) -> None:
    amplitude = np.array([0.3, 0.4]) * (1.0 if control is Control.VELOCITY else GRAVITY)
    motions = sines(control, amplitude, 2.0, 1.25, Waveform.COSINE, start=0.1)
    lanes = make_lanes(np.full(2, 0.2), 1.0)
    times = SampleTimes(3.0, 0.02)
    response = run_batch("housner", lanes, motions, times)
    assert np.all(response["peak_rotation"] > 0.01 * lanes.slenderness_angle)
    assert_follows_oracle(lanes, motions, times, response, AGREEMENT)


@pytest.mark.parametrize("quantity", first(1, list(Control)[::-1]))
def test_records_follow_the_oracle(quantity: Control) -> None:
    time = 0.02 * np.arange(151)
    shape = np.sin(2.0 * np.pi * 1.7 * time) * np.exp(-0.4 * time)
    size = {
        Control.ACCELERATION: 0.4 * GRAVITY,
        Control.VELOCITY: 0.4,
        Control.DISPLACEMENT: 0.04,
    }[quantity]
    record = Record(
        name="made",
        interval=0.02,
        samples=size * shape,
        quantity=quantity,
        source="made here",
        licence="none",
        sha256="",
        file="made here",
    )
    motions = record_motions(
        [record],
        index=np.zeros(2, np.int64),
        scale=np.array([1.0, 1.3]),
        start=np.array([0.0, 0.25]),
    )
    lanes = make_lanes(np.full(2, 0.2), 1.0)
    times = SampleTimes(4.0, 0.02)
    response = run_batch("housner", lanes, motions, times)
    assert np.all(response["peak_rotation"] > 0.01 * lanes.slenderness_angle)
    assert_follows_oracle(lanes, motions, times, response, AGREEMENT)


def test_quarter_period_exact_and_linear() -> None:
    # The first impact ends the first quarter; it shows as a jump of the impact count.
    lanes = make_lanes(np.full(2, 0.5), 1.0, np.array([0.5, 0.1]))
    quarter = rocking.quarter_period(lanes.width, lanes.height, lanes.rotation_start)
    assert quarter[0] == pytest.approx(0.365313, abs=5e-7)
    # A thousandth of a slender block obeys the linear form.
    small = make_lanes(np.full(2, 0.001), 1.0, np.array([0.5, 0.1]))
    linear = closed_forms.linear_quarter_period(small.width, small.height, small.rotation_start)
    for block, expected in ((lanes, quarter), (small, linear)):
        for lane in range(2):
            for sign, count in ((-1.0, 0), (1.0, 1)):
                times = SampleTimes(float(expected[lane] * (1.0 + sign * CLOSED_FORM)))
                response = run_batch("housner", block, StillBase(2), times)
                assert response["impact_count"][lane] == count


def test_peaks_decay_by_the_closed_form() -> None:
    lanes = make_lanes(np.full(1, 0.3), 1.2, 0.6)
    response = run_batch("housner", lanes, StillBase(1), SampleTimes(8.0, 0.001))
    rotation = np.abs(response["rotation"][0])
    # Refined by a parabola through the three highest samples of a swing.
    middle = rotation[1:-1]
    top = np.flatnonzero((middle > rotation[:-2]) & (middle >= rotation[2:])) + 1
    below, at, above = rotation[top - 1], rotation[top], rotation[top + 1]
    peaks = at + (above - below) ** 2 / (16.0 * at - 8.0 * (below + above))
    expected = closed_forms.peak_decay(
        lanes.width[0], lanes.height[0], lanes.rotation_start[0], len(peaks)
    )
    assert len(peaks) >= 6
    # A parabola over 1 ms is exact to (p dt)^4 = 1e-10 of the peak.
    np.testing.assert_allclose(peaks[:6], np.ravel(expected)[1:7], rtol=CLOSED_FORM)


def overturns(lanes: Lanes, motions: GroundMotions, duration: float) -> Array:
    """Whether each lane overturns."""
    response = run_batch("housner", lanes, motions, SampleTimes(duration))
    assert np.all(response["status"] == Status.OK)
    return np.asarray(response["outcome"] == Outcome.OVERTURNED)


def test_single_velocity_step_overturns_at_its_limit() -> None:
    limit = closed_forms.overturning_velocity_step(0.3, 1.0)
    first = limit * np.array([1.0 - CLOSED_FORM, 1.0 + CLOSED_FORM, -1.0 - CLOSED_FORM])
    lanes = make_lanes(np.full(3, 0.3), 1.0, friction=NEVER_SLIDES)
    motions = velocity_steps(first, np.zeros(3), np.full(3, 50.0))
    np.testing.assert_array_equal(overturns(lanes, motions, 20.0), [False, True, True])


def test_second_velocity_step_after_the_impact_overturns_at_its_limit() -> None:
    limit = float(closed_forms.overturning_double_velocity_step(0.3, 1.0))
    # The first step swings the block up and back; the second, opposite one meets it just after
    # the impact, where it moves as the second step pushes.
    size = limit * np.array([1.0 - CLOSED_FORM, 1.0 + CLOSED_FORM])
    p = rocking.frequency_parameter(0.3, 1.0)
    angle = rocking.slenderness_angle(0.3, 1.0)
    speed = p**2 / GRAVITY * np.cos(angle) * size
    peak = angle - np.arccos(np.cos(angle) + 0.5 * (speed / p) ** 2)
    back = 2.0 * rocking.quarter_period(0.3, 1.0, peak)
    # A hundred-millionth after the impact, which shifts the limit by less than 1e-6.
    motions = velocity_steps(size, -size, back * (1.0 + 1e-8))
    lanes = make_lanes(np.full(2, 0.3), 1.0, friction=NEVER_SLIDES)
    np.testing.assert_array_equal(overturns(lanes, motions, 20.0), [False, True])


@pytest.mark.parametrize(
    ("cycles", "limit"),
    [
        (0.5, rocking.half_sine_overturning_amplitude),
        (1.0, rocking.one_cycle_sine_overturning_amplitude),
    ],
)
def test_slender_block_overturns_under_pulses_at_their_limit(cycles: float, limit) -> None:
    # The closed forms are of a slender block: alpha^2 = 1e-8 is the model difference.
    width = 1e-4
    ratio = np.array([2.0, 5.0])
    frequency = ratio * rocking.frequency_parameter(width, 1.0) / (2.0 * np.pi)
    for factor, falls in ((1.0 - CLOSED_FORM, False), (1.0 + CLOSED_FORM, True)):
        amplitude = factor * limit(ratio) * GRAVITY * width
        motions = sines(Control.ACCELERATION, amplitude, frequency, cycles)
        # Without impact: a restitution of zero leaves a block that came back at rest.
        lanes = make_lanes(np.full(2, width), 1.0, friction=NEVER_SLIDES, angular_restitution=1e-6)
        np.testing.assert_array_equal(overturns(lanes, motions, 12.0), falls)


def test_safe_gap_between_the_overturning_modes() -> None:
    # Linear block, eta = 0.9, one-cycle sine at w = 5 p: overturning with one impact from 3.0186
    # to 6.3181 times g alpha, safe from there to 7.1681, overturning without impact above
    # (computed limits for this input, to the digits printed; alpha^2 = 1e-6).
    width = 1e-3
    limits = np.array([3.0186, 6.3181, 7.1681])
    slack = np.array([-1e-4, 1e-4])
    amplitude = (limits[:, None] + slack).ravel() * GRAVITY * width
    frequency = 5.0 * float(rocking.frequency_parameter(width, 1.0)) / (2.0 * np.pi)
    lanes = make_lanes(np.full(6, width), 1.0, friction=NEVER_SLIDES, angular_restitution=0.9)
    motions = sines(Control.ACCELERATION, amplitude, frequency, 1.0)
    fell = overturns(lanes, motions, 15.0)
    np.testing.assert_array_equal(fell, [False, True, True, False, False, True])


def test_rest_rule_is_the_stated_one() -> None:
    # With a coarse rule the block stops after the impact whose next swing would stay below it.
    lanes = make_lanes(np.full(1, 0.3), 1.0, 0.5)
    ratio = 0.05
    response = run_batch(
        "housner", lanes, StillBase(1), SampleTimes(8.0), settings=HousnerSettings(ratio)
    )
    peaks = np.ravel(closed_forms.peak_decay(0.3, 1.0, lanes.rotation_start[0], 40))
    small = peaks / lanes.slenderness_angle[0] < ratio
    # Impact n is followed by swing n; the rule takes the deceleration of the upright block,
    # sin(alpha), the swing that of sin(alpha - theta): 2 alpha theta = 0.5 % at this size.
    assert abs(int(response["impact_count"][0]) - int(np.argmax(small))) <= 1
    assert response["outcome"][0] == Outcome.AT_REST
    fine = run_batch("housner", lanes, StillBase(1), SampleTimes(8.0))
    # The tail of left-out impacts is in the rest time: to first order in the rule's swing.
    assert response["rest_time"][0] == pytest.approx(fine["rest_time"][0], abs=2.0 * ratio)


def test_block_lifts_again_during_a_motion() -> None:
    # Weak pushes of a squat block, which comes to rest between them.
    lanes = make_lanes(np.full(1, 0.6), 0.8)
    frequency, cycles = 1.0, 2.0
    limit = float(rocking.uplift_acceleration(0.6, 0.8))
    motions = sines(Control.ACCELERATION, 1.05 * limit, frequency, cycles)
    response = run_batch("housner", lanes, motions, SampleTimes(3.0, 0.01))
    moving = np.abs(response["rotation"][0]) > 0.0
    starts = np.count_nonzero(np.diff(moving.astype(int)) == 1)
    assert starts == 4
    oracle = rock(lanes, motions, 0, SampleTimes(3.0, 0.01))
    gap = np.max(np.abs(response["rotation"][0] - oracle.rotation))
    assert gap <= AGREEMENT * lanes.slenderness_angle[0]


def test_pushes_that_hardly_lift_a_block_leave_it_at_rest() -> None:
    # The acceleration peaks at a sample, above the uplift acceleration by 1e-2 to 1e-15 of it, so
    # that the block lifts for milliseconds down to less than the time can resolve.
    excess = np.append(10.0 ** -np.arange(2.0, 16.0), 0.0)
    count = len(excess)
    lanes = make_lanes(np.full(count, 0.2), 1.0)
    limit = float(rocking.uplift_acceleration(0.2, 1.0))
    samples = limit * np.interp(
        np.arange(400.0), [0.0, 170.0, 171.0, 172.0, 399.0], [0, 0, 1, 0, 0]
    )
    record = Record(
        name="made",
        interval=0.01,
        samples=samples,
        quantity=Control.ACCELERATION,
        source="made here",
        licence="none",
        sha256="",
        file="made here",
    )
    motions = record_motions(
        [record], index=np.zeros(count, np.int64), scale=1.0 + excess, start=np.zeros(count)
    )
    response = run_batch("housner", lanes, motions, SampleTimes(3.0))
    assert np.all(response["status"] == Status.OK)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    # Pushed for the time t = 0.01 s x excess on either side of the peak, by no more than
    # q slope t with q = 3/(4 R) = 1.47/m and slope = 196 m/s^3, it rises by some 2 q slope t^3.
    assert np.all(response["peak_rotation"] <= 1e-3 * excess**3)
    assert response["uplift_time"][0] == pytest.approx(1.71 - 0.01 * (1.0 - 1.0 / 1.01), abs=1e-9)


@pytest.mark.parametrize("control", first(1, list(Control)))
def test_no_lane_stalls_at_the_extremes(control: Control) -> None:
    # Heights from 5 cm to 50 m, slenderness 0.3 to 20, pushes from 0.01 to 5 g, 0.1 to 50 Hz.
    count = 1024
    chance = np.random.default_rng(3)
    height = 10.0 ** chance.uniform(-1.3, 1.7, count)
    width = height / 10.0 ** chance.uniform(-0.5, 1.3, count)
    frequency = 10.0 ** chance.uniform(-1.0, 1.7, count)
    acceleration = 10.0 ** chance.uniform(-1.0, 1.7, count)
    lanes = make_lanes(
        width,
        height,
        np.where(chance.random(count) < 0.5, chance.uniform(-0.9999, 0.9999, count), 0.0),
        angular_restitution=chance.uniform(0.05, 1.0, count),
    )
    rate = 2.0 * np.pi * frequency
    size = {
        Control.DISPLACEMENT: acceleration / rate**2,
        Control.VELOCITY: acceleration / rate,
        Control.ACCELERATION: acceleration,
    }[control]
    response = run_batch(
        "housner", lanes, sines(control, size, frequency, 3.0, start=0.2), SampleTimes(5.0)
    )
    assert np.all(np.isin(response["status"], [Status.OK, Status.OUTSIDE_MODEL]))
    assert np.count_nonzero(response["outcome"] == Outcome.OVERTURNED) > 50


def test_push_at_the_very_limit_stalls_no_lane() -> None:
    ratio = 1.0 + np.array([-1e-9, -1e-15, 0.0, 1e-15, 1e-12, 1e-9, 1e-6])
    lanes = make_lanes(np.full(7, 0.2), 1.0)
    limit = float(rocking.uplift_acceleration(0.2, 1.0))
    motions = sines(Control.ACCELERATION, ratio * limit, 1.7, 2.0)
    response = run_batch("housner", lanes, motions, SampleTimes(2.0))
    assert np.all(response["status"] == Status.OK)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    # Above the limit for the part 2 sqrt(2 x 1e-6) of a radian, 0.3 ms: hardly a motion.
    assert np.all(response["peak_rotation"] < 1e-9 * lanes.slenderness_angle)
