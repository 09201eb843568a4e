"""Runs of a body on a convex base over lanes, LANES lanes a thread; see housner/block_run.py."""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, ONLY, UPWARDS
from warprock.kernels.housner.block import end_step, observe, stall
from warprock.kernels.housner.block_found import BlockResult, Result, Seen
from warprock.kernels.housner.body import (
    Body,
    Edge,
    Ending,
    State,
    advance,
    apply_event,
    kick,
)
from warprock.kernels.housner.body_series import Foot
from warprock.kernels.lane.modes import OVERTURNED, RESTING, ROCKING
from warprock.kernels.launch.instance import HALVES_VECTORS, TWO_VECTORS
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, ground_at, knot_step, knot_time
from warprock.kernels.shape.above import Above, Motions, above_at
from warprock.kernels.shape.body_found import TO_LEFT, TO_RIGHT, Sides

if not (HALVES_VECTORS and MOTION == "record" and not VERTICAL):
    wp.set_module_options(TWO_VECTORS)


@wp.struct
class Found:
    """Where the answers go; `sides`: largest rotations to -x and to +x [rad], shape [2, lane]."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
    sides: wp.array2d(dtype=real)


@wp.struct
class Start:
    """Rotation and its rate at the start, the number of the foot there, and that of the last."""

    theta: real
    omega: real
    place: int
    last: int


@wp.func
def start_lane(start: Start):
    """Releases a body: its state, what is seen of it."""
    zero = real(0.0)
    flat = start.theta == zero and start.omega == zero
    mode = wp.where(flat, RESTING, ROCKING)
    lifted, rested = wp.where(flat, NEVER, zero), wp.where(flat, zero, NEVER)
    state = State(start.theta, start.omega, start.place, start.last, zero, 0, 0, mode, NEVER, zero)
    return state, Seen(size(start.theta), zero, lifted, rested, zero, 0, 0)


@wp.func
def settle(
    body: Body, foot: Foot, edge: Edge, ending: Ending, m: Motion, above: Above, s: State,
    seen: Seen,
):  # fmt: skip
    """What the event at the end of a step does, or else the knot of the motion that it ends at."""
    n = s
    o = seen
    apply_event(body, edge, ending, n, o)
    # After an event the foot is another: the knot is passed in a step of its own, of length zero.
    goes_on = s.mode < OVERTURNED and not (ending.impact or ending.uplift)
    passed = s.time >= knot_time(m, s.segment) and goes_on
    dv, dz = wp.where(passed, knot_step(m, s.segment), real(0.0)), real(0.0)
    n.segment = s.segment + wp.where(passed, 1, 0)
    if VERTICAL:
        rises = s.time >= knot_time(above.motion, s.risen) and goes_on
        dz = wp.where(rises, knot_step(above.motion, s.risen), real(0.0))
        n.risen = s.risen + wp.where(rises, 1, 0)
    kick(body, foot, edge, dv, dz, n, o)
    mode, theta = end_step(n.mode, n.theta, n.omega, n.time)
    n.theta = theta
    observe(n.theta, n.time, o)
    n.mode = stall(mode, o.steps, body.step_limit)
    return n, o


@kernel
def run_lanes(
    blocks: wp.array(dtype=Body),
    feet: wp.array2d(dtype=Foot),
    edges: wp.array2d(dtype=Edge),
    motions: Motions,
    pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=Start),
    sample_times: wp.array(dtype=real),
    found: Found,
):
    """Runs LANES lanes a thread, which take their steps side by side.

    `feet` and `edges` are [number, lane]; lanes with fewer repeat the last.
    """
    first = wp.tid() * LANES
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    sides = found.sides
    state = rows(State)
    seen = rows(Seen)
    reach = rows(Sides)
    for i in range(LANES):
        s0, o0 = start_lane(starts[first + i])
        state[i] = s0
        seen[i] = o0
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        busy = int(1)
        while busy > 0:
            busy = int(0)
            for i in range(LANES):
                above = Above()
                if VERTICAL:
                    m = motions[ALONG, first + i]
                    up = motions[UPWARDS, first + i]
                    above = above_at(up, state[i].risen, pool)
                else:
                    m = motions[first + i]
                ground = ground_at(m, state[i].segment, pool)
                going = state[i].mode < OVERTURNED and state[i].time < until
                # The last foot has no edge behind it.
                place = state[i].place
                last = state[i].last - 1
                foot = feet[place, first + i]
                behind = edges[wp.min(place, last), first + i]
                ahead, ending = advance(
                    blocks[first + i], foot, behind, m, ground, above, until, state[i]
                )
                number = place - wp.where(ending.upper, 0, 1)
                edge = edges[wp.min(wp.max(number, 0), last), first + i]
                after, shown = settle(
                    blocks[first + i], foot, edge, ending, m, above, ahead, seen[i]
                )
                # A lane that waits for others takes no step, not even one of length zero.
                state[i] = wp.where(going, after, state[i])
                seen[i] = wp.where(going, shown, seen[i])
                reach[i].left = larger(-state[i].theta, reach[i].left)
                reach[i].right = larger(state[i].theta, reach[i].right)
            for i in range(LANES):
                runs = state[i].mode < OVERTURNED and state[i].time < until
                busy = busy + wp.where(runs, 1, 0)
        if rotations.shape[0] > 0:
            for i in range(LANES):
                rotations[sample, ONLY, first + i] = state[i].theta
    for i in range(LANES):
        o = seen[i]
        results[first + i] = Result(
            o.uplift_time, o.rest_time, o.loss, state[i].needed, o.impacts, state[i].mode, o.steps
        )
        sides[TO_LEFT, first + i] = reach[i].left
        sides[TO_RIGHT, first + i] = reach[i].right
        leaves[0, first + i] = BlockResult(seen[i].peak, seen[i].peak_time)
