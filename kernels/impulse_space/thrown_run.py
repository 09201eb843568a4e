"""Runs of the impulse step over blocks in space that start in motion or bounce, one lane a thread.

The step is that of impulse_space/block.py. Besides,

    - a corner that comes down fast bounces, see impulse_space/bounce.py;
    - of a block that tumbles the face that looks down becomes the bottom between two steps
      (shape_space/thrown.py). Its corners begin without impulses then. Its slide is the way of its
      centre along the base.

It is a text of its own: its lanes go different ways, with a branch for each, where block_run.py
keeps LANES lanes side by side without branches.
"""

import warp as wp

from warprock.kernels.impulse_space.block import (
    FAR,
    Contact,
    Corners,
    Gains,
    Gaps,
    Impulse,
    Knobs,
    Lean,
    box_of,
    find_contact,
    find_lean,
    impulse_where,
    integrate,
    inverse_of,
    observe_contact,
    predict,
    solve_contact,
    warm_start,
)
from warprock.kernels.impulse_space.block_hold import hold, impulse_if, velocity_if
from warprock.kernels.impulse_space.block_plane import find_plane, level, solve_in_plane
from warprock.kernels.impulse_space.block_run import (
    attitude_at,
    place_at,
    start_lane,
    swap_if,
    swap_impulses_if,
)
from warprock.kernels.impulse_space.block_seen import (
    glides,
    mode_after,
    observe_block,
    observe_contacts,
    stands,
)
from warprock.kernels.impulse_space.bounce import bounce, calm
from warprock.kernels.instance import BRANCHES
from warprock.kernels.modes import OVERTURNED, RUNNING
from warprock.kernels.motion import Motion, base_velocity, sample_index, sample_segment
from warprock.kernels.rows import kernel, rows
from warprock.kernels.shape_space.block import Block, turns_of
from warprock.kernels.shape_space.block_found import Found, Peaks, block_result, start_peaks
from warprock.kernels.shape_space.frame import frame
from warprock.kernels.shape_space.lanes import State, Triple, turn_of
from warprock.kernels.shape_space.thrown import Throw, after, leans, new_axes, renamed
from warprock.kernels.vectors import Quaternion, Vector

wp.set_module_options(BRANCHES)

LANES = 1
"""Lanes of a thread."""
Corner = wp.types.vector(length=4, dtype=real)


@wp.func
def start_throw(block: Block, knobs: Knobs, throw: Throw) -> State:
    """A block where it starts, its velocity that of half a step before."""
    fall, one = HALF * knobs.time_step * knobs.gravity, real(1.0)
    turn = frame(Quaternion(block.qx, block.qy, block.qz, block.qw))
    inertia = wp.diag(Vector(one / block.inverse_x, one / block.inverse_y, one / block.inverse_z))
    spin = turn * (inertia * (wp.transpose(turn) * Vector(throw.wx, throw.wy, throw.wz)))
    return State(
        block.x, block.y, block.z, block.qx, block.qy, block.qz, block.qw,
        throw.vx, throw.vy, throw.vz + fall, spin[0], spin[1], spin[2],
    )  # fmt: skip


@wp.func
def with_attitude(s: State, x: real, y: real, z: real, w: real) -> State:
    """The block at another attitude."""
    n = s
    n.qx = x
    n.qy = y
    n.qz = z
    n.qw = w
    return n


@wp.func
def as_it_began(s: State, named: Quaternion) -> State:
    """The block in the axes that it began with; `named` leads from these to its own."""
    x, y, z, w = after(
        s.qx, s.qy, s.qz, s.qw, -named[0], -named[1], -named[2], named[3]
    )  # fmt: skip
    return with_attitude(s, x, y, z, w)


