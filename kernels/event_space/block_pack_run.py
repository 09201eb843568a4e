"""Runs of the event step over blocks in space, LANES lanes side by side on the CPU.

Steps without an event run as vector code, see event_space/block/pack.py; all other steps run one
lane after the other. One thread runs all lanes of a launch: when a lane ends, another takes its
place. Lanes do not wait for one another, since each has its own clock and sample.

Only float64 gives vector code: the compiler passes small structs of float32 in pairs. A step about
a hinge is faster in float32 too, since it has a single case.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ONLY, Quaternion, Vector
from warprock.kernels.event_space.block.contact import FLYING
from warprock.kernels.event_space.block.moves import rotate_unnormalised
from warprock.kernels.event_space.block.pack import Hinge, Rolled, frame, hinge_of, roll
from warprock.kernels.event_space.block.pack_lanes import Before, Place, keep_state, state_before
from warprock.kernels.event_space.block.seen import (
    Seen,
    attitude_at,
    block_result,
    lane_result,
    observe,
    observe_start,
    peaks_at,
    place_at,
    start,
    turning_time,
)
from warprock.kernels.event_space.block.step import TOGETHER, step
from warprock.kernels.event_space.block.trial import Base, State, next_step
from warprock.kernels.event_space.lane import (
    BaseMotion,
    Knobs,
    Lane,
    Limits,
    base_motion,
    read_samples,
)
from warprock.kernels.lane.modes import RUNNING, STALLED
from warprock.kernels.launch.instance import LOOPS_STAY, ONE_VECTOR
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion
from warprock.kernels.shape_space.block import Block, slide_of
from warprock.kernels.shape_space.block_found import BlockResult, Found
from warprock.kernels.shape_space.frame import turn_of_matrix

wp.set_module_options(ONE_VECTOR | LOOPS_STAY)

PLACES = LANES
LANES = 1
"""A launch has one thread a lane, and the first thread runs all lanes, so no pack is padded."""
GONE = -1
"""Mode of a place without a lane."""


@wp.func(inline=True)
def observe_hinge_step(block: Block, before: BlockResult, s: State, n: Rolled, d: real, time: real):
    """The observed response after a step about a hinge, see `observe`.

    Returns:
        The response; whether it is complete: it is not if two rotations turn back in one step.
    """
    zero = real(0.0)
    r0 = frame(s.q)
    r = frame(n.q)
    axis0 = Vector(r0[0, 2], r0[1, 2], r0[2, 2])
    axis = Vector(r[0, 2], r[1, 2], r[2, 2])
    rate0 = wp.cross(s.w, axis0)
    rate = wp.cross(n.swing, axis)
    first = turning_time(axis0, rate0, axis, rate, 0, d)
    other = turning_time(axis0, rate0, axis, rate, 1, d)
    tau = first + other
    part = tau / larger(d, TINY)
    q = rotate_unnormalised(s.q, tau * s.w + part * part * (n.turn - d * s.w))
    leaf = peaks_at(block, before, n.q, time)
    back = peaks_at(block, leaf, q, s.time + tau)
    turns = tau > zero
    leaf.peak_time = wp.where(turns, back.peak_time, leaf.peak_time)
    leaf.peak = wp.where(turns, back.peak, leaf.peak)
    leaf.peak_across = wp.where(turns, back.peak_across, leaf.peak_across)
    leaf.peak_tilt = wp.where(turns, back.peak_tilt, leaf.peak_tilt)
    leaf.peak_yaw = wp.where(turns, back.peak_yaw, leaf.peak_yaw)
    x, y = slide_of(block, n.x[0], n.x[1], turn_of_matrix(r))
    leaf.slide_x = x
    leaf.slide_y = y
    leaf.peak_slide = larger(x * x + y * y, before.peak_slide)
    return leaf, not (first > zero and other > zero)


@wp.func(inline=True)
def runs_quietly(s: State, b: Base, n: Rolled):
    """Whether a step of a lane has no event; whether a corner lands inside it."""
    total = n.x[0] + n.x[1] + n.x[2] + n.v[0] + n.v[1] + n.v[2] + b.time
    runs = s.mode == RUNNING and s.slip == 0 and s.stance < FLYING and total - total == real(0.0)
    lasts = b.d > TINY and wp.dot(b.kick, b.kick) == real(0.0)
    return runs and lasts and n.clear, runs and n.met


@wp.func(inline=False)
def full_step(block: Block, limits: Limits, motion: BaseMotion, end: real, s: State, seen: Seen):
    """One trial step of one lane by event_space/block/step.py, with any events."""
    n = step(block, limits, motion, end, s)
    after = seen
    if n.taken:
        after = observe(block, seen, s, n)
    return n, after, hinge_of(block, n.stance)


@wp.func(inline=False)
def start_lane(block: Block):
    """State and observed response of a lane at its start."""
    s = start(block, TOGETHER * block.half_height)
    return s, observe_start(block, s), hinge_of(block, s.stance)


@wp.func(inline=False)
def attitude_within(block: Block, until: real, s0: State, s: State) -> Quaternion:
    """Attitude at a time inside the last step, see `attitude_at`."""
    return attitude_at(block, until, s0, s)


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), lanes: wp.array(dtype=Lane),
    knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs all lanes of a launch in its first thread, PLACES of them side by side."""
    thread, _one = wp.tid()
    if thread > 0:
        return
    state = rows(State, lanes=PLACES)
    before = rows(Before, lanes=PLACES)
    hinge = rows(Hinge, lanes=PLACES)
    box = rows(Block, lanes=PLACES)
    leaf = rows(BlockResult, lanes=PLACES)
    place = rows(Place, lanes=PLACES)
    waiting, count = int(0), blocks.shape[1]
    samples = found.attitudes.shape[0]
    end = sample_times[sample_times.shape[0] - 1]
    for i in range(PLACES):
        state[i].mode = GONE
    busy = int(1)
    while busy > 0:
        busy = int(0)
        for i in range(PLACES):
            if place[i].due:
                lane = place[i].lane
                if place[i].busy:
                    shaking = read_samples(base_motion(motions, lane), state[i].knots, pool)
                    limits = Limits(knobs.gravity, place[i].longest_step, place[i].rest_gap)
                    known = Seen(leaf[i], place[i].uplift_time, place[i].rest_time)
                    old = state[i]
                    new, shown, turns = full_step(blocks[0, lane], limits, shaking, end, old, known)
                    before[i] = wp.where(new.taken, keep_state(old), before[i])
                    state[i] = new
                    hinge[i] = turns
                    leaf[i] = shown.leaf
                    place[i].uplift_time = shown.uplift_time
                    place[i].rest_time = shown.rest_time
                if place[i].steps >= place[i].step_limit and state[i].mode == RUNNING:
                    state[i].mode = STALLED
                s, s0 = state[i], state_before(before[i])
                ended = s.mode != RUNNING or s.time >= end
                sample = int(place[i].sample)
                while sample < samples and (ended or s.time >= sample_times[sample]):
                    q = attitude_within(blocks[0, lane], sample_times[sample], s0, s)
                    for part in range(4):
                        found.attitudes[sample, ONLY, part, lane] = q[part]
                    if found.places.shape[0] > 0:
                        x = place_at(sample_times[sample], s0, s)
                        for part in range(3):
                            found.places[sample, ONLY, part, lane] = x[part]
                    sample += 1
                place[i].sample = sample
                if ended:
                    seen = Seen(leaf[i], place[i].uplift_time, place[i].rest_time)
                    found.results[lane] = lane_result(blocks[0, lane], place[i].steps, s, seen)
                    found.blocks[0, lane] = block_result(s, seen)
                    state[i].mode = GONE
            if state[i].mode == GONE and waiting < count:
                first, seen_first, hangs = start_lane(blocks[0, waiting])
                state[i] = first
                before[i] = keep_state(first)
                hinge[i] = hangs
                box[i] = blocks[0, waiting]
                leaf[i] = seen_first.leaf
                place[i] = Place(
                    waiting, 0, 0, lanes[waiting].step_limit, lanes[waiting].longest_step,
                    lanes[waiting].rest_gap, end, seen_first.uplift_time, seen_first.rest_time,
                    False, False,
                )  # fmt: skip
                waiting += 1
            place[i].until = end
            if place[i].sample < samples:
                place[i].until = sample_times[place[i].sample]
            busy = busy + wp.where(state[i].mode == RUNNING, 1, 0)
        for i in range(PLACES):
            at = place[i].lane
            motion = read_samples(base_motion(motions, at), state[i].knots, pool)
            own, now = box[i], state[i]
            bounds = Limits(knobs.gravity, place[i].longest_step, place[i].rest_gap)
            b = next_step(bounds, motion, end, now)
            n = roll(own, bounds, b, hinge[i], now)
            told, complete = observe_hinge_step(own, leaf[i], now, n, b.d, b.time)
            quiet, cut = runs_quietly(now, b, n)
            ok = quiet and complete
            taken = place[i].steps + wp.where(now.mode == RUNNING, 1, 0)
            place[i].steps = taken
            late = ok and b.time >= place[i].until
            stays = not ok and not cut
            due = late or stays or taken >= place[i].step_limit
            place[i].busy = stays
            place[i].due = due and now.mode == RUNNING
            leaf[i] = wp.where(ok, told, leaf[i])
            before[i] = wp.where(ok, keep_state(now), before[i])
            # Fields that the step does not change are not stored, which saves 5 % of the time.
            state[i].x = wp.where(ok, n.x, now.x)
            state[i].q = wp.where(ok, n.q, now.q)
            state[i].v = wp.where(ok, n.v, now.v)
            state[i].w = wp.where(ok, n.w, now.w)
            state[i].turn = wp.where(ok, n.turn, now.turn)
            state[i].base = wp.where(ok, now.base + b.change, now.base)
            state[i].time = wp.where(ok, b.time, now.time)
            state[i].cap = wp.where(ok or cut, wp.where(ok, NEVER, n.cut), now.cap)
            state[i].deepest = wp.where(ok, larger(now.deepest, n.deep), now.deepest)
            state[i].knots[0] = wp.where(ok, b.knots[0], now.knots[0])
            state[i].knots[1] = wp.where(ok, b.knots[1], now.knots[1])
            state[i].knots[2] = wp.where(ok, b.knots[2], now.knots[2])
