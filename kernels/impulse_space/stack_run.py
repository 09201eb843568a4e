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
    Contact,
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
    Foot,
    Gains,
    Mobility,
    Opening,
    Spot,
    Wrench,
    add_impulse,
    add_motion,
    directions_of,
    find_contact,
    find_edge_spot,
    find_foot,
    find_lean,
    find_lower_spot,
    find_upper_spot,
    gains_of,
    ground_under,
    integrate,
    inverse_of,
    mobility_of,
    mode_after,
    moment_of,
    motion_between,
    normal_of,
    observe_block,
    observe_spot,
    place_between,
    push_lower,
    push_upper,
    rise_of,
    slip_of,
    solve_contact,
    square_of,
    turn_between,
    turn_yield,
    yield_of,
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

LOWEST = GROUND + 1
"""Number of the lowest block."""

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
Slots = wp.types.matrix(shape=(CONTACTS * BLOCKS + 1, LANES), dtype=int)
"""The slot of a contact."""
Order = wp.types.vector(length=SLOTS + 1, dtype=int)
"""Slots that some lane of the thread touches."""
Counts = wp.types.vector(length=BLOCKS + 1, dtype=int)
"""Rows of contacts of an interface that a lane of the thread uses."""
Places = wp.types.vector(length=LANES, dtype=int)
Skewed = wp.types.vector(length=ROWS, dtype=int)
"""Lanes of the thread in which a contact has directions of its own."""


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    pack, _one = wp.tid()
    first, dt, zero, one = pack * LANES, knobs.time_step, real(0.0), real(1.0)
    # Bodies, the ground first.
    block = rows(Block, BLOCKS + 1)
    state = rows(State, BLOCKS + 1)
    turn = rows(Turn, BLOCKS + 1)
    ease = rows(Symmetric, BLOCKS + 1)
    new = rows(Velocity, BLOCKS + 1)
    lean = rows(Lean, BLOCKS + 1)
    peaks = rows(Peaks, BLOCKS + 1)
    lift = rows(Triple, BLOCKS + 1)
    foot = rows(Foot, BLOCKS + 1)
    light, load, there = Numbers(), Numbers(), Numbers()
    # Slots: of one interface its spots, of all of them the impulses of the last step.
    spot = rows(Spot, SLOTS + 1)
    kept = rows(Impulse, SLOTS * BLOCKS + 1)
    apart = Marks()
    # Contacts, CONTACTS rows an interface.
    contact = rows(Contact, ROWS)
    gains = rows(Gains, ROWS)
    impulse = rows(Impulse, ROWS)
    ways = rows(Turn, ROWS)
    slot = Slots()
    slip = rows(Triple)
    more = rows(Triple)
    normal = rows(Triple)
    between = rows(Turn)
    faces = rows(Faces)
    opens = rows(Opening)
    total = rows(Opening)
    shift = rows(Triple)
    mobility = rows(Mobility, BLOCKS + 1)
    moving = rows(Velocity)
    given = rows(Wrench)
    seen = rows(Result)
    base, dv, hint, number, busy, change = Three(), Three(), Three(), Places(), Counts(), R()
    skewed = Skewed()
    part, going, fastest, flip = R(), R(), R(), Three()
    bodies, directions, slots = int(BLOCKS + 1), int(2), int(SLOTS)  # loops stay
    uppers, edges, spare, order = int(UPPER), int(12), int(SLOTS * BLOCKS), Order()
    count, running, time = int(-1), int(1), -dt
    for i in range(LANES):
        turn[GROUND, i] = Turn(one, zero, zero, zero, one, zero, zero, zero, one)
        seen[i] = Result(NEVER, zero, zero, zero, 0, RUNNING, 0)
    for k in range(1, bodies):
        for i in range(LANES):
            placed = blocks[k - 1, first + i]
            own = State(
                placed.x, placed.y, placed.z, placed.qx, placed.qy, placed.qz, placed.qw, zero,
                zero, zero, zero, zero, zero,
            )  # fmt: skip
            block[k, i] = placed
            state[k, i] = own
            turn[k, i] = turn_of(own)
            light[k, i] = one / placed.mass
            lean[k, i] = Lean(
                sign_of(placed.flat_x + placed.centre_x), sign_of(placed.flat_y + placed.centre_y)
            )
        for low in range(1, k + 1):
            for i in range(LANES):
                load[low, i] = load[low, i] + dt * knobs.gravity * block[k, i].mass
    for i in range(LANES):
        block[GROUND, i] = ground_under(block[LOWEST, i])
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while running > 0 and time < until:
            count += 1
            time = real(count) * dt
            half = larger(time - HALF * dt, HALF * dt)
            for d in range(3):
                if (knobs.moves >> d) % 2 == 1:
                    for i in range(LANES):
                        rides = base_velocity(motions[d, first + i], half, pool)
                        hint[d, i] = rides - base[d, i]
                        dv[d, i] = wp.where(count > 0, hint[d, i], zero)
                        base[d, i] = wp.where(count > 0, rides, zero)
            for i in range(LANES):
                shift[i] = Triple(zero, zero, zero)
                total[i] = Opening(zero, zero, -FAR)
                fastest[i] = zero
            for k in range(1, bodies):
                for i in range(LANES):
                    jump = Triple(dv[X, i], dv[Y, i], dv[Z, i])
                    free, j = predict(jump, knobs, inverse_of(block[k, i]), state[k, i])
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
                    between[i] = m
                    away = place_between(state[k, i], state[low, i], turn[low, i])
                    starts = Triple(hint[X, i], hint[Y, i], hint[Z, i])
                    was = lean[k, i]
                    now = find_lean(m, turn[low, i], new[k, i], new[low, i], starts, was)
                    flip[X, i] = wp.where(was.x != now.x, one, zero)
                    flip[Y, i] = wp.where(was.y != now.y, one, zero)
                    lean[k, i] = now
                    faces[i] = face_pair(block[k, i], block[low, i], m, away, now.x, now.y)
                    foot[k, i] = find_foot(away, block[low, i].half_height)
                    mobility[k, i] = mobility_of(
                        light[k, i], light[low, i], m, inverse_of(block[k, i]),
                        inverse_of(block[low, i]), foot[k, i],
                    )  # fmt: skip
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
                # Contacts to the front. If one lane touches all slots that any lane touches, whole
                # rows move; else each lane's own do, which is no vector code. There a slot that is
                # no contact is written over by the next one, without branches.
                union = int(0)
                for s in range(visits):
                    those = int(0)
                    for i in range(LANES):
                        number[i] = number[i] + int(spot[s, i].on)
                        those += int(spot[s, i].on)
                    order[union] = s
                    union += wp.where(those > 0, 1, 0)
                for i in range(LANES):
                    most = wp.max(most, number[i])
                most = wp.min(most, CONTACTS)
                if union > most:
                    for i in range(LANES):
                        n = int(0)
                        for s in range(visits):
                            slot[row + n, i] = s
                            n = wp.min(n + int(spot[s, i].on), CONTACTS)
                    for n in range(most):
                        for i in range(LANES):
                            on = n < number[i]
                            s = wp.where(on, slot[row + n, i], 0)
                            p = kept[slot_row + s, i]
                            impulse[row + n, i] = impulse_where(on, p)
                            here = spot[s, i]
                            here.on = wp.where(on, one, zero)
                            spot[n, i] = here
                else:
                    for n in range(most):
                        s = order[n]
                        for i in range(LANES):
                            p = kept[slot_row + s, i]
                            here = spot[s, i]
                            slot[row + n, i] = s
                            impulse[row + n, i] = impulse_where(here.on > zero, p)
                            spot[n, i] = here
                busy[k] = most
                for n in range(most):
                    skewed[row + n] = 0
                    for i in range(LANES):
                        p = impulse[row + n, i]
                        p.n = wp.where(count > 0, p.n, load[k, i] / real(wp.max(number[i], 1)))
                        impulse[row + n, i] = impulse_where(spot[n, i].on > zero, p)
                        contact[row + n, i] = find_contact(
                            spot[n, i], lean[k, i], block[low, i], foot[k, i], knobs
                        )
                        at_rest = yield_of(mobility[k, i], contact[row + n, i])
                        gains[row + n, i] = gains_of(at_rest, contact[row + n, i].on)
                for n in range(wp.where(partial > 0, most, 0)):
                    those = int(0)
                    for i in range(LANES):
                        at = normal_of(slot[row + n, i], spot[n, i], between[i], faces[i])
                        normal[i] = at
                        those += wp.where(size(at.x) + size(at.y) > zero, 1, 0)
                    skewed[row + n] = those
                    if those > 0:
                        for i in range(LANES):
                            e = directions_of(normal[i])
                            ways[row + n, i] = e
                            flat = yield_of(mobility[k, i], contact[row + n, i])
                            at_rest = turn_yield(flat, e)
                            gains[row + n, i] = gains_of(at_rest, contact[row + n, i].on)
                for i in range(LANES):
                    raised = shift[i]
                    all_seen = total[i]
                    rise_of(knobs, opens[i], turn[low, i], raised, all_seen)
                    shift[i] = raised
                    total[i] = all_seen
                    lift[k, i] = raised
            for k in range(1, bodies):
                low, row = k - 1, CONTACTS * (k - 1)
                for i in range(LANES):
                    given[i] = Wrench(zero, zero, zero, zero, zero, zero)
                for n in range(busy[k]):
                    c = row + n
                    for i in range(LANES):
                        more[i] = Triple(impulse[c, i].fx, impulse[c, i].fy, impulse[c, i].n)
                    if skewed[c] > 0:
                        for i in range(LANES):
                            more[i] = into_base(ways[c, i], more[i])
                    for i in range(LANES):
                        sum = given[i]
                        add_impulse(more[i], moment_of(contact[c, i], more[i]), sum)
                        given[i] = sum
                for i in range(LANES):
                    u = new[k, i]
                    push_upper(light[k, i], ease[k, i], foot[k, i], turn[low, i], given[i], u)
                    new[k, i] = u
                # Nothing moves the ground.
                for i in range(wp.where(k > 1, LANES, 0)):
                    lower = new[low, i]
                    push_lower(
                        light[low, i], ease[low, i], foot[k, i], turn[low, i], given[i], lower
                    )
                    new[low, i] = lower
            for i in range(LANES):
                going[i] = one
            step, sweeping = int(0), int(1)
            sweeps = wp.where(count > 0, knobs.sweeps, SETTLING)
            while sweeping > 0 and step < sweeps:
                step += 1
                for i in range(LANES):
                    change[i] = zero
                for k in range(1, bodies):
                    low, row = k - 1, CONTACTS * (k - 1)
                    for i in range(LANES):
                        moving[i] = motion_between(foot[k, i], turn[low, i], new[k, i], new[low, i])
                        given[i] = Wrench(zero, zero, zero, zero, zero, zero)
                    for n in range(busy[k]):
                        c = row + n
                        for i in range(LANES):
                            slip[i] = slip_of(contact[c, i], moving[i])
                        if skewed[c] > 0:
                            for i in range(LANES):
                                slip[i] = into_body(ways[c, i], slip[i])
                        for i in range(LANES):
                            p = solve_contact(
                                block[k, i].friction,
                                contact[c, i],
                                gains[c, i],
                                impulse[c, i],
                                slip[i],
                            )
                            works = going[i] > zero
                            dx = wp.where(works, p.fx - impulse[c, i].fx, zero)
                            dy = wp.where(works, p.fy - impulse[c, i].fy, zero)
                            dz = wp.where(works, p.n - impulse[c, i].n, zero)
                            impulse[c, i] = wp.where(works, p, impulse[c, i])
                            more[i] = Triple(dx, dy, dz)
                        if skewed[c] > 0:
                            for i in range(LANES):
                                more[i] = into_base(ways[c, i], more[i])
                        for i in range(LANES):
                            moment = moment_of(contact[c, i], more[i])
                            sum, v = given[i], moving[i]
                            add_impulse(more[i], moment, sum)
                            add_motion(mobility[k, i], more[i], moment, v)
                            given[i] = sum
                            moving[i] = v
                    for i in range(LANES):
                        u = new[k, i]
                        push_upper(light[k, i], ease[k, i], foot[k, i], turn[low, i], given[i], u)
                        new[k, i] = u
                        change[i] = change[i] + square_of(given[i], foot[k, i])
                    # Nothing moves the ground.
                    for i in range(wp.where(k > 1, LANES, 0)):
                        lower = new[low, i]
                        push_lower(
                            light[low, i], ease[low, i], foot[k, i], turn[low, i], given[i], lower
                        )
                        new[low, i] = lower
                sweeping = int(0)
                for i in range(LANES):
                    least = SETTLED * load[LOWEST, i]
                    going[i] = wp.where(change[i] <= least * least, zero, going[i])
                    sweeping += wp.where(going[i] > zero, 1, 0)
            for k in range(1, bodies):
                low, slot_row, row = k - 1, SLOTS * (k - 1), CONTACTS * (k - 1)
                for s in range(slots):
                    for i in range(LANES):
                        kept[slot_row + s, i] = Impulse(zero, zero, zero)
                for n in range(busy[k]):
                    for i in range(LANES):
                        touches = contact[row + n, i].on > zero
                        s = wp.where(touches, slot_row + slot[row + n, i], spare)
                        kept[s, i] = impulse[row + n, i]
                for i in range(LANES):
                    moving[i] = motion_between(foot[k, i], turn[low, i], new[k, i], new[low, i])
                for n in range(busy[k]):
                    for i in range(LANES):
                        slip[i] = slip_of(contact[row + n, i], moving[i])
                    if skewed[row + n] > 0:
                        for i in range(LANES):
                            slip[i] = into_body(ways[row + n, i], slip[i])
                    for i in range(LANES):
                        sped = dot(slip[i].x, slip[i].y, slip[i].x, slip[i].y)
                        fastest[i] = larger(fastest[i], contact[row + n, i].on * sped)
            running = int(0)
            for i in range(LANES):
                going[i] = wp.where(seen[i].mode == RUNNING, one, zero)
            for k in range(1, bodies):
                low = k - 1
                for i in range(LANES):
                    live = going[i] > zero
                    jump = Triple(dv[X, i], dv[Y, i], dv[Z, i])
                    own, took = integrate(
                        count == 0, dt, knobs.gravity, inverse_of(block[k, i]), jump, state[k, i],
                        new[k, i], lift[k, i],
                    )  # fmt: skip
                    state[k, i] = wp.where(live, own, state[k, i])
                    turn[k, i] = turn_of(state[k, i])
                    lost = seen[i].loss + block[k, i].mass * took
                    seen[i].loss = wp.where(live, lost, seen[i].loss)
                    m = turn_between(turn[k, i], turn[low, i])
                    away = place_between(state[k, i], state[low, i], turn[low, i])
                    peaks[k, i] = observe_block(
                        live, time, block[k, i], state[k, i], m, away, peaks[k, i]
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
                own, inverse = state[k, i], inverse_of(block[k, i])
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
