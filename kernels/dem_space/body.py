"""Soft-spring step of a body in space that stands on points.

As dem_space/stack.py, with a spring under every contact point (see shape_space/body.py) instead of
springs along a face. With z the height of the centre of mass above that of the rigid body at rest,
h, a point at the lever r from the centre has

    overlap    o = -(z + h + r_z),
    velocity   V = v + omega x r,

and its spring represents an area of the base, the same for all points.

A spring is closed while it pushes. A body rocks while the points that push do not span a plane and
the middle of its feet is open. It slides while a point that pushes slips faster than sticking
springs oscillate.
"""

import warp as wp

from warprock.kernels.dem.stack import Knobs
from warprock.kernels.dem.stack_lanes import observe_faces
from warprock.kernels.dem_space.stack import Load, Pace, Spring, Stress, Touch, load_spring
from warprock.kernels.lane.modes import BROKEN, OVERTURNED
from warprock.kernels.shape.stack_found import Seen
from warprock.kernels.shape_space.block import Block, turn_freely
from warprock.kernels.shape_space.block_found import (
    Peaks,
    observe_slide,
    observe_turns,
    start_peaks,
)
from warprock.kernels.shape_space.body import (
    Frame,
    Point,
    block_attitude,
    body_attitude,
    spans,
    throw_of,
    touches_as_lowest,
    turns_of_body,
)
from warprock.kernels.shape_space.lanes import State, Triple, Turn, turn_of
from warprock.kernels.shape_space.thrown import push

Pose = wp.types.vector(length=7, dtype=real)
"""Attitude of the block's axes, and centre of mass [m]."""


@wp.struct
class Lane:
    """One lane, and its body, see `Frame`.

    Time step [s]; speed up to which points may slip back and forth on their springs and not slide
    [m/s]; when it is first uplifted [s], 0 or NEVER; where its base moves, see dem_space/
    stack_lanes.py; height of its centre of mass at rest [m]; area that a point stands for [m^2].
    """

    time_step: real
    creep: real
    uplift_time: real
    moves: int
    height: real
    area: real
    frame: Frame


@wp.struct
class Footing:
    """What all points of a body share.

    Height of the centre of mass at rest [m]; area that a point stands for [m^2]; friction
    coefficient; half width of the block [m].
    """

    height: real
    area: real
    friction: real
    half_width: real


@wp.struct
class Spin:
    """Angular velocity of a body, in the axes of the base [rad/s]."""

    x: real
    y: real
    z: real


@wp.struct
class Lever:
    """A point from the centre of mass, in the axes of the base [m]."""

    x: real
    y: real
    z: real


@wp.struct
class Footprint:
    """Sums over the points of a body in a step.

    Attributes:
        count: Points that push, with `sx` to `yy` the sums of levers and of products [m, m^2].
        middle: Sum of the overlaps of the feet [m].
        deep: Largest overlap of all points [m].
        fastest: Largest square of the speed of points that push [m^2/s^2].
        touching: Points that touch, with `way_x` and `way_y` sums of how far they have slid [m].
    """

    count: real
    sx: real
    sy: real
    xx: real
    xy: real
    yy: real
    middle: real
    deep: real
    fastest: real
    touching: real
    way_x: real
    way_y: real


@wp.func
def start_body(block: Block, frame: Frame):
    """State and peaks of a body at its start."""
    zero = real(0.0)
    a, b, c, d = body_attitude(frame, block.qx, block.qy, block.qz, block.qw)
    now = turns_of_body(block, frame, a, b, c, d)
    rests = State(block.x, block.y, block.z, a, b, c, d, zero, zero, zero, zero, zero, zero)
    inverse = Triple(block.inverse_x, block.inverse_y, block.inverse_z)
    state = push(throw_of(frame), inverse, rests)
    return state, start_peaks(now.along, now.across, now.tilt)


@wp.func
def turn_body(block: Block, s: State):
    """Turn of a body, and its angular velocity."""
    m = turn_of(s)
    x = block.inverse_x * (m.r11 * s.lx + m.r21 * s.ly + m.r31 * s.lz)
    y = block.inverse_y * (m.r12 * s.lx + m.r22 * s.ly + m.r32 * s.lz)
    z = block.inverse_z * (m.r13 * s.lx + m.r23 * s.ly + m.r33 * s.lz)
    spin = Spin(
        m.r11 * x + m.r12 * y + m.r13 * z,
        m.r21 * x + m.r22 * y + m.r23 * z,
        m.r31 * x + m.r32 * y + m.r33 * z,
    )
    return m, spin


@wp.func
def find_lever(m: Turn, p: Point) -> Lever:
    """Lever of a point of a body."""
    return Lever(
        m.r11 * p.x + m.r12 * p.y + m.r13 * p.z,
        m.r21 * p.x + m.r22 * p.y + m.r23 * p.z,
        m.r31 * p.x + m.r32 * p.y + m.r33 * p.z,
    )


@wp.func
def touch_of(height: real, s: State, spin: Spin, r: Lever) -> Touch:
    """Penetration and velocity of a point; `height` is that of the centre of mass at rest [m]."""
    return Touch(
        -(s.z + (height + r.z)),
        s.vz + spin.x * r.y - spin.y * r.x,
        s.vx + spin.y * r.z - spin.z * r.y,
        s.vy + spin.z * r.x - spin.x * r.z,
    )


