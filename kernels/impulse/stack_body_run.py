"""Runs of the impulse step over stacks with bodies: LANES stacks a thread, side by side.

As impulse/stack_run.py, with three rows of points an interface in the order in which they are
visited, and the corners of all blocks in one table, block by block.
"""

import warp as wp

from warprock.kernels.account import Account, keep_account
from warprock.kernels.impulse.stack import (
    Contact,
    Knobs,
    Penetration,
    Shift,
    add_energy,
    deeper,
    find_contact,
    integrate,
    lift_out,
    predict,
    side_of,
    solve_contact,
    warm_start,
)
from warprock.kernels.impulse.stack_body import (
    balance,
    find_corners,
    move_impulses,
    observe,
    view_block,
)
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.motion import base_velocity, sample_index, sample_segment
from warprock.kernels.rows import kernel, rows
from warprock.kernels.shape.above import Motions, move_up
from warprock.kernels.shape.body_seen import CornerParting
from warprock.kernels.shape.interface import (
    Impulse,
    Mass,
    Point,
    Pose,
    Velocity,
    add_impulses,
)
from warprock.kernels.shape.rising import pulled
from warprock.kernels.shape.stack_body import (
    Block,
    Foot,
    Middle,
    Top,
    Window,
    find_foot,
    ground_top,
    overlap_of,
    start_impulses,
    top_of,
    way_of_window,
)
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

wp.set_module_options(ONE_VECTOR)

