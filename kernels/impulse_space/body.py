"""Velocity-level contact step of a body in space that stands on points.

The step is that of impulse_space/block.py, its equations and its funcs, for contacts that are the
points of a body (see shape_space/body.py) where that has the corners of a block. Sweeps visit the
points in turn, every second one backwards, so that what they leave has no sense of its own.

A body rocks while one of its feet has parted from the base, see parting.py, and the points that
carry do not span a plane; so a body that has come to lie on other points than it stood on is at
rest there. Its uplift time is when the points that carry last spanned one. It moves while it rocks,
or slides.
"""

import warp as wp

from warprock.kernels.impulse_space.block import FAR, Knobs, observe_contact, slips
from warprock.kernels.impulse_space.bounce import bounce
from warprock.kernels.modes import BROKEN, OVERTURNED, RUNNING
from warprock.kernels.shape_space.block import Block, inverse_inertia, matrix_of
from warprock.kernels.shape_space.body import (
    Frame,
    Point,
    body_attitude,
    observe_turns,
    spans,
    throw_of,
    touches_as_lowest,
    turns_of_body,
)
from warprock.kernels.shape_space.thrown import push


@wp.func
def start_body(
    block: Block, frame: Frame, knobs: Knobs, mu: wp.ref[real],
    ix: wp.ref[real], iy: wp.ref[real], iz: wp.ref[real],
    x: wp.ref[real], y: wp.ref[real], z: wp.ref[real],
    qx: wp.ref[real], qy: wp.ref[real], qz: wp.ref[real], qw: wp.ref[real],
    vx: wp.ref[real], vy: wp.ref[real], vz: wp.ref[real],
    lx: wp.ref[real], ly: wp.ref[real], lz: wp.ref[real],
    uplift_time: wp.ref[real], mode: wp.ref[int],
    peak: wp.ref[real], peak_across: wp.ref[real], peak_tilt: wp.ref[real],
):  # fmt: skip
    """Puts a body where it starts; its velocity is that of half a step before."""
    mu = block.friction
    ix = block.inverse_x
    iy = block.inverse_y
    iz = block.inverse_z
    x = block.x
    y = block.y
    z = block.z
    a, b, c, d = body_attitude(frame, block.qx, block.qy, block.qz, block.qw)
    qx = a
    qy = b
    qz = c
    qw = d
    inverse_x, inverse_y, inverse_z = block.inverse_x, block.inverse_y, block.inverse_z
    push(throw_of(frame), a, b, c, d, inverse_x, inverse_y, inverse_z, vx, vy, vz, lx, ly, lz)
    vz = vz + HALF * knobs.time_step * knobs.gravity
    stands = block.standing == frame.feet
    uplift_time = wp.where(stands, NEVER, real(0.0))
    mode = RUNNING
    along, across, tilt, _yaw, _up, _qz, _qw = turns_of_body(block, frame, a, b, c, d)
    peak = along
    peak_across = across
    peak_tilt = tilt


@wp.func
def start_point(
    point: Point, knobs: Knobs, frame: Frame, x: wp.ref[real], y: wp.ref[real], z: wp.ref[real],
    stood_x: wp.ref[real], stood_y: wp.ref[real], foot: wp.ref[real],
    n: wp.ref[real], apart: wp.ref[real],
):  # fmt: skip
    """Copies a point; the feet share the weight, the others count as parted."""
    x = point.x
    y = point.y
    z = point.z
    stood_x = point.stood_x
    stood_y = point.stood_y
    foot = point.foot
    touches = point.foot > real(0.0)
    n = wp.where(touches, HALF * knobs.time_step * knobs.gravity / frame.feet, real(0.0))
    apart = wp.where(touches, real(0.0), real(1.0))


@wp.func
def predict(
    dvx: real, dvy: real, dvz: real, knobs: Knobs,
    qx: real, qy: real, qz: real, qw: real, lx: real, ly: real, lz: real,
    ix: real, iy: real, iz: real, vx: real, vy: real, vz: real,
    r11: wp.ref[real], r12: wp.ref[real], r13: wp.ref[real],
    r21: wp.ref[real], r22: wp.ref[real], r23: wp.ref[real],
    r31: wp.ref[real], r32: wp.ref[real], r33: wp.ref[real],
    jxx: wp.ref[real], jxy: wp.ref[real], jxz: wp.ref[real],
    jyy: wp.ref[real], jyz: wp.ref[real], jzz: wp.ref[real],
    ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real],
    lowest: wp.ref[real], lifted: wp.ref[real], landed: wp.ref[real],
):  # fmt: skip
    """Velocities u and omega (o) of a body without contact, its rotation matrix, and J."""
    a, b, c, d, e, f, g, h, i = matrix_of(qx, qy, qz, qw)
    xx, xy, xz, yy, yz, zz = inverse_inertia(a, b, c, d, e, f, g, h, i, ix, iy, iz)
    r11 = a
    r12 = b
    r13 = c
    r21 = d
    r22 = e
    r23 = f
    r31 = g
    r32 = h
    r33 = i
    jxx = xx
    jxy = xy
    jxz = xz
    jyy = yy
    jyz = yz
    jzz = zz
    ux = vx - dvx
    uy = vy - dvy
    uz = vz - dvz - knobs.time_step * knobs.gravity
    ox = xx * lx + xy * ly + xz * lz
    oy = xy * lx + yy * ly + yz * lz
    oz = xz * lx + yz * ly + zz * lz
    lowest = FAR
    lifted = real(0.0)
    landed = real(0.0)


