"""Closed forms that only tests need: what a rocking block and a spring do, from textbooks.

As in `warprock.model.rocking`, blocks are given by their FULL width and height [m], alpha is the
slenderness angle, p the frequency parameter, eta the angular restitution of an impact.

References:
    Housner, G. W. (1963). The behavior of inverted pendulum structures during earthquakes.
        Bulletin of the Seismological Society of America 53(2), 403-417.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.model.rocking import (
    frequency_parameter,
    slenderness_angle,
)
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Numbers = npt.ArrayLike


def _array(values: Numbers) -> Array:
    return np.asarray(values, dtype=np.float64)


def linear_quarter_period(width: Numbers, height: Numbers, rotation: Numbers) -> Array:
    """Time from release at a rotation to the first impact [s] of a slender (linear) block.

    (1/p) acosh(1 / (1 - theta_0 / alpha)).

    Args:
        width: Full width [m].
        height: Full height [m].
        rotation: Rotation at release [rad], 0 < |rotation| < slenderness angle.

    References:
        Housner (1963), period of free rocking.
    """
    angle = slenderness_angle(width, height)
    left = angle - np.abs(_array(rotation))
    # acosh(angle / left), without cancellation where the two are close.
    reach = 2.0 * np.arcsinh(np.sqrt(0.5 * (angle - left) / left))
    return np.asarray(reach / frequency_parameter(width, height))


def peak_decay(
    width: Numbers,
    height: Numbers,
    rotation: Numbers,
    count: int,
    angular_restitution: Numbers | None = None,
) -> Array:
    """Peaks |theta_n| of free rocking on a still base [rad], shape [..., count + 1], exact.

    Each impact leaves the part eta^2 of the energy, and the next peak has all of it:
    cos(alpha - theta_n) = cos(alpha) + eta^(2n) [cos(alpha - theta_0) - cos(alpha)].

    Args:
        width: Full width [m].
        height: Full height [m].
        rotation: Rotation at release [rad], below the slenderness angle to either side.
        count: Impacts; element n of the last axis is the peak after n impacts.
        angular_restitution: Ratio eta [-]; Housner's closed form by default.

    References:
        Housner (1963), decay of free rocking, before its linearisation.
    """
    angle = slenderness_angle(width, height)
    eta = 1.0 - 1.5 * np.sin(angle) ** 2
    if angular_restitution is not None:
        eta = _array(angular_restitution)
    turned = np.abs(_array(rotation))
    # cos(alpha - theta_0) - cos(alpha), without cancellation at small rotations.
    start = 2.0 * np.sin(angle - 0.5 * turned) * np.sin(0.5 * turned)
    kept = np.asarray(eta)[..., np.newaxis] ** (2 * np.arange(count + 1))
    lift = kept * start[..., np.newaxis]
    # sin(alpha) sin(theta) - cos(alpha) (1 - cos(theta)) = lift, solved for tan(theta / 2).
    sine, cosine = np.sin(angle)[..., np.newaxis], np.cos(angle)[..., np.newaxis]
    tangent = lift / (sine + np.sqrt(sine**2 - lift * (2.0 * cosine + lift)))
    return np.asarray(2.0 * np.arctan(tangent))


def uplift_friction(width: Numbers, height: Numbers) -> Array:
    """Friction coefficient below which a flat block slides before it lifts, tan(alpha) [-].

    References:
        Shenton, H. W. (1996). Criteria for initiation of slide, rock, and slide-rock rigid-body
            modes. Journal of Engineering Mechanics 122(7), 690-693.
    """
    return np.asarray(_array(width) / _array(height))


def velocity_step_friction(width: Numbers, height: Numbers) -> Array:
    """Friction coefficient that a velocity step of the base needs under a flat block [-].

    Without slip the block turns about a corner at w = 3 h V / (4 R^2). Its centre then moves at
    h w against the base and b w upwards, so the base gives it the impulses m (V - h w) along and
    m b w upwards; their ratio is (4 b^2 + h^2) / (3 b h), never below 4/3.

    Args:
        width: Full width [m].
        height: Full height [m].
    """
    b, h = _array(width), _array(height)
    return np.asarray((4.0 * b**2 + h**2) / (3.0 * b * h))


def angular_velocity_step(
    width: Numbers, height: Numbers, rotation: Numbers, velocity_step: Numbers
) -> Array:
    """Step of the angular velocity [rad/s] of a rocking block at a velocity step of its base.

    -(p^2 / g) cos(alpha - |theta|) dV: the equation of motion integrated over the step. A flat
    block leans away from the step by the same formula at theta = 0.

    Args:
        width: Full width [m].
        height: Full height [m].
        rotation: Rotation during the step [rad], positive towards +x.
        velocity_step: Step dV of the base velocity [m/s], positive towards +x.

    References:
        Housner (1963), equation of motion, integrated over an impulse.
    """
    left = slenderness_angle(width, height) - np.abs(_array(rotation))
    factor = frequency_parameter(width, height) ** 2 / GRAVITY
    return np.asarray(-factor * np.cos(left) * _array(velocity_step))


def overturning_velocity_step(width: Numbers, height: Numbers) -> Array:
    """Velocity step of the base above which a flat block overturns [m/s].

    The kinetic energy of the step equals the lift to unstable balance:
    V = 2 g sin(alpha / 2) / (p cos(alpha)).

    References:
        Housner (1963), overturning by an impulse, before its linearisation.
    """
    angle = slenderness_angle(width, height)
    return np.asarray(
        2.0 * GRAVITY * np.sin(0.5 * angle) / (frequency_parameter(width, height) * np.cos(angle))
    )


def overturning_double_velocity_step(width: Numbers, height: Numbers) -> Array:
    """Step V of the base which overturns a flat block if -V follows right after its impact [m/s].

    The first step comes back as eta times itself, the second one adds itself:
    V = (limit of one step) / (1 + eta).
    """
    angle = slenderness_angle(width, height)
    return np.asarray(overturning_velocity_step(width, height) / (2.0 - 1.5 * np.sin(angle) ** 2))


def contact_restitution(damping_ratio: Numbers) -> Array:
    """Ratio e of speeds after and before a blow on a spring with a dashpot that cannot pull [-].

    The contact ends when its force vanishes. With z the damping ratio and s = sqrt(|1 - z^2|):
    e = exp(-(z / s) (pi - atan2(2 z s, s^2 - z^2))) below critical damping, exp(-2) at it, and
    exp(-(z / s) ln((z + s) / (z - s))) beyond.

    Args:
        damping_ratio: z = beta w / 2 with w = sqrt(k / m) of the contact, >= 0.

    References:
        Schwager and Poeschel (2007), Granular Matter 9, 465-469.
    """
    z = np.asarray(damping_ratio, dtype=np.float64)
    s = np.sqrt(np.abs(1.0 - z**2))
    safe = np.where(s > 0.0, s, 1.0)
    swings = np.pi - np.arctan2(2.0 * z * s, 1.0 - 2.0 * z**2)
    # (z + s) / (z - s) = (z + s)^2, for the product of the two is one.
    creeps = 2.0 * np.log(np.where(z > 1.0, z + s, 1.0))
    angle = np.where(z < 1.0, swings, creeps) / safe
    return np.asarray(np.exp(-z * np.where(s > 0.0, angle, 2.0)))
