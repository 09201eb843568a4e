"""Velocity-level contact step of a body on contact points.

As impulse/block.py, for the lowest corner of a body (see shape/body.py) and its two neighbours:
flat ground and a convex chain leave no other that could carry. The sweeps work on the velocities,
with all impulses so far in them,

    n = larger(n - (u_n - wish) / K_nn, 0),   f = within mu n of f - u_t / K_tt.

A body is seen so that it leans to +x; corner 1 is then the neighbour to -x, corner 2 the lowest one
and corner 3 the neighbour to +x.
"""

import warp as wp

from warprock.kernels.cone import alone
from warprock.kernels.impulse.block import ENDS_EARLY, Knobs, wish
from warprock.kernels.shape.rising import fall_in, sunk_in


@wp.struct
class Body:
    """What a step needs to know of one lane's body.

    `reach` is how far its corners are from the centre of mass [m], `start` the rotation at which it
    is let go [rad]; vx, vz and omega are its velocities then [m/s, rad/s].
    """

    inverse_inertia: real
    friction: real
    reach: real
    start: real
    vx: real
    vz: real
    omega: real


@wp.func
def visit(
    mu: real, w: real, x: real, z: real, dn: real, dt: real, wished: real,
    n: real, f: real, vx: real, vz: real, vo: real,
):  # fmt: skip
    """Impulses of a corner [m/s] and velocities after it has been visited.

    Args:
        mu: Friction coefficient.
        w: Inverse inertia for unit mass [1/m^2].
        x, z: Corner from the centre of mass [m].
        dn, dt: 1 / K_nn and 1 / K_tt, zero of a corner that is no contact.
        wished: Least normal velocity [m/s].
        n, f: Its impulses before.
        vx, vz, vo: Velocities of the body, with them in it.
    """
    n1 = larger(fused_less(dn, fused_less(vo, x, vz - wished), n), real(0.0))
    vz1 = vz + (n1 - n)
    vo1 = fused_less(w * x, n1 - n, vo)
    bound = mu * n1
    f1 = larger(smaller(fused_less(dt, fused(vo1, z, vx), f), bound), -bound)
    return n1, f1, vx + (f1 - f), vz1, fused(w * z, f1 - f, vo1)


@wp.struct
class Rows:
    """The rows of three corners, each as `visit` takes it."""

    mu: real
    w: real
    x1: real
    z1: real
    dn1: real
    dt1: real
    wish1: real
    x2: real
    z2: real
    dn2: real
    dt2: real
    wish2: real
    x3: real
    z3: real
    dn3: real
    dt3: real
    wish3: real


@wp.func
def sweep(
    r: Rows, n1: real, f1: real, n2: real, f2: real, n3: real, f3: real,
    vx: real, vz: real, vo: real,
):  # fmt: skip
    """Impulses of three corners [m/s] and velocities of the body after one sweep."""
    n1, f1, vx, vz, vo = visit(r.mu, r.w, r.x1, r.z1, r.dn1, r.dt1, r.wish1, n1, f1, vx, vz, vo)
    n2, f2, vx, vz, vo = visit(r.mu, r.w, r.x2, r.z2, r.dn2, r.dt2, r.wish2, n2, f2, vx, vz, vo)
    n3, f3, vx, vz, vo = visit(r.mu, r.w, r.x3, r.z3, r.dn3, r.dt3, r.wish3, n3, f3, vx, vz, vo)
    return n1, f1, n2, f2, n3, f3, vx, vz, vo


@wp.func
def sweeps(
    r: Rows, n1: real, f1: real, n2: real, f2: real, n3: real, f3: real,
    vx: real, vz: real, vo: real,
):  # fmt: skip
    """All sweeps from the impulses n1 to f3 [m/s] and velocities with them."""
    if ENDS_EARLY:
        for _ in range(ITERATIONS):
            o1, p1, o2 = real(n1), real(f1), real(n2)
            p2, o3, p3 = real(f2), real(n3), real(f3)
            n1, f1, n2, f2, n3, f3, vx, vz, vo = sweep(r, n1, f1, n2, f2, n3, f3, vx, vz, vo)
            if n1 == o1 and f1 == p1 and n2 == o2 and f2 == p2 and n3 == o3 and f3 == p3:
                break
    else:
        for _ in range(ITERATIONS):
            n1, f1, n2, f2, n3, f3, vx, vz, vo = sweep(r, n1, f1, n2, f2, n3, f3, vx, vz, vo)
    return n1, f1, n2, f2, n3, f3


