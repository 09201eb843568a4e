"""Soft-spring (distinct element) step of blocks in space.

Bodies are numbered from the ground: body 0 is the ground, an endless flat face that nothing moves,
body k the k-th block. Heights are kept as what they differ from those of the stack built with
rigid blocks, which keeps overlaps exact. Forces and levers of interface k, between body k (upper)
and body k - 1 (lower), are in the axes of the lower body, whose top face is the plane that the
springs press on; the springs are spread over the part of the upper block's bottom face that lies
above it, as a grid along the width (A) and the depth (B). A point at (a, b), -1 to 1, has

    lever    P = p + a A + b B       from the upper centre of mass, d + a A + b B from the lower one
    overlap  o + a o_a + b o_b,      o_a = -A_3, o_b = -B_3
    velocity V = v + a v_a + b v_b,  v_a = (w_upper - w_lower) x A, v_b likewise

all linear in a and b, so that they are found once an interface and not once a spring. Stresses at
a point, per unit of area (Eq. 3 and 4 of the paper, with a dashpot beta k in parallel):

    normal   N = k_n (o + slip tan(psi)) - beta k_n V_3,      N >= -f_t while intact
    shear    T = -k_s (u + beta V_t),  u' = V_t = (V_1, V_2),  |T| <= c + N tan(phi)
             or, friction as a box: |T_1| and |T_2| each

A point whose spring is in tension beyond f_t is open and carries nothing; a dashpot never pulls
beyond that either. Where |T| reaches its bound the point slips: T returns along its own direction
(an exact cone), or T_1 and T_2 do each by itself (a box), and u keeps what the spring carries. The
first slip or opening takes f_t and c away for good; opening forgets u, but no dilation.

One step of central differences, the velocities and angular momenta L at half steps: stresses from
the places at n and the velocities at n - 1/2, which the dashpots see one half step late; then
v(n + 1/2) = v(n - 1/2) + dt F / m - dv_base, L(n + 1/2) = L(n - 1/2) + dt M, and places and
attitudes go on freely with them, see `turn_freely` in shape_space/block.py.

Points are visited in pairs +-(a, b). Pairs on one diagonal, on the other and on the axes have sums
of their own (`kind`), so that a scene mirrored in x or in y has mirrored forces to round-off.

Cundall and Strack (1979) for the scheme, Cundall (1988) for blocks in space.
"""

import warp as wp

from warprock.kernels.dem.stack import FAILED, Knobs
from warprock.kernels.dem_space.stack_meet import Link, back_from, held_in
from warprock.kernels.shape_space.block import (
    Block,
    in_axes,
    matrix_of,
    product,
    turn_freely,
    vector_product,
)

CONE = FRICTION == "cone"
"""Whether shear is bound as a cone, else as a box along the two directions."""
NEAR_ZERO = real(1.0e-30)
"""Square of a stress below which it has no direction."""


@wp.func
def bounded(want_x: real, want_y: real, bound: real):
    """Shear stresses within their bound, where they stick, and one over what was wanted."""
    one = real(1.0)
    square = dot(want_x, want_y, want_x, want_y)
    over = one / wp.sqrt(larger(square, NEAR_ZERO))
    sticks_x = square <= bound * bound
    sticks_y = sticks_x
    part = wp.where(sticks_x, one, bound * over)
    shear_x, shear_y = part * want_x, part * want_y
    if not CONE:
        sticks_x = size(want_x) <= bound
        sticks_y = size(want_y) <= bound
        shear_x = larger(smaller(want_x, bound), -bound)
        shear_y = larger(smaller(want_y, bound), -bound)
    return shear_x, shear_y, sticks_x, sticks_y, over


