"""Start of blocks in space in the event engine, their observed response, and their results.

A sample inside a step is read off the parabola that the step follows.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Quaternion, Vector
from warprock.kernels.event_space.block.contact import FLAT, FLYING, mask_of, stance_of
from warprock.kernels.event_space.block.moves import (
    block_axis,
    body_at,
    level_attitude,
    place_on_base,
    rotate_attitude,
    rotate_freely,
)
from warprock.kernels.event_space.block.trial import State
from warprock.kernels.lane.modes import RUNNING
from warprock.kernels.shape_space.block import Block, slide_of, turns_of
from warprock.kernels.shape_space.block_found import BlockResult, Result
from warprock.kernels.shape_space.lanes import matrix_of


@wp.struct
class Seen:
    """Observed response of a lane up to its time."""

    leaf: BlockResult
    uplift_time: real
    rest_time: real


@wp.func
def start(block: Block, gap: real) -> State:
    """The state at the start; if the lowest corner touches, so do all within `gap` [m] of it."""
    s = State()
    s.x = Vector(block.x, block.y, block.z)
    s.q = Quaternion(block.qx, block.qy, block.qz, block.qw)
    body = body_at(block, s.q)
    mask = int(0)
    for k in range(4):
        if s.x[2] + body.corners[k, 2] <= gap:
            mask = mask | (1 << k)
    s.stance = stance_of(mask)
    s.q = level_attitude(s.q, s.stance)
    s.x = place_on_base(body_at(block, s.q), mask_of(s.stance), s.x)
    s.cap = NEVER
    s.mode = RUNNING
    s.taken = True
    return s


@wp.func
def attitude_at(block: Block, until: real, s0: State, s: State) -> Quaternion:
    """Attitude at a time inside the last step, from one state to the next."""
    d = s.time - s0.time
    q = s.q
    if until < s.time and d > real(0.0):
        tau = until - s0.time
        if s0.stance == FLYING:
            q = rotate_freely(block, s0.q, body_at(block, s0.q).inertia * s0.w, tau)
        else:
            part = tau / d
            q = rotate_attitude(s0.q, tau * s0.w + part * part * (s.turn - d * s0.w))
    return q


@wp.func
def place_at(until: real, s0: State, s: State) -> Vector:
    """Centre of mass at a time inside the last step [m], from one state to the next."""
    d = s.time - s0.time
    x = s.x
    if until < s.time and d > real(0.0):
        tau = until - s0.time
        part = tau / d
        x = s0.x + tau * s0.v + part * part * (s.x - s0.x - d * s0.v)
    return x


@wp.func
def peaks_at(block: Block, before: BlockResult, q: Quaternion, time: real) -> BlockResult:
    """The largest turns so far, with those of an attitude."""
    leaf = before
    r = matrix_of(q[0], q[1], q[2], q[3])
    plane, across, tilt, yaw = turns_of(block, r.r13, r.r23, r.r33, q[2], q[3])
    leaf.peak_time = wp.where(plane > leaf.peak, time, leaf.peak_time)
    leaf.peak = larger(plane, leaf.peak)
    leaf.peak_across = larger(across, leaf.peak_across)
    leaf.peak_tilt = larger(tilt, leaf.peak_tilt)
    leaf.peak_yaw = larger(yaw, leaf.peak_yaw)
    return leaf


@wp.func
def turning_time(
    axis0: Vector, rate0: Vector, axis1: Vector, rate1: Vector, i: int, d: real
) -> real:
    """Time in a step at which a rotation of the block's axis turns back; zero if it does not."""
    r0 = rate0[i] * axis0[2] - axis0[i] * rate0[2]
    r1 = rate1[i] * axis1[2] - axis1[i] * rate1[2]
    return wp.where(r0 * r1 < real(0.0), d * r0 / (r0 - r1), real(0.0))


@wp.func
def observe(block: Block, before: Seen, s0: State, s: State) -> Seen:
    """The observed response after a step from one state to the next."""
    seen = before
    d = s.time - s0.time
    seen.leaf = peaks_at(block, before.leaf, s.q, s.time)
    axis0 = block_axis(s0.q)
    axis1 = block_axis(s.q)
    for i in range(2):
        at = turning_time(axis0, wp.cross(s0.w, axis0), axis1, wp.cross(s.swing, axis1), i, d)
        if at > real(0.0):
            time = s0.time + at
            seen.leaf = peaks_at(block, seen.leaf, attitude_at(block, time, s0, s), time)
    if s.stance != FLYING:
        r = matrix_of(s.q[0], s.q[1], s.q[2], s.q[3])
        slide_x, slide_y = slide_of(block, s.x[0], s.x[1], r)
        square = slide_x * slide_x + slide_y * slide_y
        seen.leaf.slide_x = slide_x
        seen.leaf.slide_y = slide_y
        seen.leaf.peak_slide = larger(square, seen.leaf.peak_slide)
    # A velocity step of the base lifts the block at the end of a step, an acceleration at its
    # start. The first step after that turns so little that the cosine of the tilt may stay at 1.
    if s0.stance == FLAT and s.stance != FLAT and seen.uplift_time >= NEVER:
        upright_still = axis1[0] == axis0[0] and axis1[1] == axis0[1]
        seen.uplift_time = wp.where(upright_still, s.time, s0.time)
    rested = s0.stance == FLAT and s0.slip == 0
    if s.stance != FLAT or s.slip != 0:
        seen.rest_time = NEVER
    elif not rested:
        seen.rest_time = s.time
    return seen


@wp.func
def observe_start(block: Block, s: State) -> Seen:
    """Observed response of a lane at its start."""
    seen = Seen()
    seen.leaf = peaks_at(block, seen.leaf, s.q, real(0.0))
    seen.uplift_time = wp.where(s.stance == FLAT, NEVER, real(0.0))
    seen.rest_time = wp.where(s.stance == FLAT, real(0.0), NEVER)
    return seen


@wp.func
def lane_result(block: Block, steps: int, s: State, seen: Seen) -> Result:
    """Results of a lane."""
    return Result(
        seen.uplift_time, seen.rest_time, block.mass * s.lost, s.deepest, s.impacts, s.mode, steps
    )


@wp.func
def block_result(s: State, seen: Seen) -> BlockResult:
    """Results of its block."""
    leaf = seen.leaf
    leaf.qz = s.q[2]
    leaf.qw = s.q[3]
    return leaf
