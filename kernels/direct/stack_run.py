"""Runs of the direct step over stacks of blocks, one lane a thread on any device.

A run begins with a solve at the start, from velocities of zero, which gives the accelerations.
Velocities belong to half steps, so the first step starts from velocities half a step back: -dt/2
times the acceleration. An interface rocks while one of its ends has parted, see parting.py.
"""

import warp as wp

from warprock.kernels.account import book
from warprock.kernels.direct.block import wish
from warprock.kernels.direct.stack import (
    Pose,
    Shapes,
    interface_rows,
    solve,
    weighted,
    with_rows,
    with_three,
)
from warprock.kernels.direct.stack_pivot import Equations
from warprock.kernels.instance import LOOPS_STAY
from warprock.kernels.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF, UNSOLVED
from warprock.kernels.motion import Motion, base_velocity, sample_index, sample_segment
from warprock.kernels.parting import slack, slides, watch
from warprock.kernels.shape.interface_flat import GROUND_FACE, place_on
from warprock.kernels.shape.stack import Counts, Rows, Three, Triples, Values, matrix_of, three_of
from warprock.kernels.shape.stack_found import BlockResult, Found, Result, at_sample
from warprock.kernels.shape.stack_run_flat import Block, Stack, gap_of_end

wp.set_module_options(LOOPS_STAY)

LANES = 1
"""Lanes that a thread runs."""


@wp.struct
class Knobs:
    """What the lanes have in common; as in direct/block.py, CFM in 1/kg."""

    time_step: real
    rate: real
    gravity: real
    margin: real
    box: real
    cfm: real
    erp: real


@wp.struct
class State:
    """One lane: rotations and velocities of its blocks, relative to the base.

    Of its interfaces: the side to which they lean, and the last impulses at their ends at -x and
    at +x and along them towards +x [N s].
    """

    theta: Values
    velocity: Triples
    lean: Values
    left: Values
    right: Values
    along: Values


@wp.func
def leaning(state: State, k: int, hint: real) -> real:
    """Side to which interface k leans; `hint` tells which way the base is about to move [m/s]."""
    zero = real(0.0)
    turn = state.theta[k]
    rate = state.velocity[3 * k + 2]
    if k > 0:
        turn = turn - state.theta[k - 1]
        rate = rate - state.velocity[3 * k - 1]
    still = wp.where(hint != zero, -hint, state.lean[k])
    return sign_of(wp.where(turn != zero, turn, wp.where(rate != zero, rate, still)))


@wp.func
def equations(shapes: Shapes, pose: Pose, state: State, knobs: Knobs, free: Triples):
    """The contact problem of a step from the velocities without contact, and its rows.

    Returns:
        The problem; rows of the upper and of the lower blocks; the last impulses, in its order;
        the smallest gap [m].
    """
    zero = real(0.0)
    one = real(1.0)
    system = Equations()
    upper = Rows()
    lower = Rows()
    guess = Triples()
    lowest = zero
    for k in range(BLOCKS):
        lean = state.lean[k]
        up, down, gap1, gap2 = interface_rows(shapes, pose, k, lean)
        lowest = smaller(smaller(gap1, gap2), lowest)
        on1 = wp.where(gap1 <= knobs.margin, one, zero)
        on2 = wp.where(gap2 <= knobs.margin, one, zero)
        # Rows of an end that does not touch vanish.
        keep = wp.diag(Three(on1, on2, one))
        up = keep * up
        down = keep * down
        d = weighted(up, shapes, k) * wp.transpose(up)
        q = up * three_of(free, k)
        if k > 0:
            d = d + weighted(down, shapes, k - 1) * wp.transpose(down)
            q = q + down * three_of(free, k - 1)
            above = weighted(matrix_of(upper, k - 1), shapes, k - 1) * wp.transpose(down)
            system.above = with_rows(system.above, k - 1, above)
        m = shapes.inverse_mass[k]
        d = d + wp.diag(Three(knobs.cfm + m * (one - on1), knobs.cfm + m * (one - on2), zero))
        q = q + Three(
            on1 * wish(gap1, knobs.erp, knobs.rate),
            on2 * wish(gap2, knobs.erp, knobs.rate),
            zero,
        )
        mu = shapes.friction[k]
        last = knobs.box * larger(on1, on2) * (state.left[k] + state.right[k])
        system.own = with_rows(system.own, k, d)
        system.free = with_three(system.free, k, q)
        system.friction[k] = (one - knobs.box) * mu
        system.bound[k] = mu * last
        upper = with_rows(upper, k, up)
        lower = with_rows(lower, k, down)
        n1 = wp.where(lean > zero, state.left[k], state.right[k])
        n2 = wp.where(lean > zero, state.right[k], state.left[k])
        guess = with_three(guess, k, Three(on1 * n1, on2 * n2, lean * state.along[k]))
    return system, upper, lower, guess, lowest


