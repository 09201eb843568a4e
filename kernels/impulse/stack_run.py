"""Runs of the impulse step over stacks of blocks: LANES stacks a thread, side by side.

Loops over the lanes are innermost and work on local matrices, one row a body or a point, so that
the compiler turns them into vector code; with one lane a thread the same text is the plain form
for any device. A func takes the entries of the matrices, and what it finds it leaves in those that
it takes as `wp.ref`: a matrix taken by reference would be copied at every read.

A run begins with SETTLING solves at the start; for what it shares with other stacks see
shape/stack_run.py.
"""

import warp as wp

from warprock.kernels.account import book
from warprock.kernels.impulse.stack import (
    Knobs,
    find_contact,
    integrate,
    lift_out,
    predict,
    solve_contact,
    work,
)
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.motion import base_velocity, sample_index, sample_segment
from warprock.kernels.shape.above import Motions, move_up
from warprock.kernels.shape.rising import fall_in, pulled, worked
from warprock.kernels.shape.stack_found import BlockResult, Found, Result, at_sample
from warprock.kernels.shape.stack_run import (
    Block,
    Stack,
    balance,
    begin_step,
    observe,
    part_kept,
    start_block,
    start_lane,
)

wp.set_module_options(ONE_VECTOR)

SETTLING = 200
"""Solves before the run. A stack that stands flat starts from its statics, and needs none."""

Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)
Body = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=real)
BodyInt = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=int)
Point = wp.types.matrix(shape=(2 * BLOCKS, LANES), dtype=real)


