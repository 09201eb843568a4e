"""Runs of the event step over stacks with bodies, one lane a thread; event/stack_body.py.

As event/stack_run.py, with the corners of all blocks in one table, block by block.
"""

import warp as wp

from warprock.kernels.event.stack import end_of_step, sought
from warprock.kernels.event.stack_body import on_edge, overshoot, rolled_on
from warprock.kernels.event.stack_moves import started
from warprock.kernels.event.stack_run import (
    BlockResult,
    Found,
    Knobs,
    Result,
    Stack,
    between_steps,
    centres,
    observe,
    observe_start,
    rotation_at,
)
from warprock.kernels.event.stack_state import Limits, State, Trial
from warprock.kernels.event.stack_trial import tried
from warprock.kernels.instance import SHORT_LOOPS_GO
from warprock.kernels.modes import RUNNING, STALLED
from warprock.kernels.motion import sample_index
from warprock.kernels.shape.above import Above, Motions
from warprock.kernels.shape.stack import OPEN, Blocks, Counts, Values
from warprock.kernels.shape.stack_body import Foot

wp.set_module_options(SHORT_LOOPS_GO)

LANES = 1
"""Lanes that a thread runs."""


@wp.struct
class Block:
    """One block, and how it starts: see shape/stack_body.py.

    `aside` and the ends of the top are seen from the centres of mass; `edge` is the row at which
    the edge begins that it stands on at first.
    """

    inverse_mass: real
    inverse_inertia: real
    friction: real
    rest_rotation: real
    aside: real
    top_low: real
    top_high: real
    top: real
    theta: real
    edge: int


@wp.func
def with_block(blocks: Blocks, b: Block, k: int) -> Blocks:
    """The blocks with what does not change of block k."""
    new = blocks
    new.inverse_mass[k] = b.inverse_mass
    new.inverse_inertia[k] = b.inverse_inertia
    new.friction[k] = b.friction
    new.top_half[k] = HALF * (b.top_high - b.top_low)
    new.top_middle[k] = HALF * (b.top_high + b.top_low)
    new.top_height[k] = b.top
    return new


@wp.func
def on_new_edges(old: Blocks, blocks: Blocks, trial: Trial) -> Trial:
    """A trial step with its end told by the edges that its blocks have come to."""
    t = trial
    t.pose = rolled_on(old, blocks, trial.pose, trial.way, trial.falls)
    for k in range(BLOCKS):
        if t.way[k] != 0 and t.falls[k] != OPEN:
            t.deep = larger(overshoot(blocks, t.pose, k), t.deep)
    return t


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), feet: wp.array2d(dtype=Foot),
    motions: Motions, pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread."""
    lane = wp.tid()
    if VERTICAL:
        m = motions[0, lane]
        up = motions[1, lane]
    else:
        m = motions[lane]
    pile, limits, s, offset, edge = Blocks(), Limits(), State(), Values(), Counts()
    limits.gravity = knobs.gravity
    limits.mass = lanes[lane].mass
    limits.longest_step = lanes[lane].longest_step
    step_limit = lanes[lane].step_limit
    for k in range(BLOCKS):
        b = blocks[k, lane]
        e = b.edge
        edge[k] = e
        pile = with_block(pile, b, k)
        pile = on_edge(
            pile, k, feet[e - 1, lane], feet[e, lane], feet[e + 1, lane], feet[e + 2, lane]
        )
        limits.rest_rotation[k] = b.rest_rotation
        offset[k] = b.aside
        if k > 0:
            offset[k] = b.aside - pile.top_middle[k - 1]
        s.pose.along[k] = offset[k] + pile.rolled[k]
        s.pose.theta[k] = b.theta
    s.pose = started(pile, s.pose)
    s.cap = NEVER
    s0 = s
    pile0 = pile
    seen = observe_start(s.pose)
    steps = int(0)
    end = sample_times[sample_times.shape[0] - 1]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while s.mode == RUNNING and s.time < until:
            steps += 1
            place = sample_index(m, s.segment)
            if VERTICAL:
                high = sample_index(up, s.risen)
                limits.above = Above(up, s.risen, pool[0, high], pool[1, high])
            t = tried(pile, limits, m, pool[0, place], pool[1, place], end, s)
            n = sought(limits, s, t)
            after = pile
            if n.seek == s.seek or t.resting:
                for k in range(BLOCKS):
                    if t.way[k] != 0:
                        e = edge[k] + t.way[k]
                        after = on_edge(after, k, feet[e - 1, lane], feet[e, lane],
                            feet[e + 1, lane], feet[e + 2, lane])  # fmt: skip
                n = end_of_step(after, limits, s, on_new_edges(pile, after, t))
            if n.taken:
                seen = observe(after, seen, offset, s, n)
                s0 = s
                pile0 = pile
                pile = after
                edge = edge + t.way
            s = n
            if steps >= step_limit and s.mode == RUNNING:
                s.mode = STALLED
        if found.rotations.shape[0] > 0:
            for k in range(BLOCKS):
                found.rotations[sample, k, lane] = rotation_at(until, s0, s, k)
        if found.places.shape[0] > 0:
            x0, z0 = centres(pile0, s0.pose)
            x1, z1 = centres(pile, s.pose)
            for k in range(BLOCKS):
                vx, vz = s0.velocity[3 * k], s0.velocity[3 * k + 1]
                found.places[sample, k, 0, lane] = between_steps(until, s0, s, x0[k], vx, x1[k])
                found.places[sample, k, 1, lane] = between_steps(until, s0, s, z0[k], vz, z1[k])
    found.results[lane] = Result(
        seen.uplift_time, seen.rest_time, s.lost, s.deepest, s.impacts, s.mode, steps
    )
    for k in range(BLOCKS):
        found.blocks[k, lane] = BlockResult(
            seen.slide[k], seen.peak[k], seen.peak_time[k], seen.peak_slide[k]
        )
