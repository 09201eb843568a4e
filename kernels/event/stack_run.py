"""Runs of the event step over stacks, one lane a thread on any device; event/stack/step.py.

Every lane has its own clock and ends its steps at its events. A sample inside a step is read off
the polynomial that the step follows, so that histories do not change the run. If CHAINS is true
blocks are bodies, and roll from edge to edge (event/stack/edges.py).
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, UPWARDS
from warprock.kernels.event.stack.curves import turning_time, value_of
from warprock.kernels.event.stack.moves import start_pose
from warprock.kernels.event.stack.state import Limits, Rebound, Shaking, State, Trial, at_rest
from warprock.kernels.event.stack.step import finish_step
from warprock.kernels.event.stack.trial import try_step
from warprock.kernels.lane.modes import OVERTURNED, RUNNING, STALLED
from warprock.kernels.launch.instance import short_loops_go
from warprock.kernels.motion.kinds import ground_at
from warprock.kernels.shape.above import Motions, above_at
from warprock.kernels.shape.stack import (
    CLOSED,
    Blocks,
    Pose,
    Values,
    face_above,
    face_below,
    face_middles,
    flat_rotation,
    lower_face,
    slide_place,
    turn_across,
)
from warprock.kernels.shape.stack_body import Foot
from warprock.kernels.shape.stack_found import BlockResult

if CHAINS:
    from warprock.kernels.event.stack.edges import roll_on, stand_on

wp.set_module_options(short_loops_go(BLOCKS))

LANES = 1
"""Lanes that a thread runs."""


@wp.struct
class Knobs:
    """What the lanes have in common: gravity [m/s^2]."""

    gravity: real


@wp.struct
class Block:
    """One block, and how it starts.

    Attributes:
        inverse_mass, inverse_inertia: [1/kg], [1/(kg m^2)].
        friction: Coefficient of friction at the interface below it.
        rest_rotation: Swing below which it rests [rad].
        aside: How far its centre is to +x of the one below if both are upright [m].
        theta: Rotation at the start [rad].
        half_height, half_width: Half sizes of a box [m].
        top_low, top_high, top: Ends of the top of a body and its height, from the centre [m].
        edge: Row of the corners at which the edge begins that a body stands on at first, see
            shape/stack_body.py.
    """

    inverse_mass: real
    inverse_inertia: real
    friction: real
    rest_rotation: real
    aside: real
    theta: real
    if CHAINS:
        top_low: real
        top_high: real
        top: real
        edge: int
    else:
        half_height: real
        half_width: real


@wp.struct
class Stack:
    """One lane.

    Attributes:
        mass: Of all blocks [kg].
        fall: How far a centre sinks until the stack has overturned [m]; NEVER where blocks turn.
        longest_step: [s].
        rebound, slow: See `Rebound`.
        step_limit: Largest number of steps.
    """

    mass: real
    fall: real
    longest_step: real
    if BOUNCES:
        rebound: real
        slow: real
    step_limit: int


@wp.struct
class Result:
    """What one lane's run leaves behind."""

    uplift_time: real
    rest_time: real
    still: real
    ended: real
    loss: real
    deepest: real
    impacts: int
    mode: int
    steps: int


@wp.struct
class DrumResult:
    """What columns of an assembly tell of a block besides.

    Attributes:
        moved, last: Largest displacement of its centre, and that at the end [m].
        opening: Widest gap below it, at an end of what the two faces share [m].
    """

    moved: real
    last: real
    opening: real


