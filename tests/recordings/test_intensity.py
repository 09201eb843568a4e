"""Intensity measures against closed forms, and response spectra against another integrator."""

import math

import numpy as np
import pytest
from scipy import signal

from tests.shared.marks import first
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.model.motion import Control
from warprock.recordings import Record, load_record
from warprock.recordings.intensity import block_measures, measures, spectral_accelerations

GRAVITY = 9.81


def record(
    samples: np.ndarray, interval: float, quantity: Control = Control.ACCELERATION
) -> Record:
    return Record("made", "made", quantity, interval, np.asarray(samples, dtype=float), "")


def test_a_step_of_acceleration() -> None:
    """a = 2 m/s^2 for 3 s: v = 2 t, d = t^2, Arias = pi 12 / (2 g), CAV = 6, D5-95 = 2.7 s."""
    found = measures(record(np.full(31, 2.0), 0.1))
    assert found.peak_acceleration == 2.0
    assert found.peak_velocity == pytest.approx(6.0)
    assert found.peak_displacement == pytest.approx(9.0)
    assert found.velocity_over_acceleration == pytest.approx(3.0)
    assert found.arias == pytest.approx(math.pi * 12.0 / (2.0 * GRAVITY))
    assert found.cumulative_velocity == pytest.approx(6.0)
    assert found.significant_duration == pytest.approx(2.7)
    assert (found.final_velocity, found.final_displacement) == pytest.approx((6.0, 9.0))


def test_a_triangle_that_changes_its_sign_between_samples() -> None:
    """a = 3 - 4 t from 0 to 2 s in one piece: zero at 3/4 s, v = 3 t - 2 t^2, v = 0 at 3/2 s."""
    found = measures(record(np.array([3.0, -5.0]), 2.0))
    assert found.peak_acceleration == 5.0
    assert found.peak_velocity == pytest.approx(2.0)  # |v(2)| = 2 is above v(3/4) = 9/8
    assert found.cumulative_velocity == pytest.approx((9.0 + 25.0) / 8.0)
    assert found.arias == pytest.approx(math.pi / (2 * GRAVITY) * (27.0 + 125.0) / 12.0)
    # d = 3/2 t^2 - 2/3 t^3 is largest where v = 0, not at an end.
    assert found.peak_displacement == pytest.approx(1.5 * 1.5**2 - 2.0 / 3.0 * 1.5**3)
    shorter = measures(record(np.array([3.0, -1.0]), 1.0))
    assert shorter.peak_velocity == pytest.approx(9.0 / 8.0)


def test_harmonic_motion() -> None:
    """a = A sin w t over 4 cycles, 400 samples a cycle: errors (2 pi / 400)^2 / 12 = 2e-5."""
    amplitude, frequency, cycles = 3.0, 2.0, 4
    w, length = 2.0 * math.pi * frequency, cycles / frequency
    time = np.linspace(0.0, length, 400 * cycles + 1)
    found = measures(record(amplitude * np.sin(w * time), time[1]))
    near = {"rel": 1e-4}
    assert found.peak_acceleration == pytest.approx(amplitude, **near)
    assert found.peak_velocity == pytest.approx(2.0 * amplitude / w, **near)
    assert found.final_velocity == pytest.approx(0.0, abs=1e-12)
    assert found.peak_displacement == pytest.approx(amplitude / w * length, **near)
    arias = math.pi / (2.0 * GRAVITY) * amplitude**2 * length / 2.0
    assert found.arias == pytest.approx(arias, **near)
    assert found.cumulative_velocity == pytest.approx(2.0 / math.pi * amplitude * length, **near)
    # 5 % is reached where t - sin(2 w t) / (2 w) = 0.05 length, and 95 % as long before the end.
    reached = np.interp(0.05 * length, time - np.sin(2.0 * w * time) / (2.0 * w), time)
    assert found.significant_duration == pytest.approx(length - 2.0 * reached, rel=1e-3)


def test_the_velocity_steps_of_a_velocity_record_count() -> None:
    """A base that jumps to 0.5 m/s, runs for 2 s and stops: no acceleration, but a velocity."""
    found = measures(record(np.full(5, 0.5), 0.5, Control.VELOCITY))
    assert found.peak_acceleration == 0.0
    assert found.velocity_over_acceleration == 0.0
    assert found.peak_velocity == 0.5
    assert found.peak_displacement == pytest.approx(1.0)
    assert found.significant_duration == 0.0
    # An undamped oscillator swings u = v / w after a step; after n periods the stop takes it off.
    whole = record(np.full(5, 0.5), 0.5, Control.VELOCITY)
    half = 2.0 / 1.5  # the stop comes after a period and a half and adds to the swing
    assert spectral_accelerations(whole, [2.0, half], 0.0) == pytest.approx(
        [math.pi * 0.5, 2.0 * 2.0 * math.pi / half * 0.5], rel=1e-5
    )


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.2])
def test_the_response_to_a_step_overshoots(damping: float) -> None:
    """Sa = a (1 + exp(-z pi / sqrt(1 - z^2))) where the step lasts longer than half a period."""
    sa = spectral_accelerations(record(np.full(101, 2.0), 0.05), [0.02, 0.3, 2.0], damping)
    over = math.exp(-damping * math.pi / math.sqrt(1.0 - damping**2))
    if damping == 0.0:
        # Behind the step the free swings of an undamped oscillator are up to twice the overshoot.
        assert np.all(sa >= 2.0 * (1.0 + over) * (1.0 - 1e-5))
        assert np.all(sa <= 4.0 * (1.0 + 1e-12))
    else:
        assert sa == pytest.approx(2.0 * (1.0 + over), rel=1e-5)


