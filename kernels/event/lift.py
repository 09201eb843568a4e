"""When the base lets go of a block, body or stack that lies on it at rest.

It lies still while the acceleration a of the base stays below a bound. The bound is that of
friction, or the acceleration at which the base presses only one end of the face. The margin to it,
on the side s on which it is smaller, is called the lack. It is a polynomial in time,

    p(t) = bound(t) - s a(t),

given by its Taylor coefficients, as the acceleration is.

The base lets go of the body at the first zero of p, even if p is negative only for a moment. The
step ends there. The next step begins with p = 0, and its mean velocity decides what the body does.
So it ends where p is least or where p is zero again: the mean acceleration then exceeds its bound.
"""

import warp as wp

from warprock.kernels.event.block.begin import first_root
from warprock.kernels.motion.kinds import LINEAR, Acceleration, acceleration_at

NEWTON_STEPS = 4
"""Steps of Newton's method from the root of a parabola through the ends: they reach round-off."""

DEEPEST_STEPS = 2
"""Steps of Newton's method to a zero of the slope, from that of its secant."""

NEAR = real(1.0 / 32.0)
"""Part of a step within which the Taylor polynomial is right to round-off: (1 / 32)^9 / 9! where
the step is a radian of the motion. If the end lies farther away, the step is shortened by this part
of it, and the next step finds the end."""

TICK = by_precision(1.0e-15, 5.0e-7)
"""Four roundings of a time, relative: an event that is nearer has come, or no step would end."""

CREST = by_precision(1.0e-12, 1.0e-6)
"""Part of the bound by which a peak of the base acceleration must exceed it. A peak that equals the
bound to round-off lets nothing go. If a step ended at it, all later ones would end there, too."""

DOUBT = real(1.0e-3)
"""Part of the bound by which a least lack above zero still ends a step, if it is farther away than
NEAR, where the Taylor polynomial is not exact."""


@wp.func
def slope_after(p: Acceleration, tau: real) -> real:
    """First derivative of a lack a time later [m/s^3]."""
    high = fused(tau, real(8.0) * p.a8, real(7.0) * p.a7)
    high = fused(tau, fused(tau, high, real(6.0) * p.a6), real(5.0) * p.a5)
    high = fused(tau, fused(tau, high, real(4.0) * p.a4), real(3.0) * p.a3)
    return fused(tau, fused(tau, high, TWO * p.a2), p.a1)


@wp.func
def bend_after(p: Acceleration, tau: real) -> real:
    """Second derivative of a lack a time later [m/s^4]."""
    high = fused(tau, real(56.0) * p.a8, real(42.0) * p.a7)
    high = fused(tau, fused(tau, high, real(30.0) * p.a6), real(20.0) * p.a5)
    return fused(tau, fused(tau, fused(tau, high, real(12.0) * p.a4), real(6.0) * p.a3), TWO * p.a2)


@wp.func
def least_lack(p: Acceleration, d: real) -> real:
    """Time within d at which a lack is least that falls at first and rises at d [s]."""
    first, last = p.a1, slope_after(p, d)
    tau = d * first / (first - last)
    for _ in range(DEEPEST_STEPS):
        tau = larger(smaller(tau - slope_after(p, tau) / bend_after(p, tau), d), real(0.0))
    return tau


@wp.func
def crossing(p: Acceleration, d: real) -> real:
    """Time within d at which a lack is zero that has another sign at d than at first [s].

    Newton's method inside a shrinking bracket.
    """
    side = sign_of(p.a0)
    low, high = real(0.0), real(d)
    tau = first_root(side * p.a0, side * p.a1, side * acceleration_at(p, d), d)
    for _ in range(NEWTON_STEPS):
        at = acceleration_at(p, tau)
        before = side * at > real(0.0)
        low = wp.where(before, tau, low)
        high = wp.where(before, high, tau)
        tau = tau - at / slope_after(p, tau)
        tau = wp.where(tau >= low and tau <= high, tau, HALF * (low + high))
    return tau


@wp.func
def round_off(p: Acceleration, bound: real, time: real) -> real:
    """Lack at a time [s] that is round-off [m/s^2]."""
    return TICK * fused(size(p.a1), time, bound)


@wp.func
def held_time(p: Acceleration, bound: real, slack: real, d: real) -> real:
    """Longest step of a block at rest [s]; NEVER where nothing ends it within d.

    Args:
        p: What it lacks until the base lets it go.
        bound: Acceleration that lets it go [m/s^2]; zero where nothing holds it at all.
        slack: `round_off` of it [m/s^2].
        d: How far to look ahead [s].
    """
    zero = real(0.0)
    far = real(d)
    found = NEVER
    if not LINEAR:
        deepest = least_lack(p, d)
        least = acceleration_at(p, deepest) - wp.where(deepest > NEAR * d, DOUBT * bound, zero)
        dips = p.a1 < zero and slope_after(p, d) > zero and least < -CREST * bound
        far, found = wp.where(dips, deepest, d), wp.where(dips, deepest, NEVER)
    last = acceleration_at(p, far)
    crosses = (p.a0 > slack and last < zero) or (p.a0 < -slack and last > zero)
    if LINEAR:
        found = wp.where(crosses, -p.a0 / p.a1, found)
    else:
        found = wp.where(crosses, crossing(p, far), found)
        early = found > NEAR * d and found < NEVER
        found = wp.where(early, (real(1.0) - NEAR) * found, found)
    return wp.where(bound > zero, found, NEVER)
