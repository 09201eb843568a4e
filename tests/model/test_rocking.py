"""Closed forms of the rocking block against first principles, quadrature and integration."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from tests.shared import closed_forms
from warprock.model import rocking

GRAVITY = 9.81  # m/s^2, stated again here so that a changed constant is seen
ROUND_OFF = 1e-12  # relative; a few hundred operations at 2e-16 each

BLOCKS = [(0.17, 1.0), (0.5, 1.0), (1.0, 5.0), (0.9, 0.75)]  # full width, full height [m]


@pytest.mark.parametrize(("width", "height"), BLOCKS)
def test_geometry_takes_full_dimensions(width: float, height: float) -> None:
    b, h = width / 2.0, height / 2.0
    radius = math.sqrt(b * b + h * h)
    assert rocking.half_diagonal(width, height) == pytest.approx(radius, rel=ROUND_OFF)
    assert math.tan(rocking.slenderness_angle(width, height)) == pytest.approx(b / h, rel=ROUND_OFF)
    # p^2 = m g R / I about a corner, I = integral of r^2 over the rectangle.
    inertia = width * height * (width**2 + height**2) / 3.0
    expected = math.sqrt(width * height * GRAVITY * radius / inertia)
    assert rocking.frequency_parameter(width, height) == pytest.approx(expected, rel=ROUND_OFF)


def impact(width: float, height: float) -> tuple[float, float]:
    """Angular restitution and friction need from the impulses at the new corner.

    Unit mass; x along the base, y up; before the impact the block turns clockwise by one rad/s
    about the old (+x) corner and is flat; the impulse acts at the new (-x) corner.
    """
    b, h = width / 2.0, height / 2.0
    central = (width**2 + height**2) / 12.0
    # Unknown: spin after, impulse x, impulse y. A spin w and a lever l move the centre by w x l,
    # which is (-w l_y, w l_x); the old lever is (-b, h), the new one (b, h).
    spin_before = -1.0
    before = np.array([-spin_before * h, spin_before * -b])
    matrix = np.array(
        [
            [-h, -1.0, 0.0],  # -w h - before_x = j_x
            [b, 0.0, -1.0],  # w b - before_y = j_y
            [central, -h, b],  # central (w - w0) = (corner - centre) x j = -b j_y + h j_x
        ]
    )
    right = np.array([before[0], before[1], central * spin_before])
    spin, jx, jy = np.linalg.solve(matrix, right)
    return spin / spin_before, abs(jx / jy)


@pytest.mark.parametrize(("width", "height"), BLOCKS)
def test_impact_follows_from_the_impulse_at_the_new_corner(width: float, height: float) -> None:
    restitution, friction = impact(width, height)
    angle = rocking.slenderness_angle(width, height)
    assert rocking.angular_restitution(angle) == pytest.approx(restitution, rel=ROUND_OFF)
    assert rocking.impact_friction(width, height) == pytest.approx(friction, rel=ROUND_OFF)


def test_uplift_needs_what_balances_the_moments() -> None:
    # Horizontal inertia force times half height = weight times half width.
    assert rocking.uplift_acceleration(0.17, 1.0) * 0.5 == pytest.approx(GRAVITY * 0.085)
    assert closed_forms.uplift_friction(0.17, 1.0) == pytest.approx(
        rocking.uplift_acceleration(0.17, 1.0) / GRAVITY
    )


@pytest.mark.parametrize(("width", "height"), BLOCKS)
@pytest.mark.parametrize("ratio", [0.05, 0.5, 0.99, 0.999999])
def test_quarter_period_is_the_quadrature(width: float, height: float, ratio: float) -> None:
    angle = math.atan2(width, height)
    start = ratio * angle
    p = math.sqrt(3.0 * GRAVITY / (2.0 * math.hypot(width, height)))

    def slowness(x: float) -> float:
        # theta = start (1 - x^2) removes the singularity at the start. The difference of the
        # cosines is a product of sines, which loses no digits.
        gone = start * x * x
        speed = 4.0 * math.sin(angle - start + gone / 2.0) * math.sin(gone / 2.0)
        return 2.0 * start * x / math.sqrt(speed) if x > 0.0 else 0.0

    kinks = [math.sqrt(1.0 - ratio), 10.0 * math.sqrt(1.0 - ratio)]
    points = [k for k in kinks if k < 1.0]
    integral, bound = quad(slowness, 0.0, 1.0, points=points, epsabs=0.0, epsrel=1e-11, limit=500)
    assert bound < 1e-9 * integral
    # 1e-9: the quadrature's own bound.
    assert rocking.quarter_period(width, height, start) == pytest.approx(integral / p, rel=1e-9)


def test_quarter_periods_of_b2() -> None:
    start = 0.5 * rocking.slenderness_angle(0.5, 1.0)
    # Half a unit of the last digit of the published values.
    assert rocking.quarter_period(0.5, 1.0, start) == pytest.approx(0.365313, abs=5e-7)
    assert closed_forms.linear_quarter_period(0.5, 1.0, start) == pytest.approx(0.363011, abs=5e-7)


def test_linear_quarter_period_solves_the_linear_block() -> None:
    angle, p = rocking.slenderness_angle(0.17, 1.0), rocking.frequency_parameter(0.17, 1.0)
    time = closed_forms.linear_quarter_period(0.17, 1.0, 0.3 * angle)
    # theta'' = p^2 (theta - angle) from rest: angle - theta = 0.7 angle cosh(p t).
    assert angle - 0.7 * angle * np.cosh(p * time) == pytest.approx(0.0, abs=ROUND_OFF)


@given(
    height=st.floats(0.05, 50.0),
    slenderness=st.floats(1.5, 20.0),
    ratio=st.floats(1e-6, 0.9999),
)
def test_exact_and_linear_periods_agree_for_slender_blocks(
    height: float, slenderness: float, ratio: float
) -> None:
    width = height / slenderness
    start = ratio * math.atan2(width, height)
    exact = rocking.quarter_period(width, height, start)
    linear = closed_forms.linear_quarter_period(width, height, start)
    # sin(x) / x >= 1 - alpha^2/6 on the whole path bounds the ratio of the two.
    limit = 1.0 / (1.0 - math.atan2(width, height) ** 2 / 6.0)
    assert 1.0 - ROUND_OFF <= exact / linear <= limit + ROUND_OFF


@pytest.mark.parametrize(("width", "height"), [(0.17, 1.0), (0.5, 1.0)])
def test_peak_decay_keeps_the_energy_of_each_impact(width: float, height: float) -> None:
    angle = rocking.slenderness_angle(width, height)
    eta = rocking.angular_restitution(angle)
    peaks = closed_forms.peak_decay(width, height, 0.9 * angle, 6)
    assert peaks.shape == (7,)
    assert peaks[0] == pytest.approx(0.9 * angle, rel=ROUND_OFF)
    lifts = np.cos(angle - peaks) - np.cos(angle)
    # 1e-11: the cosines of this test cancel down to 1e-3 of themselves.
    assert lifts[1:] / lifts[:-1] == pytest.approx(np.full(6, eta**2), rel=1e-11)


def test_peak_decay_of_many_blocks_and_small_peaks() -> None:
    width = np.array([[0.17], [0.5]])
    start = np.array([0.1, 1e-9])
    peaks = closed_forms.peak_decay(width, 1.0, start, 3, angular_restitution=0.9)
    assert peaks.shape == (2, 2, 4)
    # Small amplitude: the lift is sin(alpha) theta, so each peak is eta^2 of the one before;
    # the next term is theta / (2 tan(alpha)) = 3e-9.
    assert peaks[:, 1, 1:] / peaks[:, 1, :-1] == pytest.approx(np.full((2, 3), 0.81), rel=1e-8)


def test_energy_is_potential_plus_kinetic() -> None:
    width, height, depth, density = 0.5, 1.0, 0.3, 2670.0
    mass = density * width * height * depth
    rotation, spin = 0.2, 0.7
    # Height of the centre of mass of the block turned about its corner.
    centre = 0.5 * height * math.cos(rotation) + 0.5 * width * math.sin(rotation)
    inertia = mass * (width**2 + height**2) / 3.0
    expected = mass * GRAVITY * (centre - 0.5 * height) + 0.5 * inertia * spin**2
    found = rocking.energy(width, height, depth, density, np.array([rotation, -rotation]), spin)
    assert found == pytest.approx([expected, expected], rel=1e-11)


def test_velocity_step_is_a_short_strong_acceleration() -> None:
    width, height, rotation, change = 0.5, 1.0, 0.2, 0.3
    angle, p = math.atan2(width, height), math.sqrt(3 * GRAVITY / (2 * math.hypot(width, height)))
    short = 1e-7

    def motion(_time: float, state: np.ndarray) -> list[float]:
        lean = angle - state[0]
        return [state[1], -(p**2) * (math.sin(lean) + change / short / GRAVITY * math.cos(lean))]

    end = solve_ivp(motion, (0.0, short), [rotation, 0.0], rtol=1e-10, atol=1e-14).y[:, -1]
    # Gravity and the way travelled add terms of the order of p^2 x 1e-7 s = 1e-6.
    assert closed_forms.angular_velocity_step(width, height, rotation, change) == pytest.approx(
        end[1], abs=5e-6
    )
    mirrored = closed_forms.angular_velocity_step(width, height, -rotation, -change)
    assert mirrored == -closed_forms.angular_velocity_step(width, height, rotation, change)


def overturns(width: float, height: float, spin: float) -> bool:
    """Whether a flat block overturns with an angular velocity, by integrating its motion."""
    angle, p = math.atan2(width, height), math.sqrt(3 * GRAVITY / (2 * math.hypot(width, height)))

    def motion(_time: float, state: np.ndarray) -> list[float]:
        return [state[1], -(p**2) * math.sin(angle - state[0])]

    end = solve_ivp(motion, (0.0, 20.0 / p), [0.0, spin], rtol=1e-10, atol=1e-12).y[0]
    return bool(np.max(end) > 1.1 * angle)


@pytest.mark.parametrize(("width", "height"), [(0.17, 1.0), (0.5, 1.0)])
def test_velocity_step_limits(width: float, height: float) -> None:
    single = closed_forms.overturning_velocity_step(width, height)
    double = closed_forms.overturning_double_velocity_step(width, height)
    eta, _ = impact(width, height)

    def kick(change: float) -> float:
        return float(-closed_forms.angular_velocity_step(width, height, 0.0, change))

    # 1e-6 to either side; the unstable balance decides by its sign alone.
    for factor, over in ((1.0 - 1e-6, False), (1.0 + 1e-6, True)):
        assert overturns(width, height, kick(factor * single)) is over
        assert overturns(width, height, (1.0 + eta) * kick(factor * double)) is over


def growing_part(amplitude: float, ratio: float, length: float) -> float:
    """Growing part of the linear block's motion at the end of a sine of `length` [rad].

    Time in 1/p, tilt in alpha: y = tilt - 1 + rate obeys y' = y + A sin(w t), y = -1 at uplift.
    """
    leave = math.asin(1.0 / amplitude) / ratio
    gathered, _ = quad(
        lambda t: amplitude * math.sin(ratio * t) * math.exp(leave - t),
        leave,
        length / ratio,
        epsabs=1e-13,
        epsrel=1e-13,
        limit=200,
    )
    return -1.0 + gathered


@pytest.mark.parametrize("ratio", [0.5, 1.0, 5.0, 12.0])
def test_pulse_limits_leave_no_growing_part(ratio: float) -> None:
    half = float(rocking.half_sine_overturning_amplitude(ratio))
    full = float(rocking.one_cycle_sine_overturning_amplitude(ratio))
    # 1e-11: the absolute error of the quadrature times the amplitude.
    assert growing_part(half, ratio, math.pi) == pytest.approx(0.0, abs=1e-11)
    assert growing_part(full, ratio, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-11)
    assert growing_part(1.01 * half, ratio, math.pi) > 0.0
    assert growing_part(1.01 * full, ratio, 2.0 * math.pi) > 0.0
    # Housner's own limit, without the exponential, is on the unsafe side.
    assert half < math.sqrt(1.0 + ratio**2)


def test_one_cycle_limit_at_the_published_frequency() -> None:
    assert rocking.one_cycle_sine_overturning_amplitude(5.0) == pytest.approx(7.1681, abs=5e-5)
    assert rocking.one_cycle_sine_overturning_amplitude([1.0, 5.0]).shape == (2,)