@wp.func
def observe_tumbling(block: Block, s: State, before: Peaks, now: Peaks) -> Peaks:
    """What is seen of a block that tumbles: its slide is the way of its centre."""
    x, y = s.x - block.x, s.y - block.y
    return Peaks(
        x, y, now.rotation, now.time, now.across, now.tilt, now.yaw,
        larger(before.slide, x * x + y * y),
    )  # fmt: skip


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), throws: wp.array(dtype=Throw),
    motions: wp.array2d(dtype=Motion), pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread."""
    lane, dt, zero, time = wp.tid(), knobs.time_step, real(0.0), real(0.0)
    block = blocks[0, lane]
    own = blocks[0, lane]
    throw = throws[lane]
    tumbles = throw.tumbles == 1
    named = Quaternion(zero, zero, zero, real(1.0))
    box = box_of(block)
    state = start_throw(block, knobs, throw)
    lean = Lean(sign_of(block.centre_x), sign_of(block.centre_y))
    seen = start_lane(block)
    r = turn_of(state)
    along, across, tilt, _yaw = turns_of(block, r.r13, r.r23, r.r33, state.qz, state.qw)
    peaks = start_peaks(along, across, tilt)
    contact = rows(Contact, 4)
    impulse = rows(Impulse, 4)
    gains = rows(Gains, 4)
    base, apart, since = Vector(), Corner(), real(0.0)
    corners, count = int(4), int(0)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until and seen.mode == RUNNING:
            count += 1
            time = real(count) * dt
            half = (real(count) - HALF) * dt
            if tumbles and leans(state.qx, state.qy):
                gx, gy, gw = new_axes(state.qx, state.qy, state.qz, state.qw)
                own = renamed(own, gx, gy)
                box = box_of(own)
                x, y, z, w = after(state.qx, state.qy, state.qz, state.qw, gx, gy, zero, gw)
                state = with_attitude(state, x, y, z, w)
                x, y, z, w = after(named[0], named[1], named[2], named[3], gx, gy, zero, gw)
                named = Quaternion(x, y, z, w)
                for c in range(corners):
                    impulse[c, 0] = Impulse(zero, zero, zero)
                    apart[c] = zero
            now = Vector()
            for d in range(3):
                way = motions[d, lane]
                place = sample_index(way, sample_segment(way, half))
                now[d] = base_velocity(way, half, pool[2, place], pool[0, place], pool[1, place])
            dv = Triple(now[0] - base[0], now[1] - base[1], now[2] - base[2])
            base = now
            p1, p2, p3, p4 = impulse[0, 0], impulse[1, 0], impulse[2, 0], impulse[3, 0]
            since = wp.where(stands(p1, p2, p3, p4), NEVER, smaller(since, time - dt))
            u, j = predict(dv, knobs, inverse_of(box), state)
            was = lean
            lean = find_lean(dv, state, u, was)
            swaps_x, swaps_y = was.x != lean.x, was.y != lean.y
            swap_impulses_if(swaps_x, p1, p2)
            swap_impulses_if(swaps_x, p3, p4)
            swap_impulses_if(swaps_y, p1, p3)
            swap_impulses_if(swaps_y, p2, p4)
            impulse[0, 0] = p1
            impulse[1, 0] = p2
            impulse[2, 0] = p3
            impulse[3, 0] = p4
            swap_if(swaps_x, apart[0], apart[1])
            swap_if(swaps_x, apart[2], apart[3])
            swap_if(swaps_y, apart[0], apart[2])
            swap_if(swaps_y, apart[1], apart[3])
            gaps, reach = Gaps(FAR, zero, zero), box.half_width + box.half_depth + box.half_height
            for c in range(corners):
                at = find_contact(c, knobs, box, lean, state)
                observe_contact(knobs, state.z + at.h, reach, u, impulse[c, 0].n, apart[c], gaps)
                at.aim = bounce(knobs, at, u)
                contact[c, 0] = at
                impulse[c, 0] = impulse_where(at.on > zero, impulse[c, 0])
            plane = find_plane(knobs, box, state, u)
            face = level(plane, Corners(contact[0, 0], contact[1, 0], contact[2, 0], contact[3, 0]))
            held = hold(knobs, box, lean, state, u, face)
            contact[0, 0] = face.a
            contact[1, 0] = face.b
            contact[2, 0] = face.c
            contact[3, 0] = face.d
            impulse[0, 0] = impulse_if(held.fits, held.a, impulse[0, 0])
            impulse[1, 0] = impulse_if(held.fits, held.b, impulse[1, 0])
            impulse[2, 0] = impulse_if(held.fits, held.c, impulse[2, 0])
            impulse[3, 0] = impulse_if(held.fits, held.d, impulse[3, 0])
            u = velocity_if(held.touches, held.after, u)
            if not held.fits:
                solved = solve_in_plane(plane, knobs, box, lean, state, u, face)
                impulse[0, 0] = impulse_if(solved.found, solved.a, impulse[0, 0])
                impulse[1, 0] = impulse_if(solved.found, solved.b, impulse[1, 0])
                impulse[2, 0] = impulse_if(solved.found, solved.c, impulse[2, 0])
                impulse[3, 0] = impulse_if(solved.found, solved.d, impulse[3, 0])
                u = velocity_if(solved.touches, solved.after, u)
                if not solved.found:
                    for c in range(corners):
                        if contact[c, 0].on > zero:
                            gains[c, 0] = warm_start(contact[c, 0], impulse[c, 0], j, u)
                    for sweep in range(knobs.sweeps * corners):
                        c = sweep % corners
                        if contact[c, 0].on > zero:
                            p = impulse[c, 0]
                            solve_contact(own.friction, contact[c, 0], gains[c, 0], j, p, u)
                            impulse[c, 0] = p
            calm(knobs, dv, inverse_of(box), state, u)
            slides = glides(box, knobs, u)
            state = integrate(True, knobs, inverse_of(box), dv, u, gaps.lowest, state, seen.loss)
            observe_contacts(True, time, gaps, slides, since, seen)
            began = as_it_began(state, named)
            mode = mode_after(seen.mode, began)
            before = peaks
            peaks = observe_block(True, time, block, began, before)
            if tumbles:
                peaks = observe_tumbling(block, state, before, peaks)
                mode = wp.where(mode == OVERTURNED, RUNNING, mode)
            seen.mode = mode
        past = wp.where(seen.mode == RUNNING, time - until, zero)
        if found.attitudes.shape[0] > 0:
            began = as_it_began(state, named)
            qx, qy, qz, qw = attitude_at(
                seen.mode == RUNNING, -past, inverse_of(box_of(block)), began
            )
            found.attitudes[sample, 0, 0, lane] = qx
            found.attitudes[sample, 0, 1, lane] = qy
            found.attitudes[sample, 0, 2, lane] = qz
            found.attitudes[sample, 0, 3, lane] = qw
        if found.places.shape[0] > 0:
            spot = place_at(past, state)
            found.places[sample, 0, 0, lane] = spot.x
            found.places[sample, 0, 1, lane] = spot.y
            found.places[sample, 0, 2, lane] = spot.z
    found.results[lane] = seen
    last = as_it_began(state, named)
    found.blocks[0, lane] = block_result(last.qz, last.qw, peaks)