@wp.func
def integrate_block(
    live: bool, kept: real, knobs: Knobs, dv: real, rise: real, m: real, j: real, gap1: real,
    nx1: real, nz1: real, gap2: real, nx2: real, nz2: real, ux: real, uz: real, uo: real,
    shift_x: wp.ref[real], shift_z: wp.ref[real], x: wp.ref[real], z: wp.ref[real],
    theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real], vx: wp.ref[real], vz: wp.ref[real],
    omega: wp.ref[real], loss: wp.ref[real], given: wp.ref[real],
):  # fmt: skip
    """Moves a block by a step; it takes over its new velocity, or a part of it (`kept`).

    The numbers 1 and 2 are the ends of the interface below it. What its contacts take from the
    energy, less what it is lifted by, is added to the loss, the base's work to what is given [J].
    """
    lift_out(gap1, nx1, nz1, gap2, nx2, nz2, knobs, rise, shift_x, shift_z)
    fall = fall_in(knobs.time_step, knobs.gravity, rise)
    done = work(dv, fall, m / j, vx, vz, omega, ux, uz, uo)
    loss = loss - wp.where(live, fused(knobs.gravity, shift_z, done) / m, real(0.0))
    given = given - wp.where(live, worked(dv, rise, vx + ux, vz + uz) / m, real(0.0))
    integrate(live, knobs.time_step, shift_x, shift_z, ux, uz, uo, x, z, theta, s, c)
    vx = kept * ux
    vz = kept * uz
    omega = kept * uo


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), motions: Motions,
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    pack, _one = wp.tid()
    first, zero, dt = pack * LANES, real(0.0), knobs.time_step
    # Rows of bodies, the ground first: what they are, where, how fast, and what is kept of them.
    half_w, half_h, m, j, mu, offset = Body(), Body(), Body(), Body(), Body(), Body()
    x, z, theta, s, c, lean = Body(), Body(), Body(), Body(), Body(), Body()
    vx, vz, omega, ux, uz, uo = Body(), Body(), Body(), Body(), Body(), Body()
    peak, peak_time, slide, peak_slide, since = Body(), Body(), Body(), Body(), Body()
    left, right, crept = BodyInt(), BodyInt(), Body()
    # Rows of points: the first and the second end of interface 1, of interface 2, ...
    nx, nz, au, bu, al, bl = Point(), Point(), Point(), Point(), Point(), Point()
    gap, pn, pt, nt, n, t = Point(), Point(), Point(), Point(), Point(), Point()
    base, dv, hint, loss, jolt, even = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    given, supplied, taken, returned, rise, rising = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    shift_x, shift_z, uplift_time, moved, deepest = Lane(), Lane(), Lane(), Lane(), Lane()
    impacts, mode, lives, steps = LaneInt(), LaneInt(), LaneInt(), LaneInt()
    bodies, points, sweeps = int(BLOCKS + 1), int(2 * BLOCKS), int(ITERATIONS)  # loops stay
    for i in range(LANES):
        start_lane(lanes[first + i], half_w[0, i], c[0, i], uplift_time[i], mode[i], even[i])
        for k in range(1, bodies):
            start_block(blocks[k - 1, first + i], lanes[first + i].lean, half_w[k, i], half_h[k, i],
                m[k, i], j[k, i], mu[k, i], offset[k, i], x[k, i], z[k, i], theta[k, i], s[k, i],
                c[k, i], peak[k, i], lean[k, i], n[2 * k - 2, i], n[2 * k - 1, i])  # fmt: skip
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
                    lane = motions[0, first + i]
                    up = motions[1, first + i]
                    there = sample_index(up, sample_segment(up, half))
                    climb = base_velocity(up, half, pool[2, there], pool[0, there], pool[1, there])
                    move_up(climb, count > 0, rise[i], rising[i])
                else:
                    lane = motions[first + i]
                place = sample_index(lane, sample_segment(lane, half))
                v = base_velocity(lane, half, pool[2, place], pool[0, place], pool[1, place])
                begin_step(v, count, mode[i], lives[i], dv[i], hint[i], base[i], steps[i], even[i])
                shift_x[i] = zero
                shift_z[i] = zero
                book(pulled(dv[i], rise[i], dt * knobs.gravity), given[i], loss[i], jolt[i],
                    supplied[i], taken[i], returned[i])  # fmt: skip
            for k in range(1, bodies):
                for i in range(LANES):
                    predict(dv[i], rise[i], hint[i], knobs, theta[k, i] - theta[k - 1, i], vx[k, i],
                        vz[k, i], omega[k, i], omega[k - 1, i], ux[k, i], uz[k, i], uo[k, i],
                        lean[k, i], n[2 * k - 2, i], t[2 * k - 2, i], n[2 * k - 1, i],
                        t[2 * k - 1, i])  # fmt: skip
            for p in range(points):
                low, k, turn = p // 2, p // 2 + 1, real(2 * (p % 2) - 1)
                for i in range(LANES):
                    find_contact(turn * lean[k, i], half_w[k, i], half_h[k, i], s[k, i],
                        c[k, i], m[k, i], j[k, i], half_w[low, i], half_h[low, i], s[low, i],
                        c[low, i], m[low, i], j[low, i], x[k, i] - x[low, i], z[k, i] -
                        z[low, i], knobs.collision_margin, nx[p, i], nz[p, i], au[p, i],
                        bu[p, i], al[p, i], bl[p, i], gap[p, i], pn[p, i], pt[p, i], nt[p, i],
                        n[p, i], t[p, i], ux[k, i], uz[k, i], uo[k, i], ux[low, i], uz[low, i],
                        uo[low, i])  # fmt: skip
            for step in range(sweeps * points):
                p, low, k = step % points, step % points // 2, step % points // 2 + 1
                q = 2 * low + 1 - p % 2
                for i in range(LANES):
                    solve_contact(mu[k, i], gap[p, i], knobs.rate, m[k, i], j[k, i], m[low, i],
                        j[low, i], nx[p, i], nz[p, i], au[p, i], bu[p, i], al[p, i], bl[p, i],
                        pn[p, i], pt[p, i], nt[p, i], pn[q, i], n[p, i], t[p, i], ux[k, i],
                        uz[k, i], uo[k, i], ux[low, i], uz[low, i], uo[low, i])  # fmt: skip
            for k in range(1, bodies):
                low, p, q = k - 1, 2 * k - 2, 2 * k - 1
                for i in range(LANES):
                    live = lives[i] > 0
                    balance(even[i], n[p, i], t[p, i], n[q, i], t[q, i], ux[k, i], uo[k, i])
                    integrate_block(live, kept, knobs, dv[i], rise[i], m[k, i], j[k, i], gap[p, i],
                        nx[p, i], nz[p, i], gap[q, i], nx[q, i], nz[q, i], ux[k, i], uz[k, i],
                        uo[k, i], shift_x[i], shift_z[i], x[k, i], z[k, i], theta[k, i], s[k, i],
                        c[k, i], vx[k, i], vz[k, i], omega[k, i], loss[i], given[i])  # fmt: skip
                    observe(live, time, dt, knobs.gravity, lean[k, i], n[p, i], n[q, i],
                        theta[k, i], theta[low, i], ux[k, i], uz[k, i], uo[k, i], uo[low, i],
                        half_w[k, i], half_h[k, i], s[k, i], c[k, i], offset[k, i], half_w[low, i],
                        half_h[low, i], s[low, i], c[low, i], x[k, i] - x[low, i], z[k, i] -
                        z[low, i], z[k, i], since[k, i], left[k, i], right[k, i], uplift_time[i],
                        moved[i], deepest[i], impacts[i], peak[k, i], peak_time[k, i], slide[k, i],
                        peak_slide[k, i], crept[k, i], mode[i])  # fmt: skip
        past = time - until
        if found.rotations.shape[0] > 0:
            for k in range(1, bodies):
                for i in range(LANES):
                    turn = at_sample(mode[i], past, theta[k, i], omega[k, i])
                    found.rotations[sample, k - 1, first + i] = turn
                    if found.places.shape[0] > 0:
                        o, f = k - 1, first + i
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
