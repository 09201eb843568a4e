"""Runs of the direct step over stacks of blocks, one lane a thread on any device.

A run begins with a solve at the start, from velocities of zero, which gives the accelerations.
Velocities belong to half steps, so the first step starts with those of half a step earlier, -dt/2
times the acceleration. An interface rocks while one of its ends has parted, see parting.py.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, UPWARDS
from warprock.kernels.contact.parting import Bearing, Parting, observe_ends, slack, slides
from warprock.kernels.direct.block import allowed_closing
from warprock.kernels.direct.stack import (
    Poses,
    Shapes,
    box_of,
    interface_rows,
    pose_of,
    set_rows,
    set_three,
    solve,
    times_inverse_mass,
)
from warprock.kernels.direct.stack_pivot import Equations
from warprock.kernels.lane.account import Account, keep_account
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF, UNSOLVED
from warprock.kernels.launch.instance import LOOPS_STAY, SHORT_COPIES
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, base_velocity
from warprock.kernels.shape.interface import gap_of_end, place_on
from warprock.kernels.shape.stack import Rows, Three, Triples, Values, matrix_of, three_of
from warprock.kernels.shape.stack_found import (
    Found,
    Peaks,
    at_sample,
    block_result,
    observe_peaks,
    result_of,
    start_peaks,
    start_seen,
)
from warprock.kernels.shape.stack_run import Block, Stack

wp.set_module_options((SHORT_COPIES if PRECISION == "float64" else {}) | LOOPS_STAY)

LANES = 1
"""Lanes that a thread runs."""


@wp.struct
class Knobs:
    """Settings that all lanes share; as in direct/block.py, CFM in 1/kg."""

    time_step: real
    rate: real
    gravity: real
    margin: real
    box: real
    cfm: real
    erp: real


@wp.struct
class State:
    """One lane: velocities of its blocks, relative to the base.

    For its interfaces: the side to which they lean, and the last impulses at their ends at -x and
    at +x, and along them towards +x [N s].
    """

    velocity: Triples
    lean: Values
    left: Values
    right: Values
    along: Values


@wp.struct
class Jacobian:
    """Matrices of the relative velocities at all interfaces, of upper and of lower blocks."""

    upper: Rows
    lower: Rows


@wp.func
def side_of_lean(poses: Poses, state: State, k: int, hint: real) -> real:
    """Side to which interface k leans; `hint` is the coming gain of the base velocity [m/s]."""
    zero = real(0.0)
    turn = poses.theta[k]
    rate = state.velocity[3 * k + 2]
    if k > 0:
        turn = turn - poses.theta[k - 1]
        rate = rate - state.velocity[3 * k - 1]
    still = wp.where(hint != zero, -hint, state.lean[k])
    return sign_of(wp.where(turn != zero, turn, wp.where(rate != zero, rate, still)))


@wp.func
def equations(shapes: Shapes, poses: Poses, state: State, knobs: Knobs, free: Triples):
    """The contact problem of a step from the velocities without contact, and its rows.

    Returns:
        The problem; its rows; the last impulses, in its order; the smallest gap [m].
    """
    zero = real(0.0)
    one = real(1.0)
    system = Equations()
    jacobian = Jacobian()
    guess = Triples()
    lowest = zero
    for k in range(BLOCKS):
        lean = state.lean[k]
        up, down, gap1, gap2 = interface_rows(shapes, poses, k, lean)
        lowest = smaller(smaller(gap1, gap2), lowest)
        on1 = wp.where(gap1 <= knobs.margin, one, zero)
        on2 = wp.where(gap2 <= knobs.margin, one, zero)
        # The rows of an open end are zero.
        keep = wp.diag(Three(on1, on2, one))
        up = keep * up
        down = keep * down
        d = times_inverse_mass(up, shapes, k) * wp.transpose(up)
        q = up * three_of(free, k)
        if k > 0:
            d = d + times_inverse_mass(down, shapes, k - 1) * wp.transpose(down)
            q = q + down * three_of(free, k - 1)
            above = times_inverse_mass(
                matrix_of(jacobian.upper, k - 1), shapes, k - 1
            ) * wp.transpose(down)
            system.above = set_rows(system.above, k - 1, above)
        m = shapes.inverse_mass[k]
        d = d + wp.diag(Three(knobs.cfm + m * (one - on1), knobs.cfm + m * (one - on2), zero))
        q = q + Three(
            on1 * allowed_closing(gap1, knobs.erp, knobs.rate),
            on2 * allowed_closing(gap2, knobs.erp, knobs.rate),
            zero,
        )
        mu = shapes.friction[k]
        last = knobs.box * larger(on1, on2) * (state.left[k] + state.right[k])
        system.own = set_rows(system.own, k, d)
        system.free = set_three(system.free, k, q)
        system.friction[k] = (one - knobs.box) * mu
        system.bound[k] = mu * last
        jacobian.upper = set_rows(jacobian.upper, k, up)
        jacobian.lower = set_rows(jacobian.lower, k, down)
        n1 = wp.where(lean > zero, state.left[k], state.right[k])
        n2 = wp.where(lean > zero, state.right[k], state.left[k])
        guess = set_three(guess, k, Three(on1 * n1, on2 * n2, lean * state.along[k]))
    return system, jacobian, guess, lowest


@wp.func
def push(shapes: Shapes, jacobian: Jacobian, free: Triples, p: Triples) -> Triples:
    """Velocities of all blocks after the impulses of all interfaces."""
    v = free
    for k in range(BLOCKS):
        kick = wp.transpose(times_inverse_mass(matrix_of(jacobian.upper, k), shapes, k)) * three_of(
            p, k
        )
        v = set_three(v, k, three_of(v, k) + kick)
        if k > 0:
            below = times_inverse_mass(matrix_of(jacobian.lower, k), shapes, k - 1)
            back = wp.transpose(below) * three_of(p, k)
            v = set_three(v, k - 1, three_of(v, k - 1) + back)
    return v


@wp.func
def step(shapes: Shapes, poses: Poses, state: State, knobs: Knobs, dv: real, hint: real):
    """Velocities and impulses after a step in which the base velocity changes by dv [m/s].

    Returns:
        The state, with the rotations before the step; work of the contacts on it [J]; the smallest
        gap at the start, if negative [m]; whether the contact problem was solved.
    """
    after = state
    free = state.velocity
    for k in range(BLOCKS):
        after.lean[k] = side_of_lean(poses, state, k, hint)
        free[3 * k] = free[3 * k] - dv
        free[3 * k + 1] = free[3 * k + 1] - knobs.time_step * knobs.gravity
    system, jacobian, guess, lowest = equations(shapes, poses, after, knobs, free)
    p, solved, _tries = solve(system, guess)
    v = push(shapes, jacobian, free, p)
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
        # Impulses near zero may be negative by round-off.
        n1, n2 = larger(p[3 * k], real(0.0)), larger(p[3 * k + 1], real(0.0))
        after.left[k] = wp.where(to_right, n1, n2)
        after.right[k] = wp.where(to_right, n2, n1)
        after.along[k] = after.lean[k] * p[3 * k + 2]
    after.velocity = v
    return after, work, lowest, solved


@wp.func
def integrate(poses: Poses, state: State, dt: real) -> Poses:
    """Poses of the blocks after a time dt at their velocities."""
    moved = poses
    for k in range(BLOCKS):
        moved.x[k] = poses.x[k] + dt * state.velocity[3 * k]
        moved.z[k] = poses.z[k] + dt * state.velocity[3 * k + 1]
        moved.theta[k] = poses.theta[k] + dt * state.velocity[3 * k + 2]
        moved.s[k] = sine(in_range(moved.theta[k]))
        moved.c[k] = cosine(in_range(moved.theta[k]))
    return moved


@wp.func
def energy_not_lifted(
    shapes: Shapes, before: Poses, poses: Poses, state: State, knobs: Knobs
) -> real:
    """Potential energy that velocities imply and heights do not gain [J], as at rest in float32.

    Without round-off it is zero.
    """
    total = real(0.0)
    for k in range(BLOCKS):
        missing = (poses.z[k] - before.z[k]) - knobs.time_step * state.velocity[3 * k + 1]
        total += knobs.gravity * missing / shapes.inverse_mass[k]
    return total


@wp.func
def gap_at(side: real, shapes: Shapes, poses: Poses, k: int) -> real:
    """Gap of interface k at its end at -x (side -1) or at +x (1) [m]."""
    box, at = box_of(shapes, k), pose_of(poses, k)
    return gap_of_end(side, box, at, box_of(shapes, k - 1), pose_of(poses, k - 1))


@wp.func
def limit_of(shapes: Shapes, poses: Poses, state: State, knobs: Knobs, k: int) -> real:
    """Gap beyond which an end of interface k has parted [m]."""
    square = state.velocity[3 * k + 2] * state.velocity[3 * k + 2]
    if k > 0:
        square += state.velocity[3 * k - 1] * state.velocity[3 * k - 1]
    reach = shapes.half_width[k] + shapes.half_height[k]
    length = shapes.half_height[k] + size(poses.z[k])
    return slack(knobs.time_step, knobs.gravity, reach, square, length)


@wp.func
def mode_of(state: State, solved: bool) -> int:
    """Mode of a lane after a step."""
    total = real(0.0)
    for i in range(3 * BLOCKS):
        total += state.velocity[i]
    return wp.where(total - total == real(0.0), wp.where(solved, RUNNING, UNSOLVED), BROKEN)


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread."""
    lane, zero, dt = wp.tid(), real(0.0), knobs.time_step
    motion = motions[lane]
    shapes = Shapes()
    poses = Poses()
    state = State()
    parting = rows(Parting, lanes=BLOCKS)
    peaks = rows(Peaks, lanes=BLOCKS)
    slide = Values()
    account = Account()
    seen = start_seen(lanes[lane].uplift_time)
    for k in range(BLOCKS):
        block = blocks[k, lane]
        shapes.half_width[k] = block.half_width
        shapes.half_height[k] = block.half_height
        shapes.inverse_mass[k] = block.inverse_mass
        shapes.inverse_inertia[k] = block.inverse_inertia
        shapes.friction[k] = block.friction
        poses.x[k] = block.x
        poses.z[k] = block.z
        poses.theta[k] = block.theta
        poses.s[k] = sine(block.theta)
        poses.c[k] = cosine(block.theta)
        state.lean[k] = sign_of(lanes[lane].lean)
        state.left[k] = block.left
        state.right[k] = block.right
        peaks[k] = start_peaks(block.theta)
    base, count = real(0.0), int(-1)
    time = -dt
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until and seen.mode == RUNNING:
            count += 1
            time = real(count) * dt
            half = larger(time - HALF * dt, HALF * dt)
            v = base_velocity(motion, half, pool)
            old = state
            if count == 0:
                # Velocities half a step before the start.
                state, _work, _gap, solved = step(shapes, poses, old, knobs, zero, v)
                state.velocity = -HALF * state.velocity
                seen.mode = mode_of(state, solved)
            else:
                state, work, gap, solved = step(shapes, poses, old, knobs, v - base, v - base)
                seen.deepest = larger(-gap, seen.deepest)
                dv = v - base
                for k in range(BLOCKS):
                    mean = HALF * (state.velocity[3 * k] + old.velocity[3 * k])
                    account.work -= dv * mean / shapes.inverse_mass[k]
                base = v
                before = poses
                poses = integrate(before, state, dt)
                account.loss -= work + energy_not_lifted(shapes, before, poses, state, knobs)
                account = keep_account(dv, account)
                seen.mode = mode_of(state, solved)
                for k in range(BLOCKS):
                    spot, overlap = place_on(
                        box_of(shapes, k), pose_of(poses, k), box_of(shapes, k - 1),
                        pose_of(poses, k - 1),
                    )  # fmt: skip
                    slid = spot - blocks[k, lane].offset
                    slips = slides(slid - slide[k], dt, knobs.gravity)
                    left = Bearing(state.left[k], gap_at(real(-1.0), shapes, poses, k))
                    right = Bearing(state.right[k], gap_at(real(1.0), shapes, poses, k))
                    limit = limit_of(shapes, poses, state, knobs, k)
                    ends = parting[k]
                    observe_ends(True, time, limit, slips, left, right, ends, seen)
                    parting[k] = ends
                    theta = poses.theta[k]
                    peaks[k] = observe_peaks(True, time, theta, slid, peaks[k])
                    slide[k] = slid
                    turn = theta - pose_of(poses, k - 1).theta
                    if overlap <= zero:
                        seen.mode = SLID_OFF
                    if larger(size(theta), size(turn)) >= HALF_PI:
                        seen.mode = OVERTURNED
                    total = theta + slid + overlap
                    if total - total != zero:
                        seen.mode = BROKEN
        if found.rotations.shape[0] > 0:
            past = wp.where(seen.mode == RUNNING, larger(time - until, zero), zero)
            for k in range(BLOCKS):
                rate = state.velocity[3 * k + 2]
                found.rotations[sample, k, lane] = poses.theta[k] - past * rate
        if found.places.shape[0] > 0:
            for k in range(BLOCKS):
                vx, vz = state.velocity[3 * k], state.velocity[3 * k + 1]
                x = at_sample(seen.mode, time - until, poses.x[k], vx)
                z = at_sample(seen.mode, time - until, poses.z[k], vz)
                found.places[sample, k, ALONG, lane] = x
                found.places[sample, k, UPWARDS, lane] = z
    seen.steps = count
    found.results[lane] = result_of(seen, account)
    for k in range(BLOCKS):
        found.blocks[k, lane] = block_result(slide[k], peaks[k])
