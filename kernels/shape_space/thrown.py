"""Blocks that start in motion, and tumble: the face that is down, by turns of 90 degrees.

Kernels of blocks in space know the four corners of a bottom face. A block that tumbles comes to
stand on any of its six faces. Its body axes are renamed for that: once the block's axis leans by
more than 60 degrees, the face that looks downwards most becomes the bottom, and a turn of 90 or
180 degrees about a body axis leads from the old axes to the new ones. Sizes and moments of inertia
change places; nothing moves. Corners that touch the base belong to the new bottom, too: those of
the old top lie higher by half of the block's height at least.

Its centre of mass is in its middle.
"""

import warp as wp

from warprock.kernels.modes import OVERTURNED, RUNNING
from warprock.kernels.shape_space.block import Block, matrix_of

LEANS = real(0.5)
"""Height of the top of a block's axis, as a part of its length, below which another face is
down: of the other two axes one then has .61 at least, so that faces do not change to and fro."""
HALVED = real(0.70710678118654752440)
"""Square root of one half."""


@wp.struct
class Throw:
    """How a block is let go: velocity [m/s], angular velocity [rad/s], in the axes of the base.

    `tumbles` says whether it may fall on any of its faces; else its run ends once it has
    overturned.
    """

    vx: real
    vy: real
    vz: real
    wx: real
    wy: real
    wz: real
    tumbles: int


@wp.func
def push(
    throw: Throw, qx: real, qy: real, qz: real, qw: real, ix: real, iy: real, iz: real,
    vx: wp.ref[real], vy: wp.ref[real], vz: wp.ref[real],
    lx: wp.ref[real], ly: wp.ref[real], lz: wp.ref[real],
):  # fmt: skip
    """Gives a block its velocity [m/s] and angular momentum for unit mass [m^2/s] at the start.

    Its attitude is that of its principal axes, of which ix to iz are the inverse moments of
    inertia for unit mass.
    """
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(qx, qy, qz, qw)
    x = (r11 * throw.wx + r21 * throw.wy + r31 * throw.wz) / ix
    y = (r12 * throw.wx + r22 * throw.wy + r32 * throw.wz) / iy
    z = (r13 * throw.wx + r23 * throw.wy + r33 * throw.wz) / iz
    vx = throw.vx
    vy = throw.vy
    vz = throw.vz
    lx = r11 * x + r12 * y + r13 * z
    ly = r21 * x + r22 * y + r23 * z
    lz = r31 * x + r32 * y + r33 * z


@wp.func
def tumble_on(
    throw: Throw, block: Block, x: real, y: real, mode: wp.ref[int], slide_x: wp.ref[real],
    slide_y: wp.ref[real], slide: wp.ref[real], way: wp.ref[real],
):  # fmt: skip
    """Lets the lane of a block that tumbles live on; its slide is the way of its centre [m].

    `slide` is the square of the largest slide, `way` that of the largest way so far [m^2].
    """
    tumbles = throw.tumbles == 1
    mode = wp.where(tumbles and mode == OVERTURNED, RUNNING, mode)
    dx, dy = x - block.x, y - block.y
    way = larger(way, dx * dx + dy * dy)
    slide_x = wp.where(tumbles, dx, slide_x)
    slide_y = wp.where(tumbles, dy, slide_y)
    slide = wp.where(tumbles, way, slide)


@wp.func
def leans(qx: real, qy: real) -> bool:
    """Whether another face is down than that which is called the bottom."""
    return real(1.0) - real(2.0) * (qx * qx + qy * qy) < LEANS


@wp.func
def new_axes(qx: real, qy: real, qz: real, qw: real):
    """The turn from the body axes to those whose bottom is the face that looks down most."""
    zero, one = real(0.0), real(1.0)
    _11, _12, _13, _21, _22, _23, r31, r32, r33 = matrix_of(qx, qy, qz, qw)
    on_x = size(r31) >= size(r32) and size(r31) > size(r33)
    on_y = not on_x and size(r32) > size(r33)
    about_x = wp.where(r32 > zero, -HALVED, HALVED)
    about_y = wp.where(r31 > zero, HALVED, -HALVED)
    return (
        wp.where(on_x, zero, wp.where(on_y, about_x, one)),
        wp.where(on_x, about_y, zero),
        wp.where(on_x or on_y, HALVED, zero),
    )


@wp.func
def after(
    ax: real, ay: real, az: real, aw: real, bx: real, by: real, bz: real, bw: real
):  # fmt: skip
    """Quaternion of the turn b followed by the turn a, of length 1 but for its round-off."""
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by + ay * bw + az * bx - ax * bz
    z = aw * bz + az * bw + ax * by - ay * bx
    w = aw * bw - ax * bx - ay * by - az * bz
    back = real(1.5) - HALF * (x * x + y * y + z * z + w * w)
    return back * x, back * y, back * z, back * w


@wp.func
def renamed(block: Block, gx: real, gy: real) -> Block:
    """The block with its axes renamed by a turn about x or y, of 180 degrees only about x."""
    n = block
    half_turn = gx == real(1.0)
    about_x = gx != real(0.0) and not half_turn
    if about_x:
        n.half_depth = block.half_height
        n.half_height = block.half_depth
        n.inverse_y = block.inverse_z
        n.inverse_z = block.inverse_y
    if gy != real(0.0):
        n.half_width = block.half_height
        n.half_height = block.half_width
        n.inverse_x = block.inverse_z
        n.inverse_z = block.inverse_x
    return n


@wp.func
def old_corner(k: int, gx: real, gy: real, gw: real) -> int:
    """Number of a bottom corner in the old axes, -1 of one that was at the top.

    Corners are numbered around the face: (-, -), (+, -), (+, +), (-, +).
    """
    zero, one = real(0.0), real(1.0)
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(gx, gy, zero, gw)
    x = wp.where(k == 1 or k == 2, one, -one)
    y = wp.where(k >= 2, one, -one)
    right = r11 * x + r12 * y - r13 > zero
    back = r21 * x + r22 * y - r23 > zero
    at = wp.where(back, wp.where(right, 2, 3), wp.where(right, 1, 0))
    return wp.where(r31 * x + r32 * y - r33 > zero, -1, at)
