"""Contact points of a body in space on its base.

Mass 1, as in event_space/block/contact.py; points, feet and frames are those of
shape_space/body.py. A set of points is a bit mask.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Quaternion, Vector
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.body import APART, Frame, Point, divide_by_moments, spans
from warprock.kernels.shape_space.frame import frame, rotate_diagonal

ALL = wp.uint64(2**64 - 1)
"""All points."""

# Rows for at least as many points as a body has: POINTS of them.
Points = wp.types.matrix(shape=(POINTS, 3), dtype=real)
PointGains = wp.types.matrix(shape=(POINTS, 12), dtype=real)
PointInts = wp.types.vector(length=POINTS, dtype=int)
PointNumbers = wp.types.vector(length=POINTS, dtype=real)


@wp.struct
class Shape:
    """A body: friction coefficient, inverse moments of inertia, reach [m], and its points.

    The points are a row of the points of all lanes; `feet` are those on which it stands at rest.
    `axis` is the block's axis in the body's axes. Of bodies that bounce, the normal restitution by
    Newton's law and by Poisson's, and the speed up to which a point does not bounce [m/s].
    """

    friction: real
    rebound: real
    expansion: real
    slow: real
    inverse: Vector
    axis: Vector
    reach: real
    count: int
    feet: wp.uint64
    points: wp.array2d(dtype=Point)
    lane: int


@wp.struct
class Pose:
    """Pose of a body: centre of mass [m], attitude, its matrix, inertia and its inverse."""

    x: Vector
    q: Quaternion
    turn: Matrix
    inertia: Matrix
    inverse: Matrix


@wp.struct
class Touches:
    """Touching points: how many, their numbers, their levers from the centre of mass [m]."""

    total: int
    which: PointInts
    lever: Points


@wp.struct
class Carried:
    """The motion with contacts.

    Velocities; points that push, and those that stick; whether the motion obeys the law.
    """

    v: Vector
    w: Vector
    held: wp.uint64
    stuck: wp.uint64
    fits: bool


@wp.func
def bit_of(k: int) -> wp.uint64:
    """The bit of a point."""
    return wp.uint64(1) << wp.uint64(k)


@wp.func
def is_among(k: int, bits: wp.uint64) -> bool:
    """Whether point k is in a set."""
    return (bits & bit_of(k)) != wp.uint64(0)


@wp.func
def shape_of(block: Block, own: Frame) -> Shape:
    """The body of a lane, still without points."""
    s = Shape()
    s.friction = block.friction
    s.inverse = Vector(block.inverse_x, block.inverse_y, block.inverse_z)
    s.reach = own.reach
    s.axis = frame(Quaternion(own.ax, own.ay, own.az, own.aw))[2]
    return s


@wp.func
def pose_of(s: Shape, x: Vector, q: Quaternion) -> Pose:
    """The pose of a centre of mass and an attitude."""
    one = real(1.0)
    pose = Pose()
    pose.x = x
    pose.q = q
    pose.turn = frame(q)
    pose.inverse = rotate_diagonal(pose.turn, s.inverse[0], s.inverse[1], s.inverse[2])
    pose.inertia = rotate_diagonal(
        pose.turn, one / s.inverse[0], one / s.inverse[1], one / s.inverse[2]
    )
    return pose


@wp.func
def place_of(point: Point) -> Vector:
    """Place of a point from the centre of mass in the body's axes [m]."""
    return Vector(point.x, point.y, point.z)


@wp.func
def touches_of(s: Shape, turn: Matrix, bits: wp.uint64) -> Touches:
    """The points of a set, in an attitude."""
    t = Touches()
    count = s.count
    for k in range(count):
        if is_among(k, bits):
            t.which[t.total] = k
            t.lever[t.total] = turn * place_of(s.points[k, s.lane])
            t.total += 1
    return t


@wp.func
def spans_plane(t: Touches, held: wp.uint64) -> bool:
    """Whether the points of a set, of those that touch, span a plane."""
    count, sx, sy, xx, xy, yy = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    total = t.total
    for k in range(total):
        if is_among(t.which[k], held):
            x, y = t.lever[k][0] - t.lever[0][0], t.lever[k][1] - t.lever[0][1]
            count += real(1.0)
            sx += x
            sy += y
            xx += x * x
            xy += x * y
            yy += y * y
    part = real(1.0) / larger(count, real(1.0))
    return spans(count, xx - part * sx * sx, xy - part * sx * sy, yy - part * sy * sy)


@wp.func
def level_points(s: Shape, z: real, t: Touches):
    """Shift upwards [m] and turn [rad] that put the points on the base, by least squares.

    z is the height of the centre of mass [m].
    """
    zero, part = real(0.0), real(1.0) / larger(real(t.total), real(1.0))
    mx, my, xx, xy, yy = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    height, hx, hy, total = real(0.0), real(0.0), real(0.0), t.total
    for k in range(total):
        r = t.lever[k]
        mx += part * r[0]
        my += part * r[1]
        height += part * (z + r[2])
    for k in range(total):
        x, y = t.lever[k][0] - mx, t.lever[k][1] - my
        gap = z + t.lever[k][2] - height
        xx += x * x
        xy += x * y
        yy += y * y
        hx += gap * x
        hy += gap * y
    flat = spans(real(total), xx, xy, yy)
    single_point = total < 2 or xx + yy <= APART * s.reach * s.reach
    ax, ay = divide_by_moments(flat, single_point, xx, xy, yy, hx, hy)
    turn = Vector(-ay, ax, zero)
    return -height - (turn[0] * my - turn[1] * mx), turn
