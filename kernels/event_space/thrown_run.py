"""Runs of the event step over blocks in space that start in motion, one lane a thread.

As event_space/block_run.py, but for the start, where what moves into the base meets it (an
inelastic impact), and for blocks that tumble: between two steps the face that looks down becomes
the bottom (shape_space/thrown.py), so that the step knows of no other. Their slide is the way of
their centre along the base.

It is a text of its own: a block and its attitude are here in axes that change between two steps,
and what is seen of it in those that it began with. block_run.py knows one set of axes.
"""

import warp as wp

from warprock.kernels.event_space.block import DUST, TOGETHER, solve, step
from warprock.kernels.event_space.block_contact import FLAT, FLYING, Corners, mask_of, stance_of
from warprock.kernels.event_space.block_moves import body_at
from warprock.kernels.event_space.block_run import (
    Seen,
    attitude_at,
    block_result,
    lane_result,
    observe,
    observe_start,
    peaks_at,
    place_at,
    start,
)
from warprock.kernels.event_space.block_trial import State, kinetic_energy
from warprock.kernels.event_space.lane import BaseMotion, Knobs, Lane, Limits
from warprock.kernels.instance import BRANCHES
from warprock.kernels.modes import RUNNING, STALLED, UNSOLVED
from warprock.kernels.motion import Motion, sample_index
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import Found
from warprock.kernels.shape_space.thrown import Throw, after, leans, new_axes, old_corner, renamed
from warprock.kernels.vectors import Quaternion, Vector

wp.set_module_options(BRANCHES)

LANES = 1
"""Lanes of a thread: which contacts act differs from lane to lane."""


@wp.func
def let_go_with(block: Block, limits: Limits, throw: Throw, at_rest: State) -> State:
    """The state at the start, with its velocities, or with what the base leaves of them."""
    s = at_rest
    s.v = Vector(throw.vx, throw.vy, throw.vz)
    s.w = Vector(throw.wx, throw.wy, throw.wz)
    if s.stance != FLYING:
        body = body_at(block, s.q)
        speed = wp.length(s.v) + wp.length(s.w) * block.half_height
        grain = DUST * (speed + limits.gravity * limits.longest_step)
        h = solve(body, s.stance, 0, Corners(), s.v, s.w, grain)
        s.lost = kinetic_energy(body, s.v, s.w) - kinetic_energy(body, h.v, h.w)
        s.v = h.v
        s.w = h.w
        s.stance = h.stance
        s.slip = h.slip
        s.mode = wp.where(h.fits, s.mode, UNSOLVED)
    return s


@wp.func
def corners_after(mask: int, gx: real, gy: real, gw: real) -> int:
    """Some corners of the old bottom, a sum of 2^k, by their numbers on the new one."""
    found = int(0)
    for k in range(4):
        old = old_corner(k, gx, gy, gw)
        if old >= 0 and (mask & (1 << old)) != 0:
            found = found | (1 << k)
    return found


@wp.func
def stood_on(s: State, gx: real, gy: real, gw: real) -> State:
    """The state in renamed axes."""
    n = s
    x, y, z, w = after(s.q[0], s.q[1], s.q[2], s.q[3], gx, gy, real(0.0), gw)
    n.q = Quaternion(x, y, z, w)
    n.stance = stance_of(corners_after(mask_of(s.stance), gx, gy, gw))
    along = corners_after(s.slip & 15, gx, gy, gw)
    n.slip = along | (corners_after(s.slip >> 4, gx, gy, gw) << 4)
    return n


@wp.func
def own_axes(q: Quaternion, named: Quaternion) -> Quaternion:
    """The attitude of the axes that the block began with."""
    x, y, z, w = after(q[0], q[1], q[2], q[3], -named[0], -named[1], -named[2], named[3])
    return Quaternion(x, y, z, w)


@wp.func
def observe_tumbling(block: Block, before: Seen, s0: State, s: State, named: Quaternion) -> Seen:
    """What a step adds to what has been observed of a block that tumbles."""
    seen = before
    seen.leaf = peaks_at(block, before.leaf, own_axes(s.q, named), s.time)
    x, y = s.x[0] - block.x, s.x[1] - block.y
    seen.leaf.slide_x = x
    seen.leaf.slide_y = y
    seen.leaf.peak_slide = larger(x * x + y * y, seen.leaf.peak_slide)
    rested = s0.stance == FLAT and s0.slip == 0
    if s.stance != FLAT or s.slip != 0:
        seen.rest_time = NEVER
    elif not rested:
        seen.rest_time = s.time
    return seen


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), throws: wp.array(dtype=Throw),
    motions: wp.array2d(dtype=Motion), pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), lanes: wp.array(dtype=Lane), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread."""
    lane = wp.tid()
    block = blocks[0, lane]
    throw = throws[lane]
    motion = BaseMotion()
    motion.x = motions[0, lane]
    motion.y = motions[1, lane]
    motion.z = motions[2, lane]
    limits = Limits()
    limits.gravity = knobs.gravity
    limits.longest_step = lanes[lane].longest_step
    limits.rest_gap = lanes[lane].rest_gap
    named = Quaternion(real(0.0), real(0.0), real(0.0), real(1.0))
    s = let_go_with(block, limits, throw, start(block, TOGETHER * block.half_height))
    s0 = s
    seen = observe_start(block, s)
    steps = int(0)
    end = sample_times[sample_times.shape[0] - 1]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while s.mode == RUNNING and s.time < until:
            steps += 1
            if throw.tumbles == 1 and leans(s.q[0], s.q[1]):
                gx, gy, gw = new_axes(s.q[0], s.q[1], s.q[2], s.q[3])
                block = renamed(block, gx, gy)
                s = stood_on(s, gx, gy, gw)
                nx, ny, nz, nw = after(
                    named[0], named[1], named[2], named[3], gx, gy, real(0.0), gw
                )
                named = Quaternion(nx, ny, nz, nw)
            px = sample_index(motion.x, s.knots[0])
            py = sample_index(motion.y, s.knots[1])
            pz = sample_index(motion.z, s.knots[2])
            motion.value = Vector(pool[0, px], pool[0, py], pool[0, pz])
            motion.slope = Vector(pool[1, px], pool[1, py], pool[1, pz])
            n = step(block, limits, motion, end, s)
            if n.taken:
                if throw.tumbles == 1:
                    seen = observe_tumbling(block, seen, s, n, named)
                else:
                    seen = observe(block, seen, s, n)
                s0 = s
            s = n
            if steps >= lanes[lane].step_limit and s.mode == RUNNING:
                s.mode = STALLED
        if found.attitudes.shape[0] > 0:
            q = own_axes(attitude_at(block, until, s0, s), named)
            for part in range(4):
                found.attitudes[sample, 0, part, lane] = q[part]
        if found.places.shape[0] > 0:
            x = place_at(until, s0, s)
            for part in range(3):
                found.places[sample, 0, part, lane] = x[part]
    s.q = own_axes(s.q, named)
    found.results[lane] = lane_result(block, steps, s, seen)
    found.blocks[0, lane] = block_result(s, seen)
