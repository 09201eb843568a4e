"""Bodies in space that stand on any number of contact points.

The axes of a body are its principal axes of inertia, and its origin is the centre of mass. The
block's axes are those in which its case describes it, z upwards while it stands. A run keeps
attitudes of the body's axes; its results are those of the block's axes.
"""

import warp as wp

from warprock.kernels.shape_space.block import TOUCH, Block, turns_of
from warprock.kernels.shape_space.lanes import matrix_of
from warprock.kernels.shape_space.thrown import Throw

MOST_POINTS = 64
"""Largest number of contact points of a body: rows that a kernel keeps for them."""
PLANE = by_precision(1.0e-8, 1.0e-4)
"""Points span a plane if the product of their two principal second moments is at least this part of
the square of their sum. On narrower points a body turns about the line along them."""
APART = by_precision(1.0e-12, 1.0e-6)
"""Least second moment of more than one point, over the square of the body's reach; a smaller one is
round-off."""


@wp.struct
class Frame:
    """The body of a lane, besides its `Block`, and its start, see `Throw`.

    Attributes:
        ax, ay, az, aw: Attitude of the body's axes in the block's axes.
        reach: Distance of the farthest point from the centre of mass [m].
        feet: Points that touch where the body stands.
        vx, vy, vz: Velocity at the start, in the axes of the base [m/s].
        wx, wy, wz: Angular velocity at the start [rad/s].
        tumbles: Whether it may lie on any of its points; else its run ends once it has overturned.
    """

    ax: real
    ay: real
    az: real
    aw: real
    reach: real
    feet: real
    vx: real
    vy: real
    vz: real
    wx: real
    wy: real
    wz: real
    tumbles: int


@wp.func
def throw_of(frame: Frame) -> Throw:
    """The start of a body."""
    return Throw(
        frame.vx, frame.vy, frame.vz, frame.wx, frame.wy, frame.wz, frame.tumbles
    )  # fmt: skip


@wp.struct
class Point:
    """A contact point.

    Attributes:
        x, y, z: From the centre of mass, in the body's axes [m].
        stood_x, stood_y: Its place on the ground if the body stood at its start [m].
        foot: 1 if it touches then, 0 if not, -1 in a row without a point.
    """

    x: real
    y: real
    z: real
    stood_x: real
    stood_y: real
    foot: real


@wp.func
def body_attitude(frame: Frame, qx: real, qy: real, qz: real, qw: real):
    """Attitude of the body's axes from that of the block's."""
    return (
        qw * frame.ax + qx * frame.aw + qy * frame.az - qz * frame.ay,
        qw * frame.ay + qy * frame.aw + qz * frame.ax - qx * frame.az,
        qw * frame.az + qz * frame.aw + qx * frame.ay - qy * frame.ax,
        qw * frame.aw - qx * frame.ax - qy * frame.ay - qz * frame.az,
    )


@wp.func
def block_attitude(frame: Frame, qx: real, qy: real, qz: real, qw: real):
    """Attitude of the block's axes from that of the body's."""
    return (
        qx * frame.aw - qw * frame.ax - qy * frame.az + qz * frame.ay,
        qy * frame.aw - qw * frame.ay - qz * frame.ax + qx * frame.az,
        qz * frame.aw - qw * frame.az - qx * frame.ay + qy * frame.ax,
        qw * frame.aw + qx * frame.ax + qy * frame.ay + qz * frame.az,
    )


@wp.struct
class Turned:
    """Rotations of a body.

    Attributes:
        along, across, tilt, yaw: See `turns_of`.
        up: Height of the top of the block's axis, over its length.
        qz, qw: Twist of the block's axes.
    """

    along: real
    across: real
    tilt: real
    yaw: real
    up: real
    qz: real
    qw: real


@wp.func
def turns_of_body(block: Block, frame: Frame, qx: real, qy: real, qz: real, qw: real) -> Turned:
    """Rotations of a body, from its attitude."""
    ex, ey, ez, ew = block_attitude(frame, qx, qy, qz, qw)
    r = matrix_of(ex, ey, ez, ew)
    along, across, tilt, yaw = turns_of(block, r.r13, r.r23, r.r33, ez, ew)
    return Turned(along, across, tilt, yaw, r.r33, ez, ew)


@wp.func
def touches_as_lowest(gap: real, lowest: real, half_width: real) -> bool:
    """Whether a point counts as touching for the slide."""
    return gap <= lowest + TOUCH * half_width


@wp.func
def spans(count: real, xx: real, xy: real, yy: real) -> bool:
    """Whether points span a plane, from their number and their second moments about the middle."""
    trace = xx + yy
    return count > real(2.5) and xx * yy - xy * xy > PLANE * trace * trace


@wp.func
def divide_by_moments(flat: bool, point: bool, xx: real, xy: real, yy: real, x: real, y: real):
    """The inverse of second moments times a vector; of a line, or a point, their pseudo-inverse."""
    trace = larger(xx + yy, TINY)
    part = real(1.0) / wp.where(flat, xx * yy - xy * xy, trace * trace)
    a, b = yy * x - xy * y, xx * y - xy * x
    c, d = xx * x + xy * y, xy * x + yy * y
    part = wp.where(point, real(0.0), part)
    return part * wp.where(flat, a, c), part * wp.where(flat, b, d)
