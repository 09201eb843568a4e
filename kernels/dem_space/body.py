"""Soft-spring step of a body in space that stands on points.

As dem_space/stack.py, with a spring under every contact point (see shape_space/body.py) in the
place of springs along a face. With z the height of the centre of mass over that of the rigid body
at rest, h, a point at the lever r from the centre has

    overlap    o = -(z + h + r_z),
    velocity   V = v + omega x r,

and the stresses of its spring stand for an area of the base, the same for all points.

Springs close while they push. A body rocks while the points that push do not span a plane and the
middle of its feet gapes; it slides while a point that pushes slips faster than springs swing that
stick.
"""

import warp as wp

from warprock.kernels.dem.stack import Knobs
from warprock.kernels.dem.stack_lanes import observe_faces
from warprock.kernels.dem_space.stack import spring
from warprock.kernels.modes import BROKEN, OVERTURNED, RUNNING
from warprock.kernels.shape_space.block import Block, matrix_of, turn_freely
from warprock.kernels.shape_space.body import (
    Frame,
    Point,
    block_attitude,
    body_attitude,
    observe_turns,
    spans,
    touches_as_lowest,
    turns_of_body,
)

Pose = wp.types.vector(length=7, dtype=real)
"""Attitude of the block's axes, and centre of mass [m]."""


@wp.struct
class Lane:
    """One lane, and its body, see `Frame`.

    Time step [s]; speed up to which points may slip back and forth on their springs and not slide
    [m/s]; when it is first uplifted [s], 0 or NEVER; height of its centre of mass at rest [m]; area
    that a point stands for [m^2].
    """

    time_step: real
    creep: real
    uplift_time: real
    height: real
    area: real
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
def frame_of(lane: Lane) -> Frame:
    """The body of a lane."""
    return Frame(
        lane.ax, lane.ay, lane.az, lane.aw, lane.reach, lane.feet, lane.vx, lane.vy, lane.vz,
        lane.wx, lane.wy, lane.wz, lane.tumbles,
    )  # fmt: skip


@wp.func
def start_body(
    block: Block, lane: Lane, x: wp.ref[real], y: wp.ref[real], z: wp.ref[real],
    qx: wp.ref[real], qy: wp.ref[real], qz: wp.ref[real], qw: wp.ref[real],
    since: wp.ref[real], peak: wp.ref[real], across: wp.ref[real], tilt: wp.ref[real],
    dt: wp.ref[real], uplift_time: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """Puts a body where it starts; it counts as closed."""
    x = block.x
    y = block.y
    z = block.z
    frame = frame_of(lane)
    a, b, c, d = body_attitude(frame, block.qx, block.qy, block.qz, block.qw)
    qx = a
    qy = b
    qz = c
    qw = d
    since = NEVER
    now, side, lean, _yaw, _up, _z, _w = turns_of_body(block, frame, a, b, c, d)
    peak = now
    across = side
    tilt = lean
    dt = lane.time_step
    uplift_time = lane.uplift_time
    mode = RUNNING


@wp.func
def keep_point(
    point: Point, px: wp.ref[real], py: wp.ref[real], pz: wp.ref[real], stood_x: wp.ref[real],
    stood_y: wp.ref[real], foot: wp.ref[real],
):  # fmt: skip
    """Hands over the fields of a point."""
    px = point.x
    py = point.y
    pz = point.z
    stood_x = point.stood_x
    stood_y = point.stood_y
    foot = point.foot


@wp.func
def turn_body(
    qx: real, qy: real, qz: real, qw: real, lx: real, ly: real, lz: real,
    ix: real, iy: real, iz: real,
    r11: wp.ref[real], r12: wp.ref[real], r13: wp.ref[real],
    r21: wp.ref[real], r22: wp.ref[real], r23: wp.ref[real],
    r31: wp.ref[real], r32: wp.ref[real], r33: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real], lowest: wp.ref[real],
):  # fmt: skip
    """Rotation matrix of a body, and its angular velocity in the axes of the base [rad/s]."""
    a, b, c, d, e, f, g, h, i = matrix_of(qx, qy, qz, qw)
    mx, my, mz = a * lx + d * ly + g * lz, b * lx + e * ly + h * lz, c * lx + f * ly + i * lz
    mx, my, mz = ix * mx, iy * my, iz * mz
    r11 = a
    r12 = b
    r13 = c
    r21 = d
    r22 = e
    r23 = f
    r31 = g
    r32 = h
    r33 = i
    ox = a * mx + b * my + c * mz
    oy = d * mx + e * my + f * mz
    oz = g * mx + h * my + i * mz
    lowest = NEVER


