"""Observed response of single blocks in space under the impulse step.

A block rocks while a corner has parted from the base, see parting.py. It lands once such a corner
carries again; both corners of an edge count as one landing. It stands flat while two opposite
corners carry; its uplift time is when it last did. It moves while it rocks or slides, see `slips`.
"""

import warp as wp

from warprock.kernels.impulse_space.block import (
    Box,
    Gaps,
    Impulse,
    Knobs,
    Velocity,
    slips,
)
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING
from warprock.kernels.shape_space.block import Block, slide_of, turns_of
from warprock.kernels.shape_space.block_found import Peaks, Result, observe_slide, observe_turns
from warprock.kernels.shape_space.lanes import State, product, turn_of


@wp.func
def glides(box: Box, knobs: Knobs, u: Velocity) -> bool:
    """Whether a flat block slides, from its velocity after a step."""
    x = fused_less(box.half_height, u.turn_y, u.x)
    y = fused(box.half_height, u.turn_x, u.y)
    turn = u.turn_z * (box.half_width + box.half_depth)
    return slips(product(x, y, turn, x, y, turn), knobs)


@wp.func
def stands(a: Impulse, b: Impulse, c: Impulse, d: Impulse) -> bool:
    """Whether a block stands flat: two opposite corners carry."""
    return smaller(a.n, d.n) > real(0.0) or smaller(b.n, c.n) > real(0.0)


@wp.func
def observe_contacts(
    live: bool, time: real, gaps: Gaps, slides: bool, since: real, seen: wp.ref[Result]
):
    """Updates motion, impacts and penetration of a lane.

    Args:
        live: Whether the lane still runs.
        time: End of the step [s].
        gaps: Observed gaps of the contacts.
        slides: Whether the block slides if it stands flat.
        since: Time since which it has not stood flat [s], or NEVER.
        seen: Observed response of the lane.
    """
    zero = real(0.0)
    rocks = live and gaps.lifted > zero
    lifts = smaller(seen.uplift_time, smaller(since, time))
    seen.uplift_time = wp.where(rocks, lifts, seen.uplift_time)
    seen.moved = wp.where(rocks or (live and slides), time, seen.moved)
    seen.impacts = seen.impacts + wp.where(live and gaps.landed > zero, 1, 0)
    seen.steps = seen.steps + wp.where(live, 1, 0)
    seen.deepest = wp.where(live, larger(-gaps.lowest, seen.deepest), seen.deepest)


@wp.func
def observe_block(live: bool, time: real, block: Block, s: State, peaks: Peaks) -> Peaks:
    """Peaks and slide of a block after a step, if its lane still runs."""
    r = turn_of(s)
    along, across, tilt, yaw = turns_of(block, r.r13, r.r23, r.r33, s.qz, s.qw)
    x, y = slide_of(block, s.x, s.y, r)
    turned = observe_turns(live, time, along, across, tilt, yaw, peaks)
    return observe_slide(live, x, y, dot(x, y, x, y), turned)


@wp.func
def mode_after(mode: int, s: State) -> int:
    """Mode of a lane after a step; it does not change once the lane has ended."""
    speed = s.vx + s.vy + s.vz + s.lx + s.ly + s.lz
    up = turn_of(s).r33
    total = s.x + s.y + s.z + up + s.qw + speed
    found = wp.where(up <= real(0.0), OVERTURNED, RUNNING)
    goes = wp.where(total - total == real(0.0), found, BROKEN)
    return wp.where(mode == RUNNING, goes, mode)
