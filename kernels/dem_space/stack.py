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
of their own (`kind`), so that a scene mirrored in x or in y has mirrored forces but for the last
bit, which the compiler's fused operations at the two points of a pair may leave.

Cundall and Strack (1979) for the scheme, Cundall (1988) for blocks in space.
"""

import warp as wp

from warprock.kernels.dem.stack import FAILED, Knobs
from warprock.kernels.dem_space.stack_meet import Link, back_from, cross, held_in, in_axes
from warprock.kernels.shape_space.block import Block, matrix_of, turn_freely

CONE = FRICTION == "cone"
"""Whether shear is bound as a cone, else as a box along the two directions."""
NEAR_ZERO = real(1.0e-30)
"""Square of a stress below which it has no direction."""


@wp.func
def bounded(want_x: real, want_y: real, bound: real):
    """Shear stresses within their bound, where they stick, and one over what was wanted."""
    one = real(1.0)
    square = want_x * want_x + want_y * want_y
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
    pressed = overlap + knobs.dilatancy * slips
    elastic = knobs.normal_stiffness * pressed
    closed = elastic > -pull
    damped = elastic - knobs.stiffness_damping * knobs.normal_stiffness * vn
    normal = wp.where(closed, larger(damped, -pull), zero)
    held = wp.where(intact, knobs.cohesion, zero) + mu * normal
    bound = wp.where(closed, larger(held, zero), zero)
    new_x, new_y = old_x + dt * vx, old_y + dt * vy
    want_x = -knobs.shear_stiffness * (new_x + knobs.stiffness_damping * vx)
    want_y = -knobs.shear_stiffness * (new_y + knobs.stiffness_damping * vy)
    shear_x, shear_y, sticks_x, sticks_y, over = bounded(want_x, want_y, bound)
    kept_x = wp.where(sticks_x, new_x, -knobs.shear_flexibility * shear_x)
    kept_y = wp.where(sticks_y, new_y, -knobs.shear_flexibility * shear_y)
    held_energy = knobs.shear_stiffness * (kept_x * kept_x + kept_y * kept_y)
    energy = wp.where(closed, elastic * pressed, zero) + held_energy
    slid = over * ((new_x - kept_x) * want_x + (new_y - kept_y) * want_y)
    if not CONE:
        slid = wp.sqrt((new_x - kept_x) * (new_x - kept_x) + (new_y - kept_y) * (new_y - kept_y))
    ux = wp.where(live, kept_x, old_x)
    uy = wp.where(live, kept_y, old_y)
    moved = wp.where(closed, slips + size(slid), larger(slips, FAILED))
    slip = wp.where(live, moved, slips)
    return normal, shear_x, shear_y, energy


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
    n1, x1, y1, e1 = spring(
        knobs, live, link.mu, dt, link.o - f * link.a3 - g * link.b3,
        link.v3 + f * link.j3 + g * link.k3, link.v1 + f * link.j1 + g * link.k1,
        link.v2 + f * link.j2 + g * link.k2, ux, uy, slip,
    )  # fmt: skip
    h, q = held_in(link, a, b)
    n2, x2, y2, e2 = spring(
        knobs, live, link.mu, dt, link.o - h * link.a3 - q * link.b3,
        link.v3 + h * link.j3 + q * link.k3, link.v1 + h * link.j1 + q * link.k1,
        link.v2 + h * link.j2 + q * link.k2, ux2, uy2, slip2,
    )  # fmt: skip
    # f n1 + h n2 by sums and differences, which mirrored scenes mirror to the last bit.
    h, f = share * real(0.5) * (h - f), share * real(0.5) * (h + f)
    q, g = share * real(0.5) * (q - g), share * real(0.5) * (q + g)
    n = n + share * (n1 + n2)
    na = na + (h * (n2 - n1) + f * (n1 + n2))
    nb = nb + (q * (n2 - n1) + g * (n1 + n2))
    t1 = t1 + share * (x1 + x2)
    ta1 = ta1 + (h * (x2 - x1) + f * (x1 + x2))
    tb1 = tb1 + (q * (x2 - x1) + g * (x1 + x2))
    t2 = t2 + share * (y1 + y2)
    ta2 = ta2 + (h * (y2 - y1) + f * (y1 + y2))
    tb2 = tb2 + (q * (y2 - y1) + g * (y1 + y2))
    e = e + share * (e1 + e2)


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
    s1, s2, s3 = cross(a1, a2, a3, ta1, ta2, na)
    r1, r2, r3 = cross(b1, b2, b3, tb1, tb2, nb)
    m1, m2, m3 = s1 + r1, s2 + r2, s3 + r3
    u1, u2, u3 = cross(p1, p2, p3, t1, t2, n)
    v1, v2, v3 = cross(d1, d2, d3, t1, t2, n)
    f1, f2, f3 = back_from(qx, qy, qz, qw, t1, t2, n)
    u1, u2, u3 = back_from(qx, qy, qz, qw, u1 + m1, u2 + m2, u3 + m3)
    v1, v2, v3 = back_from(qx, qy, qz, qw, v1 + m1, v2 + m2, v3 + m3)
    fx = fx + area * f1
    fy = fy + area * f2
    fz = fz + area * f3
    mx = mx + area * u1
    my = my + area * u2
    mz = mz + area * u3
    gx = gx - area * f1
    gy = gy - area * f2
    gz = gz - area * f3
    hx = hx - area * v1
    hy = hy - area * v2
    hz = hz - area * v3
    stored = stored + wp.where(live, real(0.5) * area * e, real(0.0))


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
    half, mass = real(0.5), block.mass
    ix, iy, iz = block.inverse_x, block.inverse_y, block.inverse_z
    over = real(1.0) / mass
    drag = knobs.mass_damping
    px, py, pz = over * fx - drag * vx, over * fy - drag * vy, over * fz - drag * vz
    ax, ay, az = over * mx - drag * lx, over * my - drag * ly, over * mz - drag * lz
    ux, uy = vx + span * px - dvx, vy + span * py - dvy
    uz = vz + span * (pz - knobs.gravity) - dvz
    kx, ky, kz = lx + span * ax, ly + span * ay, lz + span * az
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(qx, qy, qz, qw)
    o1, o2, o3 = in_axes(r11, r21, r31, r12, r22, r32, r13, r23, r33, lx + kx, ly + ky, lz + kz)
    e1, e2, e3 = in_axes(r11, r21, r31, r12, r22, r32, r13, r23, r33, ax, ay, az)
    moved = px * (vx + ux) + py * (vy + uy) + pz * (vz + uz)
    work = half * span * mass * (moved + (o1 * ix * e1 + o2 * iy * e2 + o3 * iz * e3))
    n1, n2, n3, n4 = turn_freely(qx, qy, qz, qw, kx, ky, kz, ix, iy, iz, dt)
    loss = loss - wp.where(live, work, real(0.0))
    x = wp.where(live, x + dt * ux, x)
    y = wp.where(live, y + dt * uy, y)
    z = wp.where(live, z + dt * uz, z)
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
