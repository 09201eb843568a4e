"""Impulses that stop all contacts of a block in space together, as one motion of the block.

Names are those of impulse_space/block.py; lengths and impulses are for mass 1. Contacts that are
stopped leave a block one motion: about the corner, about the line through two corners, or none flat
on its face, apart from what closes open gaps. With m the middle of what touches, w the half way
from the first to the last of two corners, A the moment of inertia about m, and s the angular
momentum about m, both less those of the motion that closes the gaps, omega is

    one corner:  A^-1 s        two:  w (w.s) / (w.A w)        four:  0,

and the centre of mass moves at m x omega. That takes the impulse e, whose moment about m is g. Four
corners share it by the pressure's centre, at the parts a and b of the half width and half depth:
e (1 +- a) (1 +- b) / 4, and a couple about the vertical. Two take halves of it, -+ g x w / (2 w.w),
and of what is along their line in proportion to their normal impulses.

Where the centre of pressure lies beyond the face, the corners on the far side are let go and the
others tried; the corners that were let go must then not sink. A block on three corners, and what
slides, is left to the sweeps.
"""

import warp as wp

from warprock.kernels.impulse_space.block import Knobs
from warprock.kernels.shape_space.block import (
    in_axes,
    inverse_inertia,
    matrix_of,
    product,
    vector_product,
)
from warprock.kernels.shape_space.contact import cofactors, holds

QUARTER = real(0.25)
WITHIN = by_precision(1.0 - 1.0e-12, 1.0 - 1.0e-5)
"""Part of the friction's bound up to which a corner sticks here: a sweep lets it, too."""
EVEN = real(1.0e-9)
"""Part of gravity's velocity in a step by which four corners may aim at no plane."""


@wp.func
def times(
    xx: real, xy: real, xz: real, yy: real, yz: real, zz: real, x: real, y: real, z: real
):  # fmt: skip
    """A symmetric matrix times a vector."""
    return in_axes(xx, xy, xz, xy, yy, yz, xz, yz, zz, x, y, z)


@wp.func
def over(xx: real, xy: real, xz: real, yy: real, yz: real, zz: real, x: real, y: real, z: real):
    """The inverse of a symmetric matrix times a vector."""
    c11, c12, c13, c22, c23, c33 = cofactors(xx, xy, xz, yy, yz, zz)
    part = real(1.0) / product(xx, xy, xz, c11, c12, c13)
    a, b, c = times(c11, c12, c13, c22, c23, c33, x, y, z)
    return part * a, part * b, part * c


@wp.func
def needed(
    vx: real, vy: real, vz: real, ox: real, oy: real, oz: real,
    ux: real, uy: real, uz: real, lx: real, ly: real, lz: real, mx: real, my: real, mz: real,
    xx: real, xy: real, xz: real, yy: real, yz: real, zz: real,
):  # fmt: skip
    """Impulse that leaves the motion v, o of a block that had u and l, and its moment about m."""
    ex, ey, ez = vx - ux, vy - uy, vz - uz
    gx, gy, gz = times(xx, xy, xz, yy, yz, zz, ox, oy, oz)
    px, py, pz = vector_product(ex, ey, ez, mx, my, mz)
    return ex, ey, ez, gx - lx + px, gy - ly + py, gz - lz + pz


@wp.func
def lying(
    t0: real, t1: real, t2: real, t3: real, ax: real, ay: real, az: real,
    bx: real, by: real, bz: real, cx: real, cy: real, cz: real,
):  # fmt: skip
    """Motion of a block on all of its corners, which move at t0 to t3 along the vertical."""
    part = QUARTER / fused_less(ay, bx, ax * by)
    tx, ty = part * (t1 - t0 + (t3 - t2)), part * (t2 - t0 + (t3 - t1))
    ox, oy = fused_less(tx, bx, ty * ax), fused_less(tx, by, ty * ay)
    oz = fused_less(tx, bz, ty * az)
    vx, vy, vz = vector_product(cx, cy, cz, ox, oy, oz)
    return vx, vy, vz + QUARTER * (t0 + t3 + (t1 + t2)), ox, oy, oz


