"""Velocity-level contact step of a block in space.

The block lives in the frame of the base, with mass 1: centre of mass (x, y, z), attitude q (see
shape_space/block.py), velocity v and angular momentum l, both in the axes of the base. Corner k is
at the lever r_k from the centre of mass; its gap is z + r_z, its velocity v + omega x r, omega = J
l, with J the inverse inertia in the axes of the base. One step of length dt is that of the planar
block (see impulse/block.py), with three rows a corner:

    1. v* = v - dt (0, 0, g) - dv, dv the change of the base velocity between the half steps;
    2. corners nearer than the collision margin are contacts. Each asks for a normal velocity of
       at least -gap / dt (it may close an open gap) or zero, and for no tangential velocity within
       Coulomb's bound |f| <= mu n;
    3. where all contacts can be stopped together, their impulses p = (f_x, f_y, n) pushing and
       with friction within the bound, they are (see impulse_space/block_hold.py): a fixed point of
       what follows, at which it need not begin. Else, where the block moves in a plane of its
       symmetry, that planar problem is solved exactly (see impulse_space/block_plane.py). Else
    4. projected Gauss-Seidel on the impulses, started from those of the last step, one corner
       after the other. With K the 3 x 3 matrix of velocity for impulse
       at the corner, p - K^-1 u stops it: if that pushes and its friction is within the bound, the
       corner sticks. Else n = max(n - u_z / K_zz, 0), and then the friction of a slip u_t: for the
       cone f - u_t / (largest eigenvalue of K_t), shortened to the bound, for the box f_x and f_y
       each within the bound. The cone's fixed points are those of Coulomb's law: a slip leaves
       f = - mu n u_t / |u_t|, in whatever direction;
    5. v = v* + sum of p, l = l + sum of r x p (J^-1 times the change of omega), and with them
       position and attitude, which rotates freely with the angular momentum l; the block is lifted
       by erp times its penetration but for the 2 g dt^2 that one step of falling can make.

A step visits first the corner away from the side that the block leans to, along its width and along
its depth, so that the corners of a mirrored scene are visited in mirrored order. In that order they
are numbered: sides (-,-), (+,-), (-,+), (+,+), with + towards the lean.

Step 3 is what keeps a block from turning about the vertical where sweeps are few: of two corners
close to each other they find the difference of the frictions slowly, b^2 / I_z beside h^2 / I_y for
each sweep (b half the way between the corners, h the height of the centre), and what they leave of
it, the corners being visited in turn, has always the same sign.

Jean and Moreau (1992) for the scheme, Catto (2005) for the solver.
"""

import warp as wp

from warprock.kernels.parting import CREEP, slack
from warprock.kernels.shape_space.block import (
    in_axes,
    inverse_inertia,
    matrix_of,
    product,
    turn_freely,
    vector_product,
)
from warprock.kernels.shape_space.contact import drag, holds, slip_gains, stop_gains

FAR = real(1.0e30)


@wp.struct
class Knobs:
    """What a step needs to know of the settings; `rate` is the inverse of the time step [1/s].

    `restitution` is read by impulse_space/thrown_run.py alone.
    """

    time_step: real
    rate: real
    gravity: real
    collision_margin: real
    erp: real
    sweeps: int
    restitution: real


@wp.func
def slips(square: real, knobs: Knobs) -> bool:
    """Whether what touches slides, from the square of its speed [m^2/s^2]."""
    creep = CREEP * knobs.time_step * knobs.gravity
    return square > creep * creep


@wp.func
def side_of(lean: real, rate: real, dv: real, before: real) -> real:
    """Side to which a block leans, -1 or 1: by its axis, else its motion, the base's, or before."""
    zero = real(0.0)
    moved = wp.where(rate != zero, rate, wp.where(dv != zero, -dv, before))
    return sign_of(wp.where(lean != zero, lean, moved))


@wp.func
def copy_vector(a: real, b: real, c: real, x: wp.ref[real], y: wp.ref[real], z: wp.ref[real]):
    """Hands over the three parts of a vector."""
    x = a
    y = b
    z = c


