"""Runs of the event step over blocks in space, LANES lanes side by side on the CPU.

Steps in which nothing happens are taken as vector code, see event_space/block_pack.py, all others
one lane after the other. One thread runs all lanes of a launch: where one has come to its end,
another takes its place. Lanes do not wait for one another, for every one has its own clock and
sample.

Of float64, that is: small structs of float32 the compiler hands on in pairs, and makes no vector
code of them. A step about a hinge, which has no cases to choose from, is quicker all the same.
"""

import warp as wp

from warprock.kernels.event_space.block import TOGETHER, step
from warprock.kernels.event_space.block_contact import FLYING
from warprock.kernels.event_space.block_moves import swung_by
from warprock.kernels.event_space.block_pack import Rolled, frame, hinge_of, rolled
from warprock.kernels.event_space.block_pack_lanes import (
    BASE,
    BUSY,
    CAP,
    DEEPEST,
    DUE,
    KNOTS,
    LANE,
    LONGEST,
    MODE,
    REST_GAP,
    SAMPLE,
    STEP_LIMIT,
    STEPS,
    TIME,
    TURN,
    UNTIL,
    Marks,
    Numbers,
    Q,
    V,
    W,
    X,
    at,
    before_of,
    block_at,
    hinge_at,
    keep,
    keep_before,
    keep_block,
    keep_hinge,
    keep_leaf,
    keep_seen,
    mark,
    put,
    put_four,
    put_mark,
    put_three,
    seen_of,
    state_of,
)
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
    turning,
)
from warprock.kernels.event_space.block_trial import State, next_step
from warprock.kernels.event_space.lane import BaseMotion, Knobs, Lane, Limits
from warprock.kernels.instance import LOOPS_STAY, ONE_VECTOR
from warprock.kernels.modes import RUNNING, STALLED
from warprock.kernels.motion import Motion, sample_index
from warprock.kernels.shape_space.block import Block, slide_of
from warprock.kernels.shape_space.block_found import BlockResult, Found
from warprock.kernels.shape_space.frame import turn_of_matrix
from warprock.kernels.vectors import Quaternion, Vector

wp.set_module_options(ONE_VECTOR | LOOPS_STAY)

PLACES = LANES
LANES = 1
"""A launch has a thread a lane, of which the first runs all: so none is run to fill a pack."""
GONE = -1
"""Mode of a place without a lane."""


@wp.func(inline=True)
def observe_hinge_step(block: Block, before: BlockResult, s: State, n: Rolled, d: real, time: real):
    """What a step about a hinge adds to what has been seen, see `observe`.

    Returns:
        That, and whether it is all: not if two rotations turn back in one step.
    """
    zero = real(0.0)
    r0 = frame(s.q)
    r = frame(n.q)
    axis0 = Vector(r0[0, 2], r0[1, 2], r0[2, 2])
    axis = Vector(r[0, 2], r[1, 2], r[2, 2])
    rate0 = wp.cross(s.w, axis0)
    rate = wp.cross(n.swing, axis)
    first = turning(axis0, rate0, axis, rate, 0, d)
    other = turning(axis0, rate0, axis, rate, 1, d)
    tau = first + other
    part = tau / larger(d, TINY)
    q = swung_by(s.q, tau * s.w + part * part * (n.turn - d * s.w))
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
def quiet_step(
    gravity: real, motion: BaseMotion, end: real, m: wp.ref[Numbers], k: wp.ref[Marks], i: int
):
    """One trial step of one lane, if nothing happens in it, or a corner lands inside.

    Else it changes nothing, and marks the lane as busy.
    """
    block = block_at(m, i)
    limits = Limits(gravity, at(m[LONGEST, i]), at(m[REST_GAP, i]))
    s = state_of(m, k, i)
    seen = seen_of(m, i)
    b = next_step(limits, motion, end, s)
    n = rolled(block, limits, b, hinge_at(m, i), s)
    leaf, whole = observe_hinge_step(block, seen.leaf, s, n, b.d, b.time)
    total = n.x[0] + n.x[1] + n.x[2] + n.v[0] + n.v[1] + n.v[2] + b.time
    runs = s.mode == RUNNING and s.slip == 0 and s.stance < FLYING and total - total == real(0.0)
    lasts = b.d > TINY and wp.dot(b.kick, b.kick) == real(0.0)
    ok = runs and lasts and n.clear and whole
    cut = runs and n.met
    count = mark(k[STEPS, i]) + wp.where(s.mode == RUNNING, 1, 0)
    k[STEPS, i] = count
    late = ok and b.time >= at(m[UNTIL, i])
    alone = not ok and not cut
    due = late or alone or count >= mark(k[STEP_LIMIT, i])
    k[BUSY, i] = wp.where(alone, 1, 0)
    k[DUE, i] = wp.where(due and s.mode == RUNNING, 1, 0)
    keep_leaf(leaf, ok, m, i)
    keep_before(s, ok, m, k, i)
    put_three(m, X, i, ok, n.x)
    put_four(m, Q, i, ok, n.q)
    put_three(m, V, i, ok, n.v)
    put_three(m, W, i, ok, n.w)
    put_three(m, TURN, i, ok, n.turn)
    put_three(m, BASE, i, ok, s.base + b.change)
    put(m, TIME, i, ok, b.time)
    put(m, CAP, i, ok or cut, wp.where(ok, NEVER, n.cut))
    put(m, DEEPEST, i, ok, larger(s.deepest, n.deep))
    put_mark(k, KNOTS, i, ok, b.knots[0])
    put_mark(k, KNOTS + 1, i, ok, b.knots[1])
    put_mark(k, KNOTS + 2, i, ok, b.knots[2])