@wp.func
def solve_point(
    knobs: Knobs, live: bool, mu: real, dt: real, area: real, there: bool, overlap: real,
    rx: real, ry: real, rz: real, vx: real, vy: real, vz: real, ox: real, oy: real, oz: real,
    ux: wp.ref[real], uy: wp.ref[real], slip: wp.ref[real],
    fx: wp.ref[real], fy: wp.ref[real], fz: wp.ref[real],
    mx: wp.ref[real], my: wp.ref[real], mz: wp.ref[real], stored: wp.ref[real],
):  # fmt: skip
    """Adds the force of a point to that on its body.

    Args:
        knobs: Settings.
        live: Whether the lane still runs.
        mu: Friction coefficient.
        dt: Time step [s].
        area: That the point stands for [m^2].
        there: Whether it is one.
        overlap: Depth in the base [m].
        rx, ry, rz: Lever of the point [m].
        vx, vy, vz: Velocity [m/s], ox, oy and oz angular velocity [rad/s].
        ux, uy, slip: State of the spring, see `spring` in dem_space/stack.py.
        fx: Force [N], to fz; mx its moment [N m], to mz; stored the energy of springs [J].

    Returns:
        What it pushes with [N], and the square of the speed at which it slips [m^2/s^2].
    """
    zero = real(0.0)
    share = wp.where(there, area, zero)
    slip_x, slip_y = vx + oy * rz - oz * ry, vy + oz * rx - ox * rz
    rate = vz + ox * ry - oy * rx
    # What is no point lies far above.
    depth = wp.where(there, overlap, real(-1.0))
    n, tx, ty, held = spring(
        knobs, live and there, mu, dt, depth, rate, slip_x, slip_y, ux, uy, slip
    )
    n = share * n
    tx = share * tx
    ty = share * ty
    fx = fx + tx
    fy = fy + ty
    fz = fz + n
    mx = mx + (ry * n - rz * ty)
    my = my + (rz * tx - rx * n)
    mz = mz + (rx * ty - ry * tx)
    stored = stored + wp.where(live, HALF * share * held, zero)
    return n, slip_x * slip_x + slip_y * slip_y


@wp.func
def add_point(
    foot: real, half_width: real, lowest: real, overlap: real, n: real, square: real,
    x: real, y: real, rx: real, ry: real, rz: real, stood_x: real, stood_y: real,
    count: wp.ref[real], sx: wp.ref[real], sy: wp.ref[real],
    xx: wp.ref[real], xy: wp.ref[real], yy: wp.ref[real],
    middle: wp.ref[real], deep: wp.ref[real], fastest: wp.ref[real],
    touching: wp.ref[real], way_x: wp.ref[real], way_y: wp.ref[real],
):  # fmt: skip
    """Adds what a point shows to the sums of its body.

    Args:
        foot, stood_x, stood_y: See `Point`.
        half_width: Of the block [m].
        lowest: Of all points, from the centre of mass [m].
        overlap: Depth in the base [m].
        n, square: See `solve_point`.
        x, y: Centre of mass, rx, ry and rz the lever of the point [m].
        count: Sums over points that push, to yy: see `spans`.
        middle: Sum of the overlaps of the feet, deep the largest one of all points [m].
        fastest: Largest square of the speed of points that push [m^2/s^2].
        touching: Points that touch, way_x and way_y sums of how far they have slid [m].
    """
    zero, one, there = real(0.0), real(1.0), foot >= real(0.0)
    pushes = n > zero
    carries = wp.where(pushes, one, zero)
    a, b = carries * rx, carries * ry
    count = count + carries
    sx = sx + a
    sy = sy + b
    xx = xx + a * rx
    xy = xy + a * ry
    yy = yy + b * ry
    middle = middle + wp.where(foot > zero, overlap, zero)
    deep = wp.where(there, larger(overlap, deep), deep)
    fastest = wp.where(pushes, larger(square, fastest), fastest)
    low = there and touches_as_lowest(rz, lowest, half_width)
    touching = touching + wp.where(low, one, zero)
    way_x = way_x + wp.where(low, x + rx - stood_x, zero)
    way_y = way_y + wp.where(low, y + ry - stood_y, zero)


