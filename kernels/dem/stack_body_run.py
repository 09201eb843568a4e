"""Runs of the soft-spring step over stacks with bodies: LANES stacks a thread, side by side.

As dem/stack_run.py, with three rows of points an interface from -x to +x, and the corners of all
blocks in one table, block by block. The part between the two points that are deepest counts as the
interface that parts and lands.
"""

import warp as wp

from warprock.kernels.account import Account, keep_account
from warprock.kernels.dem.stack import (
    Base,
    Energy,
    Knobs,
    Load,
    Pace,
    Spring,
    integrate,
    lean_of,
)
from warprock.kernels.dem.stack_body import (
    Contacts,
    Interface,
    find_contact,
    load_blocks,
    move_springs,
    press,
    see_contact,
)
from warprock.kernels.dem.stack_lanes import (
    Seat,
    begin_step,
    glides,
    lost_so_far,
    mode_after,
    move_base,
    observe_interface,
    passes_left,
    time_past,
)
from warprock.kernels.dem.stack_run import Stack
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.motion import base_velocity, sample_index, sample_segment
from warprock.kernels.rows import kernel, rows
from warprock.kernels.shape.above import Motions
from warprock.kernels.shape.interface import GROUND_FACE, Mass, Pose, Velocity
from warprock.kernels.shape.rising import pulled
from warprock.kernels.shape.stack_body import (
    Block,
    Foot,
    Top,
    Window,
    overlap_of,
    way_of_window,
)
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

wp.set_module_options(ONE_VECTOR)


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), feet: wp.array2d(dtype=Foot),
    motions: Motions, pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real),
    knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, each at its own time."""
    # Of bodies, the ground first.
    top = rows(Top, BLOCKS + 1)
    mass = rows(Mass, BLOCKS + 1)
    pose = rows(Pose, BLOCKS + 1)
    velocity = rows(Velocity, BLOCKS + 1)
    load = rows(Load, BLOCKS + 1)
    interface = rows(Interface, BLOCKS + 1)
    seat = rows(Seat, BLOCKS + 1)
    peaks = rows(Peaks, BLOCKS + 1)
    # Of points: the three of interface 1 from -x to +x, those of interface 2, ...
    spring = rows(Spring, 3 * BLOCKS)
    contacts = rows(Contacts)
    pace = rows(Pace)
    base = rows(Base)
    energy = rows(Energy)
    account = rows(Account)
    seen = rows(Seen)
    pack, _one = wp.tid()
    bodies, first, corners = int(BLOCKS + 1), pack * LANES, feet.shape[0] // BLOCKS
    for i in range(LANES):
        # The ground is level and has a face.
        top[0, i] = Top(-GROUND_FACE, GROUND_FACE, real(0.0))
        pose[0, i].c = real(1.0)
        pace[i].dt = lanes[first + i].time_step
        seen[i] = start_seen(lanes[first + i].uplift_time)
        for k in range(1, bodies):
            block = blocks[k - 1, first + i]
            top[k, i] = Top(block.top_low, block.top_high, block.top)
            mass[k, i] = Mass(block.inverse_mass, block.inverse_inertia)
            pose[k, i] = Pose(block.x, block.z, block.theta, sine(block.theta), cosine(block.theta))
            interface[k, i] = Interface(block.friction, block.area, block.aside, block.window)
            seat[k, i].since = NEVER
            peaks[k, i] = start_peaks(block.theta)
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
                    lane = motions[0, first + i]
                    up = motions[1, first + i]
                    high = sample_index(up, sample_segment(up, mid))
                    rise = base_velocity(up, mid, pool[2, high], pool[0, high], pool[1, high])
                else:
                    lane = motions[first + i]
                place = sample_index(lane, sample_segment(lane, mid))
                v = base_velocity(lane, mid, pool[2, place], pool[0, place], pool[1, place])
                base[i] = move_base(v, rise, pace[i].live, base[i])
                pull = pulled(base[i].dx, base[i].dz, knobs.gravity * pace[i].dt)
                account[i] = keep_account(pull, account[i])
            for k in range(1, bodies):
                o, p, q, r = k - 1, 3 * k - 3, 3 * k - 2, 3 * k - 1
                for i in range(LANES):
                    w = interface[k, i].window
                    f = first + i
                    turn = pose[k, i].theta - pose[o, i].theta
                    rate = velocity[k, i].omega - velocity[o, i].omega
                    way = way_of_window(
                        Window(feet[w - 1, f], feet[w, f], feet[w + 1, f]),
                        lean_of(turn, rate, base[i].dx), pose[k, i], pose[o, i], top[o, i],
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
                    row = 3 * o + 1 + role
                    for i in range(LANES):
                        w = interface[k, i].window
                        f = first + i
                        contact, point, along = find_contact(
                            Window(feet[w - 1, f], feet[w, f], feet[w + 1, f]), role, pose[k, i],
                            pose[o, i], top[o, i], velocity[k, i], velocity[o, i],
                        )  # fmt: skip
                        one = spring[row, i]
                        force = press(knobs, pace[i], interface[k, i], contact, one)
                        spring[row, i] = one
                        above, below = load[k, i], load[o, i]
                        load_blocks(point, force, above, below)
                        load[k, i] = above
                        load[o, i] = below
                        energy[i].stored = energy[i].stored + force.stored
                        contacts[i] = see_contact(role, contact, force.held, contacts[i])
                        seat[k, i].place = wp.where(role == 0, along, seat[k, i].place)
                for i in range(LANES):
                    w = interface[k, i].window
                    f = first + i
                    shared = overlap_of(
                        feet[o * corners, f], feet[w, f], feet[k * corners - 1, f], pose[k, i],
                        pose[o, i], top[o, i],
                    )  # fmt: skip
                    half = HALF * (contacts[i].first + contacts[i].second)
                    tilt, sees = size(contacts[i].first - half), seen[i]
                    slips = glides(pace[i], knobs, contacts[i].held, contacts[i].speed)
                    observe_interface(pace[i], half, tilt, shared, slips, seat[k, i].since, sees)
                    seen[i] = sees
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
                    live, slid = pace[i].live == 1, seat[k, i].place - interface[k, i].aside
                    time = real(pace[i].steps) * pace[i].dt
                    peaks[k, i] = observe_peaks(live, time, at.theta, slid, peaks[k, i])
                    seat[k, i].slide = wp.where(live, slid, seat[k, i].slide)
                    seen[i].mode = mode_after(live, at.theta, u, slid, seen[i].mode)
        for k in range(1, bodies):
            for i in range(LANES):
                o, f = k - 1, first + i
                past = time_past(until, pace[i].steps, pace[i].dt, seen[i].mode)
                if found.rotations.shape[0] > 0:
                    theta = pose[k, i].theta - past * velocity[k, i].omega
                    found.rotations[sample, o, f] = theta
                if found.places.shape[0] > 0:
                    height = pose[k, i].z - past * velocity[k, i].z
                    found.places[sample, o, 0, f] = pose[k, i].x - past * velocity[k, i].x
                    found.places[sample, o, 1, f] = height - blocks[o, f].rest
    for i in range(LANES):
        account[i].loss = lost_so_far(energy[i])
        pull = pulled(base[i].dx, base[i].dz, knobs.gravity * pace[i].dt)
        account[i] = keep_account(pull, account[i])
        seen[i].steps = pace[i].steps
        found.results[first + i] = result_of(seen[i], account[i])
        for k in range(1, bodies):
            found.blocks[k - 1, first + i] = block_result(seat[k, i].slide, peaks[k, i])
