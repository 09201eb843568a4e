"""What xpbd/stack.py does at an interface, for a block that stands on the ground.

The ground is level and nothing moves it. So both ends are corners of the block, their normal is
(0, 1), and the ground gets no correction. The functions have the names and arguments of those in
xpbd/stack.py and shape/interface.py, and the same results to round-off.
"""

import warp as wp

from warprock.kernels.cone import alone
from warprock.kernels.instance import MAX_UNROLL

TURNS_ON_GROUND = max(n for n in range(1, MAX_UNROLL + 1) if max(ITERATIONS, 1) % n == 0)
"""Sweeps in one call, written out: there is no other interface to visit."""


@wp.func
def find_end(
    side: real, half_width: real, half_height: real, s: real, c: real,
    lhalf_width: real, lhalf_height: real, ls: real, lc: real, dx: real, dz: real,
):  # fmt: skip
    """See `find_end` in shape/interface.py."""
    px = wedge(side * half_width, half_height, s, c)
    pz = -dot(half_height, side * half_width, c, s)
    ax = dx + px
    az = dz + pz
    return real(0.0), real(1.0), px, pz, ax, az, az, ax - side * half_width


@wp.func
def add_impulses(
    m: real, j: real, lm: real, lj: real, nx: real, nz: real,
    au: real, bu: real, al: real, bl: real, n: real, t: real,
    qx: wp.ref[real], qz: wp.ref[real], qo: wp.ref[real],
    lx: wp.ref[real], lz: wp.ref[real], lo: wp.ref[real],
):  # fmt: skip
    """See `add_impulses` in shape/interface.py."""
    qx = fused(m, t, qx)
    qz = fused(m, n, qz)
    qo = fused(j, wedge(bu, au, n, t), qo)


@wp.func
def solve_on_ground(
    mu: real, m: real, j: real, lm: real, lj: real,
    nx1: real, nz1: real, au1: real, bu1: real, al1: real, bl1: real,
    gap1: real, slip1: real, dn1: real, dt1: real,
    nx2: real, nz2: real, au2: real, bu2: real, al2: real, bl2: real,
    gap2: real, slip2: real, dn2: real, dt2: real,
    n1: wp.ref[real], t1: wp.ref[real], n2: wp.ref[real], t2: wp.ref[real],
    qx: wp.ref[real], qz: wp.ref[real], qo: wp.ref[real],
    lx: wp.ref[real], lz: wp.ref[real], lo: wp.ref[real],
):  # fmt: skip
    """See `solve_anywhere`; an end alone is solved exactly."""
    a = real(n1)
    b = real(t1)
    e = real(n2)
    f = real(t2)
    # What multipliers do to the gaps and slips of both ends [1/kg].
    pu, pv, qu, qv = j * au1, j * bu1, j * au2, j * bu2
    n1n1, t1t1, n2n2 = fused(pu, au1, m), fused(pv, bu1, m), fused(qu, au2, m)
    n1t1, n1n2, n1t2 = -pu * bu1, fused(pu, au2, m), -pu * bu2
    t1n2, t1t2, n2t2 = -pv * au2, fused(pv, bu2, m), -qu * bu2
    t2t2 = fused(qv, bu2, m)
    # Gaps and slips as they would be without these four, over what one of them does.
    u1, s1 = fused_less(au1, qo, gap1 + qz), fused(bu1, qo, slip1 + qx)
    u2, s2 = fused_less(au2, qo, gap2 + qz), fused(bu2, qo, slip2 + qx)
    u1 = -dn1 * less_three(fused_less(n1n1, a, u1), n1t1, b, n1n2, e, n1t2, f)
    s1 = -dt1 * less_three(fused_less(n1t1, a, s1), t1t1, b, t1n2, e, t1t2, f)
    u2 = -dn2 * less_three(fused_less(n1n2, a, u2), t1n2, b, n2n2, e, n2t2, f)
    s2 = -dt2 * less_three(fused_less(n1t2, a, s2), t1t2, b, n2t2, e, t2t2, f)
    a1, a2, a3 = dn1 * n1t1, dn1 * n1n2, dn1 * n1t2
    b1, b2, b3 = dt1 * n1t1, dt1 * t1n2, dt1 * t1t2
    c1, c2, c3 = dn2 * n1n2, dn2 * t1n2, dn2 * n2t2
    d1, d2, d3 = dt2 * n1t2, dt2 * t1t2, dt2 * n2t2
    first, second = dn2 <= real(0.0), dn1 <= real(0.0)
    n, t = alone(
        mu, wp.where(first, a1, c3), wp.where(first, b1, d3), wp.where(first, u1, u2),
        wp.where(first, s1, s2),
    )  # fmt: skip
    # The value found last comes last in each row, so that the other terms need not wait for it.
    for _ in range(TURNS_ON_GROUND):
        a = larger(less_three(u1, a1, b, a2, e, a3, f), real(0.0))
        b = larger(smaller(less_three(s1, b2, e, b3, f, b1, a), mu * a), -mu * a)
        e = larger(less_three(u2, c3, f, c1, a, c2, b), real(0.0))
        f = larger(smaller(less_three(s2, d1, a, d2, b, d3, e), mu * e), -mu * e)
    a, b = wp.where(first, n, a), wp.where(first, t, b)
    e, f = wp.where(second, n, e), wp.where(second, t, f)
    qx = fused(m, b - t1 + f - t2, qx)
    qz = fused(m, a - n1 + e - n2, qz)
    turn = wedge(bu1, au1, a - n1, b - t1) + wedge(bu2, au2, e - n2, f - t2)
    qo = fused(j, turn, qo)
    n1 = a
    t1 = b
    n2 = e
    t2 = f
