"""A body between two events as Taylor series: it rolls on an arc of radius r about one point.

The centre of the arc, its foot, lies R (sin(alpha), -cos(alpha)) from the centre of mass; alpha is
positive on the side of +x. With phi = theta - alpha the centre of mass is, from where the arc would
stand upright,

    x = r theta + R sin(phi),  z = r + R cos(phi).

Over the mass the kinetic energy is theta'^2 / 2 (k^2 + x'^2 + z'^2), k the radius of gyration, and
the weight and the inertia of a base acceleration a do work along z and x. Lagrange's equation over
D = k^2 + r^2 + R^2, with p^2 = g R / D, q = R / D, rho = r / D and eps = 2 r R / D, is

    (1 + eps C) theta'' = p^2 S - (rho + q C) a - eps C' theta' / 2,

S = sin(phi), C = cos(phi): for sharp corners, r = 0, Housner's equation. Every Taylor coefficient
follows from lower ones: wk are those of p^2 S, or of q (g + a_z) S on a base that moves upwards
(housner/body_weight.py), sk and ck are those of S and C, dk, yk and uk those of C', theta'' and
q a + eps theta'', xk = k theta_k. The contact force on the body over its mass is a + x'' along the
base and g + z'' upwards, with a_z added.
"""

import warp as wp

from warprock.kernels.housner.block_contact import Force, force_along, needed_along, ratio
from warprock.kernels.housner.body_weight import Sines, lift_at, push, weigh
from warprock.kernels.motion.kinds import Acceleration
from warprock.kernels.shape.taylor import Polynomial

PI = real(3.141592653589793)


@wp.struct
class Foot:
    """A point of the base; the symbols are those of the head of this file.

    Attributes:
        alpha, reach: Its place: the angle alpha [rad] and the distance R [m].
        p2, q, rho, eps: p^2 [1/s^2], q [1/m], rho [1/m] and eps.
        low, high: Rotations between which it touches the ground alone [rad].
    """

    alpha: real
    reach: real
    p2: real
    q: real
    rho: real
    eps: real
    low: real
    high: real


@wp.struct
class Tilt:
    """Taylor coefficients 2 to 8 of C = cos(phi) and S = sin(phi) in a step."""

    c2: real
    c3: real
    c4: real
    c5: real
    c6: real
    c7: real
    c8: real
    s2: real
    s3: real
    s4: real
    s5: real
    s6: real
    s7: real
    s8: real


@wp.func
def sine_cosine(phi: real):
    """Sine and cosine for |phi| <= pi."""
    beyond = size(phi) > HALF_PI
    folded = wp.where(beyond, sign_of(phi) * PI - phi, phi)
    c = cosine(folded)
    return sine(folded), wp.where(beyond, -c, c)


