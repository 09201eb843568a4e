"""Runs of the impulse step over stacks of blocks in space, LANES lanes a thread.

Loops over the lanes are innermost, so that the compiler turns them into vector code; with one lane
a thread the same text is the plain form for any device.

A run begins with one solve from velocities of zero. Its first guess is the weight above each
interface, shared by the contacts; it gives the impulses at rest, or at the release. Velocities
belong to half steps, so the first step starts with those of half a step earlier, -dt/2 times the
settled acceleration.

The slots of an interface are numbered in the order in which its contacts are visited, see
impulse_space/stack.py; where a block leans to another side, they swap. The contacts of an interface
are the first of them that touch, packed to the front of its rows, so that a sweep visits as many
rows as the lane with the most contacts needs.

An interface rocks while a corner of the overlap of its faces does not touch; it lands once one
touches again. A stack moves while an interface rocks or slides, see `slips` in
impulse_space/block.py. It ends when two faces no longer overlap, or a block leans by a right angle
to the vertical or to the block below.
"""

import warp as wp

from warprock.kernels.algebra.vectors import W, X, Y, Z
from warprock.kernels.impulse_space.block import (
    FAR,
    Gains,
    Impulse,
    Knobs,
    Lean,
    Velocity,
    impulse_where,
    predict,
    slips,
    spin_of,
)
from warprock.kernels.impulse_space.block_run import swap_if, swap_impulses_if
from warprock.kernels.impulse_space.stack import (
    CORNERS,
    SETTLED,
    Change,
    Contact,
    Opening,
    Spot,
    add_change,
    find_contact,
    find_edge_spot,
    find_lean,
    find_lower_spot,
    find_upper_spot,
    gains_of,
    integrate,
    mode_after,
    observe_block,
    observe_spot,
    place_between,
    push,
    rise_of,
    slip_between,
    solve_contact,
    support_of,
    turn_between,
)
from warprock.kernels.lane.modes import RUNNING
from warprock.kernels.launch.instance import ONE_VECTOR
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, base_velocity
from warprock.kernels.shape.faces import SLOTS, Faces, mirror_slot
from warprock.kernels.shape.interface import GROUND
from warprock.kernels.shape_space.block import Block, turn_freely
from warprock.kernels.shape_space.block_found import Found, Peaks, Result, block_result
from warprock.kernels.shape_space.lanes import (
    State,
    Symmetric,
    Triple,
    Turn,
    into_base,
    into_body,
    turn_of,
)
from warprock.kernels.shape_space.stack import CONTACTS, UPPER, face_pair

wp.set_module_options(ONE_VECTOR)

SETTLING = 20000
"""Largest number of sweeps of the solve before the run; they end once the impulses converge."""

