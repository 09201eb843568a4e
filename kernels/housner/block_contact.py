"""Housner's block between two events as Taylor series, and the friction that it needs.

The contact force on the block, over m R (mass, half diagonal R), follows from the motion of its
centre, which lies R (S, C), S = sin(phi), C = cos(phi), phi as in housner/block.py, from its
corner:

    along the base    f = a / R + S'',
    upwards           n = g / R + C'',

1 / R = (4/3) q and g / R = (4/3) p^2. Their Taylor coefficients are those of S and C, which the
series of the rotation needs anyhow. At rest f and n are a and g. The corner stays where it is while
n > 0 and friction >= |f| / n; the friction that a lane needs is the largest |f| / n of its run,
NEVER where n <= 0.

An impulse of the base, over m, is what the velocity of the centre gains, so

    at a velocity step dv of the base    along dv (1 - (3/4) C^2), upwards (3/4) S C dv,
    at an impact                         |along / upwards| = (1 - eta) / (1 + eta) / tan(alpha).

Where the block falls, its contact is not judged. It falls for certain once it turns outwards and
leans beyond its balance by more than the friction angle: every force that friction allows then
turns it further outwards. With a friction above 1 it counts as falling from 45 degrees on.
"""

import warp as wp

from warprock.kernels.motion.kinds import LINEAR, Acceleration
from warprock.kernels.shape.taylor import Polynomial

FOUR_THIRDS = real(4.0 / 3.0)


@wp.struct
class Force:
    """A contact force in a step: Taylor coefficients 0 to 6 of its parts, over a mass or m R.

    Attributes:
        n0 to n6: Upwards.
        f0 to f6: Along the base.
    """

    n0: real
    n1: real
    n2: real
    n3: real
    n4: real
    n5: real
    n6: real
    f0: real
    f1: real
    f2: real
    f3: real
    f4: real
    f5: real
    f6: real


if LINEAR:

    @wp.func
    def curved_term(a: real, c: real, rest: real) -> real:
        """The term a c of a base whose acceleration is not linear, and the rest of such terms."""
        return real(0.0)

else:

    @wp.func
    def curved_term(a: real, c: real, rest: real) -> real:
        """The term a c of a base whose acceleration is not linear, and the rest of such terms."""
        return fused(a, c, rest)