@wp.struct
class Found:
    """Where the answers go."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    drums: wp.array2d(dtype=DrumResult)
    rotations: wp.array3d(dtype=real)
    places: wp.array4d(dtype=real)


@wp.struct
class Seen:
    """What has been observed of one lane so far.

    Attributes:
        peak, peak_time: Largest rotations [rad], and when they were reached [s].
        slide, peak_slide: Slides at the interfaces, and the largest of them [m].
        start_x, start_z: Where the centres were at the start [m].
        moved, last: Squares of the largest displacements of the centres, and of those now [m^2].
        opening: Widest gaps [m].
        uplift_time, rest_time: When an interface first opened, and when the stack last came to
            rest [s]; NEVER if it has not.
        still: When it was last at rest [s].
        sunk: The most that a centre has sunk [m].
    """

    peak: Values
    peak_time: Values
    slide: Values
    peak_slide: Values
    start_x: Values
    start_z: Values
    moved: Values
    last: Values
    opening: Values
    uplift_time: real
    rest_time: real
    still: real
    sunk: real


@wp.func
def centres(blocks: wp.ref[Blocks], pose: wp.ref[Pose]):
    """Centres x and z of all blocks [m]."""
    x, z = Values(), Values()
    at, up = real(0.0), real(0.0)
    for k in range(BLOCKS):
        s, c = face_below(pose, k)
        su, cu = face_above(pose, k)
        _low, low_height = lower_face(blocks, k)
        reach = low_height + pose.above[k]
        if CHAINS:
            upper, lower = face_middles(blocks, k)
            along = pose.along[k] + lower
            at = at + along * c + reach * s + blocks.half_height[k] * su - upper * cu
            up = up + reach * c - along * s + blocks.half_height[k] * cu + upper * su
        else:
            at = at + pose.along[k] * c + reach * s + blocks.half_height[k] * su
            up = up + reach * c - pose.along[k] * s + blocks.half_height[k] * cu
        x[k] = at
        z[k] = up
    return x, z


@wp.func
def widest_gap(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int) -> real:
    """The wider gap at the two ends of what the faces of interface k share [m]."""
    turn, _level = turn_across(pose, k)
    half, _height = lower_face(blocks, k)
    # `above` is that of the middle of the face.
    return fused(smaller(half, blocks.half_width[k]), size(turn), pose.above[k])


@wp.func
def observe_start(blocks: wp.ref[Blocks], pose: wp.ref[Pose]) -> Seen:
    """What is observed at the start."""
    seen = Seen()
    flat = bool(True)
    x, z = centres(blocks, pose)
    seen.start_x = x
    seen.start_z = z
    for k in range(BLOCKS):
        seen.peak[k] = size(pose.theta[k])
        flat = flat and pose.touch[k] == CLOSED
    seen.uplift_time = wp.where(flat, NEVER, real(0.0))
    seen.rest_time = wp.where(flat, real(0.0), NEVER)
    return seen


@wp.func
def observe(
    blocks: wp.ref[Blocks], offset: wp.ref[Values], s0: wp.ref[State], s: wp.ref[State],
    seen: wp.ref[Seen],
):  # fmt: skip
    """Adds what a step from one state to the next shows to what has been observed."""
    d = s.time - s0.time
    x, z = centres(blocks, s.pose)
    for k in range(BLOCKS):
        dx, dz = x[k] - seen.start_x[k], z[k] - seen.start_z[k]
        seen.last[k] = dx * dx + dz * dz
        seen.moved[k] = larger(seen.last[k], seen.moved[k])
        seen.sunk = larger(-dz, seen.sunk)
        seen.opening[k] = larger(widest_gap(blocks, s.pose, k), seen.opening[k])
        omega = s.curve[k, 1]
        omega1 = s.swing[k]
        highest = size(s.pose.theta[k])
        at = s.time
        if omega * omega1 < real(0.0):
            rise = turning_time(s.curve[k], omega, omega1, d)
            apex = size(value_of(s.curve[k], rise))
            if apex >= highest:
                highest = apex
                at = s0.time + rise
        if highest > seen.peak[k]:
            seen.peak[k] = highest
            seen.peak_time[k] = at
        touch = s.pose.touch[k]
        if CHAINS or not s.stuck:
            seen.slide[k] = slide_place(blocks, s.pose, k) - offset[k]
            if CHAINS:
                seen.slide[k] = seen.slide[k] - blocks.rolled[k]
            seen.peak_slide[k] = larger(size(seen.slide[k]), seen.peak_slide[k])
        # A velocity step of the base lifts at the end of a step, an acceleration from its start.
        if s0.pose.touch[k] == CLOSED and touch != CLOSED and seen.uplift_time >= NEVER:
            at_end = s.pose.theta[k] == flat_rotation(blocks, s.pose, k)
            if VERTICAL:
                at_end = at_end and s.pose.above[k] == real(0.0)
            seen.uplift_time = wp.where(at_end, s.time, s0.time)
    rested = at_rest(s0.pose.touch, s0.slip)
    rests = at_rest(s.pose.touch, s.slip)
    if rests or rested:
        seen.still = wp.where(rests, s.time, s0.time)
    if not rests:
        seen.rest_time = NEVER
    elif not rested:
        seen.rest_time = s.time


@wp.func
def rotation_at(until: real, s0: wp.ref[State], s: wp.ref[State], k: int) -> real:
    """Rotation of a block inside the last step [rad], or at its end."""
    theta = s.pose.theta[k]
    if until < s.time:
        theta = value_of(s.curve[k], until - s0.time)
    return theta


@wp.func
def between_steps(
    until: real, s0: wp.ref[State], s: wp.ref[State], first: real, rate: real, last: real
) -> real:
    """A coordinate inside the last step, from its first to its last value."""
    value = last
    if until < s.time:
        d = s.time - s0.time
        tau = until - s0.time
        part = tau / d
        value = first + rate * tau + part * part * (last - (first + rate * d))
    return value


@wp.func
def load_block(blocks: wp.ref[Blocks], b: Block, k: int):
    """Sets what does not change of block k."""
    blocks.mass[k] = real(1.0) / b.inverse_mass
    blocks.inertia[k] = real(1.0) / b.inverse_inertia
    blocks.inverse_mass[k] = b.inverse_mass
    blocks.inverse_inertia[k] = b.inverse_inertia
    blocks.friction[k] = b.friction
    if CHAINS:
        blocks.top_half[k] = HALF * (b.top_high - b.top_low)
        blocks.top_middle[k] = HALF * (b.top_high + b.top_low)
        blocks.top_height[k] = b.top
    else:
        blocks.half_height[k] = b.half_height
        blocks.half_width[k] = b.half_width


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), feet: wp.array2d(dtype=Foot),
    motions: Motions, pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real),
    knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread; `feet` are the corners of all bodies, block by block."""
    lane = wp.tid()
    shaking = Shaking()
    if VERTICAL:
        shaking.motion = motions[ALONG, lane]
        up = motions[UPWARDS, lane]
    else:
        shaking.motion = motions[lane]
    pile, limits, s, offset = Blocks(), Limits(), State(), Values()
    limits.gravity = knobs.gravity
    limits.mass = lanes[lane].mass
    limits.longest_step = lanes[lane].longest_step
    if BOUNCES:
        limits.rebound = Rebound(lanes[lane].rebound, lanes[lane].slow)
    step_limit = lanes[lane].step_limit
    for k in range(BLOCKS):
        b = blocks[k, lane]
        load_block(pile, b, k)
        limits.rest_rotation[k] = b.rest_rotation
        offset[k] = b.aside
        s.pose.along[k] = b.aside
        s.pose.theta[k] = b.theta
        if CHAINS:
            e = b.edge
            stand_on(pile, k, e, feet[e - 1, lane], feet[e, lane], feet[e + 1, lane],
                feet[e + 2, lane])  # fmt: skip
            _upper, lower = face_middles(pile, k)
            offset[k] = b.aside - lower
            s.pose.along[k] = offset[k] + pile.rolled[k]
    s.pose = start_pose(pile, s.pose)
    s.cap = NEVER
    s0 = s
    pile0 = pile
    seen = observe_start(pile, s.pose)
    steps = int(0)
    end = sample_times[sample_times.shape[0] - 1]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while s.mode == RUNNING and s.time < until:
            steps += 1
            ground = ground_at(shaking.motion, s.segment, pool)
            shaking.value = ground.value
            shaking.slope = ground.slope
            if VERTICAL:
                shaking.above = above_at(up, s.risen, pool)
            t = Trial()
            try_step(pile, limits, shaking, end, s, t)
            before = s
            if CHAINS:
                after = pile
                for k in range(BLOCKS):
                    if t.way[k] != 0:
                        e = pile.edge[k] + t.way[k]
                        stand_on(after, k, e, feet[e - 1, lane], feet[e, lane], feet[e + 1, lane],
                            feet[e + 2, lane])  # fmt: skip
                roll_on(pile, after, t)
                finish_step(after, limits, before, t, s)
                if s.taken:
                    observe(after, offset, before, s, seen)
                    pile0 = pile
                    pile = after
            else:
                finish_step(pile, limits, before, t, s)
                if s.taken:
                    observe(pile, offset, before, s, seen)
            if s.taken:
                # Field by field: Warp copies a struct that is set under a condition each time.
                s0.pose = before.pose
                s0.velocity = before.velocity
                s0.time = before.time
            if seen.sunk > lanes[lane].fall and s.mode == RUNNING:
                s.mode = OVERTURNED
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
                found.places[sample, k, ALONG, lane] = between_steps(until, s0, s, x0[k], vx, x1[k])
                found.places[sample, k, UPWARDS, lane] = between_steps(
                    until, s0, s, z0[k], vz, z1[k]
                )
    found.results[lane] = Result(
        seen.uplift_time,
        seen.rest_time,
        seen.still,
        s.time,
        s.lost,
        s.deepest,
        s.impacts,
        s.mode,
        steps,
    )
    for k in range(BLOCKS):
        found.blocks[k, lane] = BlockResult(
            seen.slide[k], seen.peak[k], seen.peak_time[k], seen.peak_slide[k]
        )
        moved, last = wp.sqrt(seen.moved[k]), wp.sqrt(seen.last[k])
        found.drums[k, lane] = DrumResult(moved, last, seen.opening[k])