@wp.func
def predict(
    dvx: real, dvy: real, dvz: real, knobs: Knobs,
    qx: real, qy: real, qz: real, qw: real, lx: real, ly: real, lz: real,
    ix: real, iy: real, iz: real, vx: real, vy: real, vz: real,
    ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real],
    jxx: wp.ref[real], jxy: wp.ref[real], jxz: wp.ref[real],
    jyy: wp.ref[real], jyz: wp.ref[real], jzz: wp.ref[real],
    lean_x: wp.ref[real], lean_y: wp.ref[real], swap_x: wp.ref[real], swap_y: wp.ref[real],
    lowest: wp.ref[real],
):  # fmt: skip
    """Velocities u and omega (o) of a block without contact, and the sides it leans to, 1 or -1.

    Found are J, too, and in `swap_x` and `swap_y` whether each side is another than before: 1 or 0.
    The last is the lowest gap that the corners will tell of; here there is none.
    """
    one, zero = real(1.0), real(0.0)
    lowest = FAR
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(qx, qy, qz, qw)
    xx, xy, xz, yy, yz, zz = inverse_inertia(
        r11, r12, r13, r21, r22, r23, r31, r32, r33, ix, iy, iz
    )
    ux = vx - dvx
    uy = vy - dvy
    uz = vz - dvz - knobs.time_step * knobs.gravity
    wx, wy, wz = in_axes(xx, xy, xz, xy, yy, yz, xz, yz, zz, lx, ly, lz)
    copy_vector(xx, xy, xz, jxx, jxy, jxz)
    copy_vector(yy, yz, zz, jyy, jyz, jzz)
    ox = wx
    oy = wy
    oz = wz
    side_x = side_of(-r31, wy, dvx, lean_x)
    # A yaw turns round with the sense of x as with that of y.
    twist = qz * qw * side_x
    side_y = side_of(-r32, -wx, dvy, wp.where(twist != zero, twist, lean_y))
    swap_x = wp.where(side_x == lean_x, zero, one)
    swap_y = wp.where(side_y == lean_y, zero, one)
    lean_x = side_x
    lean_y = side_y


@wp.func
def swap_if(swap: real, a: wp.ref[real], b: wp.ref[real]):
    """Lets two numbers change places where `swap` is one."""
    first = real(a)
    a = wp.where(swap > real(0.0), b, first)
    b = wp.where(swap > real(0.0), first, b)


@wp.func
def observe_contact(
    knobs: Knobs, gap: real, reach: real, ox: real, oy: real, oz: real, n: real,
    apart: wp.ref[real], lifted: wp.ref[real], landed: wp.ref[real],
):  # fmt: skip
    """Counts a corner that has parted, or that has landed after it had; see parting.py.

    Args:
        knobs: Settings.
        gap: How wide it gapes after the last step [m].
        reach: At least its distance from the centre of mass [m].
        ox, oy, oz: Angular velocity [rad/s].
        n: What it carried in the last step.
        apart: 1 where it has parted and not landed since, else 0.
        lifted: Corners that have parted.
        landed: Corners that land.
    """
    zero, one, square = real(0.0), real(1.0), product(ox, oy, oz, ox, oy, oz)
    was = apart > zero
    limit = slack(knobs.time_step, knobs.gravity, reach, square, reach)
    landed = landed + wp.where(was and n > zero, one, zero)
    now = wp.where(gap > limit or (was and n <= zero), one, zero)
    lifted = lifted + now
    apart = now


