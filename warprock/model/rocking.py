"""Closed forms of Housner's rocking block, in NumPy, for any array shape.

Blocks are given by their FULL width and height [m]; half dimensions appear inside formulas only.
With half width b and half height h:

    slenderness angle    alpha = atan(b / h)
    half diagonal        R^2 = b^2 + h^2
    frequency parameter  p^2 = 3 g / (4 R)
    angular restitution  eta = 1 - (3/2) sin^2(alpha)

Between impacts theta'' = p^2 sin(theta - alpha) for theta > 0 on a still base, whose energy
integral is theta'^2 / 2 = p^2 [cos(alpha - theta_0) - cos(alpha - theta)] from rest at theta_0.

References:
    Housner, G. W. (1963). The behavior of inverted pendulum structures during earthquakes.
        Bulletin of the Seismological Society of America 53(2), 403-417.
    Makris, N. and Konstantinidis, D. (2003). The rocking spectrum and the limitations of
        practical design methodologies. Earthquake Engineering and Structural Dynamics 32,
        265-289.
    Zhang, J. and Makris, N. (2001). Rocking response of free-standing blocks under cycloidal
        pulses. Journal of Engineering Mechanics 127(5), 473-483.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Numbers = npt.ArrayLike


@functools.cache
def _gauss_rule() -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on (-1, 1): for smooth integrands 64 reach round-off."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    return nodes, weights


_BISECTIONS = 100
"""Halvings of a bracket; more than enough to close it to neighbouring numbers."""


def _array(values: Numbers) -> Array:
    return np.asarray(values, dtype=np.float64)


def slenderness_angle(width: Numbers, height: Numbers) -> Array:
    """Critical angle alpha [rad] at which the still block stands in unstable balance.

    References:
        Housner (1963), geometry of the block.
    """
    return np.arctan2(_array(width), _array(height))


def half_diagonal(width: Numbers, height: Numbers) -> Array:
    """Distance R from the centre of mass to a base corner [m].

    References:
        Housner (1963), geometry of the block.
    """
    return 0.5 * np.hypot(_array(width), _array(height))


def frequency_parameter(width: Numbers, height: Numbers) -> Array:
    """Frequency parameter p = sqrt(3 g / (4 R)) [rad/s] of a homogeneous rectangle.

    References:
        Housner (1963), definition of p, with the moment of inertia 4/3 m R^2 about a corner.
    """
    return np.asarray(np.sqrt(3.0 * GRAVITY / (4.0 * half_diagonal(width, height))))


def angular_restitution(slenderness_angle: Numbers) -> Array:
    """Ratio eta of the angular velocities after and before an impact [-].

    It follows from the angular momentum about the new corner; <= 0 from sin^2(alpha) >= 2/3 on,
    where a block keeps no rotation.

    References:
        Housner (1963), loss of energy at an impact, whose r is the square of eta.
    """
    return np.asarray(1.0 - 1.5 * np.sin(_array(slenderness_angle)) ** 2)


def energy(
    width: Numbers,
    height: Numbers,
    depth: Numbers,
    density: Numbers,
    rotation: Numbers,
    angular_velocity: Numbers,
) -> Array:
    """Energy above the block's flat state at rest [J], seen from the base.

    (2/3) m R^2 theta'^2 + m g R [cos(alpha - |theta|) - cos(alpha)].

    Args:
        width: Full width [m].
        height: Full height [m].
        depth: Full depth [m].
        density: [kg/m^3].
        rotation: [rad].
        angular_velocity: [rad/s].

    References:
        Housner (1963), energy of free rocking.
    """
    mass = _array(density) * _array(width) * _array(height) * _array(depth)
    radius = half_diagonal(width, height)
    kinetic = (2.0 / 3.0) * mass * radius**2 * _array(angular_velocity) ** 2
    lifted = _lift(slenderness_angle(width, height), np.abs(_array(rotation)))
    return np.asarray(kinetic + mass * GRAVITY * radius * lifted)


def _lift(angle: Array, rotation: Array) -> Array:
    """cos(alpha - theta) - cos(alpha) [-], without cancellation at small rotations."""
    return np.asarray(2.0 * np.sin(angle - 0.5 * rotation) * np.sin(0.5 * rotation))


def quarter_period(width: Numbers, height: Numbers, rotation: Numbers) -> Array:
    """Time from release at a rotation to the first impact [s], exact.

    (1/p) times the integral over theta from 0 to theta_0 of 1 / sqrt(2 [cos(alpha - theta_0) -
    cos(alpha - theta)]). The substitution alpha - theta = d cosh(v), d = alpha - theta_0, the
    solution of the linear block, takes out the singularity at theta_0: with S(x) = sin(x) / x

        (1/p) integral from 0 to acosh(alpha / d) of dv / sqrt(S(d cosh^2(v/2)) S(d sinh^2(v/2))).

    Args:
        width: Full width [m].
        height: Full height [m].
        rotation: Rotation at release [rad], 0 < |rotation| < slenderness angle.

    References:
        Housner (1963), period of free rocking, before its linearisation.
    """
    angle, rate = slenderness_angle(width, height), frequency_parameter(width, height)
    return quarter_period_of(angle, rate, rotation)


def quarter_period_of(angle: Numbers, rate: Numbers, rotation: Numbers) -> Array:
    """As `quarter_period`, of a block by what Housner's equation knows of it.

    Args:
        angle: Slenderness angle [rad].
        rate: Frequency parameter [rad/s].
        rotation: Rotation at release [rad], 0 < |rotation| < slenderness angle.
    """
    angle = _array(angle)
    left = angle - np.abs(_array(rotation))
    end = _reach(angle, left)
    nodes, weights = _gauss_rule()
    half = 0.25 * end[..., np.newaxis] * (1.0 + nodes)
    one = np.sinc(left[..., np.newaxis] * np.cosh(half) ** 2 / np.pi)
    other = np.sinc(left[..., np.newaxis] * np.sinh(half) ** 2 / np.pi)
    integral = 0.5 * end * np.sum(weights / np.sqrt(one * other), axis=-1)
    return np.asarray(integral / _array(rate))


def _reach(angle: Array, left: Array) -> Array:
    """acosh(angle / left), without cancellation where the two are close."""
    return np.asarray(2.0 * np.arcsinh(np.sqrt(0.5 * (angle - left) / left)))


def uplift_acceleration(width: Numbers, height: Numbers) -> Array:
    """Base acceleration above which a flat block lifts, g tan(alpha) [m/s^2].

    References:
        Housner (1963), the first condition of overturning.
    """
    return np.asarray(GRAVITY * _array(width) / _array(height))


def impact_friction(
    width: Numbers, height: Numbers, angular_restitution: Numbers | None = None
) -> Array:
    """Friction coefficient that an impact without slip needs [-].

    The block comes in at w about the old corner and leaves at eta w about the new one: the base
    gives its centre the impulses m h w (1 - eta) along and m b w (1 + eta) upwards. With Housner's
    eta their ratio is 3 sin(alpha) cos(alpha) / (4 - 3 sin^2(alpha)), less than tan(alpha).

    Args:
        width: Full width [m].
        height: Full height [m].
        angular_restitution: Ratio eta [-]; Housner's closed form by default.
    """
    angle = slenderness_angle(width, height)
    eta = 1.0 - 1.5 * np.sin(angle) ** 2
    if angular_restitution is not None:
        eta = _array(angular_restitution)
    return np.asarray(np.abs(1.0 - eta) / ((1.0 + eta) * np.tan(angle)))


def half_sine_overturning_amplitude(frequency_ratio: Numbers) -> Array:
    """Amplitude a_p / (g alpha) [-] from which a half sine overturns a slender block.

    The linear block leaves at psi = asin(1/A) and overturns if the part of its motion that grows
    with exp(p t) is positive at the end of the pulse: with w = omega_p / p
    sqrt(A^2 - 1) + A exp(-(pi - psi) / w) = w. Housner's A = sqrt(1 + w^2) leaves out the
    exponential.

    Args:
        frequency_ratio: w = omega_p / p [-], > 0, angular frequency of the sine over p.

    References:
        Makris and Konstantinidis (2003), who correct Housner (1963).
    """

    def excess(amplitude: Array, ratio: Array) -> Array:
        wait = np.pi - np.arcsin(1.0 / amplitude)
        late = amplitude * np.exp(-wait / ratio)
        return np.asarray(np.sqrt(amplitude**2 - 1.0) + late - ratio)

    return _amplitude(excess, frequency_ratio)


def one_cycle_sine_overturning_amplitude(frequency_ratio: Numbers) -> Array:
    """Amplitude a_p / (g alpha) [-] from which one cycle of sine overturns without an impact.

    As `half_sine_overturning_amplitude`, with the second half of the pulse pulling back:
    sqrt(A^2 - 1) - A exp(-(2 pi - psi) / w) = w. Below it the block may still overturn after one
    impact, for which there is no elementary form.

    Args:
        frequency_ratio: w = omega_p / p [-], > 0, angular frequency of the sine over p.

    References:
        Zhang and Makris (2001), mode 2.
    """

    def excess(amplitude: Array, ratio: Array) -> Array:
        wait = 2.0 * np.pi - np.arcsin(1.0 / amplitude)
        late = amplitude * np.exp(-wait / ratio)
        return np.asarray(np.sqrt(amplitude**2 - 1.0) - late - ratio)

    return _amplitude(excess, frequency_ratio)


def _amplitude(excess: Callable[[Array, Array], Array], frequency_ratio: Numbers) -> Array:
    """Root >= 1 of a condition that grows with the amplitude, by bisection."""
    ratio = _array(frequency_ratio)
    low, high = np.ones_like(ratio), np.full_like(ratio, 2.0)
    while np.any(excess(high, ratio) < 0.0):
        high = np.where(excess(high, ratio) < 0.0, 2.0 * high, high)
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        above = excess(middle, ratio) > 0.0
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(0.5 * (low + high))