# In a sum that is fused, what is known last stands outermost: the rest of it need not wait. But q b
# is a product of its own: p^2 s in its place, early, would take registers that packed lanes lack.
@wp.func
def rocking_series(p2: real, q: real, pivot: real, theta: real, omega: real, a: Acceleration):
    """The rotation in a step, and the contact force over m R; xk = k theta_k, b = a cos(phi).

    `pivot` is the rotation at which the block stands upright on its corner, phi = theta - pivot.
    """
    x1, phi = omega, theta - pivot
    zero, s0, c0 = real(0.0), sine(phi), cosine(phi)
    x2 = fused(p2, s0, -q * (a.a0 * c0))
    s1, c1 = x1 * c0, -x1 * s0
    x3 = OVER_2 * fused(p2, s1, -q * fused(a.a0, c1, a.a1 * c0))
    s2 = OVER_2 * fused(x2, c0, x1 * c1)
    c2 = -OVER_2 * fused(x2, s0, x1 * s1)
    b2 = curved_term(a.a2, c0, zero)
    x4 = OVER_3 * fused(p2, s2, -q * fused(a.a0, c2, fused(a.a1, c1, b2)))
    s3 = OVER_3 * fused(x3, c0, fused(x1, c2, x2 * c1))
    c3 = -OVER_3 * fused(x3, s0, fused(x1, s2, x2 * s1))
    b3 = curved_term(a.a2, c1, curved_term(a.a3, c0, zero))
    x5 = OVER_4 * fused(p2, s3, -q * fused(a.a0, c3, fused(a.a1, c2, b3)))
    s4 = OVER_4 * fused(x4, c0, fused(x1, c3, fused(x2, c2, x3 * c1)))
    c4 = -OVER_4 * fused(x4, s0, fused(x1, s3, fused(x2, s2, x3 * s1)))
    b4 = curved_term(a.a2, c2, curved_term(a.a3, c1, curved_term(a.a4, c0, zero)))
    x6 = OVER_5 * fused(p2, s4, -q * fused(a.a0, c4, fused(a.a1, c3, b4)))
    s5 = OVER_5 * fused(x5, c0, fused(x1, c4, fused(x2, c3, fused(x4, c1, x3 * c2))))
    c5 = -OVER_5 * fused(x5, s0, fused(x1, s4, fused(x2, s3, fused(x4, s1, x3 * s2))))
    b5 = curved_term(
        a.a2, c3, curved_term(a.a3, c2, curved_term(a.a4, c1, curved_term(a.a5, c0, zero)))
    )
    x7 = OVER_6 * fused(p2, s5, -q * fused(a.a0, c5, fused(a.a1, c4, b5)))
    s6 = fused(x5, c1, fused(x3, c3, x4 * c2))
    s6 = OVER_6 * fused(x6, c0, fused(x1, c5, fused(x2, c4, s6)))
    c6 = fused(x5, s1, fused(x3, s3, x4 * s2))
    c6 = -OVER_6 * fused(x6, s0, fused(x1, s5, fused(x2, s4, c6)))
    b6 = curved_term(
        a.a2,
        c4,
        curved_term(
            a.a3, c3, curved_term(a.a4, c2, curved_term(a.a5, c1, curved_term(a.a6, c0, zero)))
        ),
    )
    x8 = OVER_7 * fused(p2, s6, -q * fused(a.a0, c6, fused(a.a1, c5, b6)))
    s7 = fused(x6, c1, fused(x3, c4, fused(x5, c2, x4 * c3)))
    s7 = OVER_7 * fused(x7, c0, fused(x1, c6, fused(x2, c5, s7)))
    c7 = fused(x6, s1, fused(x3, s4, fused(x5, s2, x4 * s3)))
    c7 = -OVER_7 * fused(x7, s0, fused(x1, s6, fused(x2, s5, c7)))
    b7 = curved_term(
        a.a4, c3, curved_term(a.a5, c2, curved_term(a.a6, c1, curved_term(a.a7, c0, zero)))
    )
    b7 = curved_term(a.a2, c5, curved_term(a.a3, c4, b7))
    x9 = OVER_8 * fused(p2, s7, -q * fused(a.a0, c7, fused(a.a1, c6, b7)))
    s8 = fused(x3, c5, fused(x6, c2, fused(x4, c4, x5 * c3)))
    s8 = fused(x8, c0, fused(x1, c7, fused(x2, c6, fused(x7, c1, s8))))
    c8 = fused(x3, s5, fused(x6, s2, fused(x4, s4, x5 * s3)))
    c8 = -fused(x8, s0, fused(x1, s7, fused(x2, s6, fused(x7, s1, c8))))
    b8 = curved_term(
        a.a5, c3, curved_term(a.a6, c2, curved_term(a.a7, c1, curved_term(a.a8, c0, zero)))
    )
    b8 = curved_term(a.a2, c6, curved_term(a.a3, c5, curved_term(a.a4, c4, b8)))
    b8 = fused(real(0.125) * a.a0, c8, fused(a.a1, c7, b8))
    x10 = OVER_9 * fused(p2 * real(0.125), s8, -q * b8)
    r = FOUR_THIRDS * q
    rotation = Polynomial(
        theta, omega, x2 * OVER_2, x3 * OVER_3, x4 * OVER_4, x5 * OVER_5, x6 * OVER_6, x7 * OVER_7,
        x8 * OVER_8, x9 * OVER_9, x10 * OVER_10,
    )  # fmt: skip
    force = Force(
        fused(real(2.0), c2, FOUR_THIRDS * p2), real(6.0) * c3, real(12.0) * c4, real(20.0) * c5,
        real(30.0) * c6, real(42.0) * c7, real(7.0) * c8,
        fused(r, a.a0, real(2.0) * s2), fused(r, a.a1, real(6.0) * s3),
        fused(r, a.a2, real(12.0) * s4), fused(r, a.a3, real(20.0) * s5),
        fused(r, a.a4, real(30.0) * s6), fused(r, a.a5, real(42.0) * s7),
        fused(r, a.a6, real(7.0) * s8),
    )  # fmt: skip
    return rotation, force


