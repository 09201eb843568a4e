"""Rocking about a corner that sticks, as a polynomial in time.

With (X, Z) the lower corner from the centre of mass of a block of mass 1 that leans to +x, I its
inertia and a the acceleration of the base, the block obeys while that corner stays where it is

    omega' = (a Z - g X) / (I + X^2 + Z^2),   X' = omega Z,   Z' = -omega X.

Every Taylor coefficient of the three follows from lower ones (Leibniz's rule). The rotation is a
polynomial of degree 6, whose error is (p d)^6 / 6! of the angular velocity, p the frequency
parameter. The corner presses on the base with n = g - Z'' and pushes along it with f = a - X''. It
sticks while |f| <= friction n.
"""

import warp as wp

from warprock.kernels.event.block.contact import SOON, Block, Lever
from warprock.kernels.motion.kinds import LINEAR, Acceleration

NEWTON_STEPS = 7
"""Steps from the root of a parabola through the ends of the step. Two of them reach round-off. If
that root is far off, as it is of a block that has just lifted, some halvings come first."""


@wp.struct
class Curve:
    """A rotation [rad], or a velocity [m/s], in a step: Taylor coefficients in the time since."""

    c0: real
    c1: real
    c2: real
    c3: real
    c4: real
    c5: real
    c6: real


@wp.func
def rocking_series(
    block: Block, gravity: real, at: Lever, theta: real, w0: real, a: Acceleration
):  # fmt: skip
    """Taylor coefficients of a block that turns about its lower corner.

    Args:
        block: The block.
        gravity: [m/s^2].
        at: The corner.
        theta: Rotation [rad].
        w0: Angular velocity [rad/s].
        a: Acceleration of the base.

    Returns:
        The rotation; coefficient 2 of the corner, along the base and upwards.
    """
    # The term that is computed last is the last summand, so that the others need not wait for it.
    k, x0, z0, a0, a1 = block.inverse_pivot_inertia, at.x, at.z, a.a0, a.a1
    w1 = k * fused_less(gravity, x0, a0 * z0)
    x1 = w0 * z0
    z1 = -w0 * x0
    w2 = OVER_2 * k * fused_less(gravity, x1, fused(a0, z1, a1 * z0))
    x2 = OVER_2 * fused(w1, z0, w0 * z1)
    z2 = -OVER_2 * fused(w1, x0, w0 * x1)
    pull3 = a1 * z1
    if not LINEAR:
        pull3 = fused(a.a2, z0, pull3)
    w3 = OVER_3 * k * fused_less(gravity, x2, fused(a0, z2, pull3))
    x3 = OVER_3 * fused(w2, z0, fused(w1, z1, w0 * z2))
    z3 = -OVER_3 * fused(w2, x0, fused(w1, x1, w0 * x2))
    pull4 = a1 * z2
    if not LINEAR:
        pull4 = fused(a.a2, z1, fused(a.a3, z0, pull4))
    w4 = OVER_4 * k * fused_less(gravity, x3, fused(a0, z3, pull4))
    x4 = OVER_4 * fused(w3, z0, fused(w2, z1, fused(w1, z2, w0 * z3)))
    z4 = -OVER_4 * fused(w3, x0, fused(w2, x1, fused(w1, x2, w0 * x3)))
    pull5 = a1 * z3
    if not LINEAR:
        pull5 = fused(a.a2, z2, fused(a.a3, z1, fused(a.a4, z0, pull5)))
    w5 = OVER_5 * k * fused_less(gravity, x4, fused(a0, z4, pull5))
    curve = Curve(theta, w0, w1 * OVER_2, w2 * OVER_3, w3 * OVER_4, w4 * OVER_5, w5 * OVER_6)
    return curve, x2, z2


@wp.func
def mirror_acceleration(side: real, a: Acceleration) -> Acceleration:
    """The acceleration, reflected if the side is -1; up to the coefficient that a step reads."""
    return Acceleration(
        side * a.a0, side * a.a1, side * a.a2, side * a.a3, side * a.a4, side * a.a5, real(0.0),
        real(0.0), real(0.0),
    )  # fmt: skip


@wp.func
def mirror_curve(side: real, p: Curve) -> Curve:
    """A curve, reflected if the side is -1."""
    return Curve(
        side * p.c0, side * p.c1, side * p.c2, side * p.c3, side * p.c4, side * p.c5, side * p.c6
    )


@wp.func
def value_after(p: Curve, tau: real) -> real:
    """Value a time after the start of the step."""
    high = fused(tau, fused(tau, fused(tau, p.c6, p.c5), p.c4), p.c3)
    return fused(tau, fused(tau, fused(tau, high, p.c2), p.c1), p.c0)


@wp.func
def rate_after(p: Curve, tau: real) -> real:
    """First derivative a time after the start of the step."""
    high = fused(tau, fused(tau, real(6.0) * p.c6, real(5.0) * p.c5), real(4.0) * p.c4)
    return fused(tau, fused(tau, fused(tau, high, real(3.0) * p.c3), real(2.0) * p.c2), p.c1)


@wp.func
def zero_of(p: Curve, guess: real, d: real) -> real:
    """Time in (0, d] at which a curve is zero that is above zero at the start and below it at d.

    Newton's method inside a shrinking bracket.
    """
    tau, low, high = real(guess), real(0.0), real(d)
    for _ in range(NEWTON_STEPS):
        at = value_after(p, tau)
        low = wp.where(at > real(0.0), tau, low)
        high = wp.where(at > real(0.0), high, tau)
        tau = tau - at / rate_after(p, tau)
        tau = wp.where(tau >= low and tau <= high, tau, HALF * (low + high))
    return tau


@wp.func
def turning_point(p: Curve, d: real, omega1: real):
    """Rotation and time at which a block that turns back in a step of length d does so."""
    per = d / (p.c1 - omega1)
    secant = p.c1 * per
    rate = rate_after(p, secant)
    at = value_after(p, secant)
    late = rate * per
    return fused(HALF * rate, late, at), secant + late


@wp.func
def sticks_surely(block: Block, normal: real, along: real) -> bool:
    """Whether a corner pressed with a force per unit mass surely holds one along the base."""
    grip = block.friction * normal
    return grip - size(along) > SOON * grip and normal > real(0.0)
