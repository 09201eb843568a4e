"""Impulses that stop contact points of a body in space together, as one motion of the body.

What impulse_space/block_hold.py does for the four corners of a block, for any points. Points that
are held leave a body one motion: about the point, about the line through them, or none where they
span a plane, apart from what closes open gaps. With m their middle, w along their line, A the
moment of inertia about m, and s the angular momentum about m, both less those of the motion that
closes the gaps, omega is

    one point:  A^-1 s        a line:  w (w.s) / (w.A w)        a plane:  0,

and the centre of mass moves at m x omega. That takes the impulse e, whose moment about m is g. The
normal impulses are the plane n = a + b.(r - m) over the points that carries e_z, g_x and g_y, as of
a bed of equal springs; the friction of a point is n times what is one motion along the base,
(e_x, e_y) / e_z and a turn about the centre of pressure, that carries g_z.

Which points are held is found in rounds, beginning with all contacts: a point that would pull is
let go, one that would sink is held. Where rounds do not end, or friction is not enough, the sweeps
of impulse_space/block.py do the rest.
"""

import warp as wp

from warprock.kernels.impulse_space.block import Knobs, copy_vector
from warprock.kernels.impulse_space.block_hold import WITHIN, over, times
from warprock.kernels.shape_space.block import inverse_inertia, product, vector_product
from warprock.kernels.shape_space.body import APART, divide_by_moments, spans
from warprock.kernels.shape_space.contact import holds

LEFT = by_precision(1.0e-9, 1.0e-2)
"""Part of gravity's velocity in a step by which a point may miss what it aims at: round-off."""
ROUNDS = 6
"""Most rounds in which the held points are looked for."""


@wp.func
def add_held(
    held: real, x: real, y: real, z: real, aim: real,
    count: wp.ref[real], sx: wp.ref[real], sy: wp.ref[real], sz: wp.ref[real],
    xx: wp.ref[real], xy: wp.ref[real], yy: wp.ref[real], zx: wp.ref[real], zy: wp.ref[real],
    t: wp.ref[real], tx: wp.ref[real], ty: wp.ref[real],
):  # fmt: skip
    """Adds a point to the sums over the held ones: of their places and aims, and of products."""
    on = held > real(0.0)
    a, b, c, d = wp.where(on, x, real(0.0)), wp.where(on, y, real(0.0)), held * z, held * aim
    count = count + held
    sx = sx + a
    sy = sy + b
    sz = sz + c
    xx = xx + a * a
    xy = xy + a * b
    yy = yy + b * b
    zx = zx + c * a
    zy = zy + c * b
    t = t + d
    tx = tx + d * a
    ty = ty + d * b


@wp.func
def clear_sums(
    count: wp.ref[real], xx: wp.ref[real], xy: wp.ref[real], yy: wp.ref[real],
    zx: wp.ref[real], zy: wp.ref[real], t: wp.ref[real], tx: wp.ref[real], ty: wp.ref[real],
):  # fmt: skip
    """Makes the sums of `add_held` zero but those that become the middle of the points."""
    count = real(0.0)
    xx = real(0.0)
    xy = real(0.0)
    yy = real(0.0)
    zx = real(0.0)
    zy = real(0.0)
    t = real(0.0)
    tx = real(0.0)
    ty = real(0.0)


@wp.func
def rolling(
    alone: bool, x: real, y: real, z: real, wx: real, wy: real, wz: real,
    sx: real, sy: real, sz: real, xx: real, xy: real, xz: real, yy: real, yz: real, zz: real,
):  # fmt: skip
    """Angular velocity about a point m (x, y, z), alone, or a line w through it, from s about m.

    xx to zz are moments of inertia about the centre of mass.
    """
    mm = product(x, y, z, x, y, z)
    axx, axy, axz = xx + mm - x * x, xy - x * y, xz - x * z
    ayy, ayz, azz = yy + mm - y * y, yz - y * z, zz + mm - z * z
    hx, hy, hz = times(axx, axy, axz, ayy, ayz, azz, wx, wy, wz)
    spin = product(wx, wy, wz, sx, sy, sz) / larger(product(wx, wy, wz, hx, hy, hz), TINY)
    hx, hy, hz = over(axx, axy, axz, ayy, ayz, azz, sx, sy, sz)
    return (
        wp.where(alone, hx, spin * wx), wp.where(alone, hy, spin * wy),
        wp.where(alone, hz, spin * wz),
    )  # fmt: skip


