"""Runs of the position-level step over stacks of blocks: LANES stacks a thread, side by side.

A single block is a stack of one. Loops over the lanes are innermost and work on local matrices,
one row a body or a point (see rows.py), so that the compiler turns them into vector code. With one
lane a thread the same text is the plain form for any device.

A run begins with SETTLING solves at the start. shape/stack_run.py holds what all stepped stacks
share.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, UPWARDS
from warprock.kernels.contact.parting import Parting
from warprock.kernels.lane.account import Account, keep_account
from warprock.kernels.launch.instance import ONE_VECTOR
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, base_velocity
from warprock.kernels.shape.interface import GROUND, Box, Impulse, Mass, Point, Pose, Velocity
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
    Block,
    Interface,
    Lane,
    Slide,
    Stack,
    Step,
    balance,
    bearings,
    begin_step,
    box_of,
    ground,
    mass_of,
    move_base,
    observe,
    part_kept,
    part_of,
    start_impulses,
    start_lane,
    start_pose,
    swap_unless,
    view_interface,
)
from warprock.kernels.xpbd.stack import (
    LOOSE,
    Ahead,
    Knobs,
    Spot,
    add_energy,
    anchor_after,
    below_ahead,
    closes,
    correct,
    find_contact,
    integrate,
    pose_ahead,
    predict,
    side_of,
    solve,
    swap_anchors_unless,
    turn_ahead,
    warm_start,
)
from warprock.kernels.xpbd.stack_pair import Contact, Coupling, End, Grip

if BLOCKS == 1:
    from warprock.kernels.xpbd.stack_ground import (
        TURNS,
        add_changes,
        add_impulses,
        couple,
        find_end,
    )
else:
    from warprock.kernels.shape.interface import add_impulses, find_end
    from warprock.kernels.xpbd.stack_pair import TURNS, add_changes, couple

wp.set_module_options(ONE_VECTOR)

SETTLING = 40 * BLOCKS
"""Solves before the run. A flat stack starts from its statics and needs none."""
BEFORE = real(SETTLING)


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    pack, _one = wp.tid()
    first, dt = pack * LANES, knobs.time_step
    # Points, a row each: the first and the second end of interface 1, of interface 2, ...
    point = rows(Point, 2 * BLOCKS)
    grip = rows(Grip, 2 * BLOCKS)
    # Points in the velocity pass, then in the pose pass. Multipliers are kept as impulses.
    contact = rows(Contact, 4 * BLOCKS)
    impulse = rows(Impulse, 4 * BLOCKS)
    # Bodies, the ground first, and their corrections in both passes.
    box = rows(Box, BLOCKS + 1)
    mass = rows(Mass, BLOCKS + 1)
    pose = rows(Pose, BLOCKS + 1)
    ahead = rows(Ahead, BLOCKS + 1)
    velocity = rows(Velocity, BLOCKS + 1)
    move = rows(Velocity, 2 * BLOCKS + 2)
    interface = rows(Interface, BLOCKS + 1)
    coupling = rows(Coupling, BLOCKS + 1)
    parting = rows(Parting, BLOCKS + 1)
    slide = rows(Slide, BLOCKS + 1)
    peaks = rows(Peaks, BLOCKS + 1)
    lane = rows(Lane)
    base = rows(Base)
    account = rows(Account)
    seen = rows(Seen)
    # Variables, not constants, so that Warp does not unroll the loops over them.
    bodies, points, parts = int(BLOCKS + 1), int(2 * BLOCKS), int(2)
    sweeps = int(ITERATIONS // TURNS)
    for i in range(LANES):
        lean = sign_of(lanes[first + i].lean)
        lane[i] = start_lane(lanes[first + i])
        seen[i] = start_seen(lanes[first + i].uplift_time)
        box[GROUND, i] = ground()
        pose[GROUND, i].c = real(1.0)
        ahead[GROUND, i].c = real(1.0)
        for k in range(1, bodies):
            block = blocks[k - 1, first + i]
            box[k, i] = box_of(block)
            mass[k, i] = mass_of(block)
            pose[k, i] = start_pose(block)
            interface[k, i] = Interface(block.friction, lean)
            slide[k, i].start = block.offset
            peaks[k, i] = start_peaks(block.theta)
            one, two = start_impulses(block, lean)
            impulse[2 * k - 2, i] = one
            impulse[2 * k - 1, i] = two
            grip[2 * k - 2, i].anchor = LOOSE
            grip[2 * k - 1, i].anchor = LOOSE
    count = int(-SETTLING)
    time = -BEFORE * dt
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until:
            count += 1
            time = real(count) * dt
            half, kept = larger(time - HALF * dt, HALF * dt), part_kept(count)
            for i in range(LANES):
                motion = motions[first + i]
                moving = base_velocity(motion, half, pool)
                base[i] = move_base(moving, count, base[i])
                lane[i] = begin_step(count, seen[i].mode, base[i].hint, lane[i])
                seen[i].steps = seen[i].steps + lane[i].live
                account[i] = keep_account(base[i].gain, account[i])
            for k in range(1, bodies):
                low, p, q = k - 1, 2 * k - 2, 2 * k - 1
                for i in range(LANES):
                    turn = pose[k, i].theta - pose[low, i].theta
                    rate = velocity[k, i].omega - velocity[low, i].omega
                    lean = side_of(turn, rate, base[i].hint, interface[k, i].lean)
                    same = lean == interface[k, i].lean
                    one = impulse[p, i]
                    two = impulse[q, i]
                    swap_unless(same, one, two)
                    impulse[p, i] = one
                    impulse[q, i] = two
                    swap_anchors_unless(same, grip[p, i].anchor, grip[q, i].anchor)
                    interface[k, i].lean = lean
                    ahead[k, i] = turn_ahead(dt, pose[k, i], velocity[k, i].omega)
                    velocity[k, i] = predict(velocity[k, i], base[i].gain, knobs)
                    move[k, i] = Velocity(real(0.0), real(0.0), real(0.0))
            for p in range(points):
                low, k, r, way = p // 2, p // 2 + 1, points + p, real(2 * (p % 2) - 1)
                for i in range(LANES):
                    side = way * interface[k, i].lean
                    at, gap, place = find_end(
                        side, box[k, i], pose[k, i], box[low, i], pose[low, i]
                    )
                    _later, next_gap, next_place = find_end(
                        side, box[k, i],
                        pose_ahead(dt, pose[k, i], pose[low, i], velocity[k, i], velocity[low, i],
                                   ahead[k, i]),
                        box[low, i], below_ahead(ahead[low, i]),
                    )  # fmt: skip
                    velocities, poses, sticks = find_contact(
                        knobs, mass[k, i], mass[low, i], at, Spot(gap, place),
                        Spot(next_gap, next_place), grip[p, i].anchor,
                    )  # fmt: skip
                    one = warm_start(closes(knobs, gap), impulse[p, i])
                    u = move[k, i]
                    v = move[low, i]
                    add_impulses(mass[k, i], mass[low, i], at, one, u, v)
                    point[p, i] = at
                    contact[p, i] = velocities
                    contact[r, i] = poses
                    grip[p, i] = sticks
                    impulse[p, i] = one
                    move[k, i] = u
                    move[low, i] = v
            # Found once a step: found in every sweep, it would take a tenth of the time of a run.
            for k in range(1, bodies):
                for i in range(LANES):
                    coupling[k, i] = couple(
                        mass[k, i], mass[k - 1, i], point[2 * k - 2, i], point[2 * k - 1, i]
                    )
            for part in range(parts):  # Velocities, then poses, which start from their multipliers.
                for k in range(1, bodies * part):
                    p, q, b = 2 * k - 2, 2 * k - 1, bodies + k
                    r, w = points + p, points + q
                    for i in range(LANES):
                        one = impulse[p, i]
                        two = impulse[q, i]
                        push = move[k, i]
                        balance(lane[i].even, one, two, push.x, push.omega)
                        impulse[p, i] = one
                        impulse[q, i] = two
                        impulse[r, i] = one
                        impulse[w, i] = two
                        move[k, i] = push
                        move[b, i] = push
                for visit in range(sweeps * BLOCKS):
                    low = visit % BLOCKS
                    k, p, q = low + 1, 2 * low, 2 * low + 1
                    b, r, w = k + part * bodies, p + part * points, q + part * points
                    for i in range(LANES):
                        first_end = End(point[p, i], contact[r, i], grip[p, i].dt, impulse[r, i])
                        second_end = End(point[q, i], contact[w, i], grip[q, i].dt, impulse[w, i])
                        u = move[b, i]
                        v = move[b - 1, i]
                        one, two = solve(
                            interface[k, i].friction, coupling[k, i], first_end, second_end, u, v
                        )
                        add_changes(mass[k, i], mass[low, i], first_end, second_end, one, two, u, v)
                        impulse[r, i] = one
                        impulse[w, i] = two
                        move[b, i] = u
                        move[b - 1, i] = v
            for k in range(1, bodies):
                low, p, q, b = k - 1, 2 * k - 2, 2 * k - 1, bodies + k
                r, w = points + p, points + q
                for i in range(LANES):
                    live = lane[i].live > 0
                    one = impulse[r, i]
                    two = impulse[w, i]
                    lift = move[b, i]
                    balance(lane[i].even, one, two, lift.x, lift.omega)
                    book = account[i]
                    add_energy(
                        live,
                        knobs,
                        base[i].gain,
                        mass[k, i],
                        velocity[k, i],
                        move[k, i],
                        lift,
                        book,
                    )
                    account[i] = book
                    pose[k, i] = integrate(live, dt, pose[k, i], velocity[k, i], lift)
                    u = part_of(kept, correct(knobs.rate, velocity[k, i], move[k, i]))
                    velocity[k, i] = u
                    mu = interface[k, i].friction
                    grip[p, i].anchor = anchor_after(mu, one, grip[p, i].anchor)
                    grip[q, i].anchor = anchor_after(mu, two, grip[q, i].anchor)
                    step = Step(lane[i].live, time, dt, knobs.gravity)
                    view = view_interface(
                        step, box[k, i], pose[k, i], box[low, i], pose[low, i], u,
                        velocity[low, i].omega,
                    )  # fmt: skip
                    left, right = bearings(
                        interface[k, i].lean, impulse[p, i].n, impulse[q, i].n, box[k, i],
                        pose[k, i], box[low, i], pose[low, i],
                    )  # fmt: skip
                    ends = parting[k, i]
                    slid = slide[k, i]
                    most = peaks[k, i]
                    sees = seen[i]
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
                    turn = at_sample(seen[i].mode, past, pose[k, i].theta, velocity[k, i].omega)
                    found.rotations[sample, o, f] = turn
                    if found.places.shape[0] > 0:
                        x = at_sample(seen[i].mode, past, pose[k, i].x, velocity[k, i].x)
                        z = at_sample(seen[i].mode, past, pose[k, i].z, velocity[k, i].z)
                        found.places[sample, o, ALONG, f] = x
                        found.places[sample, o, UPWARDS, f] = z
    for i in range(LANES):
        account[i] = keep_account(base[i].gain, account[i])
        found.results[first + i] = result_of(seen[i], account[i])
        for k in range(1, bodies):
            found.blocks[k - 1, first + i] = block_result(slide[k, i].now, peaks[k, i])