# fmt: off
@wp.func
def rolling_series(foot: Foot, theta: real, omega: real, a: Acceleration, z: Acceleration):
    """The rotation of a body in a step, and the sine and cosine of phi."""
    p2, q, rho, eps = foot.p2, foot.q, foot.rho, foot.eps
    phi, x1, sines = theta - foot.alpha, omega, Sines()
    s0, c0 = sine_cosine(phi)
    over = real(1.0) / (real(1.0) + eps * c0)
    base, bend = rho + q * c0, HALF * eps
    d0 = -(x1 * s0)
    sines = push(s0, sines)
    w0 = weigh(p2, q, z, sines)
    y0 = over * (w0 - base * a.a0 - bend * (d0 * x1))
    x2, u0, c1, s1 = y0, q * a.a0 + eps * y0, d0, x1 * c0
    d1 = -(x1 * s1 + x2 * s0)
    sines = push(s1, sines)
    w1 = weigh(p2, q, z, sines)
    y1 = over * (w1 - base * a.a1 - bend * (d0 * x2 + d1 * x1) - (u0 * c1))
    x3, u1, c2 = OVER_2 * y1, q * a.a1 + eps * y1, OVER_2 * d1
    s2 = OVER_2 * (x1 * c1 + x2 * c0)
    d2 = -(x1 * s2 + x2 * s1 + x3 * s0)
    sines = push(s2, sines)
    w2 = weigh(p2, q, z, sines)
    y2 = over * (w2 - base * a.a2 - bend * (d0 * x3 + d1 * x2 + d2 * x1) - (u0 * c2 + u1 * c1))
    x4, u2, c3 = OVER_3 * y2, q * a.a2 + eps * y2, OVER_3 * d2
    s3 = OVER_3 * (x1 * c2 + x2 * c1 + x3 * c0)
    d3 = -(x1 * s3 + x2 * s2 + x3 * s1 + x4 * s0)
    sines = push(s3, sines)
    w3 = weigh(p2, q, z, sines)
    y3 = over * (w3 - base * a.a3 - bend * (d0 * x4 + d1 * x3 + d2 * x2 + d3 * x1) - (
        u0 * c3 + u1 * c2 + u2 * c1))
    x5, u3, c4 = OVER_4 * y3, q * a.a3 + eps * y3, OVER_4 * d3
    s4 = OVER_4 * (x1 * c3 + x2 * c2 + x3 * c1 + x4 * c0)
    d4 = -(x1 * s4 + x2 * s3 + x3 * s2 + x4 * s1 + x5 * s0)
    sines = push(s4, sines)
    w4 = weigh(p2, q, z, sines)
    y4 = over * (w4 - base * a.a4 - bend * (d0 * x5 + d1 * x4 + d2 * x3 + d3 * x2 + d4 * x1) - (
        u0 * c4 + u1 * c3 + u2 * c2 + u3 * c1))
    x6, u4, c5 = OVER_5 * y4, q * a.a4 + eps * y4, OVER_5 * d4
    s5 = OVER_5 * (x1 * c4 + x2 * c3 + x3 * c2 + x4 * c1 + x5 * c0)
    d5 = -(x1 * s5 + x2 * s4 + x3 * s3 + x4 * s2 + x5 * s1 + x6 * s0)
    sines = push(s5, sines)
    w5 = weigh(p2, q, z, sines)
    y5 = over * (w5 - base * a.a5 - bend * (d0 * x6 + d1 * x5 + d2 * x4 + d3 * x3 + d4 * x2
        + d5 * x1) - (u0 * c5 + u1 * c4 + u2 * c3 + u3 * c2 + u4 * c1))
    x7, u5, c6 = OVER_6 * y5, q * a.a5 + eps * y5, OVER_6 * d5
    s6 = OVER_6 * (x1 * c5 + x2 * c4 + x3 * c3 + x4 * c2 + x5 * c1 + x6 * c0)
    d6 = -(x1 * s6 + x2 * s5 + x3 * s4 + x4 * s3 + x5 * s2 + x6 * s1 + x7 * s0)
    sines = push(s6, sines)
    w6 = weigh(p2, q, z, sines)
    y6 = over * (w6 - base * a.a6 - bend * (d0 * x7 + d1 * x6 + d2 * x5 + d3 * x4 + d4 * x3
        + d5 * x2 + d6 * x1) - (u0 * c6 + u1 * c5 + u2 * c4 + u3 * c3 + u4 * c2 + u5 * c1))
    x8, u6, c7 = OVER_7 * y6, q * a.a6 + eps * y6, OVER_7 * d6
    s7 = OVER_7 * (x1 * c6 + x2 * c5 + x3 * c4 + x4 * c3 + x5 * c2 + x6 * c1 + x7 * c0)
    d7 = -(x1 * s7 + x2 * s6 + x3 * s5 + x4 * s4 + x5 * s3 + x6 * s2 + x7 * s1 + x8 * s0)
    sines = push(s7, sines)
    w7 = weigh(p2, q, z, sines)
    y7 = over * (w7 - base * a.a7 - bend * (d0 * x8 + d1 * x7 + d2 * x6 + d3 * x5 + d4 * x4
        + d5 * x3 + d6 * x2 + d7 * x1) - (u0 * c7 + u1 * c6 + u2 * c5 + u3 * c4 + u4 * c3
        + u5 * c2 + u6 * c1))
    x9, u7, c8 = OVER_8 * y7, q * a.a7 + eps * y7, OVER_8 * d7
    s8 = OVER_8 * (x1 * c7 + x2 * c6 + x3 * c5 + x4 * c4 + x5 * c3 + x6 * c2 + x7 * c1 + x8 * c0)
    d8 = -(x1 * s8 + x2 * s7 + x3 * s6 + x4 * s5 + x5 * s4 + x6 * s3 + x7 * s2 + x8 * s1
        + x9 * s0)
    sines = push(s8, sines)
    w8 = weigh(p2, q, z, sines)
    y8 = over * (w8 - base * a.a8 - bend * (d0 * x9 + d1 * x8 + d2 * x7 + d3 * x6 + d4 * x5
        + d5 * x4 + d6 * x3 + d7 * x2 + d8 * x1) - (u0 * c8 + u1 * c7 + u2 * c6 + u3 * c5
        + u4 * c4 + u5 * c3 + u6 * c2 + u7 * c1))
    rotation = Polynomial(
        theta, omega, x2 * OVER_2, x3 * OVER_3, x4 * OVER_4, x5 * OVER_5, x6 * OVER_6, x7 * OVER_7,
        x8 * OVER_8, x9 * OVER_9, OVER_9 * y8 * OVER_10,
    )
    return rotation, Tilt(c2, c3, c4, c5, c6, c7, c8, s2, s3, s4, s5, s6, s7, s8)
