"""Runs of the event step over stacks of blocks in space, one lane a thread on any device.

Every lane has its own clock. A sample inside a step is read off the parabola that the step follows,
so that histories do not change the run. Peaks are taken at the ends of steps. A stack ends when two
faces no longer overlap, or a block leans by a right angle to the vertical or to the block below.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Quaternion, Vector
from warprock.kernels.event_space.block.moves import rotate_attitude, rotate_freely
from warprock.kernels.event_space.lane import Knobs, Lane, Limits, base_motion, read_samples
from warprock.kernels.event_space.stack.contact import BOX, Ints, Own, Rebound, block_of, pose_of
from warprock.kernels.event_space.stack.look import State, look_at_step, momenta
from warprock.kernels.event_space.stack.step import step
from warprock.kernels.event_space.stack.whole import Whole, whole_of
from warprock.kernels.lane.modes import RUNNING, STALLED
from warprock.kernels.motion.kinds import Motion
from warprock.kernels.shape.interface import GROUND
from warprock.kernels.shape_space.block import Block, slide_of, turns_of
from warprock.kernels.shape_space.block_found import BlockResult, Found, Result
from warprock.kernels.shape_space.frame import frame, turn_of_matrix

# Loops over the six rows of a block are unrolled: pairs take .9 and three blocks .8 of the time.
wp.set_module_options({"max_unroll": 6})

LANES = 1
"""Lanes of a thread: which contacts act differs from lane to lane."""


@wp.func
def start(own: Own, limits: Limits) -> State:
    """The state at the start."""
    s = State()
    bodies = int(BLOCKS + 1)
    s.q[GROUND] = Quaternion(real(0.0), real(0.0), real(0.0), real(1.0))
    for k in range(1, bodies):
        b = block_of(own, k)
        s.x[k] = Vector(b.x, b.y, b.z)
        s.q[k] = Quaternion(b.qx, b.qy, b.qz, b.qw)
    pose = pose_of(own, s.x, s.q)
    look = look_at_step(own, limits, s, s, pose, pose, Ints(), real(0.0))
    for k in range(1, bodies):
        above = wp.where(k < BLOCKS, look.touch[wp.min(k + 1, BLOCKS)], 0)
        s.flies[k] = wp.where(look.touch[k] == 0 and above == 0, 1, 0)
    s.there = look.there
    s.touch = look.touch
    s.closed = look.closed
    s.cap = NEVER
    s.mode = RUNNING
    s.taken = True
    return s


@wp.func
def attitude_at(own: Own, k: int, until: real, s0: State, s: State) -> Quaternion:
    """Attitude of a block at a time inside the last step, from one state to the next."""
    d = s.time - s0.time
    q = s.q[k]
    if until < s.time and d > real(0.0) and not s.still:
        tau = until - s0.time
        part = tau / d
        if s0.flies[k] != 0:
            spin = momenta(own, s0)
            q = rotate_freely(block_of(own, k), s0.q[k], spin[k], tau)
        else:
            bend = s.turn[k] - d * s0.w[k]
            q = rotate_attitude(s0.q[k], tau * s0.w[k] + (part * part) * bend)
    return q


@wp.func
def place_at(k: int, until: real, s0: State, s: State) -> Vector:
    """Centre of mass of a block at a time inside the last step [m], from one state to the next."""
    d = s.time - s0.time
    x = s.x[k]
    if until < s.time and d > real(0.0) and not s.still:
        tau = until - s0.time
        part = tau / d
        x = s0.x[k] + tau * s0.v[k] + (part * part) * (s.x[k] - s0.x[k] - d * s0.v[k])
    return x


@wp.func
def observe(own: Own, s: State, found: Found):
    """Adds a state to what is seen of the blocks of a lane."""
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        block = block_of(own, k)
        r, down = frame(s.q[k]), wp.transpose(frame(s.q[k - 1]))
        m, c = down * r, down * (s.x[k] - s.x[k - 1])
        plane, across, tilt, yaw = turns_of(block, r[0, 2], r[1, 2], r[2, 2], s.q[k, 2], s.q[k, 3])
        n = found.blocks[k - 1, own.lane]
        n.qz = s.q[k, 2]
        n.qw = s.q[k, 3]
        if (s.touch[k] != 0) or s.time == real(0.0):
            x, y = slide_of(block, c[0], c[1], turn_of_matrix(m))
            n.slide_x = x
            n.slide_y = y
            n.peak_slide = larger(x * x + y * y, n.peak_slide)
        n.peak_time = wp.where(plane > n.peak, s.time, n.peak_time)
        n.peak = larger(plane, n.peak)
        n.peak_across = larger(across, n.peak_across)
        n.peak_tilt = larger(tilt, n.peak_tilt)
        n.peak_yaw = larger(yaw, n.peak_yaw)
        found.blocks[k - 1, own.lane] = n


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), lanes: wp.array(dtype=Lane),
    knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread."""
    lane = wp.tid()
    motion = base_motion(motions, lane)
    limits = Limits(knobs.gravity, lanes[lane].longest_step, lanes[lane].rest_gap)
    bodies = int(BLOCKS + 1)
    own = Own()
    own.blocks = blocks
    own.lane = lane
    if BOUNCES:
        own.rebound = Rebound(lanes[lane].rebound, lanes[lane].slow)
    s = start(own, limits)
    s0 = s
    on = Whole()
    for k in range(BLOCKS):
        found.blocks[k, lane] = BlockResult()
    observe(own, s, found)
    uplift_time = wp.where(s.closed, NEVER, real(0.0))
    rest_time = wp.where(s.closed, real(0.0), NEVER)
    steps = int(0)
    end = sample_times[sample_times.shape[0] - 1]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while s.mode == RUNNING and s.time < until:
            steps += 1
            motion = read_samples(motion, s.knots, pool)
            if not (BOX or on.holds):
                on = whole_of(own, limits, s)
            n = step(own, limits, motion, end, on, s)
            on.holds = on.holds and n.whole
            # A stack that stands still has nothing new to observe.
            if n.taken and not (s.still and n.still):
                observe(own, n, found)
                if not n.closed:
                    uplift_time = smaller(uplift_time, s.time)
                rested = wp.where(rest_time < NEVER, rest_time, s.time)
                rest_time = wp.where(n.still, rested, NEVER)
                s0 = s
            s = n
            if steps >= lanes[lane].step_limit and s.mode == RUNNING:
                s.mode = STALLED
        if found.attitudes.shape[0] > 0:
            for k in range(1, bodies):
                q = attitude_at(own, k, until, s0, s)
                for part in range(4):
                    found.attitudes[sample, k - 1, part, lane] = q[part]
        if found.places.shape[0] > 0:
            for k in range(1, bodies):
                x = place_at(k, until, s0, s)
                for part in range(3):
                    found.places[sample, k - 1, part, lane] = x[part]
    found.results[lane] = Result(
        uplift_time, rest_time, s.lost, s.deepest, s.impacts, s.mode, steps
    )
