"""Runs of the soft-spring step over bodies on contact points: LANES lanes a thread.

As dem/stack_run.py for one body on the ground. The edge between the two corners that are deepest
counts as the interface that parts and lands.
"""

import warp as wp

from warprock.kernels.account import book
from warprock.kernels.dem.body import Spring, find_overlap, press
from warprock.kernels.dem.stack import Knobs, integrate, rise
from warprock.kernels.dem.stack_lanes import passes_left, time_past
from warprock.kernels.dem.stack_run import begin_step, observe_block, observe_interface
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.modes import RUNNING
from warprock.kernels.motion import base_velocity, sample_index, sample_segment
from warprock.kernels.shape.above import Motions
from warprock.kernels.shape.body import turned_x
from warprock.kernels.shape.body_found import Found
from warprock.kernels.shape.rising import pulled
from warprock.kernels.shape.stack_found import BlockResult, Result

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


Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)
Point = wp.types.matrix(shape=(POINTS, LANES), dtype=real)


@wp.func
def start_body(
    body: Body, x: wp.ref[real], z: wp.ref[real], theta: wp.ref[real], vx: wp.ref[real],
    vz: wp.ref[real], omega: wp.ref[real], s: wp.ref[real], c: wp.ref[real], since: wp.ref[real],
    peak: wp.ref[real],
):  # fmt: skip
    """Puts a body where it starts; its interface counts as closed."""
    x = body.x
    z = body.z
    theta = body.theta
    vx = body.vx
    vz = body.vz
    omega = body.omega
    s = sine(body.theta)
    c = cosine(body.theta)
    since = NEVER
    peak = size(body.theta)


