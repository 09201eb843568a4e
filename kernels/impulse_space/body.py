"""Velocity-level contact step of a body in space that stands on points.

Equations and functions are those of impulse_space/block.py, with the points of a body (see
shape_space/body.py) in the place of the corners of a block. Every second sweep visits the points in
reverse order, so that the residual has no preferred sense.

A body rocks while one of its feet has parted from the base, see parting.py, and the points that
carry do not span a plane. So a body may come to rest on other points than it stood on. Its uplift
time is when the points that carry last spanned a plane. It moves while it rocks or slides.
"""

import warp as wp

from warprock.kernels.impulse_space.block import (
    FAR,
    Contact,
    Gaps,
    Knobs,
    Velocity,
    observe_contact,
    slips,
)
from warprock.kernels.impulse_space.bounce import bounce_velocity, rounded_into_base
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import Peaks, Result, observe_slide, observe_turns
from warprock.kernels.shape_space.body import (
    Frame,
    Point,
    body_attitude,
    spans,
    throw_of,
    turns_of_body,
)
from warprock.kernels.shape_space.lanes import State, Symmetric, Triple, Turn
from warprock.kernels.shape_space.thrown import push, tumble_on


@wp.struct
class Stance:
    """Sums over the points of a body in the pose after the last step.

    Attributes:
        count: Number of points that carried in the last step.
        x, y, xx, xy, yy: Sums of their levers along the base [m] and of products of these [m^2].
        touching: Number of points that touch for the slide.
        way_x, way_y: Sums of their displacements from where they stood [m].
    """

    count: real
    x: real
    y: real
    xx: real
    xy: real
    yy: real
    touching: real
    way_x: real
    way_y: real


@wp.func
def start_body(block: Block, frame: Frame, knobs: Knobs) -> State:
    """State of a body at its start, with the velocity of half a step before."""
    qx, qy, qz, qw = body_attitude(frame, block.qx, block.qy, block.qz, block.qw)
    inverse = Triple(block.inverse_x, block.inverse_y, block.inverse_z)
    zero = real(0.0)
    rests = State(
        block.x, block.y, block.z, qx, qy, qz, qw, zero, zero, zero, zero, zero, zero
    )  # fmt: skip
    s = push(throw_of(frame), inverse, rests)
    s.vz = s.vz + HALF * knobs.time_step * knobs.gravity
    return s


@wp.func
def start_lane(block: Block, frame: Frame) -> Result:
    """Observed response of a lane before its first step."""
    zero = real(0.0)
    stands = block.standing == frame.feet
    return Result(wp.where(stands, NEVER, zero), zero, zero, zero, 0, RUNNING, 0)


@wp.func
def weight_on(foot: real, knobs: Knobs, frame: Frame) -> real:
    """Normal impulse of a point at the start: the feet share the weight."""
    part = HALF * knobs.time_step * knobs.gravity / frame.feet
    return wp.where(foot > real(0.0), part, real(0.0))


@wp.func
def free_velocity(dv: Triple, knobs: Knobs, j: Symmetric, s: State) -> Velocity:
    """Velocity of a body without contact; dv is the change of the base velocity [m/s]."""
    return Velocity(
        s.vx - dv.x, s.vy - dv.y, s.vz - dv.z - knobs.time_step * knobs.gravity,
        j.xx * s.lx + j.xy * s.ly + j.xz * s.lz,
        j.xy * s.lx + j.yy * s.ly + j.yz * s.lz,
        j.xz * s.lx + j.yz * s.ly + j.zz * s.lz,
    )  # fmt: skip


@wp.func
def lever_of(point: Point, r: Turn) -> Triple:
    """Lever of a point [m]; a row without a point is high above."""
    at = rounded_into_base(r, Triple(point.x, point.y, point.z))
    return Triple(at.x, at.y, wp.where(point.foot >= real(0.0), at.z, FAR))