@wp.func
def rolling(
    first: real, last: real, alone: bool, ux: real, uy: real, uz: real,
    lx: real, ly: real, lz: real, wx: real, wy: real, wz: real, mx: real, my: real, mz: real,
    xx: real, xy: real, xz: real, yy: real, yz: real, zz: real,
):  # fmt: skip
    """Motion of a block on one corner, alone, or on two, which move at `first` and `last`."""
    closes = HALF * (last - first) / larger(product(wx, wy, wz, wx, wy, wz), TINY)
    ox, oy, rise = closes * wy, -closes * wx, HALF * (first + last)
    vx, vy, vz = fused(mz, oy, ux), fused_less(mz, ox, uy), uz - rise - fused_less(my, ox, mx * oy)
    px, py, pz = vector_product(vx, vy, vz, mx, my, mz)
    gx, gy, gz = dot(xx, xy, ox, oy), dot(xy, yy, ox, oy), dot(xz, yz, ox, oy)
    sx, sy, sz = lx - gx + px, ly - gy + py, lz - gz + pz
    mm = product(mx, my, mz, mx, my, mz)
    axx, axy, axz = fused_less(mx, mx, xx + mm), fused_less(mx, my, xy), fused_less(mx, mz, xz)
    ayy, ayz, azz = fused_less(my, my, yy + mm), fused_less(my, mz, yz), fused_less(mz, mz, zz + mm)
    gx, gy, gz = times(axx, axy, axz, ayy, ayz, azz, wx, wy, wz)
    spin = product(wx, wy, wz, sx, sy, sz) / larger(product(wx, wy, wz, gx, gy, gz), TINY)
    px, py, pz = over(axx, axy, axz, ayy, ayz, azz, sx, sy, sz)
    ox = wp.where(alone, ox + px, fused(spin, wx, ox))
    oy = wp.where(alone, oy + py, fused(spin, wy, oy))
    oz = wp.where(alone, pz, spin * wz)
    vx, vy, vz = vector_product(mx, my, mz, ox, oy, oz)
    return vx, vy, vz + rise, ox, oy, oz


@wp.func
def share(
    i: real, j: real, on: real, count: real, si: real, sj: real,
    a: real, b: real, couple: real, ax: real, ay: real, bx: real, by: real,
    ex: real, ey: real, ez: real, qx: real, qy: real, qz: real,
):  # fmt: skip
    """Impulse of the corner on the sides i and j, where it is held.

    Args:
        i, j: Sides of the corner, -1 or 1.
        on: 1 where it is held, else 0.
        count: Number of corners that are held.
        si, sj: Sides of the last of two corners as seen from the first.
        a, b, couple: Of four corners, see `centre`.
        ax, ay, bx, by: Of four corners, half of the width and half of the depth of the face.
        ex, ey, ez: Impulse of all of them.
        qx, qy, qz: Of two corners, what the last has beyond one half.
    """
    zero, one = real(0.0), real(1.0)
    end = larger(smaller(dot(i, j, si, sj), one), -one)
    flat, half = count == real(4.0), wp.where(count == one, one, HALF)
    part = wp.where(flat, QUARTER * fused(i, a, one) * fused(j, b, one), half)
    x = fused(part, ex, wp.where(flat, -couple * dot(i, j, ay, by), end * qx))
    y = fused(part, ey, wp.where(flat, couple * dot(i, j, ax, bx), end * qy))
    z = fused(part, ez, wp.where(flat, zero, end * qz))
    # Not on * x: where nothing touches, x may be infinite.
    touches = on > zero
    return wp.where(touches, x, zero), wp.where(touches, y, zero), wp.where(touches, z, zero)