def test_resonance_grows_to_one_over_twice_the_damping() -> None:
    """60 cycles at the oscillator's own frequency: 1 - exp(-2 pi z 60) of A / (2 z)."""
    z, period = 0.05, 0.5
    time = np.arange(0.0, 60.0 * period, period / 400.0)
    wave = record(np.sin(2.0 * math.pi * time / period), time[1])
    (sa,) = spectral_accelerations(wave, [period], z)
    assert sa == pytest.approx(1.0 / (2.0 * z), rel=1e-3)


def test_stiff_oscillators_follow_the_ground() -> None:
    found = load_record("ridgecrest-2019-ccc-090")
    (sa,) = spectral_accelerations(found, [4e-3], 0.05)
    # A change of slope at the peak rings with a swing of T / (2 pi) x slope, damped by 5 %.
    slope = np.max(np.abs(np.diff(found.samples))) / found.interval
    assert abs(sa - found.peak_acceleration) < 4e-3 / (2.0 * math.pi) * slope


@pytest.mark.parametrize("period", first(1, [0.8, 0.2, 3.0]))
def test_a_spectrum_agrees_with_another_integrator(period: float) -> None:
    """`lsim` is exact too for a linear input, by the exponential of a matrix.

    Its peak of 200 samples a period is low by up to (2 pi / 400)^2 / 2 = 1.2e-4.
    """
    whole = load_record("ridgecrest-2019-ccc-090")
    part = record(whole.samples[1500:3501], whole.interval)
    parts = math.ceil(200.0 * part.interval / period)
    h, last = part.interval / parts, len(part.samples) - 1
    time = h * np.arange(last * parts + math.ceil(period / h))
    base = np.interp(time, part.interval * np.arange(last + 1), part.samples)
    base[last * parts + 1 :] = 0.0
    w = 2.0 * math.pi / period
    oscillator = signal.StateSpace(
        [[0.0, 1.0], [-w * w, -0.1 * w]], [[0.0], [-1.0]], np.eye(2), np.zeros((2, 1))
    )
    place = signal.lsim(oscillator, base, time)[1][:, 0]
    (sa,) = spectral_accelerations(part, [period], 0.05)
    assert sa == pytest.approx(w * w * np.max(np.abs(place)), rel=1.3e-4)


@pytest.mark.parametrize(("periods", "damping"), [([0.0], 0.05), ([-1.0], 0.05), ([1.0], 1.0)])
def test_a_spectrum_out_of_bounds_is_refused(periods: list[float], damping: float) -> None:
    with pytest.raises(ValueError, match="the damping ratio from 0 to below 1"):
        spectral_accelerations(record(np.ones(3), 0.1), periods, damping)


def test_groups_of_a_block() -> None:
    """Width 3 m, height 4 m: tan alpha = 3/4, R = 5/2 m, p = sqrt(3 g / 10)."""
    found = block_measures(measures(record(np.full(31, 2.0), 0.1)), 3.0, 4.0)
    assert found.acceleration_ratio == pytest.approx(2.0 / (0.75 * GRAVITY))
    assert found.velocity_ratio == pytest.approx(math.sqrt(0.3 * GRAVITY) * 6.0 / (0.75 * GRAVITY))


def test_every_lane_has_the_intensity_of_its_record() -> None:
    case = load_case("record-ridgecrest")
    inputs = expand_lanes(case).inputs
    found = measures(load_record("ridgecrest-2019-ccc-090"))
    assert found.peak_velocity == pytest.approx(0.4285, abs=5e-5)
    of_block = block_measures(found, 0.17, 1.0)
    scale = inputs["scale"].to_numpy()
    assert inputs["peak_velocity_m_s"].to_numpy() == pytest.approx(scale * found.peak_velocity)
    wanted = scale * of_block.velocity_ratio
    assert inputs["normalised_velocity"].to_numpy() == pytest.approx(wanted)
    wanted = scale * of_block.acceleration_ratio
    assert inputs["normalised_acceleration"].to_numpy() == pytest.approx(wanted)