@wp.func
def spring(
    knobs: Knobs, live: bool, mu: real, dt: real, overlap: real, vn: real, vx: real, vy: real,
    ux: wp.ref[real], uy: wp.ref[real], slip: wp.ref[real],
):  # fmt: skip
    """Stresses at one point, see the head of this file; updates ux, uy and slip.

    Args:
        knobs: The settings.
        live: Whether the lane still runs.
        mu: tan(phi).
        dt: Time step [s].
        overlap: Depth to which the faces overlap [m].
        vn: Velocity at which they part [m/s], vx and vy at which they slide.
        ux: Stretch of the shear spring [m], uy likewise.
        slip: Slip so far [m], zero only of a point that never slipped or opened.

    Returns:
        N, T_1 and T_2 [N/m^2], twice the energy in the springs [J/m^2].
    """
    zero = real(0.0)
    old_x = real(ux)
    old_y = real(uy)
    slips = real(slip)
    intact = slips == zero
    pull = wp.where(intact, knobs.tensile_strength, zero)
    pressed = fused(knobs.dilatancy, slips, overlap)
    elastic = knobs.normal_stiffness * pressed
    closed = elastic > -pull
    damped = fused_less(knobs.stiffness_damping * knobs.normal_stiffness, vn, elastic)
    normal = wp.where(closed, larger(damped, -pull), zero)
    held = fused(mu, normal, wp.where(intact, knobs.cohesion, zero))
    bound = wp.where(closed, larger(held, zero), zero)
    new_x, new_y = fused(dt, vx, old_x), fused(dt, vy, old_y)
    want_x = -knobs.shear_stiffness * fused(knobs.stiffness_damping, vx, new_x)
    want_y = -knobs.shear_stiffness * fused(knobs.stiffness_damping, vy, new_y)
    shear_x, shear_y, sticks_x, sticks_y, over = bounded(want_x, want_y, bound)
    kept_x = wp.where(sticks_x, new_x, -knobs.shear_flexibility * shear_x)
    kept_y = wp.where(sticks_y, new_y, -knobs.shear_flexibility * shear_y)
    held_energy = knobs.shear_stiffness * dot(kept_x, kept_y, kept_x, kept_y)
    energy = wp.where(closed, fused(elastic, pressed, held_energy), held_energy)
    lost_x, lost_y = new_x - kept_x, new_y - kept_y
    slid = over * dot(lost_x, lost_y, want_x, want_y)
    if not CONE:
        slid = wp.sqrt(dot(lost_x, lost_y, lost_x, lost_y))
    ux = wp.where(live, kept_x, old_x)
    uy = wp.where(live, kept_y, old_y)
    moved = wp.where(closed, slips + size(slid), larger(slips, FAILED))
    slip = wp.where(live, moved, slips)
    return normal, shear_x, shear_y, energy


@wp.func
def spring_at(
    knobs: Knobs, link: Link, live: bool, dt: real, a: real, b: real,
    ux: wp.ref[real], uy: wp.ref[real], slip: wp.ref[real],
):  # fmt: skip
    """Stresses at the point (a, b) of an interface, see `spring`."""
    return spring(
        knobs, live, link.mu, dt, fused_less(b, link.b3, fused_less(a, link.a3, link.o)),
        fused(b, link.k3, fused(a, link.j3, link.v3)),
        fused(b, link.k1, fused(a, link.j1, link.v1)),
        fused(b, link.k2, fused(a, link.j2, link.v2)), ux, uy, slip,
    )  # fmt: skip