@wp.func
def find_motion(
    reach: real, ux: real, uy: real, uz: real, px: real, py: real, pz: real, lx: real, ly: real,
    lz: real, r11: real, r12: real, r13: real, r21: real, r22: real, r23: real, r31: real,
    r32: real, r33: real, ix: real, iy: real, iz: real, count: wp.ref[real], mx: wp.ref[real],
    my: wp.ref[real], mz: wp.ref[real], xx: wp.ref[real], xy: wp.ref[real], yy: wp.ref[real],
    zx: wp.ref[real], zy: wp.ref[real], t: wp.ref[real], tx: wp.ref[real], ty: wp.ref[real],
    vx: wp.ref[real], vy: wp.ref[real], vz: wp.ref[real], ox: wp.ref[real], oy: wp.ref[real],
    oz: wp.ref[real], ex: wp.ref[real], ey: wp.ref[real], ez: wp.ref[real], gz: wp.ref[real],
    push: wp.ref[real], bx: wp.ref[real], by: wp.ref[real],
):  # fmt: skip
    """Motion v, o of a body whose held points are stopped, from u, p and l without contact.

    The sums over the held points become their middle m, and zero for the next round. Found are the
    impulse e, its moment about the vertical g_z, and the plane of the normal impulses.
    """
    zero, one = real(0.0), real(1.0)
    over_count = one / larger(count, one)
    ax, ay, az, rise = over_count * mx, over_count * my, over_count * mz, over_count * t
    axx, axy, ayy = xx - mx * ax, xy - mx * ay, yy - my * ay
    flat, whole = spans(count, axx, axy, ayy), axx + ayy
    some, alone = count > zero, count < real(1.5) or whole <= APART * reach * reach
    # Slopes of the plane, or the line, through the points; and of their aims.
    slope_x, slope_y = divide_by_moments(flat, alone, axx, axy, ayy, zx - mz * ax, zy - mz * ay)
    climb_x, climb_y = divide_by_moments(flat, alone, axx, axy, ayy, tx - t * ax, ty - t * ay)
    ox = climb_y
    oy = -climb_x
    # In the plane of the points; what closes gaps along a line is level.
    oz = wp.where(flat, ox * slope_x + oy * slope_y, zero)
    # Along the line: its direction is the longer column of the second moments.
    wide = axx >= ayy
    wx, wy = wp.where(wide, axx, axy), wp.where(wide, axy, ayy)
    wz = slope_x * wx + slope_y * wy
    ixx, ixy, ixz, iyy, iyz, izz = inverse_inertia(
        r11, r12, r13, r21, r22, r23, r31, r32, r33, one / ix, one / iy, one / iz
    )
    sx, sy, sz = vector_product(ax, ay, az, ox, oy, zero)
    sx, sy, sz = vector_product(ux - sx, uy - sy, uz - sz - rise, ax, ay, az)
    hx, hy, hz = times(ixx, ixy, ixz, iyy, iyz, izz, ox, oy, zero)
    sx, sy, sz = lx - hx + sx, ly - hy + sy, lz - hz + sz
    hx, hy, hz = rolling(alone, ax, ay, az, wx, wy, wz, sx, sy, sz, ixx, ixy, ixz, iyy, iyz, izz)
    ox = ox + wp.where(flat, zero, hx)
    oy = oy + wp.where(flat, zero, hy)
    oz = oz + wp.where(flat, zero, hz)
    sx, sy, sz = vector_product(ax, ay, az, ox, oy, oz)
    vx = wp.where(some, sx, ux)
    vy = wp.where(some, sy, uy)
    vz = wp.where(some, sz + rise, uz)
    ox = wp.where(some, ox, px)
    oy = wp.where(some, oy, py)
    oz = wp.where(some, oz, pz)
    copy_vector(vx - ux, vy - uy, vz - uz, ex, ey, ez)
    hx, hy, hz = times(ixx, ixy, ixz, iyy, iyz, izz, ox, oy, oz)
    sx, sy, sz = vector_product(ex, ey, ez, ax, ay, az)
    gz = hz - lz + sz
    push = over_count * ez
    sx, sy = divide_by_moments(flat, alone, axx, axy, ayy, ly - hy - sy, hx - lx + sx)
    bx = sx
    by = sy
    copy_vector(ax, ay, az, mx, my, mz)
    clear_sums(count, xx, xy, yy, zx, zy, t, tx, ty)