@wp.func
def lonely(
    mu: real, w: real, x: real, z: real, dn: real, dt: real, wished: real,
    vx: real, vz: real, vo: real,
):  # fmt: skip
    """Impulses [m/s] of a corner that is the only contact, exactly."""
    cross = -w * x * z
    return alone(
        mu, dn * cross, dt * cross, -dn * (vz - vo * x - wished), -dt * (vx + vo * z)
    )  # fmt: skip


@wp.func
def solve(
    mu: real, w: real, x1: real, z1: real, x2: real, z2: real, x3: real, z3: real,
    on1: real, on2: real, on3: real, wish1: real, wish2: real, wish3: real,
    ux: real, uz: real, uo: real,
    n1: real, f1: real, n2: real, f2: real, n3: real, f3: real,
):  # fmt: skip
    """Impulses of three corners by projected Gauss-Seidel; of one alone, exactly.

    Args:
        mu: Friction coefficient.
        w: Inverse inertia for unit mass [1/m^2].
        x1: Corner 1 from the centre of mass [m]; all up to z3 likewise.
        on1: One where corner 1 is a contact, else zero; on2 and on3 likewise.
        wish1: Least normal velocity of corner 1 [m/s]; wish2 and wish3 likewise.
        ux, uz, uo: Velocities without contact.
        n1: First guess of the normal impulse of corner 1 [m/s]; all up to f3 likewise.
    """
    one = real(1.0)
    dn1, dt1 = on1 / fused(w * x1, x1, one), on1 / fused(w * z1, z1, one)
    dn2, dt2 = on2 / fused(w * x2, x2, one), on2 / fused(w * z2, z2, one)
    dn3, dt3 = on3 / fused(w * x3, x3, one), on3 / fused(w * z3, z3, one)
    n1, f1, n2, f2, n3, f3 = on1 * n1, on1 * f1, on2 * n2, on2 * f2, on3 * n3, on3 * f3
    count = on1 + on2 + on3
    first, last = on1 > on2 + on3, on3 > on1 + on2
    n, f = lonely(
        mu, w,
        wp.where(first, x1, wp.where(last, x3, x2)), wp.where(first, z1, wp.where(last, z3, z2)),
        dn1 + dn2 + dn3, dt1 + dt2 + dt3,
        wp.where(first, wish1, wp.where(last, wish3, wish2)), ux, uz, uo,
    )  # fmt: skip
    vx = ux + f1 + f2 + f3
    vz = uz + n1 + n2 + n3
    turn = wedge(z1, x1, n1, f1) + wedge(z2, x2, n2, f2) + wedge(z3, x3, n3, f3)
    vo = fused(w, turn, uo)
    r = Rows(
        mu, w, x1, z1, dn1, dt1, wish1, x2, z2, dn2, dt2, wish2, x3, z3, dn3, dt3, wish3
    )  # fmt: skip
    n1, f1, n2, f2, n3, f3 = sweeps(r, n1, f1, n2, f2, n3, f3, vx, vz, vo)
    alone_now = count == one
    return (
        wp.where(alone_now, on1 * n, n1), wp.where(alone_now, on1 * f, f1),
        wp.where(alone_now, on2 * n, n2), wp.where(alone_now, on2 * f, f2),
        wp.where(alone_now, on3 * n, n3), wp.where(alone_now, on3 * f, f3),
    )  # fmt: skip


@wp.func
def lean_of(theta: real, omega: real, slip: real, xl: real, xm: real, xr: real) -> real:
    """A number of the sign of the side to which a body leans; 0 if it is its own mirror image.

    One that stands still and upright leans to the side to which its base reaches further.
    """
    zero = real(0.0)
    reaches = xr + wp.where(xm == zero, xl, xm)
    still = wp.where(slip != zero, slip, reaches)
    return wp.where(theta != zero, theta, wp.where(omega != zero, omega, still))


@wp.func
def balanced(
    even: bool, amid: bool, n1: real, f1: real, n2: real, f2: real, n3: real, f3: real
):  # fmt: skip
    """Impulses of three points, of what is its own mirror image (`even`) the mean of both orders.

    Each point has its image: the last one that of the first where the second lies `amid`, else
    that of the second.
    """
    zero, outer, inner = real(0.0), even and amid, even and not amid
    n, f = HALF * (wp.where(amid, n1, n2) + n3), HALF * (wp.where(amid, f1, f2) - f3)
    return (
        wp.where(outer, n, n1), wp.where(outer, f, f1),
        wp.where(inner, n, n2), wp.where(inner, f, wp.where(outer, zero, f2)),
        wp.where(even, n, n3), wp.where(even, -f, f3),
    )  # fmt: skip