@wp.func
def pushed(shapes: Shapes, upper: Rows, lower: Rows, free: Triples, p: Triples) -> Triples:
    """Velocities of all blocks after the impulses of all interfaces."""
    v = free
    for k in range(BLOCKS):
        kick = wp.transpose(weighted(matrix_of(upper, k), shapes, k)) * three_of(p, k)
        v = with_three(v, k, three_of(v, k) + kick)
        if k > 0:
            back = wp.transpose(weighted(matrix_of(lower, k), shapes, k - 1)) * three_of(p, k)
            v = with_three(v, k - 1, three_of(v, k - 1) + back)
    return v


@wp.func
def step(shapes: Shapes, pose: Pose, state: State, knobs: Knobs, dv: real, hint: real):
    """Velocities and impulses after a step in which the base velocity changes by dv [m/s].

    Returns:
        The state, its rotations as before; work of the contacts on it [J]; the smallest gap at the
        start, if below zero [m]; whether it was solved.
    """
    after = state
    free = state.velocity
    for k in range(BLOCKS):
        after.lean[k] = leaning(state, k, hint)
        free[3 * k] = free[3 * k] - dv
        free[3 * k + 1] = free[3 * k + 1] - knobs.time_step * knobs.gravity
    system, upper, lower, guess, lowest = equations(shapes, pose, after, knobs, free)
    p, solved, _tries = solve(system, guess)
    v = pushed(shapes, upper, lower, free, p)
    work = real(0.0)
    for k in range(BLOCKS):
        done = real(0.0)
        for i in range(3):
            weight = shapes.inverse_mass[k]
            if i == 2:
                weight = shapes.inverse_inertia[k]
            a = 3 * k + i
            done += (v[a] - free[a]) * (v[a] + state.velocity[a]) / weight
        work += HALF * done
        to_right = after.lean[k] > real(0.0)
        # What carries next to nothing may be below zero by round-off.
        n1, n2 = larger(p[3 * k], real(0.0)), larger(p[3 * k + 1], real(0.0))
        after.left[k] = wp.where(to_right, n1, n2)
        after.right[k] = wp.where(to_right, n2, n1)
        after.along[k] = after.lean[k] * p[3 * k + 2]
    after.velocity = v
    return after, work, lowest, solved


@wp.func
def posed(pose: Pose, state: State, dt: real):
    """Where the blocks are after a time at their velocities, and their rotations."""
    moved = pose
    theta = state.theta
    for k in range(BLOCKS):
        moved.x[k] = pose.x[k] + dt * state.velocity[3 * k]
        moved.z[k] = pose.z[k] + dt * state.velocity[3 * k + 1]
        theta[k] = theta[k] + dt * state.velocity[3 * k + 2]
        moved.sine[k] = sine(in_range(theta[k]))
        moved.cosine[k] = cosine(in_range(theta[k]))
    return moved, theta


@wp.func
def unrisen(shapes: Shapes, before: Pose, pose: Pose, state: State, knobs: Knobs) -> real:
    """Energy that velocities have and heights have not taken up [J], as at rest in float32.

    Without round-off this is nothing.
    """
    total = real(0.0)
    for k in range(BLOCKS):
        missing = (pose.z[k] - before.z[k]) - knobs.time_step * state.velocity[3 * k + 1]
        total += knobs.gravity * missing / shapes.inverse_mass[k]
    return total


@wp.func
def placed(shapes: Shapes, pose: Pose, theta: Values, k: int, offset: real):
    """Where a block is on what it stands on, whose slide was `offset` at the start [m].

    Returns:
        Slide along that, width of the overlap, rotation against it, and how wide the ends of the
        overlap at -x and at +x gape.
    """
    lhalf_width = GROUND_FACE
    lhalf_height = real(0.0)
    ls = real(0.0)
    lc = real(1.0)
    dx = pose.x[k]
    dz = pose.z[k]
    turn = theta[k]
    if k > 0:
        lhalf_width = shapes.half_width[k - 1]
        lhalf_height = shapes.half_height[k - 1]
        ls = pose.sine[k - 1]
        lc = pose.cosine[k - 1]
        dx = dx - pose.x[k - 1]
        dz = dz - pose.z[k - 1]
        turn = turn - theta[k - 1]
    slid, overlap = place_on(
        shapes.half_width[k], shapes.half_height[k], pose.sine[k], pose.cosine[k], offset,
        lhalf_width, lhalf_height, ls, lc, dx, dz, turn,
    )  # fmt: skip
    gap1 = gap_of_end(
        real(-1.0), shapes.half_width[k], shapes.half_height[k], pose.sine[k], pose.cosine[k],
        lhalf_width, lhalf_height, ls, lc, dx, dz,
    )  # fmt: skip
    gap2 = gap_of_end(
        real(1.0), shapes.half_width[k], shapes.half_height[k], pose.sine[k], pose.cosine[k],
        lhalf_width, lhalf_height, ls, lc, dx, dz,
    )  # fmt: skip
    return slid, overlap, turn, gap1, gap2