@wp.kernel
def run_lanes(
    blocks: wp.array(dtype=Body), corners: wp.array2d(dtype=Spring),
    motions: Motions, pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, each at its own time."""
    u, slip = Point(), Point()
    m, j, mu, x, z, theta, s, c = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    vx, vz, omega, fx, fz, moment = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    since, slid, peak, peak_time, slide, peak_slide = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    deep, second, overlap, height, lift = Lane(), Lane(), Lane(), Lane(), Lane()
    left, right = Lane(), Lane()
    dt, span, base, dv, loss, spent, stored = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    at_start, given, supplied, taken, returned = Lane(), Lane(), Lane(), Lane(), Lane()
    uplift_time, moved, deepest, jolt, dz, rising = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    live, impacts, mode, steps, held = LaneInt(), LaneInt(), LaneInt(), LaneInt(), LaneInt()
    low = LaneInt()
    # A variable, not a constant: else Warp would unroll the loop over it.
    pack, _one = wp.tid()
    points, first = int(POINTS), pack * LANES
    for i in range(LANES):
        body = blocks[first + i]
        m[i] = body.inverse_mass
        j[i] = body.inverse_inertia
        mu[i] = body.friction
        height[i] = body.height
        dt[i] = body.time_step
        uplift_time[i] = body.uplift_time
        start_body(
            body, x[i], z[i], theta[i], vx[i], vz[i], omega[i], s[i], c[i], since[i], peak[i]
        )  # fmt: skip
        mode[i] = RUNNING
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        passes = int(0)
        for i in range(LANES):
            passes = wp.max(passes, passes_left(until, steps[i], dt[i], mode[i]))
        for _ in range(passes):
            for i in range(LANES):
                live[i] = wp.where(mode[i] == RUNNING and real(steps[i]) * dt[i] < until, 1, 0)
                mid = (real(steps[i]) + HALF) * dt[i]
                if VERTICAL:
                    lane = motions[0, first + i]
                    up = motions[1, first + i]
                    high = sample_index(up, sample_segment(up, mid))
                    w = base_velocity(up, mid, pool[2, high], pool[0, high], pool[1, high])
                    dz[i] = w - rising[i]
                    rising[i] = wp.where(live[i] == 1, w, rising[i])
                else:
                    lane = motions[first + i]
                place = sample_index(lane, sample_segment(lane, mid))
                v = base_velocity(lane, mid, pool[2, place], pool[0, place], pool[1, place])
                begin_step(v, live[i] == 1, steps[i], dt[i], knobs.gravity * dt[i], dz[i], dv[i],
                    base[i], span[i], stored[i], at_start[i], loss[i], spent[i], given[i],
                    jolt[i], supplied[i], taken[i], returned[i])  # fmt: skip
                lift[i] = rise(s[i], c[i])
                deep[i] = -NEVER
                second[i] = -NEVER
            for p in range(points):
                busy = LaneInt()
                for i in range(LANES):
                    find_overlap(p, corners[p, first + i].x, corners[p, first + i].z,
                        corners[p, first + i].raised, z[i], s[i], lift[i], u[p, i], slip[p, i],
                        overlap[i], deep[i], second[i], low[i], busy[i])  # fmt: skip
                works = int(0)
                for i in range(LANES):
                    works = works + busy[i]
                if works > 0:
                    for i in range(LANES):
                        press(knobs, live[i] == 1, mu[i], dt[i], corners[p, first + i].x,
                            corners[p, first + i].z, corners[p, first + i].area, overlap[i], s[i],
                            c[i], vx[i], vz[i], omega[i], u[p, i], slip[p, i], fx[i], fz[i],
                            moment[i], stored[i], held[i])  # fmt: skip
            for i in range(LANES):
                lowest = corners[low[i], first + i]
                slid[i] = x[i] + turned_x(lowest.x, lowest.z, s[i], c[i]) - lowest.along
                middle = HALF * (deep[i] + second[i])
                speed = vx[i] - omega[i] * (height[i] + z[i])
                observe_interface(live[i] == 1, real(steps[i] - 1) * dt[i], knobs.gravity,
                    dt[i], middle, deep[i] - middle, real(1.0), speed, held[i], since[i],
                    uplift_time[i], moved[i], deepest[i], impacts[i], mode[i])  # fmt: skip
                integrate(live[i] == 1, dv[i], dz[i], dt[i], span[i], knobs, m[i], j[i], fx[i],
                    fz[i], moment[i], x[i], z[i], theta[i], s[i], c[i], vx[i], vz[i], omega[i],
                    loss[i], given[i])  # fmt: skip
                observe_block(live[i] == 1, real(steps[i]) * dt[i], theta[i],
                    vx[i] + vz[i] + omega[i], slid[i], peak[i], peak_time[i], slide[i],
                    peak_slide[i], mode[i])  # fmt: skip
                left[i] = larger(-theta[i], left[i])
                right[i] = larger(theta[i], right[i])
        if found.rotations.shape[0] > 0:
            for i in range(LANES):
                past = time_past(until, steps[i], dt[i], mode[i])
                found.rotations[sample, 0, first + i] = theta[i] - past * omega[i]
        if found.places.shape[0] > 0:
            for i in range(LANES):
                past = time_past(until, steps[i], dt[i], mode[i])
                found.places[sample, 0, 0, first + i] = x[i] - past * vx[i]
                found.places[sample, 0, 1, first + i] = z[i] - past * vz[i]
    for i in range(LANES):
        lost = spent[i] - (stored[i] - at_start[i])
        pull = pulled(dv[i], dz[i], knobs.gravity * dt[i])
        book(pull, given[i], lost, jolt[i], supplied[i], taken[i], returned[i])
        found.results[first + i] = Result(uplift_time[i], moved[i], lost, jolt[i], supplied[i],
            returned[i], deepest[i], impacts[i], mode[i], steps[i])  # fmt: skip
        found.sides[0, first + i] = left[i]
        found.sides[1, first + i] = right[i]
        found.blocks[0, first + i] = BlockResult(slide[i], peak[i], peak_time[i], peak_slide[i])