ROWS = CONTACTS * BLOCKS + 1
"""Rows of contacts. An even number would map all rows of a contact to the same places in the cache,
which takes 1.6 times as long."""
R = wp.types.vector(length=LANES, dtype=real)
"""A number a lane."""
Three = wp.types.matrix(shape=(3, LANES), dtype=real)
Numbers = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=real)
"""A number a body."""
Marks = wp.types.matrix(shape=(SLOTS * BLOCKS, LANES), dtype=real)
"""A number a slot."""
Slots = wp.types.matrix(shape=(CONTACTS * BLOCKS, LANES), dtype=int)
"""The slot of a contact."""
Counts = wp.types.vector(length=BLOCKS + 1, dtype=int)
"""Rows of contacts of an interface that a lane of the thread uses."""
Places = wp.types.vector(length=LANES, dtype=int)


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    pack, _one = wp.tid()
    first, dt, zero, one = pack * LANES, knobs.time_step, real(0.0), real(1.0)
    # Bodies, the ground first.
    state = rows(State, BLOCKS + 1)
    turn = rows(Turn, BLOCKS + 1)
    ease = rows(Symmetric, BLOCKS + 1)
    new = rows(Velocity, BLOCKS + 1)
    lean = rows(Lean, BLOCKS + 1)
    peaks = rows(Peaks, BLOCKS + 1)
    lift = rows(Triple, BLOCKS + 1)
    light, mu, load, there = Numbers(), Numbers(), Numbers(), Numbers()
    # Slots: of one interface its spots, of all of them the impulses of the last step.
    spot = rows(Spot, SLOTS + 1)
    kept = rows(Impulse, SLOTS * BLOCKS + 1)
    apart = Marks()
    # Contacts, CONTACTS rows an interface.
    contact = rows(Contact, ROWS)
    gains = rows(Gains, ROWS)
    impulse = rows(Impulse, ROWS)
    slot = Slots()
    faces = rows(Faces)
    opens = rows(Opening)
    total = rows(Opening)
    shift = rows(Triple)
    change = rows(Change)
    given = rows(Triple)
    seen = rows(Result)
    base, dv, hint, number, busy = Three(), Three(), Three(), Places(), Counts()
    part, going, fastest, flip = R(), R(), R(), Three()
    bodies, directions, slots = int(BLOCKS + 1), int(2), int(SLOTS)  # loops stay
    uppers, edges = int(UPPER), int(12)
    count, running, time = int(-1), int(1), -dt
    for i in range(LANES):
        turn[GROUND, i] = Turn(one, zero, zero, zero, one, zero, zero, zero, one)
        seen[i] = Result(NEVER, zero, zero, zero, 0, RUNNING, 0)
    for k in range(1, bodies):
        for i in range(LANES):
            block = blocks[k - 1, first + i]
            own = State(
                block.x, block.y, block.z, block.qx, block.qy, block.qz, block.qw, zero, zero,
                zero, zero, zero, zero,
            )  # fmt: skip
            state[k, i] = own
            turn[k, i] = turn_of(own)
            light[k, i] = one / block.mass
            mu[k, i] = block.friction
            lean[k, i] = Lean(
                sign_of(block.flat_x + block.centre_x), sign_of(block.flat_y + block.centre_y)
            )
        for low in range(1, k + 1):
            for i in range(LANES):
                load[low, i] = load[low, i] + dt * knobs.gravity * blocks[k - 1, first + i].mass
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while running > 0 and time < until:
            count += 1
            time = real(count) * dt
            half = larger(time - HALF * dt, HALF * dt)
            for i in range(LANES):
                for d in range(3):
                    way = motions[d, first + i]
                    rides = base_velocity(way, half, pool)
                    hint[d, i] = rides - base[d, i]
                    dv[d, i] = wp.where(count > 0, hint[d, i], zero)
                    base[d, i] = wp.where(count > 0, rides, zero)
                shift[i] = Triple(zero, zero, zero)
                total[i] = Opening(zero, zero, -FAR)
                fastest[i] = zero
            for k in range(1, bodies):
                for i in range(LANES):
                    block = blocks[k - 1, first + i]
                    inverse = Triple(block.inverse_x, block.inverse_y, block.inverse_z)
                    jump = Triple(dv[X, i], dv[Y, i], dv[Z, i])
                    free, j = predict(jump, knobs, inverse, state[k, i])
                    new[k, i] = free
                    each = light[k, i]
                    ease[k, i] = Symmetric(
                        each * j.xx, each * j.xy, each * j.xz, each * j.yy, each * j.yz,
                        each * j.zz,
                    )  # fmt: skip
            for k in range(1, bodies):
                low, slot_row, row = k - 1, SLOTS * (k - 1), CONTACTS * (k - 1)
                partial, most = int(0), int(0)
                for i in range(LANES):
                    m = turn_between(turn[k, i], turn[low, i])
                    away = place_between(state[k, i], state[low, i], turn[low, i])
                    starts = Triple(hint[X, i], hint[Y, i], hint[Z, i])
                    was = lean[k, i]
                    now = find_lean(m, turn[low, i], new[k, i], new[low, i], starts, was)
                    flip[X, i] = wp.where(was.x != now.x, one, zero)
                    flip[Y, i] = wp.where(was.y != now.y, one, zero)
                    lean[k, i] = now
                    below = support_of(blocks[wp.max(k - 2, 0), first + i], k)
                    faces[i] = face_pair(blocks[k - 1, first + i], below, m, away, now.x, now.y)
                    opens[i] = Opening(zero, zero, -FAR)
                    there[k, i] = zero
                    number[i] = 0
                # Slots swap where a block leans to another side.
                for d in range(directions):
                    flips = int(0)
                    for i in range(LANES):
                        flips += wp.where(flip[d, i] > zero, 1, 0)
                    for s in range(wp.where(flips > 0, slots, 0)):
                        t = mirror_slot(s, 1 - d, d)
                        if t > s:
                            for i in range(LANES):
                                swaps = flip[d, i] > zero
                                p, q = kept[slot_row + s, i], kept[slot_row + t, i]
                                swap_impulses_if(swaps, p, q)
                                kept[slot_row + s, i] = p
                                kept[slot_row + t, i] = q
                                swap_if(swaps, apart[slot_row + s, i], apart[slot_row + t, i])
                for s in range(uppers):
                    for i in range(LANES):
                        spot[s, i] = find_upper_spot(s, faces[i], knobs, there[k, i])
                for i in range(LANES):
                    part[i] = wp.where(there[k, i] < CORNERS, one, zero)
                    partial += wp.where(part[i] > zero, 1, 0)
                visits = wp.where(partial > 0, slots, uppers)
                for s in range(uppers, visits):
                    if s < edges:
                        for i in range(LANES):
                            spot[s, i] = find_edge_spot(s, part[i], faces[i], knobs, there[k, i])
                    else:
                        for i in range(LANES):
                            spot[s, i] = find_lower_spot(s, part[i], faces[i], knobs, there[k, i])
                for s in range(visits):
                    for i in range(LANES):
                        gap_seen = opens[i]
                        observe_spot(spot[s, i], knobs, apart[slot_row + s, i], gap_seen)
                        opens[i] = gap_seen
                for s in range(visits, slots):
                    for i in range(LANES):
                        apart[slot_row + s, i] = zero
                # Contacts to the front. The place depends on the lane: no vector code.
                for i in range(LANES):
                    n = int(0)
                    for s in range(visits):
                        if spot[s, i].on > zero and n < CONTACTS:
                            slot[row + n, i] = s
                            n += 1
                    number[i] = n
                    most = wp.max(most, n)
                busy[k] = most
                for n in range(most):
                    for i in range(LANES):
                        on = n < number[i]
                        s = wp.where(on, slot[row + n, i], 0)
                        place_there = spot[s, i]
                        below = support_of(blocks[wp.max(k - 2, 0), first + i], k)
                        contact[row + n, i] = find_contact(
                            on,
                            place_there,
                            lean[k, i],
                            below,
                            turn[low, i],
                            state[k, i],
                            state[low, i],
                        )
                        p = kept[slot_row + s, i]
                        p.n = wp.where(count > 0, p.n, load[k, i] / real(wp.max(number[i], 1)))
                        impulse[row + n, i] = impulse_where(on, p)
                for i in range(LANES):
                    raised = shift[i]
                    all_seen = total[i]
                    rise_of(knobs, opens[i], turn[low, i], raised, all_seen)
                    shift[i] = raised
                    total[i] = all_seen
                    lift[k, i] = raised
            for k in range(1, bodies):
                low, row = k - 1, CONTACTS * (k - 1)
                for n in range(busy[k]):
                    c = row + n
                    for i in range(LANES):
                        gains[c, i] = gains_of(
                            light[k, i] + light[low, i], turn[low, i], ease[k, i], ease[low, i],
                            contact[c, i],
                        )  # fmt: skip
                        p = impulse[c, i]
                        more = into_base(turn[low, i], Triple(p.fx, p.fy, p.n))
                        less = Triple(-more.x, -more.y, -more.z)
                        u = new[k, i]
                        lower = new[low, i]
                        push(
                            light[k, i], ease[k, i], contact[c, i].ux, contact[c, i].uy,
                            contact[c, i].uz, more, u,
                        )  # fmt: skip
                        push(
                            light[low, i], ease[low, i], contact[c, i].lx, contact[c, i].ly,
                            contact[c, i].lz, less, lower,
                        )  # fmt: skip
                        new[k, i] = u
                        new[low, i] = lower
            for i in range(LANES):
                going[i] = one
            step, sweeping = int(0), int(1)
            sweeps = wp.where(count > 0, knobs.sweeps, SETTLING)
            while sweeping > 0 and step < sweeps:
                step += 1
                for i in range(LANES):
                    change[i] = Change(zero, zero)
                for k in range(1, bodies):
                    low, row = k - 1, CONTACTS * (k - 1)
                    for n in range(busy[k]):
                        c = row + n
                        for i in range(LANES):
                            slip = slip_between(contact[c, i], new[k, i], new[low, i])
                            p = solve_contact(
                                mu[k, i], knobs.rate, contact[c, i], gains[c, i], turn[low, i],
                                impulse[c, i], slip,
                            )  # fmt: skip
                            works = contact[c, i].on * going[i]
                            dx = wp.where(works > zero, p.fx - impulse[c, i].fx, zero)
                            dy = wp.where(works > zero, p.fy - impulse[c, i].fy, zero)
                            dz = wp.where(works > zero, p.n - impulse[c, i].n, zero)
                            impulse[c, i].fx = wp.where(works > zero, p.fx, impulse[c, i].fx)
                            impulse[c, i].fy = wp.where(works > zero, p.fy, impulse[c, i].fy)
                            impulse[c, i].n = wp.where(works > zero, p.n, impulse[c, i].n)
                            more = into_base(turn[low, i], Triple(dx, dy, dz))
                            sums = change[i]
                            add_change(more, impulse[c, i], sums)
                            change[i] = sums
                            u = new[k, i]
                            push(
                                light[k, i], ease[k, i], contact[c, i].ux, contact[c, i].uy,
                                contact[c, i].uz, more, u,
                            )  # fmt: skip
                            new[k, i] = u
                            given[i] = Triple(-more.x, -more.y, -more.z)
                        # Nothing moves the ground.
                        for i in range(wp.where(k > 1, LANES, 0)):
                            lower = new[low, i]
                            push(
                                light[low, i], ease[low, i], contact[c, i].lx, contact[c, i].ly,
                                contact[c, i].lz, given[i], lower,
                            )  # fmt: skip
                            new[low, i] = lower
                sweeping = int(0)
                for i in range(LANES):
                    settles = change[i].change <= SETTLED * SETTLED * change[i].size
                    going[i] = wp.where(settles, zero, going[i])
                    sweeping += wp.where(going[i] > zero, 1, 0)
            for k in range(1, bodies):
                low, slot_row, row = k - 1, SLOTS * (k - 1), CONTACTS * (k - 1)
                for s in range(slots):
                    for i in range(LANES):
                        kept[slot_row + s, i] = Impulse(zero, zero, zero)
                for n in range(busy[k]):
                    for i in range(LANES):
                        if contact[row + n, i].on > zero:
                            kept[slot_row + slot[row + n, i], i] = impulse[row + n, i]
                for n in range(busy[k]):
                    for i in range(LANES):
                        slip = slip_between(contact[row + n, i], new[k, i], new[low, i])
                        along = into_body(turn[low, i], slip)
                        sped = contact[row + n, i].on * dot(along.x, along.y, along.x, along.y)
                        fastest[i] = larger(fastest[i], sped)
            running = int(0)
            for i in range(LANES):
                going[i] = wp.where(seen[i].mode == RUNNING, one, zero)
            for k in range(1, bodies):
                low = k - 1
                for i in range(LANES):
                    live = going[i] > zero
                    block = blocks[k - 1, first + i]
                    jump = Triple(dv[X, i], dv[Y, i], dv[Z, i])
                    inverse = Triple(block.inverse_x, block.inverse_y, block.inverse_z)
                    own, took = integrate(
                        count == 0, dt, knobs.gravity, inverse, jump, state[k, i], new[k, i],
                        lift[k, i],
                    )  # fmt: skip
                    state[k, i] = wp.where(live, own, state[k, i])
                    turn[k, i] = turn_of(state[k, i])
                    lost = seen[i].loss + block.mass * took
                    seen[i].loss = wp.where(live, lost, seen[i].loss)
                    m = turn_between(turn[k, i], turn[low, i])
                    away = place_between(state[k, i], state[low, i], turn[low, i])
                    peaks[k, i] = observe_block(
                        live, time, block, state[k, i], m, away, peaks[k, i]
                    )
                    mode = mode_after(seen[i].mode, there[k, i], state[k, i], turn[k, i].r33, m.r33)
                    seen[i].mode = wp.where(live, mode, seen[i].mode)
            for i in range(LANES):
                live, lifts = going[i] > zero, total[i].lifted > zero
                moves = lifts or (count > 0 and slips(fastest[i], knobs))
                steps, lands = wp.where(count > 0, 1, 0), wp.where(total[i].landed > zero, 1, 0)
                seen[i].steps = seen[i].steps + wp.where(live, steps, 0)
                seen[i].impacts = seen[i].impacts + wp.where(live, lands, 0)
                seen[i].moved = wp.where(live and moves, time, seen[i].moved)
                first_lift = smaller(seen[i].uplift_time, time)
                seen[i].uplift_time = wp.where(live and lifts, first_lift, seen[i].uplift_time)
                deepest = larger(seen[i].deepest, total[i].deep)
                seen[i].deepest = wp.where(live, deepest, seen[i].deepest)
                running += wp.where(seen[i].mode == RUNNING, 1, 0)
        for k in range(1, wp.where(found.attitudes.shape[0] > 0, bodies, 0)):
            for i in range(LANES):
                past = wp.where(seen[i].mode == RUNNING, smaller(until - time, zero), zero)
                block = blocks[k - 1, first + i]
                own = state[k, i]
                inverse = Triple(block.inverse_x, block.inverse_y, block.inverse_z)
                spin = spin_of(own)
                qx, qy, qz, qw = turn_freely(own.qx, own.qy, own.qz, own.qw, spin, inverse, past)
                found.attitudes[sample, k - 1, X, first + i] = qx
                found.attitudes[sample, k - 1, Y, first + i] = qy
                found.attitudes[sample, k - 1, Z, first + i] = qz
                found.attitudes[sample, k - 1, W, first + i] = qw
        for k in range(1, wp.where(found.places.shape[0] > 0, bodies, 0)):
            for i in range(LANES):
                past = wp.where(seen[i].mode == RUNNING, smaller(until - time, zero), zero)
                own = state[k, i]
                found.places[sample, k - 1, X, first + i] = own.x + past * own.vx
                found.places[sample, k - 1, Y, first + i] = own.y + past * own.vy
                found.places[sample, k - 1, Z, first + i] = own.z + past * own.vz
    for i in range(LANES):
        found.results[first + i] = seen[i]
    for k in range(1, bodies):
        for i in range(LANES):
            found.blocks[k - 1, first + i] = block_result(
                state[k, i].qz, state[k, i].qw, peaks[k, i]
            )
