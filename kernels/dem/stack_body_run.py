"""Runs of the soft-spring step over stacks with bodies: LANES stacks a thread, side by side.

As dem/stack_run.py, with three rows of points an interface from -x to +x, and the corners of all
blocks in one table, block by block. The part between the two points that are deepest counts as the
interface that parts and lands.
"""

import warp as wp

from warprock.kernels.account import book
from warprock.kernels.dem.stack import Knobs, integrate
from warprock.kernels.dem.stack_body import move_window, press
from warprock.kernels.dem.stack_lanes import passes_left, time_past
from warprock.kernels.dem.stack_run import (
    Stack,
    begin_step,
    observe_block,
    observe_interface,
    start_lane,
)
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.modes import RUNNING
from warprock.kernels.motion import base_velocity, sample_index, sample_segment
from warprock.kernels.shape.above import Motions
from warprock.kernels.shape.interface import Pose
from warprock.kernels.shape.rising import pulled
from warprock.kernels.shape.stack_body import Block, Foot, Top, overlap_of
from warprock.kernels.shape.stack_found import BlockResult, Found, Result

wp.set_module_options(ONE_VECTOR)

Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)
Body = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=real)
BodyInt = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=int)
Point = wp.types.matrix(shape=(3 * BLOCKS, LANES), dtype=real)


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), feet: wp.array2d(dtype=Foot),
    motions: Motions, pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real),
    knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, each at its own time."""
    low, high, top, m, j, mu = Body(), Body(), Body(), Body(), Body(), Body()
    x, z, theta, s, c, vx, vz = Body(), Body(), Body(), Body(), Body(), Body(), Body()
    omega, fx, fz, moment, since, slid = Body(), Body(), Body(), Body(), Body(), Body()
    peak, peak_time, slide, peak_slide, window = Body(), Body(), Body(), Body(), BodyInt()
    u, slip = Point(), Point()
    deep, second, sliding = Lane(), Lane(), Lane()
    dt, span, base, dv, loss, spent, stored = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    at_start, given, supplied, taken, returned = Lane(), Lane(), Lane(), Lane(), Lane()
    uplift_time, moved, deepest, jolt, dz, rising = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    live, impacts, mode, steps, held = LaneInt(), LaneInt(), LaneInt(), LaneInt(), LaneInt()
    pack, _one = wp.tid()
    bodies, first, rows = int(BLOCKS + 1), pack * LANES, feet.shape[0] // BLOCKS
    for i in range(LANES):
        start_lane(lanes[first + i], high[0, i], c[0, i], dt[i], uplift_time[i], mode[i])
        low[0, i] = -high[0, i]
        for k in range(1, bodies):
            block = blocks[k - 1, first + i]
            m[k, i] = block.inverse_mass
            j[k, i] = block.inverse_inertia
            mu[k, i] = block.friction
            low[k, i] = block.top_low
            high[k, i] = block.top_high
            top[k, i] = block.top
            x[k, i] = block.x
            z[k, i] = block.z
            theta[k, i] = block.theta
            s[k, i] = sine(block.theta)
            c[k, i] = cosine(block.theta)
            peak[k, i] = size(block.theta)
            window[k, i] = block.window
            since[k, i] = NEVER
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
                    above = sample_index(up, sample_segment(up, mid))
                    w_up = base_velocity(up, mid, pool[2, above], pool[0, above], pool[1, above])
                    dz[i] = w_up - rising[i]
                    rising[i] = wp.where(live[i] == 1, w_up, rising[i])
                else:
                    lane = motions[first + i]
                place = sample_index(lane, sample_segment(lane, mid))
                v = base_velocity(lane, mid, pool[2, place], pool[0, place], pool[1, place])
                begin_step(v, live[i] == 1, steps[i], dt[i], knobs.gravity * dt[i], dz[i], dv[i],
                    base[i], span[i], stored[i], at_start[i], loss[i], spent[i], given[i],
                    jolt[i], supplied[i], taken[i], returned[i])  # fmt: skip
            for k in range(1, bodies):
                o, p, q, r = k - 1, 3 * k - 3, 3 * k - 2, 3 * k - 1
                for i in range(LANES):
                    w, f = window[k, i], first + i
                    move_window(dv[i], theta[k, i] - theta[o, i], omega[k, i] - omega[o, i],
                        feet[w - 1, f], feet[w, f], feet[w + 1, f], s[k, i], c[k, i], s[o, i],
                        c[o, i], low[o, i], high[o, i], x[k, i] - x[o, i], z[k, i] - z[o, i],
                        window[k, i], u[p, i], slip[p, i], u[q, i], slip[q, i], u[r, i], slip[r, i],
                        deep[i], second[i])  # fmt: skip
                for turn in range(3):
                    # Both sides before the middle: a mirrored scene adds up alike.
                    role = 2 * (turn % 2) - 1 + turn // 2
                    row = 3 * o + 1 + role
                    for i in range(LANES):
                        w, f = window[k, i], first + i
                        press(knobs, live[i] == 1, mu[k, i], dt[i], blocks[o, f].area,
                            feet[w - 1, f], feet[w, f], feet[w + 1, f], role, s[k, i], c[k, i],
                            s[o, i], c[o, i], low[o, i], high[o, i], top[o, i], x[k, i] - x[o, i],
                            z[k, i] - z[o, i], vx[k, i] - vx[o, i], vz[k, i] - vz[o, i],
                            omega[k, i], omega[o, i], u[row, i], slip[row, i], fx[k, i], fz[k, i],
                            moment[k, i], fx[o, i], fz[o, i], moment[o, i], stored[i], held[i],
                            deep[i], second[i], slid[k, i], sliding[i])  # fmt: skip
                for i in range(LANES):
                    w, f = window[k, i], first + i
                    shared = overlap_of(feet[o * rows, f], feet[w, f], feet[k * rows - 1, f],
                        Pose(x[k, i], z[k, i], theta[k, i], s[k, i], c[k, i]),
                        Pose(x[o, i], z[o, i], theta[o, i], s[o, i], c[o, i]),
                        Top(low[o, i], high[o, i], top[o, i]))  # fmt: skip
                    half = HALF * (deep[i] + second[i])
                    observe_interface(live[i] == 1, real(steps[i] - 1) * dt[i], knobs.gravity,
                        dt[i], half, deep[i] - half, shared, sliding[i], held[i], since[k, i],
                        uplift_time[i], moved[i], deepest[i], impacts[i], mode[i])  # fmt: skip
            for k in range(1, bodies):
                for i in range(LANES):
                    integrate(live[i] == 1, dv[i], dz[i], dt[i], span[i], knobs, m[k, i], j[k, i],
                        fx[k, i], fz[k, i], moment[k, i], x[k, i], z[k, i], theta[k, i], s[k, i],
                        c[k, i], vx[k, i], vz[k, i], omega[k, i], loss[i], given[i])  # fmt: skip
                    observe_block(live[i] == 1, real(steps[i]) * dt[i], theta[k, i],
                        vx[k, i] + vz[k, i] + omega[k, i],
                        slid[k, i] - blocks[k - 1, first + i].aside, peak[k, i], peak_time[k, i],
                        slide[k, i], peak_slide[k, i], mode[i])  # fmt: skip
        for k in range(1, bodies):
            for i in range(LANES):
                o, f, past = k - 1, first + i, time_past(until, steps[i], dt[i], mode[i])
                if found.rotations.shape[0] > 0:
                    found.rotations[sample, o, f] = theta[k, i] - past * omega[k, i]
                if found.places.shape[0] > 0:
                    found.places[sample, o, 0, f] = x[k, i] - past * vx[k, i]
                    found.places[sample, o, 1, f] = z[k, i] - past * vz[k, i] - blocks[o, f].rest
    for i in range(LANES):
        lost = spent[i] - (stored[i] - at_start[i])
        pull = pulled(dv[i], dz[i], knobs.gravity * dt[i])
        book(pull, given[i], lost, jolt[i], supplied[i], taken[i], returned[i])
        found.results[first + i] = Result(uplift_time[i], moved[i], lost, jolt[i], supplied[i],
            returned[i], deepest[i], impacts[i], mode[i], steps[i])  # fmt: skip
        for k in range(1, bodies):
            found.blocks[k - 1, first + i] = BlockResult(slide[k, i], peak[k, i], peak_time[k, i],
                peak_slide[k, i])  # fmt: skip