@wp.func
def find_lever(
    there: bool, px: real, py: real, pz: real, r11: real, r12: real, r13: real, r21: real,
    r22: real, r23: real, r31: real, r32: real, r33: real,
    rx: wp.ref[real], ry: wp.ref[real], rz: wp.ref[real], lowest: wp.ref[real],
):  # fmt: skip
    """Lever of a point [m], and the lowest one so far."""
    rx = r11 * px + r12 * py + r13 * pz
    ry = r21 * px + r22 * py + r23 * pz
    height = r31 * px + r32 * py + r33 * pz
    rz = height
    lowest = wp.where(there, smaller(lowest, height), lowest)


@wp.func
def observe_points(
    live: bool, time: real, frame: Frame, creep: real,
    count: wp.ref[real], sx: wp.ref[real], sy: wp.ref[real],
    xx: wp.ref[real], xy: wp.ref[real], yy: wp.ref[real],
    middle: wp.ref[real], deep: wp.ref[real], fastest: wp.ref[real],
    touching: wp.ref[real], way_x: wp.ref[real], way_y: wp.ref[real],
    since: wp.ref[real], uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real],
    impacts: wp.ref[int], mode: wp.ref[int],
    slide_x: wp.ref[real], slide_y: wp.ref[real], peak_slide: wp.ref[real],
):  # fmt: skip
    """What the points show of a body, see `observe_faces`; their sums become zero.

    A body that stands counts as closed, on whatever points.
    """
    zero, one = real(0.0), real(1.0)
    part = one / larger(count, one)
    stands = spans(count, xx - part * sx * sx, xy - part * sx * sy, yy - part * sy * sy)
    depth = middle / frame.feet
    depth = wp.where(stands, larger(depth, TINY), smaller(depth, zero))
    observe_faces(
        live, time, depth, deep - depth, one, fastest > creep * creep, since, uplift_time, moved,
        deepest, impacts, mode,
    )  # fmt: skip
    x, y = way_x / touching, way_y / touching
    slide_x = wp.where(live, x, slide_x)
    slide_y = wp.where(live, y, slide_y)
    peak_slide = wp.where(live, larger(x * x + y * y, peak_slide), peak_slide)
    count = zero
    sx = zero
    sy = zero
    xx = zero
    xy = zero
    yy = zero
    middle = zero
    deep = -NEVER
    fastest = zero
    touching = zero
    way_x = zero
    way_y = zero


@wp.func
def observe_body(
    live: bool, time: real, block: Block, frame: Frame, others: real,
    qx: real, qy: real, qz: real, qw: real, peak: wp.ref[real], peak_time: wp.ref[real],
    across: wp.ref[real], tilt: wp.ref[real], yaw: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """Peaks of a body after a step, and whether its lane lives on.

    `others` is a sum of its other numbers: it is finite only if all of them are.
    """
    up = real(0.0)
    observe_turns(
        live, time, block, frame, qx, qy, qz, qw, peak, peak_time, across, tilt, yaw, up
    )  # fmt: skip
    total = others + qx + qy + qz + qw
    over = wp.where(up <= real(0.0) and mode != BROKEN, OVERTURNED, mode)
    mode = wp.where(live, wp.where(total - total == real(0.0), over, BROKEN), mode)


@wp.func
def pose_before(
    block: Block, frame: Frame, past: real, qx: real, qy: real, qz: real, qw: real,
    lx: real, ly: real, lz: real, x: real, y: real, z: real, vx: real, vy: real, vz: real,
) -> Pose:  # fmt: skip
    """Attitude of the block's axes and centre of mass of a body some time ago [s]."""
    ex, ey, ez, ew = turn_freely(
        qx, qy, qz, qw, lx, ly, lz, block.inverse_x, block.inverse_y, block.inverse_z, -past
    )
    a, b, c, d = block_attitude(frame, ex, ey, ez, ew)
    return Pose(a, b, c, d, x - past * vx, y - past * vy, z - past * vz)
