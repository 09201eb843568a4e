"""Sweeps over the corners of a block in space that moves in a plane of its own symmetry.

More than one motion may obey Coulomb's law in an impact with friction. A block that comes down flat
and slides may tip over the edge ahead; it may as well take the whole impulse on one corner of that
edge, turn about the vertical, and lift all others. Corners that are visited in turn find the
second: the first one leaves the next nothing to carry.

So where a block moves in a plane of its symmetry, both corners of an edge across that plane change
at once: the first by half of what it asks for, the second by the mirror image of that. Together
that is about as much as one corner would, so that they converge no slower. The mirror image keeps
them from telling round-off apart: friction of corners that hardly slide would double it in a step.
What is a fixed point does not change. Elsewhere the corners of an edge have nothing in common, and
halves would converge far slower.

Such an edge is that of the corners 0 and 1, or 2 and 3: a block that moves along its width has its
corners 1 and 2 change their numbers, so that they are (-,-), (-,+), (+,-), (+,+).
"""

import warp as wp

from warprock.kernels.impulse_space.block import Knobs, change_of
from warprock.kernels.shape_space.block import matrix_of, vector_product

PLANE = by_precision(1.0e-6, 1.0e-3)
"""Part of its motion by which a block may leave a plane that it moves in: round-off that grew."""


@wp.func
def find_pairs(
    knobs: Knobs, half_height: real, qx: real, qy: real, qz: real, qw: real,
    ux: real, uy: real, ox: real, oy: real, across: wp.ref[real], paired: wp.ref[real],
    turn: wp.ref[real], swap_x: wp.ref[real], swap_y: wp.ref[real],
):  # fmt: skip
    """Finds whether a block moves in a plane of its symmetry, and which.

    Args:
        knobs: Settings.
        half_height: Of the block [m].
        qx, qy, qz, qw: Its attitude.
        ux, uy: Horizontal velocity without contact [m/s].
        ox, oy: Angular velocity about horizontal axes [rad/s].
        across: 1 where it moves along its width, and its corners are numbered for that, else 0.
        paired: 1 where it moves in a plane of its symmetry, else 0.
        turn: 1 where the corners 1 and 2 change places, else 0.
        swap_x, swap_y: Whether it leans to another side along the width and along the depth, 1 or
            0; these become the same for the ways from the corner 0 to 1 and to 2 as they were.
    """
    one, zero = real(1.0), real(0.0)
    r11, r12, _13, r21, r22, _23, r31, r32, _33 = matrix_of(qx, qy, qz, qw)
    # How fast it moves along its width and along its depth, how fast it turns that way, its lean.
    fall = knobs.gravity * knobs.time_step
    along = size(dot(r11, r21, ux, uy)) + half_height * size(dot(r12, r22, ox, oy))
    aside = size(dot(r12, r22, ux, uy)) + half_height * size(dot(r11, r21, ox, oy))
    along = along + fall * size(r31)
    aside = aside + fall * size(r32)
    before = across
    across = wp.where(aside <= PLANE * along, one, zero)
    paired = wp.where(aside <= PLANE * along or along <= PLANE * aside, one, zero)
    turn = wp.where(across == before, zero, one)
    first, second = real(swap_x), real(swap_y)
    swap_x = wp.where(before > zero, second, first)
    swap_y = wp.where(before > zero, first, second)


@wp.func
def is_paired(paired: real, on: real, other: real) -> real:
    """1 where a corner changes at once with the other one of its edge, else 0."""
    return paired * on * other


@wp.func
def along_edge(
    ax: real, ay: real, bx: real, by: real, mx: wp.ref[real], my: wp.ref[real]
):  # fmt: skip
    """Horizontal direction of the edge from a corner at the lever a to one at the lever b."""
    x, y = bx - ax, by - ay
    part = real(1.0) / wp.sqrt(larger(dot(x, y, x, y), TINY))
    mx = part * x
    my = part * y


@wp.func
def mirror_impulse(
    tie: real, mx: real, my: real, ax: real, ay: real, az: real,
    bx: wp.ref[real], by: wp.ref[real], bz: wp.ref[real],
):  # fmt: skip
    """Starts the second corner of an edge m, where they are tied, from the first one's impulse a.

    Else what round-off made them differ by would stay, and turn the block step by step.
    """
    tied, back = tie > real(0.0), TWO * dot(ax, ay, mx, my)
    bx = wp.where(tied, fused_less(back, mx, ax), bx)
    by = wp.where(tied, fused_less(back, my, ay), by)
    bz = wp.where(tied, az, bz)


@wp.func
def solve_paired(
    corner: int, tie: real, mx: real, my: real, mu: real, aim: real, rx: real, ry: real, rz: real,
    jxx: real, jxy: real, jxz: real, jyy: real, jyz: real, jzz: real, kx: real, ky: real,
    pn: real, p1: real, p2: real, p3: real,
    h11: real, h12: real, h13: real, h22: real, h23: real, h33: real,
    fx: wp.ref[real], fy: wp.ref[real], n: wp.ref[real],
    ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real],
    gx: wp.ref[real], gy: wp.ref[real], gz: wp.ref[real],
    sx: wp.ref[real], sy: wp.ref[real], sz: wp.ref[real],
):  # fmt: skip
    """One corner of a sweep, as `solve_contact`; where `tie` is 1, with the other of its edge m.

    What the first of two changes is kept in g, with its moment in s, until the second is there.
    """
    zero, one = real(0.0), real(1.0)
    tied = tie > zero
    waits, follows = tied and corner % 2 == 0, tied and corner % 2 == 1
    part = one - HALF * tie
    dx, dy, dz = change_of(
        mu, aim, rx, ry, rz, kx, ky, pn, p1, p2, p3, h11, h12, h13, h22, h23, h33, fx, fy, n,
        ux, uy, uz, ox, oy, oz,
    )  # fmt: skip
    back = TWO * dot(gx, gy, mx, my)
    dx = wp.where(follows, fused_less(back, mx, gx), part * dx)
    dy = wp.where(follows, fused_less(back, my, gy), part * dy)
    dz = wp.where(follows, gz, part * dz)
    fx = fx + dx
    fy = fy + dy
    n = n + dz
    x, y, z = vector_product(rx, ry, rz, dx, dy, dz)
    both_x, both_y = wp.where(follows, gx, zero) + dx, wp.where(follows, gy, zero) + dy
    both_z = wp.where(follows, gz, zero) + dz
    turn_x, turn_y = wp.where(follows, sx, zero) + x, wp.where(follows, sy, zero) + y
    turn_z = wp.where(follows, sz, zero) + z
    gx = wp.where(waits, dx, zero)
    gy = wp.where(waits, dy, zero)
    gz = wp.where(waits, dz, zero)
    sx = wp.where(waits, x, zero)
    sy = wp.where(waits, y, zero)
    sz = wp.where(waits, z, zero)
    ux = ux + wp.where(waits, zero, both_x)
    uy = uy + wp.where(waits, zero, both_y)
    uz = uz + wp.where(waits, zero, both_z)
    x = wp.where(waits, zero, turn_x)
    y = wp.where(waits, zero, turn_y)
    z = wp.where(waits, zero, turn_z)
    ox = fused(jxz, z, fused(jxy, y, fused(jxx, x, ox)))
    oy = fused(jyz, z, fused(jyy, y, fused(jxy, x, oy)))
    oz = fused(jzz, z, fused(jyz, y, fused(jxz, x, oz)))