@wp.func
def work(x: real, z: real, n: real, f: real, vx: real, vz: real, vo: real) -> real:
    """Work of the impulses of a corner [J/kg] at a velocity of the body."""
    return dot(n, f, fused_less(vo, x, vz), fused(vo, z, vx))


@wp.func
def step(
    body: Body, knobs: Knobs, dv: real, dz: real,
    xl: real, zl: real, xm: real, zm: real, xr: real, zr: real, has_l: bool, has_r: bool,
    x: real, z: real, theta: real, vx: real, vz: real, omega: real,
    nl: real, fl: real, nm: real, fm: real, nr: real, fr: real, loss: real,
):  # fmt: skip
    """One step of one lane, in which the base velocity changes by dv along and dz upwards [m/s].

    The corners are seen from the centre of mass [m]: l is the neighbour of the lowest one to -x, if
    there is one (`has_l`), m the lowest one, r that to +x. nl to fr are their impulses in the last
    step [m/s].

    Returns:
        All from `x` on after the step; the gap of the lowest corner at its start [m], and the gaps
        after it of the three, along their velocities [m].
    """
    zero, one = real(0.0), real(1.0)
    w, dt = body.inverse_inertia, knobs.time_step
    slip = vx - dv
    lean = lean_of(theta, omega, slip, xl, xm, xr)
    m = sign_of(lean)
    left = m < zero
    x1, z1 = m * wp.where(left, xr, xl), wp.where(left, zr, zl)
    x2, z2 = m * xm, zm
    x3, z3 = m * wp.where(left, xl, xr), wp.where(left, zl, zr)
    has1, has3 = wp.where(left, has_r, has_l), wp.where(left, has_l, has_r)
    gap1, gap2, gap3 = z + z1, z + z2, z + z3
    on1 = wp.where(has1 and gap1 <= knobs.collision_margin, one, zero)
    on2 = wp.where(gap2 <= knobs.collision_margin, one, zero)
    on3 = wp.where(has3 and gap3 <= knobs.collision_margin, one, zero)
    ux, uz, uo = m * slip, vz - fall_in(dt, knobs.gravity, dz), m * omega
    p1, t1, p2, t2, p3, t3 = solve(
        body.friction, w, x1, z1, x2, z2, x3, z3, on1, on2, on3,
        wish(gap1, knobs), wish(gap2, knobs), wish(gap3, knobs), ux, uz, uo,
        wp.where(left, nr, nl), m * wp.where(left, fr, fl), nm, m * fm,
        wp.where(left, nl, nr), m * wp.where(left, fl, fr),
    )  # fmt: skip
    p1, t1, p2, t2, p3, t3 = balanced(lean == zero, xm == zero, p1, t1, p2, t2, p3, t3)
    vx1 = ux + t1 + t2 + t3
    vz1 = uz + p1 + p2 + p3
    turn = wedge(z1, x1, p1, t1) + wedge(z2, x2, p2, t2) + wedge(z3, x3, p3, t3)
    vo1 = fused(w, turn, uo)
    # Of the contact impulses on the mean velocity of their corners, a loss.
    mx, mz, mo = HALF * (m * vx + vx1), HALF * (vz + vz1), HALF * (uo + vo1)
    done = work(x1, z1, p1, t1, mx, mz, mo) + work(x2, z2, p2, t2, mx, mz, mo)
    done = done + work(x3, z3, p3, t3, mx, mz, mo)
    lowest = smaller(gap2, smaller(gap1, gap3))
    lift = -knobs.erp * smaller(lowest + sunk_in(dt, knobs.gravity, dz), zero)
    ahead1 = fused(dt, fused_less(vo1, x1, vz1), gap1)
    ahead2 = fused(dt, fused_less(vo1, x2, vz1), gap2)
    ahead3 = fused(dt, fused_less(vo1, x3, vz1), gap3)
    vx1 = m * vx1
    vo1 = m * vo1
    return (
        fused(dt, vx1, x), fused(dt, vz1, z) + lift, fused(dt, vo1, theta), vx1, vz1, vo1,
        wp.where(left, p3, p1), m * wp.where(left, t3, t1), p2, m * t2,
        wp.where(left, p1, p3), m * wp.where(left, t1, t3),
        fused_less(knobs.gravity, lift, loss - done), lowest,
        wp.where(left, ahead3, ahead1), ahead2, wp.where(left, ahead1, ahead3),
    )  # fmt: skip
