"""Runs of the impulse step over stacks of blocks in space, one lane a thread on any device.

A run begins with one solve from velocities of zero. Its first guess is the weight above each
interface, shared by the contacts; it gives the impulses at rest, or at the release. Velocities
belong to half steps, so the first step starts with those of half a step earlier, -dt/2 times the
settled acceleration.

An interface rocks while a corner of the overlap of its faces does not touch; it lands once one
touches again. A stack moves while an interface rocks or slides, see `slips` in
impulse_space/block.py. It ends when two faces no longer overlap, or a block leans by a right angle
to the vertical or to the block below.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Quaternion, Vector
from warprock.kernels.impulse.stack import drop_round_off
from warprock.kernels.impulse_space.block import Knobs, side_of, slips
from warprock.kernels.impulse_space.stack import Pose, Touches, fastest_slip, find_contacts, solve
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF
from warprock.kernels.launch.instance import LOOPS_STAY
from warprock.kernels.motion.kinds import Motion, base_velocity
from warprock.kernels.shape.interface import GROUND, GROUND_FACE
from warprock.kernels.shape_space.block import Block, slide_of, turn_freely, turns_of
from warprock.kernels.shape_space.block_found import BlockResult, Found, Result
from warprock.kernels.shape_space.frame import axis_of, frame, rotate_diagonal, turn_of_matrix
from warprock.kernels.shape_space.lanes import Triple
from warprock.kernels.shape_space.stack import (
    Bodies,
    Numbers,
    PointInts,
    Points,
    rows_of,
    shared_corners,
)

wp.set_module_options(LOOPS_STAY)

LANES = 1
"""Lanes that a thread runs."""

SETTLING = 20000
"""Largest number of sweeps of the solve before the run; they end once the impulses converge."""

Attitudes = wp.types.matrix(shape=(BLOCKS + 1, 4), dtype=real)
Kept = wp.types.matrix(shape=(16 * BLOCKS, 3), dtype=real)
Ints = wp.types.vector(length=BLOCKS + 1, dtype=int)


@wp.func
def observe_block(
    seen: BlockResult, time: real, block: Block, q: Quaternion, r: Matrix, m: Matrix, c: Vector
) -> BlockResult:
    """Observed response of a block after a step.

    m and c are as in `shared_corners`, r is its own attitude.
    """
    tan_x, tan_y, tilt, yaw = turns_of(block, r[0, 2], r[1, 2], r[2, 2], q[2], q[3])
    x, y = slide_of(block, c[0], c[1], turn_of_matrix(m))
    return BlockResult(
        q[2], q[3], x, y,
        larger(tan_x, seen.peak), wp.where(tan_x > seen.peak, time, seen.peak_time),
        larger(tan_y, seen.peak_across), larger(tilt, seen.peak_tilt), larger(yaw, seen.peak_yaw),
        larger(x * x + y * y, seen.peak_slide),
    )  # fmt: skip


@wp.func
def mode_after(mode: int, total: real, shares: int, r: Matrix, m: Matrix) -> int:
    """The mode of a lane after one of its blocks has moved.

    Args:
        mode: Its mode before.
        total: A sum of the numbers of the block, finite if they are.
        shares: Not zero if the block overlaps the face below.
        r: Attitude of the block.
        m: Attitude of the block in the axes of the body below.
    """
    sums = total + r[2, 2]
    found = wp.where(shares != 0, RUNNING, SLID_OFF)
    found = wp.where(smaller(r[2, 2], m[2, 2]) <= real(0.0), OVERTURNED, found)
    found = wp.where(sums - sums == real(0.0), found, BROKEN)
    return wp.where(mode == RUNNING, found, mode)


@wp.func
def support_of(below: Block, k: int) -> Block:
    """The body below block k: the ground below the first one, else the given block."""
    if k > 1:
        return below
    base = Block()
    base.half_width = GROUND_FACE
    base.half_depth = GROUND_FACE
    return base


@wp.func
def lean_of(m: Matrix, rate: Vector, hint: Vector, before: Vector) -> Vector:
    """Sides along x and y to which a block leans on the body below, each -1 or 1.

    Args:
        m: Its attitude in the axes of the body below.
        rate: Its angular velocity relative to that body, in these axes [rad/s].
        hint: Present or next change of the base velocity [m/s].
        before: Sides that count if all of these are zero.
    """
    zero = real(0.0)
    x = side_of(drop_round_off(-m[2, 0]), drop_round_off(rate[1]), hint[0], before[0])
    twist = drop_round_off(m[1, 0] * x)
    side = wp.where(twist != zero, twist, before[1])
    y = side_of(drop_round_off(-m[2, 1]), drop_round_off(-rate[0]), hint[1], side)
    return Vector(x, y, zero)


@wp.func
def attitude_to_store(block: Block, q: Quaternion, spin: Vector, past: real) -> Quaternion:
    """Attitude of a block at a sample that its lane has passed by the time -past [s]."""
    turns = Triple(spin[0], spin[1], spin[2])
    inverse = Triple(block.inverse_x, block.inverse_y, block.inverse_z)
    e, f, g, h = turn_freely(q[0], q[1], q[2], q[3], turns, inverse, past)
    return Quaternion(e, f, g, h)


@wp.struct
class State:
    """State of a block.

    Attributes:
        at: Centre of mass [m].
        v: Velocity, of half a step before [m/s].
        spin: Angular momentum for unit mass, in the axes of the base [m^2/s].
        q: Attitude.
    """

    at: Vector
    v: Vector
    spin: Vector
    q: Quaternion


@wp.func
def integrate(
    settles: bool, block: Block, knobs: Knobs, dv: Vector, s: State, u: Vector, o: Vector,
    lift: Vector,
):  # fmt: skip
    """The state of a block after a step; before the first one, half a step back.

    Args:
        settles: Whether the step only finds impulses.
        block: The block.
        knobs: Settings.
        dv: Change of the base velocity [m/s].
        s: The block before the step.
        u: Its velocity after it [m/s].
        o: Its angular velocity after it [rad/s].
        lift: Correction of penetrations by erp [m].

    Returns:
        The block after the step, and the energy that its contacts took [J].
    """
    dt, one, r = knobs.time_step, real(1.0), frame(s.q)
    x, y, z = block.inverse_x, block.inverse_y, block.inverse_z
    before = rotate_diagonal(r, x, y, z) * s.spin
    gain = rotate_diagonal(r, one / x, one / y, one / z) * (o - before)
    if settles:
        return State(s.at, -HALF * u, -HALF * gain, s.q), real(0.0)
    push = u - s.v + dv + Vector(real(0.0), real(0.0), dt * knobs.gravity)
    work = HALF * (wp.dot(push, s.v + u) + wp.dot(gain, before + o)) + knobs.gravity * lift[2]
    turned = attitude_to_store(block, s.q, s.spin + gain, dt)
    return State(s.at + dt * u + lift, u, s.spin + gain, turned), -block.mass * work


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread."""
    lane, dt, zero = wp.tid(), knobs.time_step, real(0.0)
    at, v, spin, u, o, lean = Bodies(), Bodies(), Bodies(), Bodies(), Bodies(), Bodies()
    attitude, lift, load = Attitudes(), Bodies(), Numbers()
    pose, t, apart, there = Pose(), Touches(), Ints(), Ints()
    base, dv, hint, p = Vector(), Vector(), Vector(), Points()
    key, kept = PointInts(), Kept()
    bodies, count, steps, mode, impacts = int(BLOCKS + 1), int(-1), int(0), int(RUNNING), int(0)
    uplift_time = NEVER
    time, moved, loss, deepest = -dt, real(0.0), real(0.0), real(0.0)
    for i in range(3):
        pose.axes[i, i] = real(1.0)
    attitude[GROUND] = Quaternion(zero, zero, zero, real(1.0))
    for k in range(1, bodies):
        block = blocks[k - 1, lane]
        found.blocks[k - 1, lane] = BlockResult()
        at[k] = Vector(block.x, block.y, block.z)
        attitude[k] = Quaternion(block.qx, block.qy, block.qz, block.qw)
        pose.light[k] = real(1.0) / block.mass
        pose.friction[k] = block.friction
        for i in range(1, k + 1):
            load[i] = load[i] + dt * knobs.gravity * block.mass
        lean[k] = Vector(block.flat_x + block.centre_x, block.flat_y + block.centre_y, zero)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while mode == RUNNING and time < until:
            count += 1
            time = real(count) * dt
            half = larger(time - HALF * dt, HALF * dt)
            for d in range(3):
                way = motions[d, lane]
                rides = base_velocity(way, half, pool)
                hint[d] = rides - base[d]
                dv[d] = wp.where(count > 0, hint[d], zero)
                base[d] = wp.where(count > 0, rides, zero)
            lifted, landed, shift = int(0), int(0), Vector(zero, zero, zero)
            t.total = 0
            for k in range(1, bodies):
                block = blocks[k - 1, lane]
                r = frame(attitude[k])
                j = rotate_diagonal(r, block.inverse_x, block.inverse_y, block.inverse_z)
                for i in range(3):
                    pose.axes[3 * k + i] = axis_of(r, i)
                    pose.ease[3 * k + i] = pose.light[k] * axis_of(j, i)
                u[k] = v[k] - dv - Vector(zero, zero, dt * knobs.gravity)
                o[k] = j * spin[k]
                below, down = (
                    support_of(blocks[wp.max(k - 2, 0), lane], k),
                    rows_of(pose.axes, k - 1),
                )
                m, c = down * r, down * (at[k] - at[k - 1])
                lean[k] = lean_of(m, down * (o[k] - o[k - 1]), hint, lean[k])
                places, gaps, some = shared_corners(block, below, m, c, lean[k])
                chosen, number, open = find_contacts(gaps, some, lean[k], apart[k], knobs)
                for i in range(number):
                    slot, n = chosen[i], int(t.total)
                    lever = wp.transpose(down) * places[slot]
                    t.rl[n] = lever
                    t.ru[n] = lever + at[k - 1] - at[k]
                    t.body[n] = k
                    t.gap[n] = gaps[slot]
                    key[n] = 16 * (k - 1) + slot
                    share = Vector(zero, zero, load[k] / real(number))
                    p[n] = wp.where(count > 0, kept[key[n]], share)
                    t.total = n + 1
                there[k] = some
                apart[k] = open.wide
                lifted, landed = lifted | open.wide, landed | open.lands
                deepest, shift = (
                    larger(deepest, open.deep),
                    shift + open.push * pose.axes[3 * k - 1],
                )
                lift[k] = shift
            sweeps = wp.where(count > 0, knobs.sweeps, SETTLING)
            p, u, o = solve(sweeps, knobs.rate, pose, t, p, u, o)
            kept = Kept()
            for i in range(t.total):
                kept[key[i]] = p[i]
            for k in range(1, bodies):
                block = blocks[k - 1, lane]
                down = wp.transpose(frame(attitude[k - 1]))
                own = State(at[k], v[k], spin[k], attitude[k])
                after, took = integrate(count == 0, block, knobs, dv, own, u[k], o[k], lift[k])
                at[k] = after.at
                v[k] = after.v
                spin[k] = after.spin
                attitude[k] = after.q
                r, loss = frame(after.q), loss + took
                m, c = down * r, down * (after.at - at[k - 1])
                seen = found.blocks[k - 1, lane]
                found.blocks[k - 1, lane] = observe_block(seen, time, block, after.q, r, m, c)
                sums = after.at[0] + after.v[0] + after.v[1] + after.v[2]
                sums = sums + after.spin[0] + after.spin[1] + after.spin[2]
                mode = mode_after(mode, sums, there[k], r, m)
            steps, impacts = steps + wp.where(count > 0, 1, 0), impacts + landed
            slides = slips(fastest_slip(pose, t, u, o), knobs)
            moved = wp.where(lifted != 0 or (count > 0 and slides), time, moved)
            uplift_time = wp.where(lifted != 0, smaller(uplift_time, time), uplift_time)
        if found.attitudes.shape[0] > 0:
            past = wp.where(mode == RUNNING, smaller(until - time, zero), zero)
            for k in range(1, bodies):
                q = attitude_to_store(blocks[k - 1, lane], attitude[k], spin[k], past)
                for i in range(4):
                    found.attitudes[sample, k - 1, i, lane] = q[i]
                if found.places.shape[0] > 0:
                    spot = at[k] + past * v[k]
                    for i in range(3):
                        found.places[sample, k - 1, i, lane] = spot[i]
    found.results[lane] = Result(uplift_time, moved, loss, deepest, impacts, mode, steps)
