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

from warprock.kernels.housner.block_contact import needed_along, polynomial, ratio
from warprock.kernels.housner.body_weight import Heave, heave_after, heavy

PI = real(3.141592653589793)


@wp.func
def sine_cosine(phi: real):
    """Sine and cosine for |phi| <= pi."""
    beyond = size(phi) > HALF_PI
    folded = wp.where(beyond, sign_of(phi) * PI - phi, phi)
    c = cosine(folded)
    return sine(folded), wp.where(beyond, -c, c)


# fmt: off
@wp.func
def rolling_series(
    p2: real, q: real, rho: real, eps: real, phi: real, x1: real, z: Heave,
    a0: real, a1: real, a2: real, a3: real, a4: real, a5: real, a6: real, a7: real, a8: real,
):
    """Taylor coefficients 2 to 10 of theta, 2 to 8 of C and of S, from phi and theta' = x1."""
    s0, c0 = sine_cosine(phi)
    over, o = real(1.0) / (real(1.0) + eps * c0), real(0.0)
    base, bend = rho + q * c0, HALF * eps
    d0, w0 = -(x1 * s0), heavy(p2, q, z, s0, o, o, o, o, o, o, o, o)
    y0 = over * (w0 - base * a0 - bend * (d0 * x1))
    x2, u0, c1, s1 = y0, q * a0 + eps * y0, d0, x1 * c0
    d1, w1 = -(x1 * s1 + x2 * s0), heavy(p2, q, z, s1, s0, o, o, o, o, o, o, o)
    y1 = over * (w1 - base * a1 - bend * (d0 * x2 + d1 * x1) - (u0 * c1))
    x3, u1, c2 = OVER_2 * y1, q * a1 + eps * y1, OVER_2 * d1
    s2 = OVER_2 * (x1 * c1 + x2 * c0)
    d2, w2 = -(x1 * s2 + x2 * s1 + x3 * s0), heavy(p2, q, z, s2, s1, s0, o, o, o, o, o, o)
    y2 = over * (w2 - base * a2 - bend * (d0 * x3 + d1 * x2 + d2 * x1) - (u0 * c2 + u1 * c1))
    x4, u2, c3 = OVER_3 * y2, q * a2 + eps * y2, OVER_3 * d2
    s3 = OVER_3 * (x1 * c2 + x2 * c1 + x3 * c0)
    d3 = -(x1 * s3 + x2 * s2 + x3 * s1 + x4 * s0)
    w3 = heavy(p2, q, z, s3, s2, s1, s0, o, o, o, o, o)
    y3 = over * (w3 - base * a3 - bend * (d0 * x4 + d1 * x3 + d2 * x2 + d3 * x1) - (
        u0 * c3 + u1 * c2 + u2 * c1))
    x5, u3, c4 = OVER_4 * y3, q * a3 + eps * y3, OVER_4 * d3
    s4 = OVER_4 * (x1 * c3 + x2 * c2 + x3 * c1 + x4 * c0)
    d4 = -(x1 * s4 + x2 * s3 + x3 * s2 + x4 * s1 + x5 * s0)
    w4 = heavy(p2, q, z, s4, s3, s2, s1, s0, o, o, o, o)
    y4 = over * (w4 - base * a4 - bend * (d0 * x5 + d1 * x4 + d2 * x3 + d3 * x2 + d4 * x1) - (
        u0 * c4 + u1 * c3 + u2 * c2 + u3 * c1))
    x6, u4, c5 = OVER_5 * y4, q * a4 + eps * y4, OVER_5 * d4
    s5 = OVER_5 * (x1 * c4 + x2 * c3 + x3 * c2 + x4 * c1 + x5 * c0)
    d5 = -(x1 * s5 + x2 * s4 + x3 * s3 + x4 * s2 + x5 * s1 + x6 * s0)
    w5 = heavy(p2, q, z, s5, s4, s3, s2, s1, s0, o, o, o)
    y5 = over * (w5 - base * a5 - bend * (d0 * x6 + d1 * x5 + d2 * x4 + d3 * x3 + d4 * x2
        + d5 * x1) - (u0 * c5 + u1 * c4 + u2 * c3 + u3 * c2 + u4 * c1))
    x7, u5, c6 = OVER_6 * y5, q * a5 + eps * y5, OVER_6 * d5
    s6 = OVER_6 * (x1 * c5 + x2 * c4 + x3 * c3 + x4 * c2 + x5 * c1 + x6 * c0)
    d6 = -(x1 * s6 + x2 * s5 + x3 * s4 + x4 * s3 + x5 * s2 + x6 * s1 + x7 * s0)
    w6 = heavy(p2, q, z, s6, s5, s4, s3, s2, s1, s0, o, o)
    y6 = over * (w6 - base * a6 - bend * (d0 * x7 + d1 * x6 + d2 * x5 + d3 * x4 + d4 * x3
        + d5 * x2 + d6 * x1) - (u0 * c6 + u1 * c5 + u2 * c4 + u3 * c3 + u4 * c2 + u5 * c1))
    x8, u6, c7 = OVER_7 * y6, q * a6 + eps * y6, OVER_7 * d6
    s7 = OVER_7 * (x1 * c6 + x2 * c5 + x3 * c4 + x4 * c3 + x5 * c2 + x6 * c1 + x7 * c0)
    d7 = -(x1 * s7 + x2 * s6 + x3 * s5 + x4 * s4 + x5 * s3 + x6 * s2 + x7 * s1 + x8 * s0)
    w7 = heavy(p2, q, z, s7, s6, s5, s4, s3, s2, s1, s0, o)
    y7 = over * (w7 - base * a7 - bend * (d0 * x8 + d1 * x7 + d2 * x6 + d3 * x5 + d4 * x4
        + d5 * x3 + d6 * x2 + d7 * x1) - (u0 * c7 + u1 * c6 + u2 * c5 + u3 * c4 + u4 * c3
        + u5 * c2 + u6 * c1))
    x9, u7, c8 = OVER_8 * y7, q * a7 + eps * y7, OVER_8 * d7
    s8 = OVER_8 * (x1 * c7 + x2 * c6 + x3 * c5 + x4 * c4 + x5 * c3 + x6 * c2 + x7 * c1 + x8 * c0)
    d8, w8 = -(x1 * s8 + x2 * s7 + x3 * s6 + x4 * s5 + x5 * s4 + x6 * s3 + x7 * s2 + x8 * s1
        + x9 * s0), heavy(p2, q, z, s8, s7, s6, s5, s4, s3, s2, s1, s0)
    y8 = over * (w8 - base * a8 - bend * (d0 * x9 + d1 * x8 + d2 * x7 + d3 * x6 + d4 * x5
        + d5 * x4 + d6 * x3 + d7 * x2 + d8 * x1) - (u0 * c8 + u1 * c7 + u2 * c6 + u3 * c5
        + u4 * c4 + u5 * c3 + u6 * c2 + u7 * c1))
    return (
        x2 * OVER_2, x3 * OVER_3, x4 * OVER_4, x5 * OVER_5, x6 * OVER_6, x7 * OVER_7, x8 * OVER_8,
        x9 * OVER_9, OVER_9 * y8 * OVER_10, c2, c3, c4, c5, c6, c7, c8, s2, s3, s4, s5, s6, s7, s8,
    )