@wp.func
def add_to_stance(
    carries: bool, low: bool, at: Contact, point: Point, s: State, sums: wp.ref[Stance]
):
    """Adds a point that carried in the last step to the sums, and one that touches."""
    zero, one = real(0.0), real(1.0)
    carried = wp.where(carries, one, zero)
    a, b = carried * at.x, carried * at.y
    sums.count = sums.count + carried
    sums.x = sums.x + a
    sums.y = sums.y + b
    sums.xx = sums.xx + a * at.x
    sums.xy = sums.xy + a * at.y
    sums.yy = sums.yy + b * at.y
    sums.touching = sums.touching + wp.where(low, one, zero)
    sums.way_x = sums.way_x + wp.where(low, s.x + at.x - point.stood_x, zero)
    sums.way_y = sums.way_y + wp.where(low, s.y + at.y - point.stood_y, zero)


@wp.func
def observe_point(
    knobs: Knobs, gap: real, reach: real, foot: real, u: Velocity, n: real, apart: wp.ref[real],
    gaps: wp.ref[Gaps],
):  # fmt: skip
    """As `observe_contact` of impulse_space/block.py, for a point: only feet count as lifted."""
    lifted = real(gaps.lifted)
    gaps.lifted = real(0.0)
    observe_contact(knobs, gap, reach, u, n, apart, gaps)
    gaps.lifted = lifted + wp.where(foot > real(0.0), gaps.lifted, real(0.0))


@wp.func
def find_contact(knobs: Knobs, gap: real, at: Triple, u: Velocity) -> Contact:
    """Whether a point is a contact, and its least normal velocity.

    Where there is none its lever is level: of a row without a point, FAR has no square in float32.
    """
    zero = real(0.0)
    on = wp.where(gap <= knobs.collision_margin, real(1.0), zero)
    h = wp.where(on > zero, at.z, zero)
    closes = Contact(at.x, at.y, h, -on * larger(gap, zero) * knobs.rate, on)
    leaves = bounce_velocity(knobs, closes, u)
    aim = wp.where(knobs.restitution > zero, leaves, closes.aim)
    return Contact(at.x, at.y, h, aim, on)


@wp.func
def observe_stance(
    live: bool, before: real, sums: Stance, gaps: wp.ref[Gaps], since: real, p: Peaks
):
    """Observes the pose after the last step, at the time `before` [s], by its points.

    Returns:
        The time since which the body has not stood [s], or NEVER; the peaks with its slide.
    """
    zero, part = real(0.0), real(1.0) / larger(sums.count, real(1.0))
    stands = spans(
        sums.count, sums.xx - part * sums.x * sums.x, sums.xy - part * sums.x * sums.y,
        sums.yy - part * sums.y * sums.y,
    )  # fmt: skip
    gaps.lifted = wp.where(stands, zero, gaps.lifted)
    x, y = sums.way_x / sums.touching, sums.way_y / sums.touching
    waits = wp.where(stands, NEVER, smaller(since, before))
    return waits, observe_slide(live, x, y, x * x + y * y, p)


@wp.func
def glides(frame: Frame, knobs: Knobs, z: real, u: Velocity) -> bool:
    """Whether a standing body slides, from its velocity after a step."""
    x, y, turn = u.x - z * u.turn_y, u.y + z * u.turn_x, u.turn_z * frame.reach
    return slips(x * x + y * y + turn * turn, knobs)


@wp.func
def observe_body(
    time: real, block: Block, frame: Frame, s: State, mode: wp.ref[int], way: wp.ref[real], p: Peaks
) -> Peaks:  # fmt: skip
    """Peaks of a body after a step, and whether its lane still runs.

    The lane of a body that tumbles keeps running. Its slide is the displacement of its centre;
    `way` is the square of the largest so far [m^2].
    """
    live = mode == RUNNING
    now = turns_of_body(block, frame, s.qx, s.qy, s.qz, s.qw)
    seen = observe_turns(live, time, now.along, now.across, now.tilt, now.yaw, p)
    total = s.x + s.y + s.z + s.vx + s.vy + s.vz + s.lx + s.ly + s.lz + now.up + s.qw
    falls = wp.where(now.up <= real(0.0), OVERTURNED, RUNNING)
    goes = wp.where(total - total == real(0.0), falls, BROKEN)
    mode = wp.where(live, goes, mode)
    return tumble_on(throw_of(frame), block, s, mode, way, seen)