@wp.func
def solve_pair(
    knobs: Knobs, link: Link, live: bool, dt: real, a: real, b: real, share: real,
    ux: wp.ref[real], uy: wp.ref[real], slip: wp.ref[real],
    ux2: wp.ref[real], uy2: wp.ref[real], slip2: wp.ref[real],
    n: wp.ref[real], na: wp.ref[real], nb: wp.ref[real],
    t1: wp.ref[real], ta1: wp.ref[real], tb1: wp.ref[real],
    t2: wp.ref[real], ta2: wp.ref[real], tb2: wp.ref[real], e: wp.ref[real],
):  # fmt: skip
    """Adds a pair of points, -(a, b) and (a, b), to an interface.

    Args:
        knobs: The settings.
        link: Where the springs are, see `find_contacts`.
        live: Whether the lane still runs.
        dt: Time step [s].
        a, b: Place along the width over the half length and along the depth.
        share: Part of the area that each of the two stands for.
        ux: State of the first point, see `spring`, to slip; ux2 to slip2 of the second.
        n: Mean of N so far [N/m^2], na and nb its first moments over the half lengths; t1 to tb1
            of T_1, t2 to tb2 of T_2, e the mean of twice the energy [J/m^2]; all are added to.
    """
    f, g = held_in(link, -a, -b)
    n1, x1, y1, e1 = spring_at(knobs, link, live, dt, f, g, ux, uy, slip)
    h, q = held_in(link, a, b)
    n2, x2, y2, e2 = spring_at(knobs, link, live, dt, h, q, ux2, uy2, slip2)
    # f n1 + h n2 by sums and differences, which mirrored scenes mirror to the last bit.
    h, f = share * HALF * (h - f), share * HALF * (h + f)
    q, g = share * HALF * (q - g), share * HALF * (q + g)
    n = fused(share, n1 + n2, n)
    na = fused(h, n2 - n1, fused(f, n1 + n2, na))
    nb = fused(q, n2 - n1, fused(g, n1 + n2, nb))
    t1 = fused(share, x1 + x2, t1)
    ta1 = fused(h, x2 - x1, fused(f, x1 + x2, ta1))
    tb1 = fused(q, x2 - x1, fused(g, x1 + x2, tb1))
    t2 = fused(share, y1 + y2, t2)
    ta2 = fused(h, y2 - y1, fused(f, y1 + y2, ta2))
    tb2 = fused(q, y2 - y1, fused(g, y1 + y2, tb2))
    e = fused(share, e1 + e2, e)


@wp.func
def load_blocks(
    live: bool, qx: real, qy: real, qz: real, qw: real, area: real,
    p1: real, p2: real, p3: real, d1: real, d2: real, d3: real,
    a1: real, a2: real, a3: real, b1: real, b2: real, b3: real, n: real, na: real, nb: real,
    t1: real, ta1: real, tb1: real, t2: real, ta2: real, tb2: real, e: real,
    fx: wp.ref[real], fy: wp.ref[real], fz: wp.ref[real],
    mx: wp.ref[real], my: wp.ref[real], mz: wp.ref[real],
    gx: wp.ref[real], gy: wp.ref[real], gz: wp.ref[real],
    hx: wp.ref[real], hy: wp.ref[real], hz: wp.ref[real], stored: wp.ref[real],
):  # fmt: skip
    """Adds the forces of the springs of an interface to those on its two blocks: fx and after.

    Args:
        live: Whether the lane still runs.
        qx: Attitude of the lower body, to qw.
        area: See `Link`, as all up to b3.
        n: See `solve_pair`, as all up to e.
        fx: Force on the upper block in the base's axes [N], to fz, mx its moment about the centre
            of that block [N m], to mz; gx to hz of the lower body.
        stored: Energy in the springs [J].
    """
    s1, s2, s3 = vector_product(a1, a2, a3, ta1, ta2, na)
    r1, r2, r3 = vector_product(b1, b2, b3, tb1, tb2, nb)
    m1, m2, m3 = s1 + r1, s2 + r2, s3 + r3
    u1, u2, u3 = vector_product(p1, p2, p3, t1, t2, n)
    v1, v2, v3 = vector_product(d1, d2, d3, t1, t2, n)
    f1, f2, f3 = back_from(qx, qy, qz, qw, t1, t2, n)
    u1, u2, u3 = back_from(qx, qy, qz, qw, u1 + m1, u2 + m2, u3 + m3)
    v1, v2, v3 = back_from(qx, qy, qz, qw, v1 + m1, v2 + m2, v3 + m3)
    fx = fused(area, f1, fx)
    fy = fused(area, f2, fy)
    fz = fused(area, f3, fz)
    mx = fused(area, u1, mx)
    my = fused(area, u2, my)
    mz = fused(area, u3, mz)
    gx = fused_less(area, f1, gx)
    gy = fused_less(area, f2, gy)
    gz = fused_less(area, f3, gz)
    hx = fused_less(area, v1, hx)
    hy = fused_less(area, v2, hy)
    hz = fused_less(area, v3, hz)
    stored = stored + wp.where(live, real(0.5) * area * e, real(0.0))