SETTLING = 200
"""Solves before the run, as in impulse/stack_run.py."""


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), feet: wp.array2d(dtype=Foot),
    motions: Motions, pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real),
    knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    pack, _one = wp.tid()
    first, dt, chain = pack * LANES, knobs.time_step, feet.shape[0] // BLOCKS
    # Points, a row each: the three of interface 1, of interface 2, ...
    point = rows(Point, 3 * BLOCKS)
    contact = rows(Contact, 3 * BLOCKS)
    impulse = rows(Impulse, 3 * BLOCKS)
    # Bodies, the ground first: `old` is the velocity before a step, `new` the one after it.
    top = rows(Top, BLOCKS + 1)
    mass = rows(Mass, BLOCKS + 1)
    pose = rows(Pose, BLOCKS + 1)
    old = rows(Velocity, BLOCKS + 1)
    new = rows(Velocity, BLOCKS + 1)
    interface = rows(Interface, BLOCKS + 1)
    parting = rows(CornerParting, BLOCKS + 1)
    slide = rows(Slide, BLOCKS + 1)
    peaks = rows(Peaks, BLOCKS + 1)
    middle = rows(Middle, BLOCKS + 1)
    lane = rows(Lane)
    base = rows(Base)
    account = rows(Account)
    seen = rows(Seen)
    shift = rows(Shift)
    bodies, points, sweeps = int(BLOCKS + 1), int(3 * BLOCKS), int(ITERATIONS)  # loops stay
    for i in range(LANES):
        lean = sign_of(lanes[first + i].lean)
        lane[i] = start_lane(lanes[first + i])
        seen[i] = start_seen(lanes[first + i].uplift_time)
        top[0, i] = ground_top()
        pose[0, i].c = real(1.0)
        for k in range(1, bodies):
            block = blocks[k - 1, first + i]
            top[k, i] = top_of(block)
            mass[k, i] = mass_of(block)
            pose[k, i] = start_pose(block)
            interface[k, i] = Interface(block.friction, lean)
            slide[k, i].start = block.aside
            peaks[k, i] = start_peaks(block.theta)
            middle[k, i].row = block.window
            one, two = start_impulses(block, lean, pose[k - 1, i].theta)
            impulse[3 * k - 3, i] = one
            impulse[3 * k - 2, i] = two
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
                    motion = motions[0, first + i]
                    up = motions[1, first + i]
                    line = sample_index(up, sample_segment(up, half))
                    climb = base_velocity(up, half, pool[2, line], pool[0, line], pool[1, line])
                    move_up(climb, count > 0, base[i].rise, base[i].rising)
                else:
                    motion = motions[first + i]
                line = sample_index(motion, sample_segment(motion, half))
                moving = base_velocity(motion, half, pool[2, line], pool[0, line], pool[1, line])
                base[i] = move_base(moving, count, base[i])
                lane[i] = begin_step(count, seen[i].mode, base[i].hint, lane[i])
                seen[i].steps = seen[i].steps + lane[i].live
                shift[i] = Shift(real(0.0), real(0.0))
                pull = pulled(base[i].gain, base[i].rise, dt * knobs.gravity)
                account[i] = keep_account(pull, account[i])
            for k in range(1, bodies):
                low, p, q, r = k - 1, 3 * k - 3, 3 * k - 2, 3 * k - 1
                for i in range(LANES):
                    new[k, i] = predict(old[k, i], base[i], knobs)
                    turn = pose[k, i].theta - pose[low, i].theta
                    rate = old[k, i].omega - old[low, i].omega
                    lean = side_of(turn, rate, base[i].hint, interface[k, i].lean)
                    f = first + i
                    w = middle[k, i].row
                    window = Window(feet[w - 1, f], feet[w, f], feet[w + 1, f])
                    way = way_of_window(window, lean, pose[k, i], pose[low, i], top[low, i])
                    one = impulse[p, i]
                    two = impulse[q, i]
                    three = impulse[r, i]
                    move_impulses(way, lean, lean == interface[k, i].lean, one, two, three)
                    impulse[p, i] = one
                    impulse[q, i] = two
                    impulse[r, i] = three
                    middle[k, i] = Middle(w + way, way)
                    interface[k, i].lean = lean
            for p in range(points):
                low, k, nth = p // 3, p // 3 + 1, p % 3 - 1
                for i in range(LANES):
                    margin = knobs.collision_margin
                    role = wp.where(interface[k, i].lean > real(0.0), nth, -nth)
                    f = first + i
                    w = middle[k, i].row
                    window = Window(feet[w - 1, f], feet[w, f], feet[w + 1, f])
                    there, at, found_gap, _place = find_foot(
                        window, role, pose[k, i], pose[low, i], top[low, i]
                    )
                    gap = wp.where(there, found_gap, NEVER)
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
                p, low, k = visit % points, visit % points // 3, visit % points // 3 + 1
                q, r = 3 * low + (p + 1) % 3, 3 * low + (p + 2) % 3
                for i in range(LANES):
                    u = new[k, i]
                    v = new[low, i]
                    one = solve_contact(
                        interface[k, i].friction, knobs.rate, point[p, i], contact[p, i],
                        contact[q, i].pn + contact[r, i].pn, impulse[p, i], u, v,
                    )  # fmt: skip
                    change = Impulse(one.n - impulse[p, i].n, one.t - impulse[p, i].t)
                    add_impulses(mass[k, i], mass[low, i], point[p, i], change, u, v)
                    impulse[p, i] = one
                    new[k, i] = u
                    new[low, i] = v
            for k in range(1, bodies):
                low, p, q, r = k - 1, 3 * k - 3, 3 * k - 2, 3 * k - 1
                for i in range(LANES):
                    live, f = lane[i].live > 0, first + i
                    w = middle[k, i].row
                    one = impulse[p, i]
                    two = impulse[q, i]
                    three = impulse[r, i]
                    u = new[k, i]
                    balance(lane[i].even, point[q, i].au, one, two, three, u)
                    impulse[p, i] = one
                    impulse[q, i] = two
                    impulse[r, i] = three
                    new[k, i] = u
                    deepest = deeper(
                        Penetration(contact[p, i].gap, point[p, i].nx, point[p, i].nz),
                        Penetration(contact[q, i].gap, point[q, i].nx, point[q, i].nz),
                    )
                    deepest = deeper(
                        deepest, Penetration(contact[r, i].gap, point[r, i].nx, point[r, i].nz)
                    )
                    shift[i] = lift_out(knobs, base[i].rise, deepest, shift[i])
                    book = account[i]
                    add_energy(live, knobs, base[i], mass[k, i], shift[i], old[k, i], u, book)
                    account[i] = book
                    pose[k, i] = integrate(live, dt, shift[i], u, pose[k, i])
                    old[k, i] = part_of(kept, u)
                    step = Step(lane[i].live, time, dt, knobs.gravity)
                    window = Window(feet[w - 1, f], feet[w, f], feet[w + 1, f])
                    corners, place = find_corners(
                        window, pose[k, i], pose[low, i], top[low, i], interface[k, i].lean, one.n,
                        two.n, three.n,
                    )  # fmt: skip
                    overlap = overlap_of(
                        feet[low * chain, f], window.middle, feet[k * chain - 1, f], pose[k, i],
                        pose[low, i], top[low, i],
                    )  # fmt: skip
                    view = view_block(
                        step, blocks[low, f], pose[k, i], pose[low, i], place, overlap, u,
                        new[low, i].omega,
                    )  # fmt: skip
                    ends = parting[k, i]
                    slid = slide[k, i]
                    most = peaks[k, i]
                    sees = seen[i]
                    observe(step, view, middle[k, i].way, corners, ends, slid, most, sees)
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
                        found.places[sample, o, 0, f] = x
                        found.places[sample, o, 1, f] = z
    for i in range(LANES):
        pull = pulled(base[i].gain, base[i].rise, dt * knobs.gravity)
        account[i] = keep_account(pull, account[i])
        found.results[first + i] = result_of(seen[i], account[i])
        for k in range(1, bodies):
            found.blocks[k - 1, first + i] = block_result(slide[k, i].now, peaks[k, i])