@wp.func
def sinks(
    dropped: real, aim: real, i: real, j: real, ax: real, ay: real, bx: real, by: real,
    cx: real, cy: real, vz: real, ox: real, oy: real,
) -> bool:  # fmt: skip
    """Whether a corner that is let go would sink."""
    x, y = fused(j, bx, fused(i, ax, cx)), fused(j, by, fused(i, ay, cy))
    rise = fused_less(oy, x, fused(ox, y, vz))
    return dropped > real(0.0) and rise < aim


@wp.func
def keep(held: bool, x: real, y: real, z: real, a: wp.ref[real], b: wp.ref[real], c: wp.ref[real]):
    """Writes a vector where a block is held. Zero is added so that no number is -0."""
    zero = real(0.0)
    a = wp.where(held, x, a) + zero
    b = wp.where(held, y, b) + zero
    c = wp.where(held, z, c) + zero


@wp.func
def foremost(k0: real, k1: real, k2: real, x0: real, x1: real, x2: real, x3: real) -> real:
    """The number of the first corner whose k is not zero; that of the last if there is none."""
    zero = real(0.0)
    return wp.where(k0 > zero, x0, wp.where(k1 > zero, x1, wp.where(k2 > zero, x2, x3)))


@wp.func
def ends(flat: bool, k0: real, k1: real, k2: real, k3: real):
    """Half the way from the first to the last held corner, and their middle, as parts of the face.

    Each along the half width and along the half depth; zero where all four are held.
    """
    one, part = real(1.0), wp.where(flat, real(0.0), HALF)
    i = foremost(k0, k1, k2, -one, one, -one, one)
    j = foremost(k0, k1, k2, -one, -one, one, one)
    x = foremost(k3, k2, k1, one, -one, one, -one)
    y = foremost(k3, k2, k1, one, one, -one, -one)
    return part * (x - i), part * (y - j), part * (x + i), part * (y + j)


@wp.func
def tried(s0: real, s1: real, s2: real, s3: real, push: real, a: real, b: real):
    """Which contacts to hold: of four those on the side of the pressure's centre (a, b)."""
    zero, one = real(0.0), real(1.0)
    full = s0 * s1 * s2 * s3 > zero and push > zero
    return (
        wp.where(full and (a > one or b > one), zero, s0),
        wp.where(full and (a < -one or b > one), zero, s1),
        wp.where(full and (a > one or b < -one), zero, s2),
        wp.where(full and (a < -one or b < -one), zero, s3),
    )


@wp.func
def centre(
    ex: real, ey: real, ez: real, gx: real, gy: real, gz: real, ax: real, ay: real, bx: real,
    by: real,
):  # fmt: skip
    """How four corners share an impulse e with the moment g about their middle.

    Returns:
        The centre of pressure along the half width a and the half depth b, and the couple of their
        friction beside what is in proportion to the pressure, over the levers.
    """
    part = real(1.0) / (larger(ez, TINY) * fused_less(ay, bx, ax * by))
    a, b = -part * dot(gx, gy, bx, by), part * dot(gx, gy, ax, ay)
    moment = fused_less(dot(a, b, ay, by), ex, dot(a, b, ax, bx) * ey)
    couple = QUARTER * (gz - moment) / (dot(ax, ay, ax, ay) + dot(bx, by, bx, by))
    return a, b, couple


