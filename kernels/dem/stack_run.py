"""Runs of the soft-spring step over stacks: LANES stacks a thread, side by side.

A single block is a stack of one. Every lane has its own time step, and with it its own number of
steps; a pack goes on until the last of its lanes has reached the next sample.

Loops over the lanes are innermost and work on local matrices, one row a body or a point, so that
the compiler turns them into vector code; with one lane a thread the same text is the plain form
for any device.

An interface has parted once its faces gape from the middle to three quarters of the way to an end
(`PIVOT` of dem/stack_lanes.py): the springs of an eighth of the face carry all, and the block turns
about that end, where before it leaned on its springs. It has landed, an impact, once it is closed
in the middle again. It slides while all springs that carry slip, faster than the bound of `slides`
in parting.py.

If CHAINS is true blocks are bodies, with a spring under each of three points an interface
(dem/stack_body.py), and the corners of all of them are one table, block by block. What lies between
the two points that are deepest counts as the interface that parts and lands.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, UPWARDS
from warprock.kernels.dem.stack import Base, Energy, Knobs, Load, Pace, Spring, integrate
from warprock.kernels.dem.stack_lanes import (
    Seat,
    begin_step,
    dissipated_energy,
    glides,
    mode_after,
    move_base,
    observe_interface,
    passes_left,
    time_past,
)
from warprock.kernels.lane.account import Account, keep_account
from warprock.kernels.launch.instance import ONE_VECTOR
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import base_velocity
from warprock.kernels.shape.above import Motions
from warprock.kernels.shape.interface import GROUND, Mass, Pose, Velocity
from warprock.kernels.shape.rising import equivalent_gain
from warprock.kernels.shape.stack_body import Foot
from warprock.kernels.shape.stack_found import (
    Found,
    Peaks,
    Seen,
    block_result,
    observe_peaks,
    result_of,
    start_peaks,
    start_seen,
)
from warprock.kernels.shape.stack_run import mass_of, start_pose

if CHAINS:
    from warprock.kernels.dem.stack import lean_of
    from warprock.kernels.dem.stack_body import (
        Contacts,
        Interface,
        find_contact,
        load_blocks,
        move_springs,
        observe_contact,
        press,
    )
    from warprock.kernels.shape.stack_body import Block, Window, overlap_of, way_of_window
    from warprock.kernels.shape.stack_body import Top as Face
    from warprock.kernels.shape.stack_body import ground_top as ground
    from warprock.kernels.shape.stack_body import top_of as face_of
else:
    from warprock.kernels.dem.stack import (
        Block,
        Interface,
        Meeting,
        Stretch,
        Sums,
        add_pair,
        find_contacts,
        load_blocks,
        press,
    )
    from warprock.kernels.shape.interface import Box as Face
    from warprock.kernels.shape.stack_run import box_of as face_of
    from warprock.kernels.shape.stack_run import ground

wp.set_module_options(ONE_VECTOR)

POINTS = max(ITERATIONS, 2)
"""Sub-contacts of an interface."""
PAIRS = (POINTS + 1) // 2
"""Pairs of them; one in the middle counts as a pair of two halves."""
EACH = 3 if CHAINS else 2 * PAIRS
"""Springs of an interface: of bodies from -x to +x, of boxes pair by pair from the middle outwards,
in each the one at -x before the one at +x."""
ODD = POINTS % 2
SPACING = real(1.0 / (POINTS - 1))
"""Distance of two points over the length of the interface."""


@wp.struct
class Stack:
    """One lane's stack: its time step [s], when it is first uplifted [s], 0 or NEVER."""

    time_step: real
    uplift_time: real


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), feet: wp.array2d(dtype=Foot),
    motions: Motions, pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real),
    knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, each at its own time; of boxes there are no `feet`."""
    # Of bodies, the ground first.
    face = rows(Face, BLOCKS + 1)
    mass = rows(Mass, BLOCKS + 1)
    pose = rows(Pose, BLOCKS + 1)
    velocity = rows(Velocity, BLOCKS + 1)
    load = rows(Load, BLOCKS + 1)
    interface = rows(Interface, BLOCKS + 1)
    seat = rows(Seat, BLOCKS + 1)
    peaks = rows(Peaks, BLOCKS + 1)
    # Of points, those of interface 1, of interface 2, ...
    spring = rows(Spring, BLOCKS * EACH)
    # Of the interface that is being looked at.
    if CHAINS:
        contacts = rows(Contacts)
    else:
        stretch = rows(Stretch)
        meeting = rows(Meeting)
        sums = rows(Sums)
    pace = rows(Pace)
    base = rows(Base)
    energy = rows(Energy)
    account = rows(Account)
    seen = rows(Seen)
    # Variables, not constants: else Warp would unroll the loops over them.
    pack, _one = wp.tid()
    bodies, pairs, first = int(BLOCKS + 1), int(PAIRS), pack * LANES
    if CHAINS:
        corners = feet.shape[0] // BLOCKS
    for i in range(LANES):
        # The ground is level and has a face.
        face[GROUND, i] = ground()
        pose[GROUND, i].c = real(1.0)
        pace[i].dt = lanes[first + i].time_step
        seen[i] = start_seen(lanes[first + i].uplift_time)
        for k in range(1, bodies):
            block = blocks[k - 1, first + i]
            face[k, i] = face_of(block)
            mass[k, i] = mass_of(block)
            pose[k, i] = start_pose(block)
            seat[k, i].since = NEVER
            peaks[k, i] = start_peaks(block.theta)
            if CHAINS:
                interface[k, i] = Interface(block.friction, block.area, block.aside, block.window)
            else:
                velocity[k, i] = Velocity(block.vx, block.vz, block.omega)
                interface[k, i] = Interface(block.friction, block.depth, block.offset)
                for p in range(2 * pairs):
                    spring[2 * pairs * (k - 1) + p, i].u = block.stretch
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        passes = int(0)
        for i in range(LANES):
            left = passes_left(until, pace[i].steps, pace[i].dt, seen[i].mode)
            passes = wp.max(passes, left)
        for _ in range(passes):
            for i in range(LANES):
                mid = (real(pace[i].steps) + HALF) * pace[i].dt
                own, spent = pace[i], energy[i]
                account[i].loss = begin_step(until, seen[i].mode, own, spent)
                pace[i] = own
                energy[i] = spent
                rise = real(0.0)
                if VERTICAL:
                    lane = motions[ALONG, first + i]
                    up = motions[UPWARDS, first + i]
                    rise = base_velocity(up, mid, pool)
                else:
                    lane = motions[first + i]
                v = base_velocity(lane, mid, pool)
                base[i] = move_base(v, rise, pace[i].live, base[i])
                pull = equivalent_gain(base[i].dx, base[i].dz, knobs.gravity * pace[i].dt)
                account[i] = keep_account(pull, account[i])
            for k in range(1, bodies):
                low = k - 1
                if CHAINS:
                    p, q, r = 3 * k - 3, 3 * k - 2, 3 * k - 1
                    for i in range(LANES):
                        w = interface[k, i].window
                        f = first + i
                        turn = pose[k, i].theta - pose[low, i].theta
                        rate = velocity[k, i].omega - velocity[low, i].omega
                        way = way_of_window(
                            Window(feet[w - 1, f], feet[w, f], feet[w + 1, f]),
                            lean_of(turn, rate, base[i].dx), pose[k, i], pose[low, i],
                            face[low, i],
                        )  # fmt: skip
                        interface[k, i].window = w + way
                        one, two, three = spring[p, i], spring[q, i], spring[r, i]
                        move_springs(way, one, two, three)
                        spring[p, i] = one
                        spring[q, i] = two
                        spring[r, i] = three
                        contacts[i] = Contacts(-NEVER, -NEVER, contacts[i].speed, 0)
                    for visit in range(3):
                        # Both sides before the middle: a mirrored scene adds up alike.
                        role = 2 * (visit % 2) - 1 + visit // 2
                        row = 3 * low + 1 + role
                        for i in range(LANES):
                            w = interface[k, i].window
                            f = first + i
                            contact, point, along = find_contact(
                                Window(feet[w - 1, f], feet[w, f], feet[w + 1, f]), role,
                                pose[k, i], pose[low, i], face[low, i], velocity[k, i],
                                velocity[low, i],
                            )  # fmt: skip
                            one = spring[row, i]
                            force = press(knobs, pace[i], interface[k, i], contact, one)
                            spring[row, i] = one
                            above, below = load[k, i], load[low, i]
                            load_blocks(point, force, above, below)
                            load[k, i] = above
                            load[low, i] = below
                            energy[i].stored = energy[i].stored + force.stored
                            contacts[i] = observe_contact(role, contact, force.held, contacts[i])
                            seat[k, i].place = wp.where(role == 0, along, seat[k, i].place)
                    for i in range(LANES):
                        w = interface[k, i].window
                        f = first + i
                        shared = overlap_of(
                            feet[low * corners, f], feet[w, f], feet[k * corners - 1, f],
                            pose[k, i], pose[low, i], face[low, i],
                        )  # fmt: skip
                        half = HALF * (contacts[i].first + contacts[i].second)
                        tilt, sees = size(contacts[i].first - half), seen[i]
                        slips = glides(pace[i], knobs, contacts[i].held, contacts[i].speed)
                        observe_interface(
                            pace[i], half, tilt, shared, slips, seat[k, i].since, sees
                        )  # fmt: skip
                        seen[i] = sees
                else:
                    row = low * EACH
                    for i in range(LANES):
                        faces, meets, slid = find_contacts(
                            base[i].dx, face[k, i], pose[k, i], velocity[k, i], face[low, i],
                            pose[low, i], velocity[low, i],
                        )  # fmt: skip
                        stretch[i] = faces
                        meeting[i] = meets
                        seat[k, i].place = slid
                    for p in range(pairs):
                        away = SPACING * real(2 * p + 1 - ODD)
                        share = SPACING * wp.where(p == pairs - 1 or p < ODD, HALF, real(1.0))
                        for i in range(LANES):
                            mu = interface[k, i].friction
                            one = spring[row + 2 * p, i]
                            first_end = press(knobs, pace[i], mu, -away, meeting[i], one)
                            spring[row + 2 * p, i] = one
                            two = spring[row + 2 * p + 1, i]
                            second_end = press(knobs, pace[i], mu, away, meeting[i], two)
                            spring[row + 2 * p + 1, i] = two
                            sums[i] = add_pair(share, away, first_end, second_end, sums[i])
                    for i in range(LANES):
                        above, below = load[k, i], load[low, i]
                        held = load_blocks(interface[k, i].depth, stretch[i], sums[i], above, below)
                        load[k, i] = above
                        load[low, i] = below
                        held = wp.where(pace[i].live == 1, held, real(0.0))
                        energy[i].stored = energy[i].stored + held
                        slips = glides(pace[i], knobs, sums[i].held, meeting[i].vt)
                        sees = seen[i]
                        observe_interface(
                            pace[i], meeting[i].overlap, size(meeting[i].tilt), stretch[i].half,
                            slips, seat[k, i].since, sees,
                        )  # fmt: skip
                        seen[i] = sees
                        sums[i] = Sums()
            for k in range(1, bodies):
                for i in range(LANES):
                    at, u = pose[k, i], velocity[k, i]
                    work = integrate(
                        knobs, pace[i], base[i], mass[k, i], load[k, i], at, u, energy[i].loss
                    )
                    account[i].work = account[i].work - work
                    pose[k, i] = at
                    velocity[k, i] = u
                    load[k, i] = Load()
                    live, slid = pace[i].live == 1, seat[k, i].place - interface[k, i].start
                    time = real(pace[i].steps) * pace[i].dt
                    peaks[k, i] = observe_peaks(live, time, at.theta, slid, peaks[k, i])
                    seat[k, i].slide = wp.where(live, slid, seat[k, i].slide)
                    seen[i].mode = mode_after(live, at.theta, u, slid, seen[i].mode)
        if found.rotations.shape[0] > 0:
            for k in range(1, bodies):
                for i in range(LANES):
                    past = time_past(until, pace[i].steps, pace[i].dt, seen[i].mode)
                    theta = pose[k, i].theta - past * velocity[k, i].omega
                    found.rotations[sample, k - 1, first + i] = theta
        if found.places.shape[0] > 0:
            for i in range(LANES):
                past = time_past(until, pace[i].steps, pace[i].dt, seen[i].mode)
                for k in range(1, bodies):
                    x = pose[k, i].x - past * velocity[k, i].x
                    z = pose[k, i].z - past * velocity[k, i].z
                    if CHAINS:
                        z = z - blocks[k - 1, first + i].rest
                    found.places[sample, k - 1, ALONG, first + i] = x
                    found.places[sample, k - 1, UPWARDS, first + i] = z
    for i in range(LANES):
        account[i].loss = dissipated_energy(energy[i])
        pull = equivalent_gain(base[i].dx, base[i].dz, knobs.gravity * pace[i].dt)
        account[i] = keep_account(pull, account[i])
        seen[i].steps = pace[i].steps
        found.results[first + i] = result_of(seen[i], account[i])
        for k in range(1, bodies):
            found.blocks[k - 1, first + i] = block_result(seat[k, i].slide, peaks[k, i])