@wp.func
def solve_point(
    knobs: Knobs, pace: Pace, mu: real, area: real, there: bool, touch: Touch,
    spring: wp.ref[Spring],
) -> Stress:  # fmt: skip
    """Forces of a point that represents an area [m^2] [N], and twice its energy [J].

    `there` says whether the point exists.
    """
    share = wp.where(there, area, real(0.0))
    # A row without a point lies far above.
    depth = wp.where(there, touch.overlap, real(-1.0))
    meets = Touch(depth, touch.vn, touch.vx, touch.vy)
    bears = load_spring(knobs, pace.live == 1 and there, mu, pace.dt, meets, spring)
    return Stress(share * bears.n, share * bears.x, share * bears.y, share * bears.energy)


@wp.func
def add_force(force: Stress, r: Lever, load: wp.ref[Load]):
    """Adds the force of a point to the load on its body."""
    load.fx = load.fx + force.x
    load.fy = load.fy + force.y
    load.fz = load.fz + force.n
    load.mx = load.mx + (r.y * force.n - r.z * force.y)
    load.my = load.my + (r.z * force.x - r.x * force.n)
    load.mz = load.mz + (r.x * force.y - r.y * force.x)


@wp.func
def start_footprint() -> Footprint:
    """The sums before the first point."""
    zero = real(0.0)
    return Footprint(zero, zero, zero, zero, zero, zero, zero, -NEVER, zero, zero, zero, zero)


@wp.func
def add_point(
    point: Point, low: bool, touch: Touch, n: real, s: State, r: Lever, sums: wp.ref[Footprint]
):
    """Adds a point to the sums of its body.

    Args:
        point: The point.
        low: Whether it counts as touching for the slide.
        touch: Its penetration and velocity.
        n: Its normal force [N].
        s: State of the body.
        r: Lever of the point.
        sums: Those of the body.
    """
    zero, one, there = real(0.0), real(1.0), point.foot >= real(0.0)
    pushes = n > zero
    carries = wp.where(pushes, one, zero)
    a, b = carries * r.x, carries * r.y
    square = touch.vx * touch.vx + touch.vy * touch.vy
    sums.count = sums.count + carries
    sums.sx = sums.sx + a
    sums.sy = sums.sy + b
    sums.xx = sums.xx + a * r.x
    sums.xy = sums.xy + a * r.y
    sums.yy = sums.yy + b * r.y
    sums.middle = sums.middle + wp.where(point.foot > zero, touch.overlap, zero)
    sums.deep = wp.where(there, larger(touch.overlap, sums.deep), sums.deep)
    sums.fastest = wp.where(pushes, larger(square, sums.fastest), sums.fastest)
    sums.touching = sums.touching + wp.where(low, one, zero)
    sums.way_x = sums.way_x + wp.where(low, s.x + r.x - point.stood_x, zero)
    sums.way_y = sums.way_y + wp.where(low, s.y + r.y - point.stood_y, zero)


@wp.func
def is_low(point: Point, r: Lever, lowest: real, half_width: real) -> bool:
    """Whether a point counts as touching for the slide; `lowest` is the lowest height [m]."""
    return point.foot >= real(0.0) and touches_as_lowest(r.z, lowest, half_width)


@wp.func
def observe_points(
    pace: Pace, frame: Frame, sums: Footprint, since: wp.ref[real], peaks: wp.ref[Peaks],
    seen: wp.ref[Seen],
):  # fmt: skip
    """Observes a body by the sums over its points, see `observe_faces`.

    A body that stands counts as closed, on any points.
    """
    zero, one, live = real(0.0), real(1.0), pace.live == 1
    time = real(pace.steps - 1) * pace.dt
    sx, sy, part = sums.sx, sums.sy, one / larger(sums.count, one)
    xx, xy, yy = sums.xx - part * sx * sx, sums.xy - part * sx * sy, sums.yy - part * sy * sy
    depth = sums.middle / frame.feet
    depth = wp.where(spans(sums.count, xx, xy, yy), larger(depth, TINY), smaller(depth, zero))
    slips = sums.fastest > pace.creep * pace.creep
    observe_faces(live, time, depth, sums.deep - depth, one, slips, since, seen)
    x, y = sums.way_x / sums.touching, sums.way_y / sums.touching
    peaks = observe_slide(live, x, y, x * x + y * y, peaks)


@wp.func
def observe_body(
    pace: Pace, block: Block, frame: Frame, s: State, peaks: wp.ref[Peaks], mode: int
) -> int:
    """Updates the peaks of a body after a step; returns the mode of its lane."""
    live, zero = pace.live == 1, real(0.0)
    now = turns_of_body(block, frame, s.qx, s.qy, s.qz, s.qw)
    time = real(pace.steps) * pace.dt
    peaks = observe_turns(live, time, now.along, now.across, now.tilt, now.yaw, peaks)
    # A sum of numbers is finite if all of them are.
    total = s.x + s.y + s.z + peaks.slide_x + peaks.slide_y + s.qx + s.qy + s.qz + s.qw
    over = wp.where(now.up <= zero and mode != BROKEN, OVERTURNED, mode)
    return wp.where(live, wp.where(total - total == zero, over, BROKEN), mode)


@wp.func
def pose_before(block: Block, frame: Frame, past: real, s: State) -> Pose:
    """Attitude of the block's axes and centre of mass of a body some time ago [s]."""
    spin, inverse = (
        Triple(s.lx, s.ly, s.lz),
        Triple(block.inverse_x, block.inverse_y, block.inverse_z),
    )
    ex, ey, ez, ew = turn_freely(s.qx, s.qy, s.qz, s.qw, spin, inverse, -past)
    a, b, c, d = block_attitude(frame, ex, ey, ez, ew)
    return Pose(a, b, c, d, s.x - past * s.vx, s.y - past * s.vy, s.z - past * s.vz)