@wp.func
def stopped(
    s0: real, s1: real, s2: real, s3: real, t0: real, t1: real, t2: real, t3: real,
    ux: real, uy: real, uz: real, lx: real, ly: real, lz: real,
    ax: real, ay: real, az: real, bx: real, by: real, bz: real, cx: real, cy: real, cz: real,
    xx: real, xy: real, xz: real, yy: real, yz: real, zz: real,
):  # fmt: skip
    """Motion of a block whose contacts are stopped, or those that the pressure's centre lies by.

    s tells the contacts, 1 or 0, and t their normal velocities [m/s]; u, l is the motion without
    contact; a and b are half width and half depth towards the lean, c is the face's middle [m].

    Returns:
        Which corners are held, 1 or 0; the way from the first to the last of two over half width
        and half depth; velocity and angular velocity; impulse, and its moment about their middle.
    """
    vx, vy, vz, ox, oy, oz = lying(t0, t1, t2, t3, ax, ay, az, bx, by, bz, cx, cy, cz)
    ex, ey, ez, gx, gy, gz = needed(
        vx, vy, vz, ox, oy, oz, ux, uy, uz, lx, ly, lz, cx, cy, cz, xx, xy, xz, yy, yz, zz
    )
    a, b, _c = centre(ex, ey, ez, gx, gy, gz, ax, ay, bx, by)
    k0, k1, k2, k3 = tried(s0, s1, s2, s3, ez, a, b)
    count = k0 + k1 + k2 + k3
    flat = count == real(4.0)
    si, sj, i, j = ends(flat, k0, k1, k2, k3)
    wx, wy, wz = dot(si, sj, ax, bx), dot(si, sj, ay, by), dot(si, sj, az, bz)
    mx, my, mz = cx + dot(i, j, ax, bx), cy + dot(i, j, ay, by), cz + dot(i, j, az, bz)
    fx, fy, fz, px, py, pz = rolling(
        foremost(k0, k1, k2, t0, t1, t2, t3), foremost(k3, k2, k1, t3, t2, t1, t0),
        count == real(1.0), ux, uy, uz, lx, ly, lz, wx, wy, wz, mx, my, mz,
        xx, xy, xz, yy, yz, zz,
    )  # fmt: skip
    vx, vy, vz = wp.where(flat, vx, fx), wp.where(flat, vy, fy), wp.where(flat, vz, fz)
    ox, oy, oz = wp.where(flat, ox, px), wp.where(flat, oy, py), wp.where(flat, oz, pz)
    ex, ey, ez, gx, gy, gz = needed(
        vx, vy, vz, ox, oy, oz, ux, uy, uz, lx, ly, lz, mx, my, mz, xx, xy, xz, yy, yz, zz
    )
    return k0, k1, k2, k3, si, sj, vx, vy, vz, ox, oy, oz, ex, ey, ez, gx, gy, gz


@wp.func
def beyond(
    ex: real, ey: real, ez: real, gx: real, gy: real, gz: real, wx: real, wy: real, wz: real
):  # fmt: skip
    """Part of the impulse of two corners that the last has beyond one half; w as at the head."""
    part = HALF / larger(product(wx, wy, wz, wx, wy, wz), TINY)
    qx, qy, qz = vector_product(gx, gy, gz, wx, wy, wz)
    qx, qy, qz = part * qx, part * qy, part * qz
    along = (part + part) * product(ex, ey, ez, wx, wy, wz) * qz / larger(ez, TINY)
    return fused(along, wx, qx), fused(along, wy, qy), fused(along, wz, qz)