# fmt: on


@wp.func
def force_series(
    gravity: real, radius: real, reach: real, rotation: Polynomial, tilt: Tilt, a: Acceleration,
    z: Acceleration,
) -> Force:  # fmt: skip
    """The contact force over the mass."""
    r, t, w = radius, rotation, tilt
    force = Force(
        gravity + real(2.0) * reach * w.c2,
        real(6.0) * reach * w.c3,
        real(12.0) * reach * w.c4,
        real(20.0) * reach * w.c5,
        real(30.0) * reach * w.c6,
        real(42.0) * reach * w.c7,
        real(56.0) * reach * w.c8,
        a.a0 + real(2.0) * (r * t.c2 + reach * w.s2),
        a.a1 + real(6.0) * (r * t.c3 + reach * w.s3),
        a.a2 + real(12.0) * (r * t.c4 + reach * w.s4),
        a.a3 + real(20.0) * (r * t.c5 + reach * w.s5),
        a.a4 + real(30.0) * (r * t.c6 + reach * w.s6),
        a.a5 + real(42.0) * (r * t.c7 + reach * w.s7),
        a.a6 + real(56.0) * (r * t.c8 + reach * w.s8),
    )
    if VERTICAL:
        force.n0 = force.n0 + z.a0
        force.n1 = force.n1 + z.a1
        force.n2 = force.n2 + z.a2
        force.n3 = force.n3 + z.a3
        force.n4 = force.n4 + z.a4
        force.n5 = force.n5 + z.a5
        force.n6 = force.n6 + z.a6
    return force


@wp.func
def friction_at_rest(
    gravity: real, needed: real, tau: real, a: Acceleration, z: Acceleration
) -> real:
    """The larger of a friction and |a| / (g + a_z) in a step of length tau of a body at rest."""
    force = Force(
        gravity + z.a0, z.a1, z.a2, z.a3, z.a4, z.a5, z.a6,
        a.a0, a.a1, a.a2, a.a3, a.a4, a.a5, a.a6,
    )  # fmt: skip
    most = larger(ratio(force.f0, force.n0), needed)
    if VERTICAL:
        # Without a_z a step ends where a(t) turns; the quotient may turn inside.
        most = needed_along(needed, tau, force)
    return larger(ratio(force_along(force, tau), gravity + lift_at(z, tau)), most)
