"""Runs of the event step over bodies in space that stand on points, one lane a thread.

Every lane has its own clock and ends its steps at its events. A sample inside a step is read off
the parabola that the step follows, so that histories do not change the run.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ONLY, Quaternion, Vector, W, X, Y, Z
from warprock.kernels.event_space.block.moves import rotate_attitude, rotate_freely
from warprock.kernels.event_space.block.seen import Seen, turning_time
from warprock.kernels.event_space.body.contact import (
    Shape,
    bit_of,
    is_among,
    place_of,
    pose_of,
    shape_of,
)
from warprock.kernels.event_space.body.quiet import Support, support_of
from warprock.kernels.event_space.body.start import keep_running, observe_tumbling, start_thrown
from warprock.kernels.event_space.body.step import State, step
from warprock.kernels.event_space.lane import Knobs, Limits, base_motion, read_samples
from warprock.kernels.lane.modes import RUNNING, STALLED
from warprock.kernels.launch.instance import BRANCHES
from warprock.kernels.motion.kinds import Motion
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import BlockResult, Found, Result
from warprock.kernels.shape_space.body import (
    Frame,
    Point,
    block_attitude,
    body_attitude,
    turns_of_body,
)
from warprock.kernels.shape_space.frame import frame as matrix_at

FLAGS = f"{BRANCHES['cpu_compiler_flags']} -mprefer-vector-width=128"
"""Structs are copied by 16 bytes, which saves 4 % in float32; see SHORT_COPIES in instance.py."""
wp.set_module_options(BRANCHES | ({"cpu_compiler_flags": FLAGS} if PRECISION == "float32" else {}))

LANES = 1
"""Lanes of a thread: which points act differs from lane to lane."""


@wp.struct
class Lane:
    """One lane: see event_space/lane.py and `Shape`; its body and its start, see `Frame`."""

    longest_step: real
    rest_gap: real
    rebound: real
    expansion: real
    slow: real
    step_limit: int
    frame: Frame


@wp.func
def start(block: Block, frame: Frame, body: Shape, limits: Limits) -> State:
    """The state at the start; points within `rest_gap` of the base touch."""
    s = State()
    s.x = Vector(block.x, block.y, block.z)
    qx, qy, qz, qw = body_attitude(frame, block.qx, block.qy, block.qz, block.qw)
    s.q = Quaternion(qx, qy, qz, qw)
    pose = pose_of(body, s.x, s.q)
    count = body.count
    for k in range(count):
        if s.x[2] + wp.dot(pose.turn[2], place_of(body.points[k, body.lane])) <= limits.rest_gap:
            s.touch = s.touch | bit_of(k)
    s.flies = s.touch == wp.uint64(0)
    s.stands = (s.touch & body.feet) == body.feet
    s.cap = NEVER
    s.mode = RUNNING
    s.taken = True
    return s


@wp.func
def attitude_at(block: Block, body: Shape, until: real, s0: State, s: State) -> Quaternion:
    """Attitude at a time inside the last step, from one state to the next."""
    d = s.time - s0.time
    q = s.q
    if until < s.time and d > real(0.0) and not s.still:
        tau = until - s0.time
        if s0.flies:
            q = rotate_freely(block, s0.q, pose_of(body, s0.x, s0.q).inertia * s0.w, tau)
        else:
            part = tau / d
            q = rotate_attitude(s0.q, tau * s0.w + part * part * (s.turn - d * s0.w))
    return q


@wp.func
def place_at(until: real, s0: State, s: State) -> Vector:
    """Centre of mass at a time inside the last step [m], from one state to the next."""
    d = s.time - s0.time
    x = s.x
    if until < s.time and d > real(0.0) and not s.still:
        tau = until - s0.time
        part = tau / d
        x = s0.x + tau * s0.v + part * part * (s.x - s0.x - d * s0.v)
    return x


@wp.func
def peaks_at(block: Block, frame: Frame, before: BlockResult, q: Quaternion, time: real):
    """The largest turns so far, with those of an attitude."""
    leaf = before
    now = turns_of_body(block, frame, q[0], q[1], q[2], q[3])
    leaf.peak_time = wp.where(now.along > leaf.peak, time, leaf.peak_time)
    leaf.peak = larger(now.along, leaf.peak)
    leaf.peak_across = larger(now.across, leaf.peak_across)
    leaf.peak_tilt = larger(now.tilt, leaf.peak_tilt)
    leaf.peak_yaw = larger(now.yaw, leaf.peak_yaw)
    leaf.qz = now.qz
    leaf.qw = now.qw
    return leaf


@wp.func
def slide_of_body(body: Shape, s: State) -> Vector:
    """Mean displacement of the points that touch, from where each stood; the third is zero."""
    turn, count, total, way = matrix_at(s.q), body.count, real(0.0), Vector()
    for k in range(count):
        if is_among(k, s.touch):
            point = body.points[k, body.lane]
            r = turn * place_of(point)
            total += real(1.0)
            way += Vector(s.x[0] + r[0] - point.stood_x, s.x[1] + r[1] - point.stood_y, real(0.0))
    return way / total


@wp.func
def observe(
    block: Block, frame: Frame, body: Shape, before: Seen, s0: State, s: State,
) -> Seen:  # fmt: skip
    """The observed response after a step from one state to the next."""
    seen = before
    d = s.time - s0.time
    axis0, axis1 = matrix_at(s0.q) * body.axis, matrix_at(s.q) * body.axis
    for i in range(2):
        at = turning_time(axis0, wp.cross(s0.w, axis0), axis1, wp.cross(s.swing, axis1), i, d)
        if at > real(0.0):
            time = s0.time + at
            q = attitude_at(block, body, time, s0, s)
            seen.leaf = peaks_at(block, frame, seen.leaf, q, time)
    seen.leaf = peaks_at(block, frame, seen.leaf, s.q, s.time)
    # About a hinge it slides no further.
    if not (s.flies or s.quiet):
        way = slide_of_body(body, s)
        seen.leaf.slide_x = way[0]
        seen.leaf.slide_y = way[1]
        seen.leaf.peak_slide = larger(wp.length_sq(way), seen.leaf.peak_slide)
    if not s.stands:
        seen.uplift_time = smaller(seen.uplift_time, s0.time)
    rested = wp.where(seen.rest_time < NEVER, seen.rest_time, s0.time)
    seen.rest_time = wp.where(s.still, rested, NEVER)
    return seen


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Lane),
    points: wp.array2d(dtype=Point), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread."""
    lane = wp.tid()
    block, own = blocks[0, lane], lanes[lane]
    frame = own.frame
    motion = base_motion(motions, lane)
    limits = Limits(knobs.gravity, own.longest_step, own.rest_gap)
    body = shape_of(block, frame)
    body.rebound = own.rebound
    body.expansion = own.expansion
    body.slow = own.slow
    body.points = points
    body.lane = lane
    rows = points.shape[0]
    for k in range(rows):
        foot = points[k, lane].foot
        body.count = wp.where(foot >= real(0.0), k + 1, body.count)
        if foot > real(0.0):
            body.feet = body.feet | bit_of(k)
    s = start_thrown(body, limits, frame, start(block, frame, body, limits))
    s0 = s
    on = Support()
    seen = Seen()
    seen.leaf = peaks_at(block, frame, seen.leaf, s.q, real(0.0))
    seen.uplift_time = wp.where(s.stands, NEVER, real(0.0))
    seen.rest_time = wp.where(s.stands, real(0.0), NEVER)
    steps = int(0)
    end = sample_times[sample_times.shape[0] - 1]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while s.mode == RUNNING and s.time < until:
            steps += 1
            motion = read_samples(motion, s.knots, pool)
            if s.touch != on.touch:
                on = support_of(block, body, s.x[2], s.q, s.touch)
            after = step(block, body, limits, motion, end, on, s)
            n = keep_running(frame, after)
            # A body that stands still has nothing new to observe.
            if n.taken and not (s.still and n.still):
                before = seen.leaf
                seen = observe(block, frame, body, seen, s, n)
                seen.leaf = observe_tumbling(frame, block, before, seen.leaf, n)
                s0 = s
            s = n
            if steps >= own.step_limit and s.mode == RUNNING:
                s.mode = STALLED
        if found.attitudes.shape[0] > 0:
            q = attitude_at(block, body, until, s0, s)
            ex, ey, ez, ew = block_attitude(frame, q[0], q[1], q[2], q[3])
            found.attitudes[sample, ONLY, X, lane] = ex
            found.attitudes[sample, ONLY, Y, lane] = ey
            found.attitudes[sample, ONLY, Z, lane] = ez
            found.attitudes[sample, ONLY, W, lane] = ew
        if found.places.shape[0] > 0:
            x = place_at(until, s0, s)
            for part in range(3):
                found.places[sample, ONLY, part, lane] = x[part]
    found.results[lane] = Result(
        seen.uplift_time, seen.rest_time, block.mass * s.lost, s.deepest, s.impacts, s.mode, steps
    )
    found.blocks[0, lane] = seen.leaf