@wp.func
def hold(
    knobs: Knobs, lean_x: real, lean_y: real, half_width: real, half_depth: real, half_height: real,
    cx: real, cy: real, mu: real, qx: real, qy: real, qz: real, qw: real,
    ix: real, iy: real, iz: real, lx: real, ly: real, lz: real,
    aim0: real, aim1: real, aim2: real, aim3: real,
    on0: wp.ref[real], on1: wp.ref[real], on2: wp.ref[real], on3: wp.ref[real],
    fx0: wp.ref[real], fx1: wp.ref[real], fx2: wp.ref[real], fx3: wp.ref[real],
    fy0: wp.ref[real], fy1: wp.ref[real], fy2: wp.ref[real], fy3: wp.ref[real],
    n0: wp.ref[real], n1: wp.ref[real], n2: wp.ref[real], n3: wp.ref[real],
    ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real],
):  # fmt: skip
    """Stops the contacts of a block together, where that obeys the law of contact.

    Then its velocities and impulses are those, and no corner is left to the sweeps: `on` becomes 0.
    """
    zero, one = real(0.0), real(1.0)
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(qx, qy, qz, qw)
    # Moments of inertia; half width a and half depth b, each towards the lean; the face's middle.
    xx, xy, xz, yy, yz, zz = inverse_inertia(
        r11, r12, r13, r21, r22, r23, r31, r32, r33, one / ix, one / iy, one / iz
    )
    w, d = lean_x * half_width, lean_y * half_depth
    ax, ay, az, bx, by, bz = r11 * w, r21 * w, r31 * w, r12 * d, r22 * d, r32 * d
    mx, my, mz = in_axes(r11, r12, r13, r21, r22, r23, r31, r32, r33, -cx, -cy, -half_height)
    s0, s1, s2, s3 = real(on0), real(on1), real(on2), real(on3)
    t0, t1, t2, t3 = s0 * aim0, s1 * aim1, s2 * aim2, s3 * aim3
    k0, k1, k2, k3, si, sj, vx, vy, vz, px, py, pz, ex, ey, ez, gx, gy, gz = stopped(
        s0, s1, s2, s3, t0, t1, t2, t3, ux, uy, uz, lx, ly, lz, ax, ay, az, bx, by, bz, mx, my, mz,
        xx, xy, xz, yy, yz, zz,
    )  # fmt: skip
    count = k0 + k1 + k2 + k3
    a, b, c = centre(ex, ey, ez, gx, gy, gz, ax, ay, bx, by)
    x, y, z = beyond(
        ex, ey, ez, gx, gy, gz, dot(si, sj, ax, bx), dot(si, sj, ay, by), dot(si, sj, az, bz)
    )
    x0, y0, z0 = share(-one, -one, k0, count, si, sj, a, b, c, ax, ay, bx, by, ex, ey, ez, x, y, z)
    x1, y1, z1 = share(one, -one, k1, count, si, sj, a, b, c, ax, ay, bx, by, ex, ey, ez, x, y, z)
    x2, y2, z2 = share(-one, one, k2, count, si, sj, a, b, c, ax, ay, bx, by, ex, ey, ez, x, y, z)
    x3, y3, z3 = share(one, one, k3, count, si, sj, a, b, c, ax, ay, bx, by, ex, ey, ez, x, y, z)
    uneven = size(t0 - t1 - t2 + t3) > EVEN * knobs.gravity * knobs.time_step
    fits = count != real(3.0) and not (count == real(4.0) and uneven)
    fits = fits and holds(x0, y0, z0, WITHIN * mu) and holds(x1, y1, z1, WITHIN * mu)
    fits = fits and holds(x2, y2, z2, WITHIN * mu) and holds(x3, y3, z3, WITHIN * mu)
    fits = fits and not sinks(s0 - k0, t0, -one, -one, ax, ay, bx, by, mx, my, vz, px, py)
    fits = fits and not sinks(s1 - k1, t1, one, -one, ax, ay, bx, by, mx, my, vz, px, py)
    fits = fits and not sinks(s2 - k2, t2, -one, one, ax, ay, bx, by, mx, my, vz, px, py)
    fits = fits and not sinks(s3 - k3, t3, one, one, ax, ay, bx, by, mx, my, vz, px, py)
    keep(fits, x0, y0, z0, fx0, fy0, n0)
    keep(fits, x1, y1, z1, fx1, fy1, n1)
    keep(fits, x2, y2, z2, fx2, fy2, n2)
    keep(fits, x3, y3, z3, fx3, fy3, n3)
    keep(fits and count > zero, vx, vy, vz, ux, uy, uz)
    keep(fits and count > zero, px, py, pz, ox, oy, oz)
    on0 = wp.where(fits, zero, s0)
    on1 = wp.where(fits, zero, s1)
    on2 = wp.where(fits, zero, s2)
    on3 = wp.where(fits, zero, s3)
