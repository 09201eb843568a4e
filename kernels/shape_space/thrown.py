"""Blocks that start in motion and tumble: change of the bottom face by turns of 90 degrees.

Kernels of blocks in space handle the four corners of one bottom face. A block that tumbles may
stand on any of its six faces. For that its body axes are renamed: once the block's axis leans by
more than 60 degrees, the face that points downwards most becomes the bottom. A turn of 90 or 180
degrees about a body axis leads from the old axes to the new ones. Sizes and moments of inertia
are swapped; the block does not move. Corners that touch the base also belong to the new bottom,
since those of the old top are higher by at least half the height of the block.

The centre of mass is in the middle of the block.
"""

import warp as wp

from warprock.kernels.lane.modes import OVERTURNED, RUNNING
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import Peaks
from warprock.kernels.shape_space.lanes import State, Triple, matrix_of, turn_of

LEANS = real(0.5)
"""Height of the top of a block's axis, over its length, below which another face is down. One of
the other two axes then has at least 0.61, so that the bottom does not alternate."""
HALVED = real(0.70710678118654752440)
"""Square root of one half."""


@wp.struct
class Throw:
    """Velocity [m/s] and angular velocity [rad/s] of a block at its start, in axes of the base.

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
def push(throw: Throw, inverse: Triple, s: State) -> State:
    """A block with its velocity and angular momentum at the start.

    Args:
        throw: Its velocities at the start.
        inverse: Its inverse principal moments of inertia, for unit mass [1/m^2].
        s: The block; its attitude is that of its principal axes.
    """
    r = turn_of(s)
    x = (r.r11 * throw.wx + r.r21 * throw.wy + r.r31 * throw.wz) / inverse.x
    y = (r.r12 * throw.wx + r.r22 * throw.wy + r.r32 * throw.wz) / inverse.y
    z = (r.r13 * throw.wx + r.r23 * throw.wy + r.r33 * throw.wz) / inverse.z
    return State(
        s.x, s.y, s.z, s.qx, s.qy, s.qz, s.qw, throw.vx, throw.vy, throw.vz,
        r.r11 * x + r.r12 * y + r.r13 * z,
        r.r21 * x + r.r22 * y + r.r23 * z,
        r.r31 * x + r.r32 * y + r.r33 * z,
    )  # fmt: skip


@wp.func
def tumble_on(
    throw: Throw, block: Block, s: State, mode: wp.ref[int], way: wp.ref[real], p: Peaks
) -> Peaks:  # fmt: skip
    """Keeps the lane of a body that tumbles running; its slide is that of its centre [m].

    `way` is the square of the largest distance so far [m^2].
    """
    tumbles = throw.tumbles == 1
    mode = wp.where(tumbles and mode == OVERTURNED, RUNNING, mode)
    dx, dy = s.x - block.x, s.y - block.y
    way = larger(way, dx * dx + dy * dy)
    seen = p
    seen.slide_x = wp.where(tumbles, dx, p.slide_x)
    seen.slide_y = wp.where(tumbles, dy, p.slide_y)
    seen.slide = wp.where(tumbles, way, p.slide)
    return seen


@wp.func
def needs_new_axes(qx: real, qy: real) -> bool:
    """Whether the bottom face is no longer the one that points down."""
    return real(1.0) - real(2.0) * (qx * qx + qy * qy) < LEANS


@wp.func
def new_axes(qx: real, qy: real, qz: real, qw: real):
    """The turn from the body axes to those whose bottom is the face that points down most."""
    zero, one = real(0.0), real(1.0)
    r = matrix_of(qx, qy, qz, qw)
    r31, r32, r33 = r.r31, r.r32, r.r33
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
def compose(
    ax: real, ay: real, az: real, aw: real, bx: real, by: real, bz: real, bw: real
):  # fmt: skip
    """Quaternion of the turn b followed by the turn a, of length 1 to round-off."""
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by + ay * bw + az * bx - ax * bz
    z = aw * bz + az * bw + ax * by - ay * bx
    w = aw * bw - ax * bx - ay * by - az * bz
    back = real(1.5) - HALF * (x * x + y * y + z * z + w * w)
    return back * x, back * y, back * z, back * w


@wp.func
def rename_block_axes(block: Block, gx: real, gy: real) -> Block:
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
    """Number of a bottom corner in the old axes; -1 if it was at the top.

    Corners are numbered around the face: (-, -), (+, -), (+, +), (-, +).
    """
    zero, one = real(0.0), real(1.0)
    r = matrix_of(gx, gy, zero, gw)
    x = wp.where(k == 1 or k == 2, one, -one)
    y = wp.where(k >= 2, one, -one)
    right = r.r11 * x + r.r12 * y - r.r13 > zero
    back = r.r21 * x + r.r22 * y - r.r23 > zero
    at = wp.where(back, wp.where(right, 2, 3), wp.where(right, 1, 0))
    return wp.where(r.r31 * x + r.r32 * y - r.r33 > zero, -1, at)
