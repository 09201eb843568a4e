"""Runs of assemblies of blocks with dry joints, LANES lanes a thread side by side.

The lanes of a pack have the same joints between the same blocks, of whatever sizes; `graph` says
which, two rows a contact. Every lane has a clock of its own: one whose step is settled waits until
enough others do (`PATIENCE`), and then they begin their next steps together, while the sweeps of
the rest go on. So a pack does not wait for its slowest lane, and no lane depends on its neighbours.

A run begins with SETTLING solves at the start, from velocities of zero. With one lane a thread the
same text is the plain form. Matrices with a row a contact have an odd number of rows, POINTS: at a
multiple of 4096 bytes all of them would lie on the same lines of the cache, three times slower.

If SPRINGS is true contacts are springs (spring.py), whose forces are known where a step begins: all
lanes of a pack begin it together, and there are no sweeps.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, UPWARDS
from warprock.kernels.assembly.block import (
    Block,
    Peak,
    Pull,
    Seen,
    Track,
    add_energy,
    integrate,
    last_mode,
    length_of,
    observe_block,
    observe_gap,
    observe_off,
    observe_slide,
    start_seen,
)
from warprock.kernels.assembly.found import (
    DRIFT,
    FIRST,
    ROOM,
    SAME,
    SETTLING,
    BlockResult,
    Clock,
    ContactResult,
    Found,
    Knobs,
    Result,
)
from warprock.kernels.assembly.joint import (
    Contact,
    Edges,
    Impulse,
    find_contact,
    opening_speed,
    push,
    sliding_speed,
)
from warprock.kernels.assembly.landing import (
    FAST,
    LANDS,
    LEAVES,
    STILL,
    STRIKES,
    Borne,
    comes_down,
    landing_part,
    leaves_by,
    may_land,
)
from warprock.kernels.assembly.meeting import (
    BLOCK_COUNT,
    JOINT_COUNT,
    NONE,
    SLIP,
    Laid,
    Near,
    blocks_of,
    find_free,
    is_old,
    list_pairs,
    look_out,
    observe_free,
)
from warprock.kernels.assembly.solve import (
    Leap,
    Solve,
    Trail,
    Way,
    decide,
    drift_after,
    extrapolate,
    start_solve,
    sweep_contact,
)
from warprock.kernels.contact.parting import slack
from warprock.kernels.lane.account import Account, keep_account
from warprock.kernels.lane.modes import RUNNING, STALLED, UNSOLVED
from warprock.kernels.launch.instance import ONE_VECTOR
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, base_velocity
from warprock.kernels.shape.interface import Mass, Pose, Velocity

if BONDS:
    from warprock.kernels.assembly.bond import Bond, Breaks, after_break, is_torn
if TREES:
    from warprock.kernels.assembly.tree import (
        Node,
        add_contact,
        aim,
        change_of,
        eliminate,
        leap_to,
        limit_share,
        start_node,
        substitute,
    )
if SPRINGS:
    from warprock.kernels.assembly.spring import Pace, Spring, Store, press

wp.set_module_options(ONE_VECTOR)

TREE = 2 + 2 * (POINTS // 2)
"""Where the tree of a pack stands in its row of `graph`: how many blocks it has."""
NODES = TREE + 1
"""Where each block of the tree and its parent stand there, from the leaves to the roots."""
CHILDREN = NODES + 2 * BLOCKS
"""Where the place of the child of each joint stands there (`add_contact`)."""

PATIENCE = 2
"""Sweeps that lanes lose, over the lanes that run, until those that wait begin their next steps:
about what beginning costs all of them."""


@wp.func
def node_of(laid: Laid, pack: int, number: int):
    """A block of the tree and its parent, from the leaves to the roots."""
    at = NODES + 2 * number
    return int(laid.graph[pack, at]), int(laid.graph[pack, at + 1])


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), joints: wp.array2d(dtype=Edges), laid: Laid,
    motions: wp.array(dtype=Motion), pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread.

    `laid` says which blocks touch, see meeting.py.
    """
    pack, _one = wp.tid()
    first, dt = pack * LANES, real(knobs.time_steps[pack])
    rate = real(1.0) / dt
    block_count = int(laid.graph[pack, BLOCK_COUNT])
    contact_count = 2 * int(laid.graph[pack, JOINT_COUNT])
    samples = sample_times.shape[0]
    end = sample_times[samples - 1]
    mass = rows(Mass, BLOCKS)
    pose = rows(Pose, BLOCKS)
    old = rows(Velocity, BLOCKS)
    new = rows(Velocity, BLOCKS)
    trail = rows(Trail, BLOCKS)
    peak = rows(Peak, BLOCKS)
    contact = rows(Contact, POINTS)
    impulse = rows(Impulse, POINTS)
    way = rows(Way, POINTS)
    track = rows(Track, POINTS)
    clock = rows(Clock)
    solve = rows(Solve)
    pull = rows(Pull)
    account = rows(Account)
    seen = rows(Seen)
    near = rows(Near)
    borne = rows(Borne, POINTS)
    weighs = knobs.gravity * dt
    if TREES:
        node = rows(Node, BLOCKS)
        leap = rows(Leap)
        node_count = int(laid.graph[pack, TREE])
    if SPRINGS:
        spring = rows(Spring, POINTS)
        store = rows(Store)
    if BONDS:
        bond = rows(Bond, POINTS)
        breaks = rows(Breaks)
    for i in range(LANES):
        seen[i] = start_seen()
        seen[i].mode = wp.where(laid.spare[first + i] > 0, STALLED, RUNNING)
        near[i].pairs = NONE
        clock[i].count = -SETTLING - 1
    for k in range(block_count):
        for i in range(LANES):
            block = blocks[k, first + i]
            mass[k, i] = Mass(block.inverse_mass, block.inverse_inertia)
            turn = real(block.theta)
            pose[k, i] = Pose(block.x, block.z, turn, sine(turn), cosine(turn))
    for q in range(contact_count):
        for i in range(LANES):
            track[q, i].since = NEVER
            if BONDS:
                bond[q // 2, i].holds = wp.where(
                    joints[q // 2, first + i].tension > real(0.0), 1, 0
                )
                breaks[i].first = NEVER
            if SPRINGS:
                edges = joints[q // 2, first + i]
                spring[q, i].u = wp.where(q % 2 == 0, edges.first, edges.second)
    lost, busy, crowded = int(0), int(1), int(0)
    striking, landing = int(0), int(0)
    while busy > 0:
        busy, waiting = int(0), int(0)
        for i in range(LANES):
            time = real(clock[i].count) * dt
            last = smaller(end, seen[i].collapse_time + knobs.after_collapse)
            runs = wp.where(seen[i].mode == RUNNING and time < last, 1, 0)
            waits = wp.where(solve[i].on > real(0.0), 0, runs)
            clock[i].goes = waits
            busy = busy + runs
            waiting = waiting + waits
        if striking > 0:
            striking, landing, waiting = int(0), int(0), int(0)
            for i in range(LANES):
                lands = clock[i].goes > 0 and clock[i].phase > 0 and clock[i].phase < LEAVES
                clock[i].strikes = wp.where(lands, 1, 0)
                clock[i].goes = wp.where(lands, 0, clock[i].goes)
                waiting = waiting + clock[i].goes
                landing = landing + clock[i].strikes
                striking = striking + clock[i].phase
        lost = lost + waiting
        if landing > 0:
            # The next solve of a step in which a corner lands, see landing.py.
            landing = int(0)
            for i in range(LANES):
                clock[i].phase = clock[i].phase + clock[i].strikes
                clock[i].lands = wp.where(clock[i].strikes > 0, 0, clock[i].lands)
            for q in range(contact_count):
                a, b = blocks_of(laid, pack, q // 2)
                for i in range(LANES):
                    opening = opening_speed(contact[q, i], new[a, i], new[b, i])
                    lands = clock[i].strikes > 0 and contact[q, i].wn == real(0.0)
                    lands = lands and comes_down(weighs, contact[q, i].b, opening)
                    clock[i].lands = wp.where(lands, 1, clock[i].lands)
            for q in range(contact_count):
                a, b = blocks_of(laid, pack, q // 2)
                for i in range(LANES):
                    zero = real(0.0)
                    hits = clock[i].strikes > 0 and clock[i].phase == STRIKES
                    leaves = clock[i].strikes > 0 and clock[i].phase == LEAVES
                    va = new[a, i]
                    vb = new[b, i]
                    opening = opening_speed(contact[q, i], va, vb)
                    leaves = leaves and leaves_by(weighs, borne[q, i], impulse[q, i], opening)
                    part = wp.where(leaves, clock[i].part - HALF, zero)
                    n, t = part * borne[q, i].n, part * borne[q, i].t
                    push(contact[q, i], n, t, mass[a, i], mass[b, i], va, vb)
                    new[a, i] = va
                    new[b, i] = vb
                    borne[q, i].n = wp.where(leaves, zero, borne[q, i].n)
                    borne[q, i].t = wp.where(leaves, zero, borne[q, i].t)
                    borne[q, i].n = wp.where(hits, impulse[q, i].n, borne[q, i].n)
                    borne[q, i].t = wp.where(hits, impulse[q, i].t, borne[q, i].t)
                    impulse[q, i].n = wp.where(hits, zero, impulse[q, i].n)
                    impulse[q, i].t = wp.where(hits, zero, impulse[q, i].t)
                    hits = hits and clock[i].lands > 0
                    contact[q, i].wn = wp.where(
                        hits, real(1.0) / contact[q, i].kn, contact[q, i].wn
                    )
                    contact[q, i].wt = wp.where(
                        hits, real(1.0) / contact[q, i].kt, contact[q, i].wt
                    )
                    way[q, i] = wp.where(clock[i].strikes > 0, Way(), way[q, i])
            for k in range(block_count):
                for i in range(LANES):
                    zero = real(0.0)
                    v = new[k, i]
                    trail[k, i] = wp.where(
                        clock[i].strikes > 0, Trail(zero, zero, zero, v.x, v.z, v.omega),
                        trail[k, i],
                    )  # fmt: skip
            for i in range(LANES):
                strikes = clock[i].strikes > 0
                seen[i].sweeps = seen[i].sweeps + clock[i].strikes * solve[i].sweeps
                left = larger(solve[i].left, seen[i].residual)
                seen[i].residual = wp.where(strikes, left, seen[i].residual)
                drift = drift_after(dt, solve[i], clock[i].drift)
                clock[i].drift = wp.where(strikes, drift, clock[i].drift)
                again = start_solve(real(1.0), knobs.settled, real(0.0))
                again.loose = solve[i].loose
                solve[i] = wp.where(strikes, again, solve[i])
        if busy > 0 and (waiting == busy or lost > PATIENCE * busy):
            lost, gliding = int(0), int(0)
            if striking > 0:
                for q in range(contact_count):
                    for i in range(LANES):
                        adds = clock[i].goes > 0 and clock[i].phase > LANDS
                        n, t = impulse[q, i].n + borne[q, i].n, impulse[q, i].t + borne[q, i].t
                        impulse[q, i].n = wp.where(adds, n, impulse[q, i].n)
                        impulse[q, i].t = wp.where(adds, t, impulse[q, i].t)
                for i in range(LANES):
                    clock[i].phase = wp.where(clock[i].goes > 0, 0, clock[i].phase)
            for i in range(LANES):
                begins = clock[i].goes
                started = wp.where(clock[i].count < -SETTLING, 0, begins)
                misses = solve[i].left > solve[i].loose
                drift = drift_after(dt, solve[i], clock[i].drift)
                clock[i].drift = wp.where(started > 0, drift, clock[i].drift)
                over = clock[i].drift > DRIFT * laid.around[first + i].scale
                over = started > 0 and (over or (misses and clock[i].count < 0))
                clock[i].ended = started
                clock[i].count = clock[i].count + begins
                clock[i].keeps = wp.where(clock[i].count > 0, started, 0)
                keeps = clock[i].keeps > 0
                seen[i].steps = seen[i].steps + clock[i].keeps
                seen[i].sweeps = seen[i].sweeps + started * solve[i].sweeps
                left = larger(solve[i].left, seen[i].residual)
                seen[i].residual = wp.where(started > 0, left, seen[i].residual)
                seen[i].mode = wp.where(over, UNSOLVED, seen[i].mode)
                moves = started > 0 and seen[i].speed > STILL * weighs
                gliding = gliding + wp.where(moves, 1, 0)
                book = account[i]
                book = keep_account(wp.where(keeps, clock[i].gain, real(0.0)), book)
                account[i] = book
            for q in range(contact_count):
                a, b = blocks_of(laid, pack, q // 2)
                for i in range(LANES):
                    tracks = track[q, i]
                    glides = sliding_speed(contact[q, i], new[a, i], new[b, i])
                    stands = clock[i].keeps > 0 and seen[i].collapse_time >= NEVER
                    observe_slide(stands, dt, glides, impulse[q, i].n, tracks)
                    track[q, i] = tracks
            if gliding > 0:
                for q in range(contact_count):
                    a, b = blocks_of(laid, pack, q // 2)
                    for i in range(LANES):
                        length = smaller(
                            length_of(blocks[a, first + i]), length_of(blocks[b, first + i])
                        )
                        stands = clock[i].keeps > 0 and seen[i].speed > STILL * weighs
                        stands = stands and seen[i].collapse_time >= NEVER
                        time = real(clock[i].count) * dt
                        sees = seen[i]
                        observe_off(stands and size(track[q, i].slide) > length, time, sees)
                        seen[i] = sees
            for i in range(LANES):
                seen[i].speed = wp.where(clock[i].ended > 0, real(0.0), seen[i].speed)
            if BONDS:
                for joint in range(contact_count // 2):
                    for i in range(LANES):
                        edges = joints[joint, first + i]
                        torn = is_torn(
                            edges, rate, impulse[2 * joint, i], impulse[2 * joint + 1, i]
                        )
                        fails = clock[i].keeps > 0 and bond[joint, i].holds > 0 and torn
                        time = smaller(real(clock[i].count) * dt, breaks[i].first)
                        breaks[i].first = wp.where(fails, time, breaks[i].first)
                        breaks[i].count = breaks[i].count + wp.where(fails, 1, 0)
                        bond[joint, i].holds = wp.where(fails, 0, bond[joint, i].holds)
            for k in range(block_count):
                for i in range(LANES):
                    keeps = clock[i].keeps > 0
                    book = account[i]
                    add_energy(
                        keeps, pull[i], clock[i].gain, mass[k, i], old[k, i], new[k, i], book
                    )
                    account[i] = book
                    pose[k, i] = wp.where(keeps, integrate(dt, new[k, i], pose[k, i]), pose[k, i])
                    time = real(clock[i].count) * dt
                    sees = seen[i]
                    peaks = peak[k, i]
                    observe_block(
                        keeps, time, blocks[k, first + i], pose[k, i], new[k, i], peaks, sees
                    )
                    peak[k, i] = peaks
                    seen[i] = sees
            for i in range(LANES):
                time = real(clock[i].count) * dt
                stays = clock[i].keeps > 0 and seen[i].speed <= blocks[0, first + i].calm
                seen[i].still = wp.where(stays, time, seen[i].still)
            if found.rotations.shape[0] > 0:
                for i in range(LANES):
                    passed = fused(real(clock[i].count), dt, SAME * dt)
                    sample = int(clock[i].sample)
                    stores = clock[i].ended > 0 and clock[i].count >= 0
                    while stores and sample < samples and sample_times[sample] <= passed:
                        back = larger(passed - sample_times[sample], real(0.0))
                        back = wp.where(clock[i].keeps > 0, back, real(0.0))
                        for k in range(block_count):
                            v = new[k, i]
                            f = first + i
                            found.rotations[sample, k, f] = fused_less(
                                back, v.omega, pose[k, i].theta
                            )
                            if found.places.shape[0] > 0:
                                found.places[sample, k, ALONG, f] = fused_less(
                                    back, v.x, pose[k, i].x
                                )
                                found.places[sample, k, UPWARDS, f] = fused_less(
                                    back, v.z, pose[k, i].z
                                )
                        sample += 1
                    clock[i].sample = sample
            for i in range(LANES):
                goes = clock[i].goes > 0
                half = larger((real(clock[i].count) + HALF) * dt, HALF * dt)
                motion = motions[first + i]
                moving = base_velocity(motion, half, pool)
                acts = goes and clock[i].count >= 0
                gain = wp.where(acts, moving - clock[i].base, real(0.0))
                clock[i].gain = wp.where(goes, gain, clock[i].gain)
                clock[i].base = clock[i].base + gain
                pull[i] = wp.where(goes, Pull(-gain, -dt * knobs.gravity), pull[i])
            for k in range(block_count):
                for i in range(LANES):
                    goes = clock[i].goes > 0
                    free = wp.where(mass[k, i].m > real(0.0), real(1.0), real(0.0))
                    kept = wp.where(clock[i].count > 0, real(1.0), real(0.0))
                    v = Velocity(kept * new[k, i].x, kept * new[k, i].z, kept * new[k, i].omega)
                    old[k, i] = wp.where(goes, v, old[k, i])
                    after = Velocity(
                        fused(free, pull[i].x, v.x), fused(free, pull[i].z, v.z), v.omega
                    )
                    if SPRINGS:
                        drag = dt * knobs.stiffness.mass_damping
                        after.x = fused_less(drag, v.x, after.x)
                        after.z = fused_less(drag, v.z, after.z)
                        after.omega = fused_less(drag, v.omega, after.omega)
                    new[k, i] = wp.where(goes, after, new[k, i])
            crowded, seeks = int(0), int(0)
            for i in range(LANES):
                # Vector code: what stands has nothing to look for.
                goes = clock[i].goes > 0
                seek = near[i]
                seek = look_out(
                    laid.around[first + i].scale, dt, knobs.gravity, seen[i].speed, seek
                )
                looks = wp.where(goes and (seek.pairs > 0 or is_old(seek)), 1, 0)
                seek.looks = looks
                near[i] = wp.where(goes, seek, near[i])
                seeks = seeks + looks
            if seeks > 0:
                for i in range(LANES):
                    if clock[i].goes > 0 and near[i].looks > 0:
                        lane = first + i
                        for k in range(block_count):
                            laid.bodies[lane, k].pose = pose[k, i]
                        seek = near[i]
                        if is_old(seek):
                            seek = list_pairs(laid, lane, pack, seek)
                        near[i] = find_free(laid, lane, rate, seek)
            for i in range(LANES):
                goes = clock[i].goes > 0
                keeps = clock[i].keeps > 0 and goes
                sees = seen[i]
                observe_free(keeps, goes, near[i], sees)
                if SPRINGS:
                    # Only joints have springs.
                    sunk = near[i].deepest > SLIP * laid.around[first + i].scale
                    sees.astray = sees.astray + wp.where(keeps and sunk, 1, 0)
                seen[i] = sees
            for q in range(contact_count):
                joint = q // 2
                end_of = real(q % 2)
                a, b = blocks_of(laid, pack, joint)
                for i in range(LANES):
                    goes = clock[i].goes > 0
                    time = real(clock[i].count) * dt
                    at, gap = find_contact(
                        joints[joint, first + i], end_of, rate, pose[a, i], pose[b, i],
                        mass[a, i], mass[b, i],
                    )  # fmt: skip
                    va = new[a, i]
                    vb = new[b, i]
                    reach = larger(size(at.ba), size(at.bb)) + size(at.aa) + size(at.ab)
                    turning = fused(va.omega, va.omega, vb.omega * vb.omega)
                    limit = slack(dt, knobs.gravity, reach, turning, real(0.0))
                    sees = seen[i]
                    tracks = track[q, i]
                    keeps = goes and clock[i].count >= 0
                    observe_gap(keeps, time, gap, limit, impulse[q, i], tracks, sees)
                    seen[i] = sees
                    track[q, i] = tracks
                    contact[q, i] = wp.where(goes, at, contact[q, i])
                    if BONDS:
                        dried = after_break(at.friction, impulse[q, i])
                        dry = goes and (bond[joint, i].holds == 0 or clock[i].count < 0)
                        impulse[q, i].n = wp.where(dry, dried.n, impulse[q, i].n)
                        impulse[q, i].t = wp.where(dry, dried.t, impulse[q, i].t)
                        # Bonds set once the weight is borne: they begin without stress.
                        holds = bond[joint, i].holds > 0 and clock[i].count >= 0
                        impulse[q, i].hold = wp.where(holds, NEVER, real(0.0))
                    there = wp.where(gap < NEVER, real(1.0), real(0.0))
                    n = wp.where(goes, there * impulse[q, i].n, real(0.0))
                    t = wp.where(goes, there * impulse[q, i].t, real(0.0))
                    if SPRINGS:
                        pace = Pace(dt, dt, clock[i].goes, 0)
                        one = spring[q, i]
                        n, t, stored = press(
                            knobs.stiffness, pace, joints[joint, first + i], at, gap,
                            old[a, i], old[b, i], one,
                        )  # fmt: skip
                        spring[q, i] = one
                        n = wp.where(goes, n, real(0.0))
                        t = wp.where(goes, t, real(0.0))
                        store[i].now = store[i].now + wp.where(goes, stored, real(0.0))
                    impulse[q, i].n = wp.where(goes, n, impulse[q, i].n)
                    impulse[q, i].t = wp.where(goes, t, impulse[q, i].t)
                    push(contact[q, i], n, t, mass[a, i], mass[b, i], va, vb)
                    new[a, i] = va
                    new[b, i] = vb
                    way[q, i] = wp.where(goes, Way(), way[q, i])
            quick = int(0)
            for i in range(LANES):
                crowded = crowded + near[i].touching
                # Two corners may come towards each other, each at half of that.
                lively = clock[i].goes > 0 and seen[i].speed > HALF * FAST * weighs
                quick = quick + wp.where(lively, 1, 0)
            striking = int(0)
            if quick > 0 and not SPRINGS:
                for i in range(LANES):
                    clock[i].part = wp.where(clock[i].goes > 0, real(1.0), clock[i].part)
                for q in range(contact_count):
                    a, b = blocks_of(laid, pack, q // 2)
                    for i in range(LANES):
                        opening = opening_speed(contact[q, i], old[a, i], old[b, i])
                        lands = may_land(weighs, contact[q, i].b, impulse[q, i].n, opening)
                        lands = lands and clock[i].goes > 0 and clock[i].count > 0
                        part = landing_part(contact[q, i].b, opening)
                        part = wp.where(lands, smaller(part, clock[i].part), clock[i].part)
                        clock[i].part = part
                        clock[i].phase = wp.where(lands, LANDS, clock[i].phase)
                        contact[q, i].wn = wp.where(lands, real(0.0), contact[q, i].wn)
                        contact[q, i].wt = wp.where(lands, real(0.0), contact[q, i].wt)
            for i in range(LANES):
                striking = striking + clock[i].phase
            if crowded > 0:
                for i in range(LANES):
                    for q in range(wp.where(clock[i].goes > 0, near[i].touching, 0)):
                        held = laid.free[first + i, laid.touching[first + i, q]]
                        a, b = int(held.a), int(held.b)
                        va = new[a, i]
                        vb = new[b, i]
                        push(held.at, held.n, held.t, mass[a, i], mass[b, i], va, vb)
                        new[a, i] = va
                        new[b, i] = vb
            for k in range(block_count):
                for i in range(LANES):
                    goes = clock[i].goes > 0
                    zero = real(0.0)
                    v = new[k, i]
                    trail[k, i] = wp.where(
                        goes, Trail(zero, zero, zero, v.x, v.z, v.omega), trail[k, i]
                    )
            for i in range(LANES):
                goes = clock[i].goes > 0
                time = real(clock[i].count) * dt
                last = smaller(end, seen[i].collapse_time + knobs.after_collapse)
                on = wp.where(seen[i].mode == RUNNING and time < last, real(1.0), real(0.0))
                if SPRINGS:
                    # What springs hold they have not taken.
                    more = wp.where(
                        goes and clock[i].count > 0, store[i].now - store[i].before, real(0.0)
                    )
                    account[i].loss = account[i].loss - more
                    store[i].before = wp.where(goes, store[i].now, store[i].before)
                    store[i].now = real(0.0)
                    on = real(0.0)
                solve[i] = wp.where(goes, start_solve(on, knobs.settled, seen[i].speed), solve[i])
        if SPRINGS:
            pass
        else:
            for q in range(contact_count):
                joint = q // 2
                a, b = blocks_of(laid, pack, joint)
                for i in range(LANES):
                    va = new[a, i]
                    vb = new[b, i]
                    one = impulse[q, i]
                    goes_on = way[q, i]
                    own = solve[i]
                    sweep_contact(own, contact[q, i], mass[a, i], mass[b, i], one, goes_on, va, vb)
                    impulse[q, i] = one
                    way[q, i] = goes_on
                    solve[i] = own
                    new[a, i] = va
                    new[b, i] = vb
            if crowded > 0:
                for i in range(LANES):
                    if solve[i].on > real(0.0):
                        for q in range(near[i].touching):
                            place = laid.touching[first + i, q]
                            held = laid.free[first + i, place]
                            a, b = int(held.a), int(held.b)
                            va = new[a, i]
                            vb = new[b, i]
                            pair = Impulse()
                            pair.n = held.n
                            pair.t = held.t
                            along = Way(held.pn, held.pt, held.dn, held.dt)
                            own = solve[i]
                            sweep_contact(own, held.at, mass[a, i], mass[b, i], pair, along, va, vb)
                            solve[i] = own
                            new[a, i] = va
                            new[b, i] = vb
                            held.n = pair.n
                            held.t = pair.t
                            held.pn = along.pn
                            held.pt = along.pt
                            held.dn = along.dn
                            held.dt = along.dt
                            laid.free[first + i, place] = held
            for i in range(LANES):
                most = wp.where(clock[i].count < FIRST, ROOM * knobs.sweeps, knobs.sweeps)
                own = solve[i]
                if TREES:
                    jump = leap[i]
                    decide(knobs.settled, most, node_count > 0, own, jump)
                    leap[i] = jump
                else:
                    none = Leap()
                    decide(knobs.settled, most, False, own, none)
                solve[i] = own
            for k in range(block_count):
                for i in range(LANES):
                    v = new[k, i]
                    behind = trail[k, i]
                    extrapolate(solve[i].beta, v, behind)
                    new[k, i] = v
                    trail[k, i] = behind
            if TREES:
                leaping = int(0)
                for i in range(LANES):
                    leaping = leaping + leap[i].next
                if leaping > 0:
                    for k in range(block_count + 1):
                        for i in range(LANES):
                            node[k, i] = start_node(mass[k, i])
                    for joint in range(contact_count // 2):
                        q, p = 2 * joint, 2 * joint + 1
                        place = int(laid.graph[pack, CHILDREN + joint])
                        a, b = blocks_of(laid, pack, joint)
                        child, parent = (
                            wp.where(place % 2 == 0, a, b),
                            wp.where(place % 2 == 0, b, a),
                        )
                        for i in range(LANES):
                            below = node[child, i]
                            above = node[parent, i]
                            add_contact(
                                contact[q, i], impulse[q, i], place, new[a, i], new[b, i],
                                below, above,
                            )  # fmt: skip
                            add_contact(
                                contact[p, i], impulse[p, i], place, new[a, i], new[b, i],
                                below, above,
                            )  # fmt: skip
                            node[child, i] = below
                            node[parent, i] = above
                    for m in range(node_count):
                        child, parent = node_of(laid, pack, m)
                        for i in range(LANES):
                            below = node[child, i]
                            above = node[parent, i]
                            eliminate(below, above)
                            node[child, i] = below
                            node[parent, i] = above
                    for m in range(node_count):
                        child, parent = node_of(laid, pack, node_count - 1 - m)
                        for i in range(LANES):
                            below = node[child, i]
                            substitute(node[parent, i], below)
                            node[child, i] = below
                    for joint in range(contact_count // 2):
                        q, p = 2 * joint, 2 * joint + 1
                        a, b = blocks_of(laid, pack, joint)
                        for i in range(LANES):
                            leaps = leap[i].next > 0
                            da = change_of(node[a, i], mass[a, i])
                            db = change_of(node[b, i], mass[b, i])
                            along = way[q, i]
                            beside = way[p, i]
                            aim(
                                contact[q, i], impulse[q, i], new[a, i], new[b, i], da, db,
                                along,
                            )  # fmt: skip
                            aim(
                                contact[p, i], impulse[p, i], new[a, i], new[b, i], da, db,
                                beside,
                            )  # fmt: skip
                            jump = leap[i]
                            limit_share(
                                contact[q, i], impulse[q, i], along, contact[p, i], impulse[p, i],
                                beside, jump,
                            )  # fmt: skip
                            leap[i] = jump
                            way[q, i] = wp.where(leaps, along, way[q, i])
                            way[p, i] = wp.where(leaps, beside, way[p, i])
                    for joint in range(contact_count // 2):
                        q, p = 2 * joint, 2 * joint + 1
                        a, b = blocks_of(laid, pack, joint)
                        for i in range(LANES):
                            leaps = leap[i].next > 0
                            n0, t0, n1, t1 = leap_to(
                                contact[q, i], impulse[q, i], way[q, i], contact[p, i],
                                impulse[p, i], way[p, i], leap[i].share,
                            )  # fmt: skip
                            zero = real(0.0)
                            n0, t0 = wp.where(leaps, n0, zero), wp.where(leaps, t0, zero)
                            n1, t1 = wp.where(leaps, n1, zero), wp.where(leaps, t1, zero)
                            impulse[q, i].n = impulse[q, i].n + n0
                            impulse[q, i].t = impulse[q, i].t + t0
                            impulse[p, i].n = impulse[p, i].n + n1
                            impulse[p, i].t = impulse[p, i].t + t1
                            va = new[a, i]
                            vb = new[b, i]
                            push(contact[q, i], n0, t0, mass[a, i], mass[b, i], va, vb)
                            push(contact[p, i], n1, t1, mass[a, i], mass[b, i], va, vb)
                            new[a, i] = va
                            new[b, i] = vb
                            way[q, i].dn = wp.where(leaps, zero, way[q, i].dn)
                            way[q, i].dt = wp.where(leaps, zero, way[q, i].dt)
                            way[p, i].dn = wp.where(leaps, zero, way[p, i].dn)
                            way[p, i].dt = wp.where(leaps, zero, way[p, i].dt)
                    for k in range(block_count):
                        for i in range(LANES):
                            zero = real(0.0)
                            v = new[k, i]
                            trail[k, i] = wp.where(
                                leap[i].next > 0, Trail(zero, zero, zero, v.x, v.z, v.omega),
                                trail[k, i],
                            )  # fmt: skip
    if found.rotations.shape[0] > 0:
        for i in range(LANES):
            for sample in range(int(clock[i].sample), samples):
                for k in range(block_count):
                    f = first + i
                    found.rotations[sample, k, f] = pose[k, i].theta
                    if found.places.shape[0] > 0:
                        found.places[sample, k, ALONG, f] = pose[k, i].x
                        found.places[sample, k, UPWARDS, f] = pose[k, i].z
    for i in range(LANES):
        sees = seen[i]
        book = account[i]
        found.results[first + i] = Result(
            last_mode(sees), sees.steps, sees.impacts, sees.sweeps, sees.astray, sees.uplift_time,
            sees.moved, sees.deepest, sees.peak, sees.peak_time, sees.collapse_time, sees.still,
            sees.residual, book.loss, book.supplied, book.returned,
        )  # fmt: skip
        if BONDS:
            found.breaks[first + i] = breaks[i]
        for k in range(block_count):
            dx, dz = pose[k, i].x - blocks[k, first + i].x, pose[k, i].z - blocks[k, first + i].z
            last = wp.sqrt(dot(dx, dz, dx, dz))
            found.blocks[k, first + i] = BlockResult(peak[k, i].theta, peak[k, i].moved, last)
        for q in range(contact_count):
            found.contacts[q, first + i] = ContactResult(
                track[q, i].opening, track[q, i].most, track[q, i].slide
            )
            if BONDS:
                found.bonds[q, first + i] = bond[q // 2, i].holds