# fmt: on


@wp.func
def force_series(
    gravity: real, r: real, reach: real,
    t2: real, t3: real, t4: real, t5: real, t6: real, t7: real, t8: real,
    c2: real, c3: real, c4: real, c5: real, c6: real, c7: real, c8: real,
    s2: real, s3: real, s4: real, s5: real, s6: real, s7: real, s8: real,
    a0: real, a1: real, a2: real, a3: real, a4: real, a5: real, a6: real, z: Heave,
):  # fmt: skip
    """Taylor coefficients 0 to 6 of the contact force over the mass, upwards, then along."""
    n0 = gravity + real(2.0) * reach * c2
    f0 = a0 + real(2.0) * (r * t2 + reach * s2)
    n1, n2, n3 = real(6.0) * reach * c3, real(12.0) * reach * c4, real(20.0) * reach * c5
    n4, n5, n6 = real(30.0) * reach * c6, real(42.0) * reach * c7, real(56.0) * reach * c8
    if VERTICAL:
        n0, n1, n2, n3 = n0 + z.z0, n1 + z.z1, n2 + z.z2, n3 + z.z3
        n4, n5, n6 = n4 + z.z4, n5 + z.z5, n6 + z.z6
    return (
        n0, n1, n2, n3, n4, n5, n6,
        f0, a1 + real(6.0) * (r * t3 + reach * s3), a2 + real(12.0) * (r * t4 + reach * s4),
        a3 + real(20.0) * (r * t5 + reach * s5), a4 + real(30.0) * (r * t6 + reach * s6),
        a5 + real(42.0) * (r * t7 + reach * s7), a6 + real(56.0) * (r * t8 + reach * s8),
    )  # fmt: skip


@wp.func
def friction_at_rest(
    gravity: real, needed: real, tau: real,
    a0: real, a1: real, a2: real, a3: real, a4: real, a5: real, a6: real, z: Heave,
) -> real:  # fmt: skip
    """The larger of a friction and |a| / (g + a_z) in a step of length tau of a body at rest."""
    most = larger(ratio(a0, gravity + z.z0), needed)
    if VERTICAL:
        # Without a_z a step ends where a(t) turns; the quotient may turn inside.
        n0 = gravity + z.z0
        most = needed_along(
            needed, tau, n0, z.z1, z.z2, z.z3, z.z4, z.z5, z.z6, a0, a1, a2, a3, a4, a5, a6
        )
    a = polynomial(a0, a1, a2, a3, a4, a5, a6, tau)
    return larger(ratio(a, gravity + heave_after(z, tau)), most)