@wp.func
def driven(over: real, drag: real, fx: real, fy: real, fz: real, vx: real, vy: real, vz: real):
    """Acceleration by a force, or by a moment, with mass damping."""
    return fused(over, fx, -drag * vx), fused(over, fy, -drag * vy), fused(over, fz, -drag * vz)


@wp.func
def integrate(
    live: bool, block: Block, knobs: Knobs, dt: real, span: real,
    dvx: real, dvy: real, dvz: real,
    x: wp.ref[real], y: wp.ref[real], z: wp.ref[real],
    qx: wp.ref[real], qy: wp.ref[real], qz: wp.ref[real], qw: wp.ref[real],
    vx: wp.ref[real], vy: wp.ref[real], vz: wp.ref[real],
    lx: wp.ref[real], ly: wp.ref[real], lz: wp.ref[real],
    fx: wp.ref[real], fy: wp.ref[real], fz: wp.ref[real],
    mx: wp.ref[real], my: wp.ref[real], mz: wp.ref[real], loss: wp.ref[real],
):  # fmt: skip
    """Moves a block by a step.

    Args:
        live: Whether the lane still runs.
        block: The block.
        knobs: The settings.
        dt: Time step [s].
        span: Time over which the forces act: half of it in the first step, from rest [s].
        dvx: Change of the base velocity in the step [m/s], to dvz.
        x: Where the block is and how it moves, see `Moving`, to lz; all move on.
        fx: Force on the block [N], to fz; mx its moment [N m], to mz; zero afterwards.
        loss: Work of the springs and of mass damping against the blocks so far [J].
    """
    mass, over, drag = block.mass, real(1.0) / block.mass, knobs.mass_damping
    ix, iy, iz = block.inverse_x, block.inverse_y, block.inverse_z
    px, py, pz = driven(over, drag, fx, fy, fz, vx, vy, vz)
    ax, ay, az = driven(over, drag, mx, my, mz, lx, ly, lz)
    ux, uy = fused(span, px, vx - dvx), fused(span, py, vy - dvy)
    uz = fused(span, pz - knobs.gravity, vz - dvz)
    kx, ky, kz = fused(span, ax, lx), fused(span, ay, ly), fused(span, az, lz)
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(qx, qy, qz, qw)
    o1, o2, o3 = in_axes(r11, r21, r31, r12, r22, r32, r13, r23, r33, lx + kx, ly + ky, lz + kz)
    e1, e2, e3 = in_axes(r11, r21, r31, r12, r22, r32, r13, r23, r33, ax, ay, az)
    moved = product(px, py, pz, vx + ux, vy + uy, vz + uz)
    work = HALF * span * mass * (moved + product(o1 * ix, o2 * iy, o3 * iz, e1, e2, e3))
    n1, n2, n3, n4 = turn_freely(qx, qy, qz, qw, kx, ky, kz, ix, iy, iz, dt)
    loss = loss - wp.where(live, work, real(0.0))
    x = wp.where(live, fused(dt, ux, x), x)
    y = wp.where(live, fused(dt, uy, y), y)
    z = wp.where(live, fused(dt, uz, z), z)
    qx = wp.where(live, n1, qx)
    qy = wp.where(live, n2, qy)
    qz = wp.where(live, n3, qz)
    qw = wp.where(live, n4, qw)
    vx = wp.where(live, ux, vx)
    vy = wp.where(live, uy, vy)
    vz = wp.where(live, uz, vz)
    lx = wp.where(live, kx, lx)
    ly = wp.where(live, ky, ly)
    lz = wp.where(live, kz, lz)
    fx = real(0.0)
    fy = real(0.0)
    fz = real(0.0)
    mx = real(0.0)
    my = real(0.0)
    mz = real(0.0)
