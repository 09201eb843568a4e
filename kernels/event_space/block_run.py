"""Runs of the event step over blocks in space (event_space/block/step.py), one lane a thread.

Every lane has its own clock and ends its steps at its events. A sample inside a step is read off
the parabola that the step follows, so that histories do not change the run. If THROWN is true,
blocks start in motion, see event_space/block/thrown.py.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ONLY, Quaternion
from warprock.kernels.event_space.block.seen import (
    attitude_at,
    block_result,
    lane_result,
    observe,
    observe_start,
    place_at,
    start,
)
from warprock.kernels.event_space.block.step import TOGETHER, step
from warprock.kernels.event_space.lane import Knobs, Lane, Limits, base_motion, read_samples
from warprock.kernels.lane.modes import RUNNING, STALLED
from warprock.kernels.launch.instance import BRANCHES
from warprock.kernels.motion.kinds import Motion
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import Found
from warprock.kernels.shape_space.thrown import (
    Throw,
    compose,
    needs_new_axes,
    new_axes,
    rename_block_axes,
)

if THROWN:
    from warprock.kernels.event_space.block.thrown import (
        observe_tumbling,
        own_axes,
        rename_axes,
        start_thrown,
    )

wp.set_module_options(BRANCHES)

LANES = 1
"""Lanes of a thread: which contacts act differs from lane to lane."""


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), throws: wp.array(dtype=Throw),
    motions: wp.array2d(dtype=Motion), pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), lanes: wp.array(dtype=Lane), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread; `throws` say how blocks start if THROWN is true."""
    lane = wp.tid()
    block = blocks[0, lane]
    motion = base_motion(motions, lane)
    limits = Limits(knobs.gravity, lanes[lane].longest_step, lanes[lane].rest_gap)
    s = start(block, TOGETHER * block.half_height)
    if THROWN:
        throw = throws[lane]
        s = start_thrown(block, limits, throw, s)
        # Turn from the body axes at the start to the present ones, which change between steps.
        named = Quaternion(real(0.0), real(0.0), real(0.0), real(1.0))
    s0 = s
    seen = observe_start(block, s)
    steps = int(0)
    end = sample_times[sample_times.shape[0] - 1]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while s.mode == RUNNING and s.time < until:
            steps += 1
            if THROWN:
                down = throw.tumbles == 1 and needs_new_axes(s.q[0], s.q[1])
                if down:
                    gx, gy, gw = new_axes(s.q[0], s.q[1], s.q[2], s.q[3])
                    block = rename_block_axes(block, gx, gy)
                    s = rename_axes(s, gx, gy, gw)
                    nx, ny, nz, nw = compose(
                        named[0], named[1], named[2], named[3], gx, gy, real(0.0), gw
                    )
                    named = Quaternion(nx, ny, nz, nw)
            motion = read_samples(motion, s.knots, pool)
            n = step(block, limits, motion, end, s)
            if n.taken:
                if THROWN:
                    if throw.tumbles == 1:
                        seen = observe_tumbling(block, seen, s, n, named)
                    else:
                        seen = observe(block, seen, s, n)
                else:
                    seen = observe(block, seen, s, n)
                s0 = s
            s = n
            if steps >= lanes[lane].step_limit and s.mode == RUNNING:
                s.mode = STALLED
        if found.attitudes.shape[0] > 0:
            q = attitude_at(block, until, s0, s)
            if THROWN:
                q = own_axes(q, named)
            for part in range(4):
                found.attitudes[sample, ONLY, part, lane] = q[part]
        if found.places.shape[0] > 0:
            x = place_at(until, s0, s)
            for part in range(3):
                found.places[sample, ONLY, part, lane] = x[part]
    if THROWN:
        s.q = own_axes(s.q, named)
    found.results[lane] = lane_result(block, steps, s, seen)
    found.blocks[0, lane] = block_result(s, seen)