@wp.func
def judge(
    knobs: Knobs, on: real, aim: real, x: real, y: real, mx: real, my: real,
    vz: real, ox: real, oy: real, push: real, bx: real, by: real,
    held: wp.ref[real], same: wp.ref[real],
):  # fmt: skip
    """Lets a held point go that would pull, holds one that would sink; `same` is 0 then."""
    zero, one = real(0.0), real(1.0)
    # What is no contact may lie anywhere.
    n = push + bx * (x - mx) + by * (y - my)
    sinks = vz + ox * y - oy * x < aim - LEFT * knobs.gravity * knobs.time_step
    was = held > zero
    now = on > zero and ((was and n > zero) or (not was and sinks))
    held = wp.where(now, one, zero)
    same = wp.where(now == was, same, zero)


@wp.func
def add_pressure(
    held: real, x: real, y: real, mx: real, my: real, push: real, bx: real, by: real,
    sx: wp.ref[real], sy: wp.ref[real], sq: wp.ref[real],
):  # fmt: skip
    """Adds a point to the moments of the normal impulses about m: first ones and the polar one."""
    ax, ay = x - mx, y - my
    n = wp.where(held > real(0.0), push + bx * ax + by * ay, real(0.0))
    sx = sx + n * ax
    sy = sy + n * ay
    sq = sq + n * (ax * ax + ay * ay)


@wp.func
def find_turn(
    ex: real, ey: real, ez: real, gz: real, mx: real, my: real,
    sx: wp.ref[real], sy: wp.ref[real], sq: wp.ref[real],
):  # fmt: skip
    """From the sums of `add_pressure`: the centre of pressure, and friction's turn about it."""
    part = real(1.0) / larger(ez, TINY)
    cx, cy = part * sx, part * sy
    polar = sq - (sx * cx + sy * cy)
    sq = wp.where(polar > TINY, (gz - (cx * ey - cy * ex)) / larger(polar, TINY), real(0.0))
    sx = mx + cx
    sy = my + cy


@wp.func
def share(
    knobs: Knobs, mu: real, on: real, held: real, aim: real, x: real, y: real, mx: real, my: real,
    push: real, bx: real, by: real, ex: real, ey: real, ez: real, cx: real, cy: real, turn: real,
    vz: real, ox: real, oy: real,
    fx: wp.ref[real], fy: wp.ref[real], n: wp.ref[real], good: wp.ref[real],
):  # fmt: skip
    """Impulse of a point; `good` becomes 0 where it does not obey the law of contact.

    A held point moves as it aims to, and pushes with friction within the bound; another one carries
    nothing and does not sink.
    """
    zero, part = real(0.0), real(1.0) / larger(ez, TINY)
    touches = held > zero
    push_n = push + bx * (x - mx) + by * (y - my)
    new_x = push_n * (part * ex - turn * (y - cy))
    new_y = push_n * (part * ey + turn * (x - cx))
    left = vz + ox * y - oy * x - aim
    dust = LEFT * knobs.gravity * knobs.time_step
    held_well = size(left) <= dust and holds(new_x, new_y, push_n, WITHIN * mu)
    obeys = on <= zero or (touches and held_well) or (not touches and left >= -dust)
    good = wp.where(obeys, good, zero)
    fx = wp.where(touches, new_x, zero)
    fy = wp.where(touches, new_y, zero)
    n = wp.where(touches, push_n, zero)


@wp.func
def keep(
    good: bool, a: real, b: real, c: real, d: real, e: real, f: real,
    ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real],
    mx: wp.ref[real], my: wp.ref[real], mz: wp.ref[real],
    cx: wp.ref[real], cy: wp.ref[real], turn: wp.ref[real],
):  # fmt: skip
    """Writes the velocities of a body that is held; sums become zero for the next step."""
    ux = wp.where(good, a, ux)
    uy = wp.where(good, b, uy)
    uz = wp.where(good, c, uz)
    ox = wp.where(good, d, ox)
    oy = wp.where(good, e, oy)
    oz = wp.where(good, f, oz)
    mx = real(0.0)
    my = real(0.0)
    mz = real(0.0)
    cx = real(0.0)
    cy = real(0.0)
    turn = real(0.0)


@wp.func
def take(
    good: bool, a: real, b: real, c: real,
    fx: wp.ref[real], fy: wp.ref[real], n: wp.ref[real], on: wp.ref[real],
):  # fmt: skip
    """Writes the impulse of a point where its body is held: the sweeps then leave it alone."""
    fx = wp.where(good, a, fx)
    fy = wp.where(good, b, fy)
    n = wp.where(good, c, n)
    on = wp.where(good, real(0.0), on)