@wp.func
def find_point(
    there: bool, px: real, py: real, pz: real, z: real,
    r11: real, r12: real, r13: real, r21: real, r22: real, r23: real, r31: real, r32: real,
    r33: real,
    rx: wp.ref[real], ry: wp.ref[real], rz: wp.ref[real], lowest: wp.ref[real],
):  # fmt: skip
    """Lever of a point (rx, ry, rz) [m], and the lowest gap so far; a point that is not is high."""
    rx = r11 * px + r12 * py + r13 * pz
    ry = r21 * px + r22 * py + r23 * pz
    height = wp.where(there, r31 * px + r32 * py + r33 * pz, FAR)
    rz = height
    lowest = smaller(lowest, z + height)


@wp.func
def find_contact(
    knobs: Knobs, foot: real, reach: real, half_width: real, lowest: real,
    x: real, y: real, z: real, rx: real, ry: real, rz: real, stood_x: real, stood_y: real,
    uz: real, ox: real, oy: real, oz: real,
    aim: wp.ref[real], on: wp.ref[real], held: wp.ref[real],
    fx: wp.ref[real], fy: wp.ref[real], n: wp.ref[real], apart: wp.ref[real],
    lifted: wp.ref[real], landed: wp.ref[real],
    count: wp.ref[real], sx: wp.ref[real], sy: wp.ref[real],
    xx: wp.ref[real], xy: wp.ref[real], yy: wp.ref[real],
    touching: wp.ref[real], slide_x: wp.ref[real], slide_y: wp.ref[real],
):  # fmt: skip
    """Finds whether a point is a contact, as `find_contact` of impulse_space/block.py.

    Besides, adds a point that carried in the last step to the sums of `spans`, and one that touches
    to those of the slide.
    """
    zero, one = real(0.0), real(1.0)
    g = z + rz
    carried = wp.where(n > zero, one, zero)
    a, b = carried * rx, carried * ry
    count = count + carried
    sx = sx + a
    sy = sy + b
    xx = xx + a * rx
    xy = xy + a * ry
    yy = yy + b * ry
    low = touches_as_lowest(g, lowest, half_width)
    touching = touching + wp.where(low, one, zero)
    slide_x = slide_x + wp.where(low, x + rx - stood_x, zero)
    slide_y = slide_y + wp.where(low, y + ry - stood_y, zero)
    gone = real(0.0)
    observe_contact(knobs, g, reach, ox, oy, oz, n, apart, gone, landed)
    lifted = lifted + wp.where(foot > zero, gone, zero)
    contact = g <= knobs.collision_margin
    now = wp.where(contact, one, zero)
    closes = -now * larger(g, zero) * knobs.rate
    leaves = bounce(knobs, rx, ry, uz, ox, oy, now, closes)
    aim = wp.where(knobs.restitution > zero, leaves, closes)
    on = now
    held = now
    fx = wp.where(contact, fx, zero)
    fy = wp.where(contact, fy, zero)
    n = wp.where(contact, n, zero)


@wp.func
def tell_stance(
    live: bool, before: real, count: wp.ref[real], sx: wp.ref[real], sy: wp.ref[real],
    xx: wp.ref[real], xy: wp.ref[real], yy: wp.ref[real], lifted: wp.ref[real],
    since: wp.ref[real], touching: wp.ref[real], way_x: wp.ref[real], way_y: wp.ref[real],
    slide_x: wp.ref[real], slide_y: wp.ref[real], peak_slide: wp.ref[real],
):  # fmt: skip
    """What the points tell of the pose that the last step led to, at the time `before` [s].

    The sums become zero; `since` is the time since which the body has not stood, or NEVER.
    """
    zero, part = real(0.0), real(1.0) / larger(count, real(1.0))
    stands = spans(count, xx - part * sx * sx, xy - part * sx * sy, yy - part * sy * sy)
    since = wp.where(stands, NEVER, smaller(since, before))
    lifted = wp.where(stands, zero, lifted)
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
    touching = zero
    way_x = zero
    way_y = zero


@wp.func
def glides(
    frame: Frame, knobs: Knobs, z: real, ux: real, uy: real, ox: real, oy: real, oz: real
) -> bool:
    """Whether a body that stands slides, with the velocities u and o after a step."""
    x, y, turn = ux - z * oy, uy + z * ox, oz * frame.reach
    return slips(x * x + y * y + turn * turn, knobs)


@wp.func
def observe_body(
    live: bool, time: real, block: Block, frame: Frame, sum: real,
    qx: real, qy: real, qz: real, qw: real, peak: wp.ref[real], peak_time: wp.ref[real],
    peak_across: wp.ref[real], peak_tilt: wp.ref[real], peak_yaw: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """Peaks of a body after a step, and whether its lane lives on.

    `sum` is one of its other numbers, which is finite only if they are.
    """
    up = real(0.0)
    observe_turns(
        live, time, block, frame, qx, qy, qz, qw, peak, peak_time, peak_across, peak_tilt,
        peak_yaw, up,
    )  # fmt: skip
    total = sum + up + qw
    found = wp.where(up <= real(0.0), OVERTURNED, RUNNING)
    mode = wp.where(live, wp.where(total - total == real(0.0), found, BROKEN), mode)