@wp.func(inline=False)
def full_step(block: Block, limits: Limits, motion: BaseMotion, end: real, s: State, seen: Seen):
    """One trial step of one lane, whatever happens in it."""
    n = step(block, limits, motion, end, s)
    after = seen
    if n.taken:
        after = observe(block, seen, s, n)
    return n, after, hinge_of(block, n.stance)


@wp.func(inline=False)
def begun(block: Block):
    """A lane at its start, and what is seen of it then."""
    s = start(block, TOGETHER * block.half_height)
    return s, observe_start(block, s), hinge_of(block, s.stance)


@wp.func(inline=False)
def attitude_within(block: Block, until: real, s0: State, s: State) -> Quaternion:
    """Attitude at a time inside the last step, see `attitude_at`."""
    return attitude_at(block, until, s0, s)


@wp.func(inline=True)
def step_alone(
    block: Block, gravity: real, motion: BaseMotion, end: real, m: wp.ref[Numbers],
    k: wp.ref[Marks], i: int,
):  # fmt: skip
    """One trial step of one lane, whatever happens in it."""
    limits = Limits(gravity, at(m[LONGEST, i]), at(m[REST_GAP, i]))
    s = state_of(m, k, i)
    n, seen, h = full_step(block, limits, motion, end, s, seen_of(m, i))
    keep_before(s, n.taken, m, k, i)
    keep_seen(seen, m, i)
    keep_hinge(h, m, i)
    keep(n, m, k, i)


@wp.func(inline=True)
def start_lane(block: Block, limits: Lane, lane: int, m: wp.ref[Numbers], k: wp.ref[Marks], i: int):
    """Puts a lane in a place that has none."""
    s, seen, h = begun(block)
    keep(s, m, k, i)
    keep_before(s, True, m, k, i)
    keep_seen(seen, m, i)
    keep_hinge(h, m, i)
    keep_block(block, m, i)
    m[LONGEST, i] = limits.longest_step
    m[REST_GAP, i] = limits.rest_gap
    k[STEP_LIMIT, i] = limits.step_limit
    k[STEPS, i] = 0
    k[LANE, i] = lane
    k[SAMPLE, i] = 0


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), lanes: wp.array(dtype=Lane),
    knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs all lanes of a launch in its first thread, PLACES of them side by side."""
    thread, _one = wp.tid()
    if thread > 0:
        return
    m, k = Numbers(), Marks()
    waiting, count = int(0), blocks.shape[1]
    samples = found.attitudes.shape[0]
    end = sample_times[sample_times.shape[0] - 1]
    for i in range(PLACES):
        k[MODE, i] = GONE
    busy = int(1)
    while busy > 0:
        busy = int(0)
        for i in range(PLACES):
            if k[DUE, i] != 0:
                lane = k[LANE, i]
                if k[BUSY, i] != 0:
                    mx, my, mz = motions[0, lane], motions[1, lane], motions[2, lane]
                    px = sample_index(mx, k[KNOTS, i])
                    py = sample_index(my, k[KNOTS + 1, i])
                    pz = sample_index(mz, k[KNOTS + 2, i])
                    value = Vector(pool[0, px], pool[0, py], pool[0, pz])
                    slope = Vector(pool[1, px], pool[1, py], pool[1, pz])
                    motion = BaseMotion(mx, my, mz, value, slope)
                    step_alone(blocks[0, lane], knobs.gravity, motion, end, m, k, i)
                if k[STEPS, i] >= k[STEP_LIMIT, i] and k[MODE, i] == RUNNING:
                    k[MODE, i] = STALLED
                s, s0 = state_of(m, k, i), before_of(m, k, i)
                ended = s.mode != RUNNING or s.time >= end
                sample = int(k[SAMPLE, i])
                while sample < samples and (ended or s.time >= sample_times[sample]):
                    q = attitude_within(blocks[0, lane], sample_times[sample], s0, s)
                    for part in range(4):
                        found.attitudes[sample, 0, part, lane] = q[part]
                    if found.places.shape[0] > 0:
                        x = place_at(sample_times[sample], s0, s)
                        for part in range(3):
                            found.places[sample, 0, part, lane] = x[part]
                    sample += 1
                k[SAMPLE, i] = sample
                if ended:
                    seen = seen_of(m, i)
                    found.results[lane] = lane_result(blocks[0, lane], k[STEPS, i], s, seen)
                    found.blocks[0, lane] = block_result(s, seen)
                    k[MODE, i] = GONE
            if k[MODE, i] == GONE and waiting < count:
                start_lane(blocks[0, waiting], lanes[waiting], waiting, m, k, i)
                waiting += 1
            m[UNTIL, i] = end
            if k[SAMPLE, i] < samples:
                m[UNTIL, i] = sample_times[k[SAMPLE, i]]
            busy = busy + wp.where(k[MODE, i] == RUNNING, 1, 0)
        for i in range(PLACES):
            place = k[LANE, i]
            nx, ny, nz = motions[0, place], motions[1, place], motions[2, place]
            ix = sample_index(nx, k[KNOTS, i])
            iy = sample_index(ny, k[KNOTS + 1, i])
            iz = sample_index(nz, k[KNOTS + 2, i])
            first = Vector(pool[0, ix], pool[0, iy], pool[0, iz])
            other = Vector(pool[1, ix], pool[1, iy], pool[1, iz])
            quiet_step(knobs.gravity, BaseMotion(nx, ny, nz, first, other), end, m, k, i)