@wp.func
def find_contact(
    corner: int, lean_x: real, lean_y: real, half_width: real, half_depth: real, half_height: real,
    cx: real, cy: real, z: real, knobs: Knobs, qx: real, qy: real, qz: real, qw: real,
    ox: real, oy: real, oz: real,
    rx: wp.ref[real], ry: wp.ref[real], rz: wp.ref[real], aim: wp.ref[real], on: wp.ref[real],
    fx: wp.ref[real], fy: wp.ref[real], n: wp.ref[real], apart: wp.ref[real],
    lowest: wp.ref[real], lifted: wp.ref[real], landed: wp.ref[real],
):  # fmt: skip
    """Finds a corner, and whether it is a contact; if not, it keeps no impulse.

    Found are its lever (rx, ry, rz) [m], the normal velocity that it aims at if it is a contact
    [m/s], and 1 in `on` if it is, else 0; what the last step made of it, see `observe_contact`.
    """
    zero = real(0.0)
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(qx, qy, qz, qw)
    ax = real(2 * (corner % 2) - 1) * lean_x * half_width - cx
    ay = real(2 * (corner // 2) - 1) * lean_y * half_depth - cy
    x, y, h = in_axes(r11, r12, r13, r21, r22, r23, r31, r32, r33, ax, ay, -half_height)
    rx = x
    ry = y
    rz = h
    g = z + h
    contact = g <= knobs.collision_margin
    lowest = smaller(lowest, g)
    observe_contact(
        knobs, g, half_width + half_depth + half_height, ox, oy, oz, n, apart, lifted, landed
    )
    aim = -larger(g, zero) * knobs.rate
    on = wp.where(contact, real(1.0), zero)
    fx = wp.where(contact, fx, zero)
    fy = wp.where(contact, fy, zero)
    n = wp.where(contact, n, zero)


@wp.func
def warm_start(
    on: real, x: real, y: real, h: real, fx: real, fy: real, n: real,
    jxx: real, jxy: real, jxz: real, jyy: real, jyz: real, jzz: real,
    kx: wp.ref[real], ky: wp.ref[real],
    pn: wp.ref[real], p1: wp.ref[real], p2: wp.ref[real], p3: wp.ref[real],
    h11: wp.ref[real], h12: wp.ref[real], h13: wp.ref[real],
    h22: wp.ref[real], h23: wp.ref[real], h33: wp.ref[real],
    ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real],
):  # fmt: skip
    """What impulses at a corner do that the sweeps visit, and starts it from its last ones.

    Found are kx and ky, slip for a normal impulse; and the impulses for velocities, zero where `on`
    is, for corners that need no sweep: pn, along z, p1 to p3 of `slip_gains`, h11 to h33 of
    `stop_gains`.
    """
    one = real(1.0)
    # J (r x e) for e along x, y, z: r x e is (0, h, -y), (-h, 0, x), (y, -x, 0).
    a1, b1, c1 = vector_product(jxx, jxy, jxz, x, y, h)
    a2, b2, c2 = vector_product(jxy, jyy, jyz, x, y, h)
    a3, b3, c3 = vector_product(jxz, jyz, jzz, x, y, h)
    kxx = fused_less(y, a3, fused(h, a2, one))
    kyy = fused_less(h, b1, fused(x, b3, one))
    kzz = fused_less(x, c2, fused(y, c1, one))
    kxy, kxz, kyz = fused_less(y, b3, h * b2), fused_less(y, c3, h * c2), fused_less(h, c1, x * c3)
    g1, g2, g3 = slip_gains(on, kxx, kxy, kyy)
    copy_vector(g1, g2, g3, p1, p2, p3)
    g1, g2, g3, g4, g5, g6 = stop_gains(on, kxx, kxy, kxz, kyy, kyz, kzz)
    copy_vector(g1, g2, g3, h11, h12, h13)
    copy_vector(g4, g5, g6, h22, h23, h33)
    kx = kxz
    ky = kyz
    pn = on / kzz
    px, py, pz = on * fx, on * fy, on * n
    ux = ux + px
    uy = uy + py
    uz = uz + pz
    ox = fused(c1, pz, fused(b1, py, fused(a1, px, ox)))
    oy = fused(c2, pz, fused(b2, py, fused(a2, px, oy)))
    oz = fused(c3, pz, fused(b3, py, fused(a3, px, oz)))


@wp.func
def solve_contact(
    mu: real, aim: real, rx: real, ry: real, rz: real,
    jxx: real, jxy: real, jxz: real, jyy: real, jyz: real, jzz: real, kx: real, ky: real,
    pn: real, p1: real, p2: real, p3: real,
    h11: real, h12: real, h13: real, h22: real, h23: real, h33: real,
    fx: wp.ref[real], fy: wp.ref[real], n: wp.ref[real],
    ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real],
):  # fmt: skip
    """Gauss-Seidel on the three impulses of a corner; mu is the friction coefficient."""
    zero = real(0.0)
    slip_x = fused_less(oz, ry, fused(oy, rz, ux))
    slip_y = fused_less(ox, rz, fused(oz, rx, uy))
    normal = fused_less(oy, rx, fused(ox, ry, uz - aim))
    stop_x = fused_less(h13, normal, fused_less(h12, slip_y, fused_less(h11, slip_x, fx)))
    stop_y = fused_less(h23, normal, fused_less(h22, slip_y, fused_less(h12, slip_x, fy)))
    stop_z = fused_less(h33, normal, fused_less(h23, slip_y, fused_less(h13, slip_x, n)))
    push = larger(fused_less(pn, normal, n), zero)
    dn = push - n
    # The slip that the normal impulse leaves.
    slip_x = fused(dn, kx, slip_x)
    slip_y = fused(dn, ky, slip_y)
    new_x, new_y = drag(mu * push, fx, fy, slip_x, slip_y, p1, p2, p3)
    sticks = holds(stop_x, stop_y, stop_z, mu)
    dx = wp.where(sticks, stop_x, new_x) - fx
    dy = wp.where(sticks, stop_y, new_y) - fy
    dz = wp.where(sticks, stop_z, push) - n
    fx = fx + dx
    fy = fy + dy
    n = n + dz
    ux = ux + dx
    uy = uy + dy
    uz = uz + dz
    x, y, z = vector_product(rx, ry, rz, dx, dy, dz)
    ox = fused(jxz, z, fused(jxy, y, fused(jxx, x, ox)))
    oy = fused(jyz, z, fused(jyy, y, fused(jxy, x, oy)))
    oz = fused(jzz, z, fused(jyz, y, fused(jxz, x, oz)))