@wp.func
def ratio(along: real, upwards: real) -> real:
    """Friction that a force or an impulse needs; NEVER where it pulls."""
    return wp.where(upwards > real(0.0), size(along) / upwards, NEVER)


@wp.func
def force_upwards(force: Force, x: real) -> real:
    """The force upwards a time x after the start of a step."""
    high = fused(x, fused(x, fused(x, force.n6, force.n5), force.n4), force.n3)
    return fused(x, fused(x, fused(x, high, force.n2), force.n1), force.n0)


@wp.func
def force_along(force: Force, x: real) -> real:
    """The force along the base then."""
    high = fused(x, fused(x, fused(x, force.f6, force.f5), force.f4), force.f3)
    return fused(x, fused(x, fused(x, high, force.f2), force.f1), force.f0)


@wp.func
def needed_along(needed: real, span: real, force: Force) -> real:
    """The larger of a friction and what the force needs in a time `span` from now.

    Looked at are its start and the time at which needed x n - |f| is least: there |f| / n is
    largest once `needed` is near it (Dinkelbach 1967). That is the root of its slope, a parabola
    through the slopes at both ends, or the end.
    """
    zero = real(0.0)
    most = larger(ratio(force.f0, force.n0), needed)
    pull = sign_of(force.f0)
    g1 = fused_less(pull, force.f1, most * force.n1)
    g2 = real(2.0) * fused_less(pull, force.f2, most * force.n2)
    g3 = real(3.0) * fused_less(pull, force.f3, most * force.n3)
    g4 = real(4.0) * fused_less(pull, force.f4, most * force.n4)
    g5 = real(5.0) * fused_less(pull, force.f5, most * force.n5)
    g6 = real(6.0) * fused_less(pull, force.f6, most * force.n6)
    high = fused(span, fused(span, fused(span, g6, g5), g4), g3)
    # The slope over time times the span: g1 + rise + bend at its end.
    rise = g2 * span
    bend = high * span * span
    end = g1 + (rise + bend)
    square = fused(rise, rise, real(-4.0) * g1 * bend)
    steep = rise + wp.sqrt(wp.where(square > zero, square, zero))
    turn = real(-2.0) * g1 * span / steep
    inside = g1 < zero and end > zero and turn < span
    at = wp.where(inside, turn, span)
    n = force_upwards(force, at)
    return larger(ratio(force_along(force, at), n), most)


@wp.func
def needed_in_step(
    needed: real, rocking: bool, fall_angle: real, lean: real, speed: real, end_speed: real,
    tau: real, force: Force,
) -> real:  # fmt: skip
    """The larger of a friction and what a step of length tau needs, up to where the block falls.

    Args:
        needed: The friction.
        rocking: Whether the block rocks.
        fall_angle: Rotation from which a block that turns outwards falls.
        lean: Rotation at the start of the step, positive towards the side that it leans to.
        speed: Its rate there.
        end_speed: Its rate at the end of the step.
        tau: Length of the step.
        force: The contact force in the step.
    """
    zero = real(0.0)
    left = fall_angle - lean
    # A lean that grows faster and faster comes to the fall angle later than at its mean rate.
    mean_speed = real(0.5) * (speed + end_speed)
    reaches = left < mean_speed * tau
    falls = mean_speed > zero and reaches
    span = wp.where(falls, left / mean_speed, tau)
    asked = needed_along(needed, span, force)
    fallen = left <= zero and speed >= zero
    return wp.where(rocking and not fallen, asked, needed)


@wp.func
def needed_at_step(lean: real, side: real, dv: real, alpha: real) -> real:
    """Friction that a velocity step dv of the base needs of a block that leans to a side."""
    c = cosine(alpha - lean)
    upwards = real(-3.0) * sine(alpha - lean) * c * side * sign_of(dv)
    return ratio(fused(real(-3.0) * c, c, real(4.0)), upwards)
