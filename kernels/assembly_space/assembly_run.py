"""Runs of assemblies of blocks in space with dry joints, one lane a thread on any device.

The same scheme as in the plane (assembly/assembly_run.py): a run begins with SETTLING solves at the
start, from velocities of zero; a step moves the blocks by the velocities that its solve found.
Corners land in one solve. A sweep takes contacts side by side, by vector code, in the order of
packing.py.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Vector
from warprock.kernels.assembly.block import last_mode, observe_off, start_seen
from warprock.kernels.assembly.found import (
    DRIFT,
    FIRST,
    ROOM,
    SAME,
    SETTLING,
    ContactResult,
    Knobs,
    Result,
)
from warprock.kernels.assembly.meeting import (
    BLOCK_COUNT,
    JOINT_COUNT,
    NONE,
    Near,
    is_old,
    look_out,
    observe_free,
)
from warprock.kernels.assembly_space.block import (
    Block,
    Peak,
    Place,
    add_energy,
    add_weighted,
    extrapolate,
    heft_of,
    inertia,
    integrate,
    observe_block,
    start_place,
    strayed_by,
    turn_block,
)
from warprock.kernels.assembly_space.contact import (
    STEEP,
    Apart,
    Couple,
    Given,
    Heft,
    Impulse,
    Move,
    Rest,
    Row,
    Weighted,
    add_part,
    apart_of,
    give,
    inner,
    move_of,
    sweep_contact,
    times,
    weighted_of,
)
from warprock.kernels.assembly_space.finding import find_joint, find_pairs, list_pairs
from warprock.kernels.assembly_space.meeting import KEPT, Laid, Sides, Step, has_left, slip_of_joint
from warprock.kernels.assembly_space.pace import decide, start_solve
from warprock.kernels.assembly_space.packing import (
    CONTACT,
    COUPLE,
    NUMBERS,
    WIDTH,
    fill_packs,
    keep_contacts,
    keep_impulses,
    pack_up,
)
from warprock.kernels.lane.account import Account, keep_account
from warprock.kernels.lane.modes import RUNNING, UNSOLVED
from warprock.kernels.launch.address import address_of
from warprock.kernels.launch.instance import VECTORS_INSIDE
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, base_velocity

if BONDS:
    from warprock.kernels.assembly.bond import Breaks
    from warprock.kernels.assembly_space.bond import is_torn

wp.set_module_options(VECTORS_INSIDE)

LANES = 1
"""Lanes that a thread runs."""


@wp.struct
class BlockResult:
    """What a block leaves behind: its largest turn [rad] and displacement [m], its last one."""

    turn: real
    moved: real
    last: real


@wp.struct
class Kept:
    """What a lane keeps of its blocks from step to step, shape [lane, block] each.

    Attributes:
        stood: Where they were when contacts were found.
        before: Velocities before the step.
        free: Weighted velocities that blocks would have without contacts after the step.
        ends: Weighted velocities at the end of the last sweep.
        peaks: See `Peak`.
    """

    stood: wp.array2d(dtype=Place)
    before: wp.array2d(dtype=Move)
    free: wp.array2d(dtype=Weighted)
    ends: wp.array2d(dtype=Weighted)
    peaks: wp.array2d(dtype=Peak)


@wp.struct
class Found:
    """Where the kernel leaves what it finds.

    Attributes:
        results: Of every lane, shape [lane].
        blocks: Of every block, shape [block, lane].
        contacts: Two rows a joint, of which the first one tells, shape [2 joints, lane].
        attitudes: Quaternions at the samples, shape [sample, block, 4, lane]; empty if not asked
            for.
        places: Centres of mass at the samples [m], shape [sample, block, 3, lane]; likewise.
        breaks: Bonds that broke, shape [lane].
        bonds: 1 where a joint is bonded at the end, two rows a joint as in `contacts`.
    """

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    contacts: wp.array2d(dtype=ContactResult)
    attitudes: wp.array4d(dtype=real)
    places: wp.array4d(dtype=real)
    if BONDS:
        breaks: wp.array(dtype=Breaks)
        bonds: wp.array2d(dtype=int)


@wp.func
def set_place(laid: Laid, lane: int, k: int, block: Block):
    """Brings what follows from the place of a block up to date."""
    place = laid.places[lane, k]
    laid.hefts[lane, k] = heft_of(block, place.r)
    solid = laid.solids[lane, k]
    for i in range(solid.corners):
        spot = times(place.r, laid.corners[lane, solid.corner + i])
        laid.spots[lane, solid.corner + i] = place.at + spot


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), laid: Laid, kept: Kept, motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread."""
    lane, _one = wp.tid()
    dt, zero, drift = real(knobs.time_steps[lane]), real(0.0), real(0.0)
    count = int(laid.sizes[lane, BLOCK_COUNT])
    joints = int(laid.sizes[lane, JOINT_COUNT])
    room = laid.contacts.shape[1] // 2
    samples = sample_times.shape[0]
    end = sample_times[samples - 1]
    seen, account, near = start_seen(), Account(), Near()
    sides = rows(Sides, lanes=WIDTH)
    ya = rows(Weighted, lanes=WIDTH)
    yb = rows(Weighted, lanes=WIDTH)
    apart = rows(Apart, lanes=WIDTH)
    given = rows(Given, lanes=WIDTH)
    one = rows(Impulse, lanes=WIDTH)
    rest = rows(Rest, lanes=WIDTH)
    step = Step()
    step.dt = dt
    step.gravity = knobs.gravity
    step.half = room
    base, gain = Vector(), Vector()
    near.pairs = NONE
    sample = int(0)
    for k in range(count):
        laid.places[lane, k] = start_place(blocks[k, lane])
        laid.moves[lane, k] = Move()
        kept.peaks[lane, k] = Peak()
    laid.hefts[lane, count] = Heft()
    laid.moves[lane, count] = Move()
    laid.weighted[lane, count] = Weighted()
    laid.weighted[lane, count + 1] = Weighted()
    if BONDS:
        breaks = Breaks()
        breaks.first = NEVER
        for joint in range(joints):
            laid.joined[lane, joint].holds = wp.where(laid.links[lane, joint].tension > zero, 1, 0)
    steepest = real(laid.friction[lane])
    for joint in range(joints):
        steepest = larger(laid.links[lane, joint].friction, steepest)
    steep = wp.where(steepest > STEEP, 1, 0)
    strayed, gapes = real(0.0), int(0)
    number = int(-SETTLING)
    time = real(number) * dt
    last = end
    while seen.mode == RUNNING and time < last:
        live = wp.where(number >= 0, 1, 0)
        half = larger((real(number) + HALF) * dt, HALF * dt)
        for d in range(3):
            way = motions[d, lane]
            rides = base_velocity(way, half, pool)
            gain[d] = wp.where(live > 0, rides - base[d], zero)
            base[d] = base[d] + gain[d]
        pull = Vector(-gain[0], -gain[1], -gain[2] - dt * knobs.gravity)
        near = look_out(laid.scale[lane], dt, knobs.gravity, seen.speed, near)
        # Blocks that hardly move touch as they did.
        finds = number <= 0 or is_old(near) or strayed > KEPT * knobs.gravity * dt * dt
        step.live = live
        step.time = time
        if finds:
            for k in range(count):
                set_place(laid, lane, k, blocks[k, lane])
                kept.stood[lane, k] = laid.places[lane, k]
            if is_old(near):
                near = list_pairs(laid, lane, near)
            near.deepest = zero
            near.landed = 0
            near.carries = 0
            step.old = step.half
            step.half = room - step.half
            step.total = 0
            moved = real(seen.moved)
            seen.moved = -NEVER
            for joint in range(joints):
                find_joint(laid, lane, joint, step, seen, near)
            gapes = wp.where(seen.moved > -NEVER, 1, 0)
            seen.moved = larger(moved, seen.moved)
            find_pairs(laid, lane, step, seen, near)
            pack_up(laid, lane, near, step)
            near.full = wp.max(near.full, step.full)
        else:
            keep_contacts(laid, lane, step)
            near.landed = 0
            seen.moved = wp.where(gapes > 0, time, seen.moved)
        observe_free(live > 0, True, near, seen)
        for k in range(count):
            v = laid.moves[lane, k]
            if number <= 0:
                v = Move()
            kept.before[lane, k] = v
            if blocks[k, lane].light > zero:
                v.v = v.v + pull
            y = weighted_of(laid.hefts[lane, k], v)
            # The first guess of what contacts give it is what they gave it in the last step.
            former = add_weighted(real(-1.0), kept.free[lane, k], laid.weighted[lane, k])
            kept.free[lane, k] = y
            laid.weighted[lane, k] = add_weighted(wp.where(finds, zero, real(1.0)), former, y)
        if finds:
            fill_packs(laid, lane, near, step)
        for k in range(count):
            kept.ends[lane, k] = laid.weighted[lane, k]
        solve = start_solve(live, steep, knobs.settled, seen.speed)
        most = wp.where(number < FIRST, ROOM * knobs.sweeps, knobs.sweeps)
        own_rows = lane * (laid.order.shape[1] // WIDTH)
        own_packs = lane * laid.packs.shape[1]
        while solve.goes > 0:
            for i in range(WIDTH):
                rest[i] = Rest()
            beta, eased = real(solve.beta), real(solve.eased)
            for rank in range(step.packs):
                # Forces that are not unique would drift to one side: turn back at new contacts.
                pack = wp.where(step.half == 0, rank, step.packs - 1 - rank)
                meets = laid.packs[lane, pack]
                for i in range(WIDTH):
                    sides[i] = laid.sides[lane, pack * WIDTH + i]
                    ya[i] = laid.weighted[lane, sides[i].a]
                    yb[i] = laid.weighted[lane, sides[i].b]
                couples = wp.array(
                    ptr=address_of(laid.couples.ptr, own_packs + pack, COUPLE * WIDTH),
                    shape=(COUPLE * WIDTH,),
                    dtype=real,
                )
                couple = rows(Couple, within=couples, lanes=WIDTH)
                for i in range(WIDTH):
                    own = couple[i]
                    apart[i] = apart_of(own, ya[i], yb[i])
                    given[i] = Given()
                for turn in range(meets.depth):
                    held = wp.array(
                        ptr=address_of(laid.rows.ptr, own_rows + meets.first + turn, NUMBERS),
                        shape=(NUMBERS,),
                        dtype=real,
                    )
                    row = rows(Row, within=held, lanes=WIDTH)
                    borne = rows(Impulse, within=held, first=CONTACT, lanes=WIDTH)
                    if solve.sweeps == 0:
                        for i in range(WIDTH):
                            borne[i].pn = zero
                            borne[i].pt = zero
                            borne[i].ps = zero
                    for i in range(WIDTH):
                        one[i] = borne[i]
                    for i in range(WIDTH):
                        own = couple[i]
                        contact = row[i]
                        left = rest[i]
                        bears = one[i]
                        moves = apart[i]
                        gets = given[i]
                        sweep_contact(left, beta, eased, own, contact, bears, moves, gets)
                        rest[i] = left
                        one[i] = bears
                        apart[i] = moves
                        given[i] = gets
                    for i in range(WIDTH):
                        borne[i] = one[i]
                for i in range(WIDTH):
                    own = couple[i]
                    first_y = ya[i]
                    second_y = yb[i]
                    give(own, given[i], first_y, second_y)
                    ya[i] = first_y
                    yb[i] = second_y
                for i in range(WIDTH):
                    laid.weighted[lane, sides[i].a] = ya[i]
                    laid.weighted[lane, sides[i].b] = yb[i]
            for i in range(WIDTH):
                solve.square = solve.square + rest[i].square
                solve.worst = larger(wp.sqrt(rest[i].worst), solve.worst)
            decide(most, solve)
            for k in range(count):
                y = laid.weighted[lane, k]
                laid.weighted[lane, k] = extrapolate(solve.beta, kept.ends[lane, k], y)
                kept.ends[lane, k] = y
        keep_impulses(laid, lane, step)
        for k in range(count):
            if blocks[k, lane].light > zero:
                laid.moves[lane, k] = move_of(laid.hefts[lane, k], laid.weighted[lane, k])
        seen.sweeps = seen.sweeps + solve.sweeps
        seen.residual = larger(solve.left, seen.residual)
        misses = solve.left > solve.loose
        drift = wp.where(misses, fused(dt, solve.left, drift), drift)
        if drift > DRIFT * laid.scale[lane] or (misses and live == 0):
            seen.mode = UNSOLVED
        number += 1
        time = real(number) * dt
        if live > 0:
            seen.steps += 1
            seen.speed = zero
            strayed = zero
            if BONDS:
                for joint in range(joints):
                    if laid.joined[lane, joint].holds > 0 and is_torn(
                        laid, lane, joint, step.half, dt
                    ):
                        laid.joined[lane, joint].holds = 0
                        strayed = NEVER
                        breaks.count += 1
                        breaks.first = smaller(time, breaks.first)
            # A joint tells of its slide until something has fallen or slid off.
            for joint in range(wp.where(seen.collapse_time >= NEVER, joints, 0)):
                joined = laid.joined[lane, joint]
                slip = slip_of_joint(laid, lane, step.half, joined)
                joined.slide = add_part(dt, slip, joined.slide)
                far = wp.sqrt(inner(joined.slide, joined.slide))
                joined.most = larger(far, joined.most)
                laid.joined[lane, joint] = joined
                if far > laid.links[lane, joint].least:
                    link = laid.links[lane, joint]
                    off = has_left(laid, lane, link.a, joined.slide)
                    off = off or has_left(laid, lane, link.b, joined.slide)
                    observe_off(off, time, seen)
            for k in range(count):
                block = blocks[k, lane]
                place = laid.places[lane, k]
                v = laid.moves[lane, k]
                if block.light > zero:
                    add_energy(pull, gain, block, place, kept.before[lane, k], v, account)
                    integrate(dt, block, v, place)
                    laid.moves[lane, k] = v
                    laid.places[lane, k] = place
                    strayed = larger(strayed_by(block, kept.stood[lane, k], place), strayed)
                    peak = kept.peaks[lane, k]
                    observe_block(time, block, place, v, peak, seen)
                    kept.peaks[lane, k] = peak
            account = keep_account(wp.sqrt(inner(gain, gain)), account)
            seen.still = wp.where(seen.speed <= blocks[0, lane].calm, time, seen.still)
            last = smaller(end, seen.collapse_time + knobs.after_collapse)
        if found.attitudes.shape[0] > 0 and number >= 0:
            passed = time + SAME * dt
            while sample < samples and sample_times[sample] <= passed:
                back = wp.where(live > 0, larger(passed - sample_times[sample], zero), zero)
                for k in range(count):
                    block = blocks[k, lane]
                    q = laid.places[lane, k].q
                    v = laid.moves[lane, k]
                    if block.light > zero:
                        spin = times(inertia(block, laid.places[lane, k].r), v.o)
                        q = turn_block(block, q, spin, -back)
                    at = add_part(-back, v.v, laid.places[lane, k].at)
                    for i in range(4):
                        found.attitudes[sample, k, i, lane] = q[i]
                    if found.places.shape[0] > 0:
                        for i in range(3):
                            found.places[sample, k, i, lane] = at[i]
                sample += 1
    if found.attitudes.shape[0] > 0:
        for late in range(sample, samples):
            for k in range(count):
                for i in range(4):
                    found.attitudes[late, k, i, lane] = laid.places[lane, k].q[i]
                if found.places.shape[0] > 0:
                    for i in range(3):
                        found.places[late, k, i, lane] = laid.places[lane, k].at[i]
    found.results[lane] = Result(
        last_mode(seen), seen.steps, seen.impacts, seen.sweeps, seen.astray, seen.uplift_time,
        seen.moved, seen.deepest, seen.peak, seen.peak_time, seen.collapse_time, seen.still,
        seen.residual, account.loss, account.supplied, account.returned,
    )  # fmt: skip
    for k in range(count):
        away = laid.places[lane, k].at - start_place(blocks[k, lane]).at
        peak = kept.peaks[lane, k]
        found.blocks[k, lane] = BlockResult(peak.turn, peak.moved, wp.sqrt(inner(away, away)))
    for joint in range(joints):
        joined = laid.joined[lane, joint]
        slide = wp.sqrt(inner(joined.slide, joined.slide))
        row = 2 * laid.links[lane, joint].number
        found.contacts[row, lane] = ContactResult(joined.opening, joined.most, slide)
        if BONDS:
            found.bonds[row, lane] = joined.holds
    if BONDS:
        found.breaks[lane] = breaks