@wp.func
def integrate(
    live: bool, knobs: Knobs, ix: real, iy: real, iz: real, dvx: real, dvy: real, dvz: real,
    ux: real, uy: real, uz: real, ox: real, oy: real, oz: real, lowest: real,
    x: wp.ref[real], y: wp.ref[real], z: wp.ref[real],
    qx: wp.ref[real], qy: wp.ref[real], qz: wp.ref[real], qw: wp.ref[real],
    vx: wp.ref[real], vy: wp.ref[real], vz: wp.ref[real],
    lx: wp.ref[real], ly: wp.ref[real], lz: wp.ref[real], loss: wp.ref[real],
):  # fmt: skip
    """Moves a block by a step, where its lane is alive.

    What its contacts take is added to the loss, for unit mass [J/kg]: the work of their impulses on
    the mean of the velocities before and after, less what lifting gives back.
    """
    dt, zero = knobs.time_step, real(0.0)
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(qx, qy, qz, qw)
    # Body axes: momentum before, and what the contacts have changed in the angular velocity.
    mx, my, mz = in_axes(r11, r21, r31, r12, r22, r32, r13, r23, r33, lx, ly, lz)
    bx, by, bz = in_axes(r11, r21, r31, r12, r22, r32, r13, r23, r33, ox, oy, oz)
    ax, ay, az = ix * mx, iy * my, iz * mz
    bx, by, bz = bx - ax, by - ay, bz - az
    hx, hy, hz = bx / ix, by / iy, bz / iz
    px = ux - vx + dvx
    py = uy - vy + dvy
    pz = uz - vz + dvz + dt * knobs.gravity
    linear = product(px, py, pz, vx + ux, vy + uy, vz + uz)
    angular = product(hx, hy, hz, ax + ax + bx, ay + ay + by, az + az + bz)
    lift = -knobs.erp * smaller(lowest + real(2.0) * dt * dt * knobs.gravity, zero)
    loss = loss - wp.where(live, HALF * (linear + angular) + knobs.gravity * lift, zero)
    vx = ux
    vy = uy
    vz = uz
    kx, ky, kz = in_axes(r11, r12, r13, r21, r22, r23, r31, r32, r33, hx, hy, hz)
    lx = lx + kx
    ly = ly + ky
    lz = lz + kz
    e, f, g, h = turn_freely(qx, qy, qz, qw, lx, ly, lz, ix, iy, iz, dt)
    x = wp.where(live, fused(dt, ux, x), x)
    y = wp.where(live, fused(dt, uy, y), y)
    z = wp.where(live, fused(dt, uz, z + lift), z)
    qx = wp.where(live, e, qx)
    qy = wp.where(live, f, qy)
    qz = wp.where(live, g, qz)
    qw = wp.where(live, h, qw)
