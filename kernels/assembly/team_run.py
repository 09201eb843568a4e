"""Runs of one assembly of many blocks, by a team of threads.

The law and what is seen are those of `assembly_run.py`, but that corners land in one solve. What
else differs is the order of the contacts in a sweep. The host gives every joint a colour, so that
joints of one colour have no block in common that can move. The team takes one colour after the
other, and its threads meet between them. A thread takes packs of LANES joints side by side, both
ends of each: it reads the velocities of their blocks, sweeps, and writes these back. Contacts that
no joint declares, of which there are few until blocks fall, come last; the first thread finds and
sweeps them.

The numbers do not depend on the size of the team. Whoever takes a pack finds the same velocities
there, and what is summed over contacts or blocks is summed by bundles of packs, these by heaps of
HEAP bundles, in their order. All threads add up the heaps and come to the same decision.

A launch does some steps and ends; the next one goes on where it ended.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, ONLY, UPWARDS
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
    push,
    sliding_speed,
)
from warprock.kernels.assembly.meeting import (
    Laid,
    Near,
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
from warprock.kernels.lane.modes import RUNNING, UNSOLVED
from warprock.kernels.launch.address import address_of
from warprock.kernels.launch.instance import ONE_VECTOR
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.launch.team import Crew, meet, share
from warprock.kernels.motion.kinds import Motion, base_velocity
from warprock.kernels.shape.interface import Mass, Pose, Velocity

wp.set_module_options(ONE_VECTOR)

HEAP = 64
"""Bundles whose sums one thread adds up."""

CONTACT, FORCE, MASS, TRAIL = 12 * LANES, 6 * LANES, 4 * LANES, 6 * LANES
"""Numbers of LANES contacts, impulses with their directions, joints' masses and blocks' trails. A
row of LANES is a field: of `Contact`; of `Impulse` and `Way`; of `Mass` of the first blocks and of
the second ones; of `Trail`."""


@wp.struct
class Pair:
    """The two blocks of a joint."""

    a: int
    b: int


@wp.struct
class Sums:
    """What is summed over a bundle of contacts or blocks, or its largest value.

    Attributes:
        square, worst: Of contacts in a sweep, see `Solve`.
        work, loss: Of blocks in a step, see `Account`.
    """

    square: real
    worst: real
    work: real
    loss: real


@wp.struct
class Scene:
    """An assembly as the host lays it out.

    Places of joints lie colour by colour, each colour filled up to whole packs; what fills it up is
    between two blocks beyond the last.

    Attributes:
        blocks: Every block, shape [block].
        joints: Every joint, shape [place].
        pairs: Between which blocks it is, shape [place].
        masses: Their masses, shape [pack].
        bundles: The first pack of every bundle, then the number of all packs, shape [bundle + 1].
        colours: The first bundle of every colour, then that of all bundles, shape [colour + 1].
        laid: Where blocks may meet elsewhere than at their joints, see meeting.py.
        count: Blocks.
        block_packs: Packs of blocks in a bundle of them.
    """

    blocks: wp.array(dtype=Block)
    joints: wp.array(dtype=Edges)
    pairs: wp.array(dtype=Pair)
    masses: wp.array(dtype=real)
    bundles: wp.array(dtype=int)
    colours: wp.array(dtype=int)
    laid: Laid
    count: int
    block_packs: int


@wp.struct
class Store:
    """What goes from launch to launch, and between threads.

    Attributes:
        mass: Of every block, shape [block].
        pose, peak: Likewise, as in `assembly_run.py`.
        past, now: Likewise, its velocity before the step and in it.
        trail: Of packs of blocks, shape [pack].
        contact, force: Of packs of joints, shape [2 pack + end].
        track: Likewise, shape [2 pack + end, lane of the pack].
        sums, heaps: Shape [bundle], [heap].
        near: What there is of contacts that no joint declares, shape [1].
        clock, account, lane: Of the lane, shape [1]; there `count` begins at 0, and `ended` is 1
            once the lane has ended.
        seen: By every thread, shape [thread, lane].
    """

    mass: wp.array(dtype=Mass)
    pose: wp.array(dtype=Pose)
    past: wp.array(dtype=Velocity)
    now: wp.array(dtype=Velocity)
    peak: wp.array(dtype=Peak)
    trail: wp.array(dtype=real)
    contact: wp.array(dtype=real)
    force: wp.array(dtype=real)
    track: wp.array2d(dtype=Track)
    sums: wp.array(dtype=Sums)
    heaps: wp.array(dtype=Sums)
    near: wp.array(dtype=Near)
    clock: wp.array(dtype=Clock)
    account: wp.array(dtype=Account)
    lane: wp.array(dtype=Seen)
    seen: wp.array2d(dtype=Seen)


@wp.func
def add(a: Sums, b: Sums) -> Sums:
    """The sums of two bundles together."""
    return Sums(a.square + b.square, larger(a.worst, b.worst), a.work + b.work, a.loss + b.loss)


@wp.func
def heap_up(store: Store, crew: Crew, rank: int, bundles: int) -> Sums:
    """The sums of all bundles, where all threads have written theirs: the same in every thread."""
    heaps = (bundles + HEAP - 1) // HEAP
    meet(crew)
    for h in range(share(crew, rank, heaps), share(crew, rank + 1, heaps)):
        total = Sums()
        for b in range(h * HEAP, wp.min((h + 1) * HEAP, bundles)):
            total = add(total, store.sums[b])
        store.heaps[h] = total
    meet(crew)
    found = Sums()
    for h in range(heaps):
        found = add(found, store.heaps[h])
    return found


@wp.func
def merge(a: Seen, b: Seen) -> Seen:
    """What is seen of a lane by two of those that look at its blocks and contacts."""
    later = b.peak > a.peak or (b.peak == a.peak and b.peak_time < a.peak_time)
    return Seen(
        wp.max(a.mode, b.mode), a.steps, a.impacts + b.impacts, a.sweeps,
        smaller(a.uplift_time, b.uplift_time), larger(a.moved, b.moved),
        larger(a.deepest, b.deepest), larger(a.peak, b.peak),
        wp.where(later, b.peak_time, a.peak_time), smaller(a.collapse_time, b.collapse_time),
        wp.max(a.off, b.off), a.still, a.residual, larger(a.speed, b.speed), a.astray, a.leans,
    )  # fmt: skip


@kernel
def run_lanes(
    scene: Scene, store: Store, motions: wp.array(dtype=Motion), pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found, crew: Crew,
):  # fmt: skip
    """Takes up to so many steps of a lane."""
    _one, thread = wp.tid()
    rank = crew.rank + thread
    next_rank = rank + 1
    dt = real(knobs.time_steps[0])
    rate = real(1.0) / dt
    samples = sample_times.shape[0]
    end = sample_times[samples - 1]
    colours, bundles = scene.colours.shape[0] - 1, scene.bundles.shape[0] - 1
    packs = scene.masses.shape[0] // MASS
    block_packs = (scene.count + LANES - 1) // LANES
    block_bundles = (block_packs + scene.block_packs - 1) // scene.block_packs
    calm = real(scene.blocks[0].calm)
    ends = int(2)
    clock = rows(Clock, lanes=1)
    lane = rows(Seen, lanes=1)
    account = rows(Account, lanes=1)
    solve = rows(Solve, lanes=1)
    pull = rows(Pull, lanes=1)
    clock[0] = store.clock[0]
    clock[0].count = clock[0].count - SETTLING
    lane[0] = store.lane[0]
    account[0] = store.account[0]
    seen = rows(Seen)
    books = rows(Account)
    pair = rows(Pair)
    mass = rows(Mass)
    pose_a = rows(Pose)
    pose_b = rows(Pose)
    new_a = rows(Velocity)
    new_b = rows(Velocity)
    edges = rows(Edges)
    track = rows(Track)
    one = rows(Impulse)
    way = rows(Way)
    sweep = rows(Solve)
    for i in range(LANES):
        seen[i] = store.seen[rank, i]
    left = int(crew.steps)
    last = smaller(end, lane[0].collapse_time + knobs.after_collapse)
    while left > 0 and lane[0].mode == RUNNING and real(clock[0].count) * dt < last:
        left = left - 1
        # What gravity and the base do in the step.
        half = larger((real(clock[0].count) + HALF) * dt, HALF * dt)
        motion = motions[0]
        moving = base_velocity(motion, half, pool)
        acts = clock[0].count >= 0
        gain = wp.where(acts, moving - clock[0].base, real(0.0))
        clock[0].gain = gain
        clock[0].base = clock[0].base + gain
        pull[0] = Pull(-gain, -dt * knobs.gravity)
        kept = wp.where(clock[0].count > 0, real(1.0), real(0.0))
        for p in range(share(crew, rank, block_packs), share(crew, next_rank, block_packs)):
            for i in range(LANES):
                k = p * LANES + i
                moves = wp.where(store.mass[k].m > real(0.0), real(1.0), real(0.0))
                was = store.now[k]
                v = Velocity(kept * was.x, kept * was.z, kept * was.omega)
                store.past[k] = v
                store.now[k] = Velocity(
                    fused(moves, pull[0].x, v.x), fused(moves, pull[0].z, v.z), v.omega
                )
        if rank == 0:
            near = look_out(
                scene.laid.around[0].scale, dt, knobs.gravity, lane[0].speed, store.near[0]
            )
            if near.pairs > 0 or is_old(near):
                for k in range(scene.count):
                    scene.laid.bodies[ONLY, k].pose = store.pose[k]
                if is_old(near):
                    near = list_pairs(scene.laid, 0, 0, near)
                near = find_free(scene.laid, 0, rate, near)
            sees = seen[0]
            observe_free(clock[0].count > 0, True, near, sees)
            seen[0] = sees
            store.near[0] = near
        meet(crew)
        touching, leans = int(store.near[0].touching), int(store.near[0].carries)
        for i in range(LANES):
            seen[i].leans = leans
        # Where contacts are; what they carried in the last step is what the solve begins with.
        time = real(clock[0].count) * dt
        for colour in range(colours):
            before = scene.colours[colour]
            many = scene.colours[colour + 1] - before
            low = scene.bundles[before + share(crew, rank, many)]
            for p in range(low, scene.bundles[before + share(crew, next_rank, many)]):
                weights = wp.array(
                    ptr=address_of(scene.masses.ptr, p, MASS), shape=(MASS,), dtype=real
                )
                mass_a = rows(Mass, within=weights)
                mass_b = rows(Mass, within=weights, first=2)
                for i in range(LANES):
                    pair[i] = scene.pairs[p * LANES + i]
                    edges[i] = scene.joints[p * LANES + i]
                    pose_a[i] = store.pose[pair[i].a]
                    pose_b[i] = store.pose[pair[i].b]
                    new_a[i] = store.now[pair[i].a]
                    new_b[i] = store.now[pair[i].b]
                for side in range(ends):
                    held = wp.array(
                        ptr=address_of(store.contact.ptr, 2 * p + side, CONTACT),
                        shape=(CONTACT,),
                        dtype=real,
                    )
                    contact = rows(Contact, within=held)
                    force = wp.array(
                        ptr=address_of(store.force.ptr, 2 * p + side, FORCE),
                        shape=(FORCE,),
                        dtype=real,
                    )
                    borne = rows(Impulse, within=force)
                    kept = rows(Way, within=force, first=2)
                    for i in range(LANES):
                        track[i] = store.track[2 * p + side, i]
                    for i in range(LANES):
                        ma, mb = mass_a[i], mass_b[i]
                        at, gap = find_contact(
                            edges[i], real(side), rate, pose_a[i], pose_b[i], ma, mb
                        )
                        va = new_a[i]
                        vb = new_b[i]
                        reach = larger(size(at.ba), size(at.bb)) + size(at.aa) + size(at.ab)
                        turning = fused(va.omega, va.omega, vb.omega * vb.omega)
                        limit = slack(dt, knobs.gravity, reach, turning, real(0.0))
                        sees = seen[i]
                        tracks = track[i]
                        carried = borne[i]
                        live = acts and pair[i].a < scene.count
                        observe_gap(live, time, gap, limit, carried, tracks, sees)
                        seen[i] = sees
                        track[i] = tracks
                        there = wp.where(gap < NEVER, real(1.0), real(0.0))
                        n, t = there * carried.n, there * carried.t
                        push(at, n, t, ma, mb, va, vb)
                        new_a[i] = va
                        new_b[i] = vb
                        borne[i] = Impulse(n, t)
                        kept[i] = Way()
                        contact[i] = at
                    for i in range(LANES):
                        store.track[2 * p + side, i] = track[i]
                for i in range(LANES):
                    if pair[i].a < scene.count and mass_a[i].m > real(0.0):
                        store.now[pair[i].a] = new_a[i]
                    if pair[i].b < scene.count and mass_b[i].m > real(0.0):
                        store.now[pair[i].b] = new_b[i]
            meet(crew)
        if touching > 0:
            if rank == 0:
                for q in range(touching):
                    free = scene.laid.free[ONLY, scene.laid.touching[ONLY, q]]
                    va = store.now[free.a]
                    vb = store.now[free.b]
                    push(free.at, free.n, free.t, store.mass[free.a], store.mass[free.b], va, vb)
                    store.now[free.a] = va
                    store.now[free.b] = vb
            meet(crew)
        for p in range(share(crew, rank, block_packs), share(crew, next_rank, block_packs)):
            trails = wp.array(ptr=address_of(store.trail.ptr, p, TRAIL), shape=(TRAIL,), dtype=real)
            trail = rows(Trail, within=trails)
            for i in range(LANES):
                v = store.now[p * LANES + i]
                trail[i].x = v.x
                trail[i].z = v.z
                trail[i].omega = v.omega
        meet(crew)
        # The sweeps.
        solve[0] = start_solve(real(1.0), knobs.settled, lane[0].speed)
        most = wp.where(clock[0].count < FIRST, ROOM * knobs.sweeps, knobs.sweeps)
        while solve[0].on > real(0.0):
            for colour in range(colours):
                before = scene.colours[colour]
                many = scene.colours[colour + 1] - before
                for b in range(
                    before + share(crew, rank, many), before + share(crew, next_rank, many)
                ):
                    for i in range(LANES):
                        own = solve[0]
                        sweep[i] = own
                    for p in range(scene.bundles[b], scene.bundles[b + 1]):
                        weights = wp.array(
                            ptr=address_of(scene.masses.ptr, p, MASS), shape=(MASS,), dtype=real
                        )
                        mass_a = rows(Mass, within=weights)
                        mass_b = rows(Mass, within=weights, first=2)
                        for i in range(LANES):
                            pair[i] = scene.pairs[p * LANES + i]
                            new_a[i] = store.now[pair[i].a]
                            new_b[i] = store.now[pair[i].b]
                        for side in range(ends):
                            held = wp.array(
                                ptr=address_of(store.contact.ptr, 2 * p + side, CONTACT),
                                shape=(CONTACT,),
                                dtype=real,
                            )
                            contact = rows(Contact, within=held)
                            force = wp.array(
                                ptr=address_of(store.force.ptr, 2 * p + side, FORCE),
                                shape=(FORCE,),
                                dtype=real,
                            )
                            borne = rows(Impulse, within=force)
                            kept = rows(Way, within=force, first=2)
                            for i in range(LANES):
                                one[i] = borne[i]
                                way[i] = kept[i]
                            for i in range(LANES):
                                at = contact[i]
                                ma = mass_a[i]
                                mb = mass_b[i]
                                va = new_a[i]
                                vb = new_b[i]
                                own = sweep[i]
                                pushes = one[i]
                                goes_on = way[i]
                                sweep_contact(own, at, ma, mb, pushes, goes_on, va, vb)
                                sweep[i] = own
                                new_a[i] = va
                                new_b[i] = vb
                                one[i] = pushes
                                way[i] = goes_on
                            for i in range(LANES):
                                borne[i] = one[i]
                                kept[i] = way[i]
                        for i in range(LANES):
                            if pair[i].a < scene.count and mass_a[i].m > real(0.0):
                                store.now[pair[i].a] = new_a[i]
                            if pair[i].b < scene.count and mass_b[i].m > real(0.0):
                                store.now[pair[i].b] = new_b[i]
                    total = Sums()
                    for i in range(LANES):
                        total = add(
                            total, Sums(sweep[i].square, sweep[i].worst, real(0.0), real(0.0))
                        )
                    store.sums[b] = total
                if colour < colours - 1:
                    meet(crew)
            if touching > 0:
                meet(crew)
            if rank == 0:
                own = solve[0]
                for q in range(touching):
                    held_at = scene.laid.touching[ONLY, q]
                    free = scene.laid.free[ONLY, held_at]
                    va = store.now[free.a]
                    vb = store.now[free.b]
                    pushes = Impulse(free.n, free.t)
                    goes_on = Way(free.pn, free.pt, free.dn, free.dt)
                    sweep_contact(
                        own, free.at, store.mass[free.a], store.mass[free.b], pushes, goes_on,
                        va, vb,
                    )  # fmt: skip
                    store.now[free.a] = va
                    store.now[free.b] = vb
                    free.n = pushes.n
                    free.t = pushes.t
                    free.pn = goes_on.pn
                    free.pt = goes_on.pt
                    free.dn = goes_on.dn
                    free.dt = goes_on.dt
                    scene.laid.free[ONLY, held_at] = free
                store.sums[bundles] = Sums(own.square, own.worst, real(0.0), real(0.0))
            all_of = heap_up(store, crew, rank, bundles + 1)
            solve[0].square = all_of.square
            solve[0].worst = all_of.worst
            own = solve[0]
            none = Leap()
            decide(knobs.settled, most, False, own, none)
            solve[0] = own
            for p in range(share(crew, rank, block_packs), share(crew, next_rank, block_packs)):
                trails = wp.array(
                    ptr=address_of(store.trail.ptr, p, TRAIL), shape=(TRAIL,), dtype=real
                )
                trail = rows(Trail, within=trails)
                for i in range(LANES):
                    new_a[i] = store.now[p * LANES + i]
                for i in range(LANES):
                    v = new_a[i]
                    past = trail[i]
                    extrapolate(solve[0].beta, v, past)
                    new_a[i] = v
                    trail[i] = past
                for i in range(LANES):
                    store.now[p * LANES + i] = new_a[i]
            meet(crew)
        # What the step has done.
        clock[0].count = clock[0].count + 1
        keeps = clock[0].count > 0
        lane[0].steps = lane[0].steps + wp.where(keeps, 1, 0)
        lane[0].sweeps = lane[0].sweeps + solve[0].sweeps
        lane[0].residual = larger(solve[0].left, lane[0].residual)
        misses = solve[0].left > solve[0].loose
        clock[0].drift = drift_after(dt, solve[0], clock[0].drift)
        over = clock[0].drift > DRIFT * scene.laid.around[0].scale or (misses and not keeps)
        book = account[0]
        book = keep_account(wp.where(keeps, clock[0].gain, real(0.0)), book)
        account[0] = book
        time = real(clock[0].count) * dt
        for p in range(share(crew, rank, packs), share(crew, next_rank, packs)):
            for i in range(LANES):
                pair[i] = scene.pairs[p * LANES + i]
                new_a[i] = store.now[pair[i].a]
                new_b[i] = store.now[pair[i].b]
            for side in range(ends):
                held = wp.array(
                    ptr=address_of(store.contact.ptr, 2 * p + side, CONTACT),
                    shape=(CONTACT,),
                    dtype=real,
                )
                contact = rows(Contact, within=held)
                force = wp.array(
                    ptr=address_of(store.force.ptr, 2 * p + side, FORCE), shape=(FORCE,), dtype=real
                )
                borne = rows(Impulse, within=force)
                for i in range(LANES):
                    track[i] = store.track[2 * p + side, i]
                for i in range(LANES):
                    at = contact[i]
                    tracks = track[i]
                    glides = sliding_speed(at, new_a[i], new_b[i])
                    observe_slide(keeps, dt, glides, borne[i].n, tracks)
                    track[i] = tracks
                for i in range(LANES):
                    length = smaller(
                        length_of(scene.blocks[pair[i].a]), length_of(scene.blocks[pair[i].b])
                    )
                    stands = keeps and lane[0].collapse_time >= NEVER
                    sees = seen[i]
                    observe_off(stands and size(track[i].slide) > length, time, sees)
                    seen[i] = sees
                for i in range(LANES):
                    store.track[2 * p + side, i] = track[i]
        for i in range(LANES):
            seen[i].mode = wp.max(seen[i].mode, wp.where(over, UNSOLVED, RUNNING))
            seen[i].speed = real(0.0)
        blocks_low = share(crew, rank, block_bundles)
        for b in range(blocks_low, share(crew, next_rank, block_bundles)):
            for i in range(LANES):
                books[i] = Account()
            first = b * scene.block_packs
            for p in range(first, wp.min(first + scene.block_packs, block_packs)):
                for i in range(LANES):
                    k = p * LANES + i
                    pose_a[i] = store.pose[k]
                    new_a[i] = store.past[k]
                    new_b[i] = store.now[k]
                    mass[i] = store.mass[k]
                for i in range(LANES):
                    book = books[i]
                    add_energy(keeps, pull[0], clock[0].gain, mass[i], new_a[i], new_b[i], book)
                    books[i] = book
                    pose_a[i] = wp.where(keeps, integrate(dt, new_b[i], pose_a[i]), pose_a[i])
                for i in range(LANES):
                    k = p * LANES + i
                    sees = seen[i]
                    peaks = store.peak[k]
                    observe_block(keeps, time, scene.blocks[k], pose_a[i], new_b[i], peaks, sees)
                    store.peak[k] = peaks
                    store.pose[k] = pose_a[i]
                    seen[i] = sees
            total = Sums()
            for i in range(LANES):
                total = add(total, Sums(real(0.0), real(0.0), books[i].work, books[i].loss))
            store.sums[b] = total
        for i in range(LANES):
            store.seen[rank, i] = seen[i]
        done = heap_up(store, crew, rank, block_bundles)
        account[0].work = account[0].work + done.work
        account[0].loss = account[0].loss + done.loss
        mode = int(RUNNING)
        speed = real(0.0)
        fell = real(lane[0].collapse_time)
        for r in range(crew.size):
            for i in range(LANES):
                mode = wp.max(mode, store.seen[r, i].mode)
                speed = larger(store.seen[r, i].speed, speed)
                fell = smaller(store.seen[r, i].collapse_time, fell)
        lane[0].mode = mode
        lane[0].collapse_time = fell
        last = smaller(end, fell + knobs.after_collapse)
        lane[0].speed = speed
        stays = keeps and speed <= calm
        lane[0].still = wp.where(stays, time, lane[0].still)
        if found.rotations.shape[0] > 0 and clock[0].count >= 0:
            passed = fused(real(clock[0].count), dt, SAME * dt)
            sample = int(clock[0].sample)
            while sample < samples and sample_times[sample] <= passed:
                back = larger(passed - sample_times[sample], real(0.0))
                back = wp.where(keeps, back, real(0.0))
                for k in range(share(crew, rank, scene.count), share(crew, next_rank, scene.count)):
                    v = store.now[k]
                    found.rotations[sample, k, ONLY] = fused_less(
                        back, v.omega, store.pose[k].theta
                    )
                    if found.places.shape[0] > 0:
                        found.places[sample, k, ALONG, ONLY] = fused_less(
                            back, v.x, store.pose[k].x
                        )
                        found.places[sample, k, UPWARDS, ONLY] = fused_less(
                            back, v.z, store.pose[k].z
                        )
                sample += 1
            clock[0].sample = sample
        meet(crew)
    ended = lane[0].mode != RUNNING or real(clock[0].count) * dt >= last
    meet(crew)
    if rank == 0:
        clock[0].count = clock[0].count + SETTLING
        clock[0].ended = wp.where(ended, 1, 0)
        store.clock[0] = clock[0]
        store.lane[0] = lane[0]
        store.account[0] = account[0]
    if ended:
        if found.rotations.shape[0] > 0:
            for sample in range(int(clock[0].sample), samples):
                for k in range(share(crew, rank, scene.count), share(crew, next_rank, scene.count)):
                    found.rotations[sample, k, ONLY] = store.pose[k].theta
                    if found.places.shape[0] > 0:
                        found.places[sample, k, ALONG, ONLY] = store.pose[k].x
                        found.places[sample, k, UPWARDS, ONLY] = store.pose[k].z
        for k in range(share(crew, rank, scene.count), share(crew, next_rank, scene.count)):
            dx = store.pose[k].x - scene.blocks[k].x
            dz = store.pose[k].z - scene.blocks[k].z
            away = wp.sqrt(dot(dx, dz, dx, dz))
            found.blocks[k, ONLY] = BlockResult(store.peak[k].theta, store.peak[k].moved, away)
        for p in range(share(crew, rank, 2 * packs), share(crew, next_rank, 2 * packs)):
            for i in range(LANES):
                tracks = store.track[p, i]
                found.contacts[p * LANES + i, ONLY] = ContactResult(
                    tracks.opening, tracks.most, tracks.slide
                )
        if rank == 0:
            for r in range(crew.size):
                for i in range(LANES):
                    sees = lane[0]
                    lane[0] = merge(sees, store.seen[r, i])
            found.results[0] = Result(
                last_mode(lane[0]), lane[0].steps, lane[0].impacts, lane[0].sweeps, lane[0].astray,
                lane[0].uplift_time, lane[0].moved, lane[0].deepest, lane[0].peak,
                lane[0].peak_time, lane[0].collapse_time, lane[0].still, lane[0].residual,
                account[0].loss, account[0].supplied, account[0].returned,
            )  # fmt: skip
