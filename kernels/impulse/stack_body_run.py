"""Runs of the impulse step over stacks with bodies: LANES stacks a thread, side by side.

As impulse/stack_run.py, with three rows of points an interface in the order in which they are
visited, and the corners of all blocks in one table, block by block.
"""

import warp as wp

from warprock.kernels.account import book
from warprock.kernels.impulse.stack_body import balance, find_contact, finish_step, predict
from warprock.kernels.impulse.stack_flat import Knobs, solve_contact
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.motion import base_velocity, sample_index, sample_segment
from warprock.kernels.shape.above import Motions, move_up
from warprock.kernels.shape.rising import pulled
from warprock.kernels.shape.stack_body import Block, Foot, start_block
from warprock.kernels.shape.stack_found import BlockResult, Found, Result, at_sample
from warprock.kernels.shape.stack_run_flat import Stack, begin_step, part_kept, start_lane

wp.set_module_options(ONE_VECTOR)

SETTLING = 200
"""Solves before the run, as in impulse/stack_run.py."""

Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)
Body = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=real)
BodyInt = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=int)
Point = wp.types.matrix(shape=(3 * BLOCKS, LANES), dtype=real)


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), feet: wp.array2d(dtype=Foot),
    motions: Motions, pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    pack, _one = wp.tid()
    first, dt, rows = pack * LANES, knobs.time_step, feet.shape[0] // BLOCKS
    low, high, top, m, j, mu = Body(), Body(), Body(), Body(), Body(), Body()
    x, z, theta, s, c, lean = Body(), Body(), Body(), Body(), Body(), Body()
    vx, vz, omega, ux, uz, uo = Body(), Body(), Body(), Body(), Body(), Body()
    peak, peak_time, slide, peak_slide, since = Body(), Body(), Body(), Body(), Body()
    left, under, right, window, crept = BodyInt(), BodyInt(), BodyInt(), BodyInt(), Body()
    nx, nz, au, bu, al, bl = Point(), Point(), Point(), Point(), Point(), Point()
    gap, pn, pt, nt, n, t = Point(), Point(), Point(), Point(), Point(), Point()
    base, dv, hint, loss, jolt, even = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    given, supplied, taken, returned, rise, rising = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    shift_x, shift_z, uplift_time, moved, deepest = Lane(), Lane(), Lane(), Lane(), Lane()
    impacts, mode, lives, steps, by = LaneInt(), LaneInt(), LaneInt(), LaneInt(), BodyInt()
    bodies, points, sweeps = int(BLOCKS + 1), int(3 * BLOCKS), int(ITERATIONS)
    for i in range(LANES):
        start_lane(lanes[first + i], high[0, i], c[0, i], uplift_time[i], mode[i], even[i])
        low[0, i] = -high[0, i]
        for k in range(1, bodies):
            start_block(blocks[k - 1, first + i], lanes[first + i].lean, theta[k - 1, i], m[k, i],
                j[k, i], mu[k, i], low[k, i], high[k, i], top[k, i], x[k, i], z[k, i], theta[k, i],
                s[k, i], c[k, i], peak[k, i], lean[k, i], window[k, i], n[3 * k - 3, i],
                n[3 * k - 2, i])  # fmt: skip
    count, time = int(-SETTLING), real(-SETTLING) * dt
    for sample in range(sample_times.shape[0]):
        while time < sample_times[sample]:
            count += 1
            time = real(count) * dt
            half, kept = larger(time - HALF * dt, HALF * dt), part_kept(count)
            for i in range(LANES):
                if VERTICAL:
                    lane, up = motions[0, first + i], motions[1, first + i]
                    there = sample_index(up, sample_segment(up, half))
                    climb = base_velocity(up, half, pool[2, there], pool[0, there], pool[1, there])
                    move_up(climb, count > 0, rise[i], rising[i])
                else:
                    lane = motions[first + i]
                place = sample_index(lane, sample_segment(lane, half))
                v = base_velocity(lane, half, pool[2, place], pool[0, place], pool[1, place])
                begin_step(v, count, mode[i], lives[i], dv[i], hint[i], base[i], steps[i], even[i])
                book(pulled(dv[i], rise[i], dt * knobs.gravity), given[i], loss[i], jolt[i],
                    supplied[i], taken[i], returned[i])  # fmt: skip
            for k in range(1, bodies):
                o, p, q, r = k - 1, 3 * k - 3, 3 * k - 2, 3 * k - 1
                for i in range(LANES):
                    w, f = window[k, i], first + i
                    predict(dv[i], rise[i], hint[i], knobs, theta[k, i] - theta[o, i], vx[k, i],
                        vz[k, i], omega[k, i], omega[o, i], feet[w - 1, f], feet[w, f],
                        feet[w + 1, f], s[k, i], c[k, i], s[o, i], c[o, i], low[o, i], high[o, i],
                        x[k, i] - x[o, i], z[k, i] - z[o, i], ux[k, i], uz[k, i], uo[k, i],
                        lean[k, i], window[k, i], by[k, i], n[p, i], t[p, i], n[q, i], t[q, i],
                        n[r, i], t[r, i], shift_x[i], shift_z[i])  # fmt: skip
            for p in range(points):
                o, k, role = p // 3, p // 3 + 1, p % 3 - 1
                for i in range(LANES):
                    w, f = window[k, i], first + i
                    find_contact(feet[w - 1, f], feet[w, f], feet[w + 1, f], role, lean[k, i],
                        s[k, i], c[k, i], m[k, i], j[k, i], s[o, i], c[o, i], low[o, i], high[o, i],
                        top[o, i], m[o, i], j[o, i], x[k, i] - x[o, i], z[k, i] - z[o, i],
                        knobs.collision_margin, nx[p, i], nz[p, i], au[p, i], bu[p, i], al[p, i],
                        bl[p, i], gap[p, i], pn[p, i], pt[p, i], nt[p, i], n[p, i], t[p, i],
                        ux[k, i], uz[k, i], uo[k, i], ux[o, i], uz[o, i], uo[o, i])  # fmt: skip
            for step in range(sweeps * points):
                p, o, k = step % points, step % points // 3, step % points // 3 + 1
                q, r = 3 * o + (p + 1) % 3, 3 * o + (p + 2) % 3
                for i in range(LANES):
                    solve_contact(mu[k, i], gap[p, i], knobs.rate, m[k, i], j[k, i], m[o, i],
                        j[o, i], nx[p, i], nz[p, i], au[p, i], bu[p, i], al[p, i], bl[p, i],
                        pn[p, i], pt[p, i], nt[p, i], pn[q, i] + pn[r, i], n[p, i], t[p, i],
                        ux[k, i], uz[k, i], uo[k, i], ux[o, i], uz[o, i], uo[o, i])  # fmt: skip
            for k in range(1, bodies):
                o, p, q, r = k - 1, 3 * k - 3, 3 * k - 2, 3 * k - 1
                for i in range(LANES):
                    live, w, f = lives[i] > 0, window[k, i], first + i
                    balance(even[i], au[q, i], n[p, i], t[p, i], n[q, i], t[q, i], n[r, i],
                        t[r, i], ux[k, i], uo[k, i])  # fmt: skip
                    finish_step(feet[w - 1, f], feet[w, f], feet[w + 1, f], feet[o * rows, f],
                        feet[k * rows - 1, f], by[k, i], blocks[o, f], live, kept, knobs, time,
                        dv[i], rise[i], lean[k, i], m[k, i], j[k, i], gap[p, i], nx[p, i], nz[p, i],
                        n[p, i], gap[q, i], nx[q, i], nz[q, i], n[q, i], gap[r, i], nx[r, i],
                        nz[r, i], n[r, i], ux[k, i], uz[k, i], uo[k, i], x[o, i], z[o, i],
                        theta[o, i], uo[o, i], s[o, i], c[o, i], low[o, i], high[o, i], top[o, i],
                        shift_x[i], shift_z[i], x[k, i], z[k, i], theta[k, i], s[k, i], c[k, i],
                        vx[k, i], vz[k, i], omega[k, i], loss[i], given[i], since[k, i], left[k, i],
                        under[k, i], right[k, i], uplift_time[i], moved[i], deepest[i], impacts[i],
                        peak[k, i], peak_time[k, i], slide[k, i], peak_slide[k, i], crept[k, i],
                        mode[i])  # fmt: skip
        past = time - sample_times[sample]
        if found.rotations.shape[0] > 0:
            for k in range(1, bodies):
                for i in range(LANES):
                    o, f = k - 1, first + i
                    angle = at_sample(mode[i], past, theta[k, i], omega[k, i])
                    found.rotations[sample, o, f] = angle
                    if found.places.shape[0] > 0:
                        found.places[sample, o, 0, f] = at_sample(mode[i], past, x[k, i], vx[k, i])
                        found.places[sample, o, 1, f] = at_sample(mode[i], past, z[k, i], vz[k, i])
    for i in range(LANES):
        book(pulled(dv[i], rise[i], dt * knobs.gravity), given[i], loss[i], jolt[i], supplied[i],
            taken[i], returned[i])  # fmt: skip
        found.results[first + i] = Result(uplift_time[i], moved[i], loss[i], jolt[i], supplied[i],
            returned[i], deepest[i], impacts[i], mode[i], steps[i])  # fmt: skip
        for k in range(1, bodies):
            found.blocks[k - 1, first + i] = BlockResult(slide[k, i], peak[k, i], peak_time[k, i],
                peak_slide[k, i])  # fmt: skip