@wp.func
def limit_of(shapes: Shapes, pose: Pose, state: State, knobs: Knobs, k: int) -> real:
    """Gap beyond which an end of interface k has parted [m]."""
    square = state.velocity[3 * k + 2] * state.velocity[3 * k + 2]
    if k > 0:
        square += state.velocity[3 * k - 1] * state.velocity[3 * k - 1]
    reach = shapes.half_width[k] + shapes.half_height[k]
    length = shapes.half_height[k] + size(pose.z[k])
    return slack(knobs.time_step, knobs.gravity, reach, square, length)


@wp.func
def mode_of(state: State, solved: bool) -> int:
    """How a lane goes on after a step."""
    total = real(0.0)
    for i in range(3 * BLOCKS):
        total += state.velocity[i]
    return wp.where(total - total == real(0.0), wp.where(solved, RUNNING, UNSOLVED), BROKEN)


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread."""
    lane, zero, dt = wp.tid(), real(0.0), knobs.time_step
    m = motions[lane]
    shapes = Shapes()
    pose = Pose()
    state = State()
    peak, peak_time, slide, peak_slide = Values(), Values(), Values(), Values()
    since, left, right = Values(), Counts(), Counts()
    for k in range(BLOCKS):
        block = blocks[k, lane]
        shapes.half_width[k] = block.half_width
        shapes.half_height[k] = block.half_height
        shapes.inverse_mass[k] = block.inverse_mass
        shapes.inverse_inertia[k] = block.inverse_inertia
        shapes.friction[k] = block.friction
        pose.x[k] = block.x
        pose.z[k] = block.z
        pose.sine[k] = sine(block.theta)
        pose.cosine[k] = cosine(block.theta)
        state.theta[k] = block.theta
        state.lean[k] = sign_of(lanes[lane].lean)
        state.left[k] = block.left
        state.right[k] = block.right
        peak[k] = size(block.theta)
    uplift_time = lanes[lane].uplift_time
    moved, base, loss, deepest = real(0.0), real(0.0), real(0.0), real(0.0)
    given, supplied, taken, returned = real(0.0), real(0.0), real(0.0), real(0.0)
    jolt = real(0.0)
    impacts, count = int(0), int(-1)
    mode = int(RUNNING)
    time = -dt
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until and mode == RUNNING:
            count += 1
            time = real(count) * dt
            half = larger(time - HALF * dt, HALF * dt)
            place = sample_index(m, sample_segment(m, half))
            v = base_velocity(m, half, pool[2, place], pool[0, place], pool[1, place])
            old = state
            if count == 0:
                # The velocities half a step before the start.
                state, _work, _gap, solved = step(shapes, pose, old, knobs, zero, v)
                state.velocity = -HALF * state.velocity
                mode = mode_of(state, solved)
            else:
                state, work, gap, solved = step(shapes, pose, old, knobs, v - base, v - base)
                deepest = larger(-gap, deepest)
                dv = v - base
                for k in range(BLOCKS):
                    mean = HALF * (state.velocity[3 * k] + old.velocity[3 * k])
                    given -= dv * mean / shapes.inverse_mass[k]
                base = v
                before = pose
                pose, theta = posed(pose, state, dt)
                state.theta = theta
                loss -= work + unrisen(shapes, before, pose, state, knobs)
                book(dv, given, loss, jolt, supplied, taken, returned)
                mode = mode_of(state, solved)
                for k in range(BLOCKS):
                    slid, overlap, turn, gap1, gap2 = placed(
                        shapes, pose, theta, k, blocks[k, lane].offset
                    )
                    watch(
                        True, time, limit_of(shapes, pose, state, knobs, k), state.left[k], gap1,
                        state.right[k], gap2, slides(slid - slide[k], dt, knobs.gravity),
                        since[k], left[k], right[k], uplift_time, moved, impacts,
                    )  # fmt: skip
                    if size(theta[k]) > peak[k]:
                        peak[k] = smaller(size(theta[k]), HALF_PI)
                        peak_time[k] = time
                    slide[k] = slid
                    peak_slide[k] = larger(size(slid), peak_slide[k])
                    if overlap <= zero:
                        mode = SLID_OFF
                    if larger(size(theta[k]), size(turn)) >= HALF_PI:
                        mode = OVERTURNED
                    total = theta[k] + slid + overlap
                    if total - total != zero:
                        mode = BROKEN
        if found.rotations.shape[0] > 0:
            past = wp.where(mode == RUNNING, larger(time - until, zero), zero)
            for k in range(BLOCKS):
                rate = state.velocity[3 * k + 2]
                found.rotations[sample, k, lane] = state.theta[k] - past * rate
        if found.places.shape[0] > 0:
            for k in range(BLOCKS):
                vx, vz = state.velocity[3 * k], state.velocity[3 * k + 1]
                found.places[sample, k, 0, lane] = at_sample(mode, time - until, pose.x[k], vx)
                found.places[sample, k, 1, lane] = at_sample(mode, time - until, pose.z[k], vz)
    found.results[lane] = Result(
        uplift_time, moved, loss, jolt, supplied, returned, deepest, impacts, mode, count
    )
    for k in range(BLOCKS):
        found.blocks[k, lane] = BlockResult(slide[k], peak[k], peak_time[k], peak_slide[k])
