"""Runs of the impulse step over blocks in space, LANES lanes a thread.

The values of LANES lanes lie side by side in rows of structs, one row a corner, so that the
compiler turns them into vector code. With one lane a thread the same text is the plain form for
any device. The sweeps skip a corner that is no contact in any lane of the thread, which changes no
bit.

If THROWN is true, blocks start in motion (impulse_space/block_thrown.py), and corners that come
down fast bounce (impulse_space/bounce.py). There is then one lane a thread, since a block may
change its axes between two steps.

impulse_space/block_seen.py defines when a block rocks, lands and lifts.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ONLY, W, X, Y, Z
from warprock.kernels.impulse_space.block import (
    AHEAD_X,
    AHEAD_Y,
    FAR,
    LOWEST,
    REAR,
    Box,
    Contact,
    Corners,
    Gains,
    Gaps,
    Impulse,
    Knobs,
    Lean,
    Velocity,
    box_of,
    find_contact,
    find_lean,
    impulse_where,
    integrate,
    inverse_of,
    observe_contact,
    predict,
    solve_contact,
    spin_of,
    warm_start,
)
from warprock.kernels.impulse_space.block_hold import impulse_if, stop_contacts, velocity_if
from warprock.kernels.impulse_space.block_plane import find_plane, mirror_aims, solve_in_plane
from warprock.kernels.impulse_space.block_seen import (
    glides,
    mode_after,
    observe_block,
    observe_contacts,
    stands,
)
from warprock.kernels.lane.modes import OVERTURNED, RUNNING
from warprock.kernels.launch.instance import BRANCHES, ONE_VECTOR
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, base_velocity
from warprock.kernels.shape_space.block import Block, turn_freely, turns_of
from warprock.kernels.shape_space.block_found import Found, Peaks, Result, block_result, start_peaks
from warprock.kernels.shape_space.lanes import State, Symmetric, Triple
from warprock.kernels.shape_space.thrown import Throw

if THROWN:
    from warprock.kernels.algebra.vectors import Quaternion
    from warprock.kernels.impulse_space.block_thrown import (
        in_first_axes,
        observe_tumbling,
        set_attitude,
        start_throw,
        start_throw_peaks,
    )
    from warprock.kernels.impulse_space.bounce import bounce_velocity, remove_gained_energy
    from warprock.kernels.shape_space.thrown import (
        compose,
        needs_new_axes,
        new_axes,
        rename_block_axes,
    )

wp.set_module_options(BRANCHES if THROWN else ONE_VECTOR)

R = wp.types.vector(length=LANES, dtype=real)
"""A number a lane."""
Three = wp.types.matrix(shape=(3, LANES), dtype=real)
Corner = wp.types.matrix(shape=(4, LANES), dtype=real)
Counts = wp.types.vector(length=4, dtype=int)


@wp.func
def start_block(block: Block, knobs: Knobs) -> State:
    """State of a block at its start.

    Velocities belong to half steps: half a step before the start the block rises with the velocity
    at which it falls half a step after.
    """
    zero, fall = real(0.0), HALF * knobs.time_step * knobs.gravity
    return State(
        block.x, block.y, block.z, block.qx, block.qy, block.qz, block.qw, zero, zero, fall,
        zero, zero, zero,
    )  # fmt: skip


@wp.func
def start_lane(block: Block) -> Result:
    """Observed response of a lane before its first step."""
    zero = real(0.0)
    flat = block.standing == real(4.0)
    return Result(wp.where(flat, NEVER, zero), zero, zero, zero, 0, RUNNING, 0)


@wp.func
def start_block_peaks(block: Block) -> Peaks:
    """Observed response of a block before its first step."""
    r13 = real(2.0) * (block.qx * block.qz + block.qy * block.qw)
    r23 = real(2.0) * (block.qy * block.qz - block.qx * block.qw)
    r33 = real(1.0) - real(2.0) * (block.qx * block.qx + block.qy * block.qy)
    along, across, tilt, _yaw = turns_of(block, r13, r23, r33, block.qz, block.qw)
    return start_peaks(along, across, tilt)


@wp.func
def swap_if(swaps: bool, a: wp.ref[real], b: wp.ref[real]):
    """Swaps two numbers if `swaps`."""
    first = real(a)
    a = wp.where(swaps, b, first)
    b = wp.where(swaps, first, b)


@wp.func
def swap_impulses_if(swaps: bool, a: wp.ref[Impulse], b: wp.ref[Impulse]):
    """Swaps two impulses if `swaps`."""
    swap_if(swaps, a.fx, b.fx)
    swap_if(swaps, a.fy, b.fy)
    swap_if(swaps, a.n, b.n)


@wp.func
def attitude_at(live: bool, past: real, inverse: Triple, s: State):
    """Attitude at a sample that a block has passed by the time -past [s], if it lives on."""
    time = wp.where(live, past, real(0.0))
    x, y, z, w = turn_freely(s.qx, s.qy, s.qz, s.qw, spin_of(s), inverse, time)
    return x, y, z, w


@wp.func
def place_at(past: real, s: State) -> Triple:
    """Centre of mass at a sample that a block has passed by a time [s]."""
    return Triple(s.x - past * s.vx, s.y - past * s.vy, s.z - past * s.vz)


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), throws: wp.array(dtype=Throw),
    motions: wp.array2d(dtype=Motion), pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time; `throws` are how blocks start if THROWN."""
    pack, _one = wp.tid()
    first, dt, zero, time = pack * LANES, knobs.time_step, real(0.0), real(0.0)
    block = rows(Block)
    box = rows(Box)
    state = rows(State)
    free = rows(Velocity)
    ease = rows(Symmetric)
    lean = rows(Lean)
    contact = rows(Contact, 4)
    impulse = rows(Impulse, 4)
    gains = rows(Gains, 4)
    gaps = rows(Gaps)
    seen = rows(Result)
    peaks = rows(Peaks)
    base, dv, apart, since, plane, busy = Three(), Three(), Corner(), R(), R(), Counts()
    corners, count = int(4), int(0)  # no constant: else Warp would unroll the loops over it
    for i in range(LANES):
        block[i] = blocks[0, first + i]
        box[i] = box_of(block[i])
        if THROWN:
            state[i] = start_throw(block[i], knobs, throws[first + i])
            peaks[i] = start_throw_peaks(block[i], state[i])
        else:
            state[i] = start_block(block[i], knobs)
            peaks[i] = start_block_peaks(block[i])
        lean[i] = Lean(sign_of(block[i].centre_x), sign_of(block[i].centre_y))
        seen[i] = start_lane(block[i])
    if THROWN:
        own = blocks[0, first]
        tumbles = throws[first].tumbles == 1
        # Turn from the body axes at the start to the present ones, which change between steps.
        named = Quaternion(zero, zero, zero, real(1.0))
    else:
        for c in range(corners):
            for i in range(LANES):
                # The touching corners share its weight.
                impulse[c, i].n = HALF * dt * knobs.gravity / block[i].standing
    for sample in range(sample_times.shape[0]):
        while time < sample_times[sample]:
            if THROWN:
                if seen[ONLY].mode != RUNNING:
                    break
                if tumbles and needs_new_axes(state[ONLY].qx, state[ONLY].qy):
                    s = state[ONLY]
                    gx, gy, gw = new_axes(s.qx, s.qy, s.qz, s.qw)
                    own = rename_block_axes(own, gx, gy)
                    box[ONLY] = box_of(own)
                    x, y, z, w = compose(s.qx, s.qy, s.qz, s.qw, gx, gy, zero, gw)
                    state[ONLY] = set_attitude(s, x, y, z, w)
                    x, y, z, w = compose(named[0], named[1], named[2], named[3], gx, gy, zero, gw)
                    named = Quaternion(x, y, z, w)
                    for c in range(corners):
                        impulse[c, ONLY] = Impulse(zero, zero, zero)
                        apart[c, ONLY] = zero
            count += 1
            time, half = real(count) * dt, (real(count) - HALF) * dt
            # Loops of their own: what reads a record and does more than that is no vector code.
            for d in range(3):
                if (knobs.moves >> d) % 2 == 1:
                    for i in range(LANES):
                        v = base_velocity(motions[d, first + i], half, pool)
                        dv[d, i] = v - base[d, i]
                        base[d, i] = v
            for i in range(LANES):
                flat = stands(
                    impulse[REAR, i], impulse[AHEAD_X, i], impulse[AHEAD_Y, i], impulse[LOWEST, i]
                )
                since[i] = wp.where(flat, NEVER, smaller(since[i], time - dt))
                change = Triple(dv[X, i], dv[Y, i], dv[Z, i])
                u, j = predict(change, knobs, inverse_of(box[i]), state[i])
                was, now = lean[i], find_lean(change, state[i], u, lean[i])
                free[i] = u
                ease[i] = j
                lean[i] = now
                gaps[i] = Gaps(FAR, zero, zero)
                # Corners swap if the block leans to another side.
                swaps_x, swaps_y = was.x != now.x, was.y != now.y
                p1, p2, p3, p4 = (
                    impulse[REAR, i],
                    impulse[AHEAD_X, i],
                    impulse[AHEAD_Y, i],
                    impulse[LOWEST, i],
                )
                swap_impulses_if(swaps_x, p1, p2)
                swap_impulses_if(swaps_x, p3, p4)
                swap_impulses_if(swaps_y, p1, p3)
                swap_impulses_if(swaps_y, p2, p4)
                impulse[REAR, i] = p1
                impulse[AHEAD_X, i] = p2
                impulse[AHEAD_Y, i] = p3
                impulse[LOWEST, i] = p4
                swap_if(swaps_x, apart[REAR, i], apart[AHEAD_X, i])
                swap_if(swaps_x, apart[AHEAD_Y, i], apart[LOWEST, i])
                swap_if(swaps_y, apart[REAR, i], apart[AHEAD_Y, i])
                swap_if(swaps_y, apart[AHEAD_X, i], apart[LOWEST, i])
            for c in range(corners):
                for i in range(LANES):
                    at = find_contact(c, knobs, box[i], lean[i], state[i])
                    reach = box[i].half_width + box[i].half_depth + box[i].half_height
                    gap, shows = state[i].z + at.h, gaps[i]
                    n = impulse[c, i].n
                    observe_contact(knobs, gap, reach, free[i], n, apart[c, i], shows)
                    gaps[i] = shows
                    if THROWN:
                        at.aim = bounce_velocity(knobs, at, free[i])
                    contact[c, i] = at
                    impulse[c, i] = impulse_where(at.on > zero, impulse[c, i])
            for i in range(LANES):
                plane[i] = find_plane(knobs, box[i], state[i], free[i])
                face = mirror_aims(
                    plane[i],
                    Corners(
                        contact[REAR, i],
                        contact[AHEAD_X, i],
                        contact[AHEAD_Y, i],
                        contact[LOWEST, i],
                    ),
                )
                held = stop_contacts(knobs, box[i], lean[i], state[i], free[i], face)
                contact[REAR, i] = face.a
                contact[AHEAD_X, i] = face.b
                contact[AHEAD_Y, i] = face.c
                contact[LOWEST, i] = face.d
                impulse[REAR, i] = impulse_if(held.fits, held.a, impulse[REAR, i])
                impulse[AHEAD_X, i] = impulse_if(held.fits, held.b, impulse[AHEAD_X, i])
                impulse[AHEAD_Y, i] = impulse_if(held.fits, held.c, impulse[AHEAD_Y, i])
                impulse[LOWEST, i] = impulse_if(held.fits, held.d, impulse[LOWEST, i])
                free[i] = velocity_if(held.touches, held.after, free[i])
                for c in range(4):
                    contact[c, i].on = wp.where(held.fits, zero, contact[c, i].on)
            planar = int(0)
            for i in range(LANES):
                left = (
                    contact[REAR, i].on
                    + contact[AHEAD_X, i].on
                    + contact[AHEAD_Y, i].on
                    + contact[LOWEST, i].on
                )
                planar += wp.where(plane[i] * left > zero, 1, 0)
            if planar > 0:
                for i in range(LANES):
                    corner = Corners(
                        contact[REAR, i],
                        contact[AHEAD_X, i],
                        contact[AHEAD_Y, i],
                        contact[LOWEST, i],
                    )
                    solved = solve_in_plane(
                        plane[i], knobs, box[i], lean[i], state[i], free[i], corner
                    )
                    impulse[REAR, i] = impulse_if(solved.found, solved.a, impulse[REAR, i])
                    impulse[AHEAD_X, i] = impulse_if(solved.found, solved.b, impulse[AHEAD_X, i])
                    impulse[AHEAD_Y, i] = impulse_if(solved.found, solved.c, impulse[AHEAD_Y, i])
                    impulse[LOWEST, i] = impulse_if(solved.found, solved.d, impulse[LOWEST, i])
                    free[i] = velocity_if(solved.touches, solved.after, free[i])
                    for c in range(4):
                        contact[c, i].on = wp.where(solved.found, zero, contact[c, i].on)
            swept = int(0)
            for c in range(corners):
                busy[c] = 0
                for i in range(LANES):
                    busy[c] += wp.where(contact[c, i].on > zero, 1, 0)
                swept += busy[c]
                if busy[c] > 0:
                    for i in range(LANES):
                        u = free[i]
                        gains[c, i] = warm_start(contact[c, i], impulse[c, i], ease[i], u)
                        free[i] = u
            for step in range(wp.where(swept > 0, knobs.sweeps * corners, 0)):
                c = step % corners
                if busy[c] > 0:
                    for i in range(LANES):
                        p, u = impulse[c, i], free[i]
                        solve_contact(box[i].friction, contact[c, i], gains[c, i], ease[i], p, u)
                        impulse[c, i] = p
                        free[i] = u
            for i in range(LANES):
                live = seen[i].mode == RUNNING
                change = Triple(dv[X, i], dv[Y, i], dv[Z, i])
                if THROWN:
                    u = free[i]
                    if knobs.restitution > zero:
                        remove_gained_energy(knobs, change, inverse_of(box[i]), state[i], u)
                    free[i] = u
                slides, sees = glides(box[i], knobs, free[i]), seen[i]
                lowest = gaps[i].lowest
                s = integrate(
                    live, knobs, inverse_of(box[i]), change, free[i], lowest, state[i], sees.loss
                )
                observe_contacts(live, time, gaps[i], slides, since[i], sees)
                if THROWN:
                    before, began = peaks[i], in_first_axes(s, named)
                    sees.mode = mode_after(sees.mode, began)
                    peaks[i] = observe_block(live, time, block[i], began, before)
                    if tumbles:
                        peaks[i] = observe_tumbling(block[i], s, before, peaks[i])
                        sees.mode = wp.where(sees.mode == OVERTURNED, RUNNING, sees.mode)
                else:
                    sees.mode = mode_after(sees.mode, s)
                    peaks[i] = observe_block(live, time, block[i], s, peaks[i])
                seen[i] = sees
                state[i] = s
        past = time - sample_times[sample]
        for i in range(wp.where(found.attitudes.shape[0] > 0, LANES, 0)):
            live, inverse, s = seen[i].mode == RUNNING, inverse_of(box[i]), state[i]
            if THROWN:
                inverse, s = (
                    inverse_of(box_of(block[i])),
                    in_first_axes(state[i], named),
                )
            qx, qy, qz, qw = attitude_at(live, -past, inverse, s)
            found.attitudes[sample, ONLY, X, first + i] = qx
            found.attitudes[sample, ONLY, Y, first + i] = qy
            found.attitudes[sample, ONLY, Z, first + i] = qz
            found.attitudes[sample, ONLY, W, first + i] = qw
        for i in range(wp.where(found.places.shape[0] > 0, LANES, 0)):
            spot = place_at(wp.where(seen[i].mode == RUNNING, past, zero), state[i])
            found.places[sample, ONLY, X, first + i] = spot.x
            found.places[sample, ONLY, Y, first + i] = spot.y
            found.places[sample, ONLY, Z, first + i] = spot.z
    for i in range(LANES):
        if THROWN:
            state[i] = in_first_axes(state[i], named)
        found.results[first + i] = seen[i]
        found.blocks[0, first + i] = block_result(state[i].qz, state[i].qw, peaks[i])
