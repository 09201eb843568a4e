"""Runs of the impulse step over stacks of blocks: LANES stacks a thread, side by side.

Loops over the lanes are innermost and work on local matrices, one row a body or a point (see
rows.py), so that the compiler turns them into vector code. With one lane a thread the same text is
the plain form for any device.

A run begins with SETTLING solves at the start. shape/stack_run.py holds what all stepped stacks
share. If CHAINS is true, blocks are bodies, with three points an interface
(impulse/stack_body.py), and the corners of all of them are one table, block by block.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, UPWARDS
from warprock.kernels.impulse.block import Knobs
from warprock.kernels.impulse.stack import (
    Contact,
    Penetration,
    Shift,
    add_energy,
    deeper_of,
    find_contact,
    integrate,
    lift_out,
    predict,
    side_of,
    solve_contact,
    warm_start,
)
from warprock.kernels.lane.account import Account, keep_account
from warprock.kernels.launch.instance import ONE_VECTOR
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import base_velocity
from warprock.kernels.shape.above import Motions, move_up
from warprock.kernels.shape.interface import (
    GROUND,
    Impulse,
    Mass,
    Point,
    Pose,
    Velocity,
    add_impulses,
)
from warprock.kernels.shape.rising import equivalent_gain
from warprock.kernels.shape.stack_body import Foot
from warprock.kernels.shape.stack_found import (
    Found,
    Peaks,
    Seen,
    at_sample,
    block_result,
    result_of,
    start_peaks,
    start_seen,
)
from warprock.kernels.shape.stack_run import (
    Base,
    Interface,
    Lane,
    Slide,
    Stack,
    Step,
    begin_step,
    mass_of,
    move_base,
    part_kept,
    part_of,
    start_lane,
    start_pose,
)

if CHAINS:
    from warprock.kernels.impulse.stack_body import (
        balance,
        find_corners,
        move_impulses,
        observe,
        view_block,
    )
    from warprock.kernels.shape.body_seen import CornerParting as Parting
    from warprock.kernels.shape.stack_body import (
        Block,
        Middle,
        Window,
        find_foot,
        overlap_of,
        start_impulses,
        way_of_window,
    )
    from warprock.kernels.shape.stack_body import Top as Face
    from warprock.kernels.shape.stack_body import ground_top as ground
    from warprock.kernels.shape.stack_body import top_of as face_of
else:
    from warprock.kernels.contact.parting import Parting
    from warprock.kernels.shape.interface import Box as Face
    from warprock.kernels.shape.interface import find_end
    from warprock.kernels.shape.stack_run import (
        Block,
        balance,
        bearings,
        ground,
        observe,
        start_impulses,
        swap_unless,
        view_interface,
    )
    from warprock.kernels.shape.stack_run import box_of as face_of

wp.set_module_options(ONE_VECTOR)

SETTLING = 200
"""Solves before the run. A flat stack starts from its statics and needs none."""
EACH = 3 if CHAINS else 2
"""Points of an interface."""


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), feet: wp.array2d(dtype=Foot),
    motions: Motions, pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real),
    knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time; `feet` is empty for boxes."""
    pack, _one = wp.tid()
    first, dt = pack * LANES, knobs.time_step
    # Points, a row each: those of interface 1 in the order of visits, those of interface 2, ...
    point = rows(Point, EACH * BLOCKS)
    contact = rows(Contact, EACH * BLOCKS)
    impulse = rows(Impulse, EACH * BLOCKS)
    # Bodies, the ground first: `old` is the velocity before a step, `new` the one after it.
    face = rows(Face, BLOCKS + 1)
    mass = rows(Mass, BLOCKS + 1)
    pose = rows(Pose, BLOCKS + 1)
    old = rows(Velocity, BLOCKS + 1)
    new = rows(Velocity, BLOCKS + 1)
    interface = rows(Interface, BLOCKS + 1)
    parting = rows(Parting, BLOCKS + 1)
    slide = rows(Slide, BLOCKS + 1)
    peaks = rows(Peaks, BLOCKS + 1)
    if CHAINS:
        middle = rows(Middle, BLOCKS + 1)
        chain = feet.shape[0] // BLOCKS
    lane = rows(Lane)
    base = rows(Base)
    account = rows(Account)
    seen = rows(Seen)
    shift = rows(Shift)
    bodies, points, sweeps = int(BLOCKS + 1), int(EACH * BLOCKS), int(ITERATIONS)  # loops stay
    for i in range(LANES):
        lean = sign_of(lanes[first + i].lean)
        lane[i] = start_lane(lanes[first + i])
        seen[i] = start_seen(lanes[first + i].uplift_time)
        face[GROUND, i] = ground()
        pose[GROUND, i].c = real(1.0)
        for k in range(1, bodies):
            block = blocks[k - 1, first + i]
            face[k, i] = face_of(block)
            mass[k, i] = mass_of(block)
            pose[k, i] = start_pose(block)
            interface[k, i] = Interface(block.friction, lean)
            peaks[k, i] = start_peaks(block.theta)
            if CHAINS:
                slide[k, i].start = block.aside
                middle[k, i].row = block.window
                one, two = start_impulses(block, lean, pose[k - 1, i].theta)
            else:
                slide[k, i].start = block.offset
                one, two = start_impulses(block, lean)
            impulse[EACH * k - EACH, i] = one
            impulse[EACH * k - EACH + 1, i] = two
    count = int(-SETTLING)
    time = real(count) * dt
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until:
            count += 1
            time = real(count) * dt
            half, kept = larger(time - HALF * dt, HALF * dt), part_kept(count)
            for i in range(LANES):
                if VERTICAL:
                    motion = motions[ALONG, first + i]
                    up = motions[UPWARDS, first + i]
                    climb = base_velocity(up, half, pool)
                    move_up(climb, count > 0, base[i].rise, base[i].rising)
                else:
                    motion = motions[first + i]
                moving = base_velocity(motion, half, pool)
                base[i] = move_base(moving, count, base[i])
                lane[i] = begin_step(count, seen[i].mode, base[i].hint, lane[i])
                seen[i].steps = seen[i].steps + lane[i].live
                shift[i] = Shift(real(0.0), real(0.0))
                pull = equivalent_gain(base[i].gain, base[i].rise, dt * knobs.gravity)
                account[i] = keep_account(pull, account[i])
            for k in range(1, bodies):
                low, p, q, r = k - 1, EACH * k - EACH, EACH * k - EACH + 1, EACH * k - 1
                for i in range(LANES):
                    new[k, i] = predict(old[k, i], base[i], knobs)
                    turn = pose[k, i].theta - pose[low, i].theta
                    rate = old[k, i].omega - old[low, i].omega
                    lean = side_of(turn, rate, base[i].hint, interface[k, i].lean)
                    one = impulse[p, i]
                    two = impulse[q, i]
                    if CHAINS:
                        f = first + i
                        w = middle[k, i].row
                        window = Window(feet[w - 1, f], feet[w, f], feet[w + 1, f])
                        way = way_of_window(window, lean, pose[k, i], pose[low, i], face[low, i])
                        three = impulse[r, i]
                        move_impulses(way, lean, lean == interface[k, i].lean, one, two, three)
                        impulse[r, i] = three
                        middle[k, i] = Middle(w + way, way)
                    else:
                        swap_unless(lean == interface[k, i].lean, one, two)
                    impulse[p, i] = one
                    impulse[q, i] = two
                    interface[k, i].lean = lean
            for p in range(points):
                low, k = p // EACH, p // EACH + 1
                for i in range(LANES):
                    margin = knobs.collision_margin
                    if CHAINS:
                        nth = p % EACH - 1
                        role = wp.where(interface[k, i].lean > real(0.0), nth, -nth)
                        f = first + i
                        w = middle[k, i].row
                        window = Window(feet[w - 1, f], feet[w, f], feet[w + 1, f])
                        there, at, found_gap, _place = find_foot(
                            window, role, pose[k, i], pose[low, i], face[low, i]
                        )
                        gap = wp.where(there, found_gap, NEVER)
                    else:
                        side = real(2 * (p % EACH) - 1) * interface[k, i].lean
                        at, gap, _place = find_end(
                            side, face[k, i], pose[k, i], face[low, i], pose[low, i]
                        )
                    one = warm_start(gap, margin, impulse[p, i])
                    u = new[k, i]
                    v = new[low, i]
                    add_impulses(mass[k, i], mass[low, i], at, one, u, v)
                    contact[p, i] = find_contact(at, gap, margin, mass[k, i], mass[low, i])
                    point[p, i] = at
                    impulse[p, i] = one
                    new[k, i] = u
                    new[low, i] = v
            for visit in range(sweeps * points):
                p = visit % points
                low, k = p // EACH, p // EACH + 1
                q, r = EACH * low + (p + 1) % EACH, EACH * low + (p + 2) % EACH
                for i in range(LANES):
                    u = new[k, i]
                    v = new[low, i]
                    others = contact[q, i].pn
                    if CHAINS:
                        others = others + contact[r, i].pn
                    one = solve_contact(
                        interface[k, i].friction, knobs.rate, point[p, i], contact[p, i], others,
                        impulse[p, i], u, v,
                    )  # fmt: skip
                    change = Impulse(one.n - impulse[p, i].n, one.t - impulse[p, i].t)
                    add_impulses(mass[k, i], mass[low, i], point[p, i], change, u, v)
                    impulse[p, i] = one
                    new[k, i] = u
                    new[low, i] = v
            for k in range(1, bodies):
                low, p, q, r = k - 1, EACH * k - EACH, EACH * k - EACH + 1, EACH * k - 1
                for i in range(LANES):
                    live = lane[i].live > 0
                    one = impulse[p, i]
                    two = impulse[q, i]
                    deepest = deeper_of(
                        Penetration(contact[p, i].gap, point[p, i].nx, point[p, i].nz),
                        Penetration(contact[q, i].gap, point[q, i].nx, point[q, i].nz),
                    )
                    if CHAINS:
                        three = impulse[r, i]
                        u = new[k, i]
                        balance(lane[i].even, point[q, i].au, one, two, three, u)
                        impulse[r, i] = three
                        new[k, i] = u
                        deepest = deeper_of(
                            deepest, Penetration(contact[r, i].gap, point[r, i].nx, point[r, i].nz)
                        )
                    else:
                        balance(lane[i].even, one, two, new[k, i].x, new[k, i].omega)
                    impulse[p, i] = one
                    impulse[q, i] = two
                    shift[i] = lift_out(knobs, base[i].rise, deepest, shift[i])
                    book = account[i]
                    add_energy(
                        live, knobs, base[i], mass[k, i], shift[i], old[k, i], new[k, i], book
                    )
                    account[i] = book
                    pose[k, i] = integrate(live, dt, shift[i], new[k, i], pose[k, i])
                    old[k, i] = part_of(kept, new[k, i])
                    step = Step(lane[i].live, time, dt, knobs.gravity)
                    ends = parting[k, i]
                    slid = slide[k, i]
                    most = peaks[k, i]
                    sees = seen[i]
                    if CHAINS:
                        f = first + i
                        w = middle[k, i].row
                        window = Window(feet[w - 1, f], feet[w, f], feet[w + 1, f])
                        corners, place = find_corners(
                            window, pose[k, i], pose[low, i], face[low, i], interface[k, i].lean,
                            one.n, two.n, three.n,
                        )  # fmt: skip
                        overlap = overlap_of(
                            feet[low * chain, f], window.middle, feet[k * chain - 1, f],
                            pose[k, i], pose[low, i], face[low, i],
                        )  # fmt: skip
                        view = view_block(
                            step, blocks[low, f], pose[k, i], pose[low, i], place, overlap,
                            new[k, i], new[low, i].omega,
                        )  # fmt: skip
                        observe(step, view, middle[k, i].way, corners, ends, slid, most, sees)
                    else:
                        view = view_interface(
                            step, face[k, i], pose[k, i], face[low, i], pose[low, i],
                            new[k, i], new[low, i].omega,
                        )  # fmt: skip
                        left, right = bearings(
                            interface[k, i].lean, one.n, two.n, face[k, i], pose[k, i],
                            face[low, i], pose[low, i],
                        )  # fmt: skip
                        observe(step, view, left, right, ends, slid, most, sees)
                    parting[k, i] = ends
                    slide[k, i] = slid
                    peaks[k, i] = most
                    seen[i] = sees
        past = time - until
        if found.rotations.shape[0] > 0:
            for k in range(1, bodies):
                for i in range(LANES):
                    o, f = k - 1, first + i
                    turn = at_sample(seen[i].mode, past, pose[k, i].theta, old[k, i].omega)
                    found.rotations[sample, o, f] = turn
                    if found.places.shape[0] > 0:
                        x = at_sample(seen[i].mode, past, pose[k, i].x, old[k, i].x)
                        z = at_sample(seen[i].mode, past, pose[k, i].z, old[k, i].z)
                        found.places[sample, o, ALONG, f] = x
                        found.places[sample, o, UPWARDS, f] = z
    for i in range(LANES):
        pull = equivalent_gain(base[i].gain, base[i].rise, dt * knobs.gravity)
        account[i] = keep_account(pull, account[i])
        found.results[first + i] = result_of(seen[i], account[i])
        for k in range(1, bodies):
            found.blocks[k - 1, first + i] = block_result(slide[k, i].now, peaks[k, i])
