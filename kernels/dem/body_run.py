"""Runs of the soft-spring step over bodies on contact points: LANES lanes a thread.

As dem/stack_run.py for one body on the ground. The edge between the two corners that are deepest
counts as the interface that parts and lands.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, ONLY, UPWARDS
from warprock.kernels.dem.body import Corner, Deepest, depth_of, find_deepest, has_work, press
from warprock.kernels.dem.stack import (
    Base,
    Energy,
    Knobs,
    Load,
    Pace,
    Spring,
    integrate,
    one_minus_cosine,
)
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
from warprock.kernels.shape.body import rotated_x
from warprock.kernels.shape.body_found import TO_LEFT, TO_RIGHT, Found, Sides, observe_sides
from warprock.kernels.shape.interface import Mass, Pose, Velocity
from warprock.kernels.shape.rising import equivalent_gain
from warprock.kernels.shape.stack_found import (
    Peaks,
    Seen,
    block_result,
    observe_peaks,
    result_of,
    start_peaks,
    start_seen,
)

wp.set_module_options(ONE_VECTOR)


@wp.struct
class Body:
    """One lane's body, and where it starts: z is from its height at rest if it were rigid.

    vx, vz and omega are its velocities then.
    """

    inverse_mass: real
    inverse_inertia: real
    friction: real
    height: real
    time_step: real
    uplift_time: real
    x: real
    z: real
    theta: real
    vx: real
    vz: real
    omega: real


@wp.struct
class Own:
    """What is known of a body besides its mass: friction coefficient, and height at rest [m]."""

    friction: real
    height: real


@wp.struct
class Step:
    """A body in a step.

    Attributes:
        lift: 1 - cosine of its rotation.
        depth: How deep the corner is that is being looked at [m].
        held: Corners so far that are pressed and do not slip.
    """

    lift: real
    depth: real
    held: int


@kernel
def run_lanes(
    blocks: wp.array(dtype=Body), corners: wp.array2d(dtype=Corner),
    motions: Motions, pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, each at its own time."""
    spring = rows(Spring, POINTS)
    corner = rows(Corner, POINTS)
    own = rows(Own)
    mass = rows(Mass)
    pose = rows(Pose)
    velocity = rows(Velocity)
    load = rows(Load)
    deep = rows(Deepest)
    step = rows(Step)
    seat = rows(Seat)
    peaks = rows(Peaks)
    sides = rows(Sides)
    pace = rows(Pace)
    base = rows(Base)
    energy = rows(Energy)
    account = rows(Account)
    seen = rows(Seen)
    # A variable, not a constant: else Warp would unroll the loop over it.
    pack, _one = wp.tid()
    points, first = int(POINTS), pack * LANES
    for i in range(LANES):
        body = blocks[first + i]
        own[i] = Own(body.friction, body.height)
        mass[i] = Mass(body.inverse_mass, body.inverse_inertia)
        pose[i] = Pose(body.x, body.z, body.theta, sine(body.theta), cosine(body.theta))
        velocity[i] = Velocity(body.vx, body.vz, body.omega)
        seat[i].since = NEVER
        peaks[i] = start_peaks(body.theta)
        pace[i].dt = body.time_step
        seen[i] = start_seen(body.uplift_time)
    for p in range(points):
        for i in range(LANES):
            corner[p, i] = corners[p, first + i]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        passes = int(0)
        for i in range(LANES):
            left = passes_left(until, pace[i].steps, pace[i].dt, seen[i].mode)
            passes = wp.max(passes, left)
        for _ in range(passes):
            for i in range(LANES):
                mid = (real(pace[i].steps) + HALF) * pace[i].dt
                clock, spent = pace[i], energy[i]
                account[i].loss = begin_step(until, seen[i].mode, clock, spent)
                pace[i] = clock
                energy[i] = spent
                climb = real(0.0)
                if VERTICAL:
                    lane = motions[ALONG, first + i]
                    up = motions[UPWARDS, first + i]
                    climb = base_velocity(up, mid, pool)
                else:
                    lane = motions[first + i]
                v = base_velocity(lane, mid, pool)
                base[i] = move_base(v, climb, pace[i].live, base[i])
                pull = equivalent_gain(base[i].dx, base[i].dz, knobs.gravity * pace[i].dt)
                account[i] = keep_account(pull, account[i])
                step[i].lift = one_minus_cosine(pose[i].s, pose[i].c)
                step[i].held = 0
                deep[i] = Deepest(-NEVER, -NEVER, 0)
            for p in range(points):
                works = int(0)
                for i in range(LANES):
                    depth = depth_of(
                        corner[p, i].x, corner[p, i].z, corner[p, i].raised, pose[i].z, pose[i].s,
                        step[i].lift,
                    )  # fmt: skip
                    step[i].depth = depth
                    deep[i] = find_deepest(p, depth, deep[i])
                    works = works + has_work(depth, spring[p, i])
                if works > 0:
                    for i in range(LANES):
                        one = spring[p, i]
                        more, pressed = press(
                            knobs, pace[i], own[i].friction, corner[p, i], step[i].depth, pose[i],
                            velocity[i], one,
                        )  # fmt: skip
                        spring[p, i] = one
                        load[i].x = load[i].x + more.x
                        load[i].z = load[i].z + more.z
                        load[i].moment = load[i].moment + more.moment
                        energy[i].stored = energy[i].stored + pressed.stored
                        step[i].held = step[i].held + pressed.held
            for i in range(LANES):
                at, u = pose[i], velocity[i]
                lowest = corners[deep[i].corner, first + i]
                slid = at.x + rotated_x(lowest.x, lowest.z, at.s, at.c) - lowest.along
                middle = HALF * (deep[i].first + deep[i].second)
                speed = u.x - u.omega * (own[i].height + at.z)
                slips = glides(pace[i], knobs, step[i].held, speed)
                tilt, sees = size(deep[i].first - middle), seen[i]
                observe_interface(
                    pace[i], middle, tilt, real(1.0), slips, seat[i].since, sees
                )  # fmt: skip
                work = integrate(knobs, pace[i], base[i], mass[i], load[i], at, u, energy[i].loss)
                account[i].work = account[i].work - work
                pose[i] = at
                velocity[i] = u
                load[i] = Load()
                live, time = pace[i].live == 1, real(pace[i].steps) * pace[i].dt
                peaks[i] = observe_peaks(live, time, at.theta, slid, peaks[i])
                seat[i].slide = wp.where(live, slid, seat[i].slide)
                sees.mode = mode_after(live, at.theta, u, slid, sees.mode)
                seen[i] = sees
                sides[i] = observe_sides(live, at.theta, sides[i])
        if found.rotations.shape[0] > 0:
            for i in range(LANES):
                past = time_past(until, pace[i].steps, pace[i].dt, seen[i].mode)
                found.rotations[sample, ONLY, first + i] = pose[i].theta - past * velocity[i].omega
        if found.places.shape[0] > 0:
            for i in range(LANES):
                past = time_past(until, pace[i].steps, pace[i].dt, seen[i].mode)
                found.places[sample, ONLY, ALONG, first + i] = pose[i].x - past * velocity[i].x
                found.places[sample, ONLY, UPWARDS, first + i] = pose[i].z - past * velocity[i].z
    for i in range(LANES):
        account[i].loss = dissipated_energy(energy[i])
        pull = equivalent_gain(base[i].dx, base[i].dz, knobs.gravity * pace[i].dt)
        account[i] = keep_account(pull, account[i])
        seen[i].steps = pace[i].steps
        found.results[first + i] = result_of(seen[i], account[i])
        found.sides[TO_LEFT, first + i] = sides[i].left
        found.sides[TO_RIGHT, first + i] = sides[i].right
        found.blocks[0, first + i] = block_result(seat[i].slide, peaks[i])
