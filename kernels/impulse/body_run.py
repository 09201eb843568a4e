"""Runs of the impulse step over bodies on contact points, LANES lanes a thread.

In each step a lane looks up its lowest corner and the two beside it; what is known of corners from
the last step, impulses and whether they have parted, moves along with them.

A body rocks while less than two of its corners are closed, see shape/body_seen.py.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.account import book
from warprock.kernels.impulse.block import Knobs
from warprock.kernels.impulse.body import Body, step
from warprock.kernels.modes import RUNNING
from warprock.kernels.motion import base_velocity, sample_index, sample_segment
from warprock.kernels.parting import slack, slides
from warprock.kernels.shape.above import Motions
from warprock.kernels.shape.block import observe
from warprock.kernels.shape.body import Corner, is_past, turned_x, turned_z
from warprock.kernels.shape.body_found import Found
from warprock.kernels.shape.body_seen import moved_along, watch
from warprock.kernels.shape.rising import pulled, worked
from warprock.kernels.shape.stack_found import BlockResult, Result, at_sample


@wp.func
def turned_corner(corner: Corner, s: real, c: real):
    """A corner, x and z from the centre of mass [m], of a body turned by (s, c)."""
    return turned_x(corner.x, corner.z, s, c), turned_z(corner.x, corner.z, s, c)


@wp.func
def keep(
    live: bool, new1: real, new2: real, new3: real, new4: real, new5: real, new6: real,
    a1: wp.ref[real], a2: wp.ref[real], a3: wp.ref[real], a4: wp.ref[real], a5: wp.ref[real],
    a6: wp.ref[real],
):  # fmt: skip
    """Takes over six numbers of a lane that still runs."""
    a1 = wp.where(live, new1, a1)
    a2 = wp.where(live, new2, a2)
    a3 = wp.where(live, new3, a3)
    a4 = wp.where(live, new4, a4)
    a5 = wp.where(live, new5, a5)
    a6 = wp.where(live, new6, a6)


@wp.func
def see(
    live: bool, mode: int, time: real, theta: real, omega: real, slide: real,
    peak: wp.ref[real], left: wp.ref[real], right: wp.ref[real], peak_time: wp.ref[real],
    peak_slide: wp.ref[real],
) -> int:  # fmt: skip
    """Peaks of a lane that still runs after a step, see `observe` in shape/block.py; its mode."""
    how, highest, when, farthest = observe(
        mode, time, theta, omega, slide, peak, peak_time, peak_slide
    )
    peak = wp.where(live, highest, peak)
    left = wp.where(live, larger(-theta, left), left)
    right = wp.where(live, larger(theta, right), right)
    peak_time = wp.where(live, when, peak_time)
    peak_slide = wp.where(live, farthest, peak_slide)
    return wp.where(live, how, mode)


@wp.func
def start_lane(
    corner: Corner, ahead: Corner, body: Body, fall: real, x: wp.ref[real], z: wp.ref[real],
    theta: wp.ref[real], vx: wp.ref[real], vz: wp.ref[real], omega: wp.ref[real],
    nm: wp.ref[real], nr: wp.ref[real], peak: wp.ref[real], uplift_time: wp.ref[real],
    mode: wp.ref[int],
):  # fmt: skip
    """Lets a body go at its start, where a corner is lowest; `ahead` is the next one.

    `fall` is what half a step of gravity makes of a velocity [m/s]. On an edge the first corner
    counts as the lowest; the other one has its share of the weight by statics.
    """
    start = body.start
    foot, low = turned_corner(corner, sine(start), cosine(start))
    flat = start == corner.angle
    length = wp.where(flat, ahead.along - corner.along, real(1.0))
    share = larger(smaller(-foot / length, real(1.0)), real(0.0))
    share = wp.where(flat, share, real(0.0))
    x = corner.along - foot
    z = -low
    theta = start
    vx = body.vx
    vz = body.vz + fall
    omega = body.omega
    nm = (real(1.0) - share) * fall
    nr = share * fall
    peak = size(start)
    uplift_time = wp.where(flat and body.omega == real(0.0), NEVER, real(0.0))
    mode = RUNNING


Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)


@wp.kernel
def run_lanes(
    blocks: wp.array(dtype=Body), corners: wp.array2d(dtype=Corner),
    motions: Motions, pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    first = wp.tid() * LANES
    # By names of their own: read off the struct they would keep the loop over lanes scalar.
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    sides = found.sides
    places = found.places
    x, z, theta, vx, vz, omega = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    nl, fl, nm, fm, nr, fr = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    loss, base, slide, left, right, rising = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    given, jolt, supplied, taken, returned = Lane(), Lane(), Lane(), Lane(), Lane()
    peak, peak_time, peak_slide, deepest, steps = Lane(), Lane(), Lane(), Lane(), LaneInt()
    uplift_time, moved, since, impacts, mode = Lane(), Lane(), Lane(), LaneInt(), LaneInt()
    apart_l, apart_m, apart_r, low, last = LaneInt(), LaneInt(), LaneInt(), LaneInt(), LaneInt()
    edges = corners.shape[0] - 1
    for i in range(LANES):
        for k in range(edges):
            low[i] = low[i] + is_past(blocks[first + i].start, corners[k, first + i].angle)
            last[i] = last[i] + wp.where(corners[k, first + i].angle < NEVER, 1, 0)
        start_lane(corners[low[i], first + i], corners[wp.min(low[i] + 1, last[i]), first + i],
            blocks[first + i], HALF * knobs.time_step * knobs.gravity, x[i], z[i], theta[i], vx[i],
            vz[i], omega[i], nm[i], nr[i], peak[i], uplift_time[i], mode[i])  # fmt: skip
    k = int(0)
    time = real(0.0)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until:
            k += 1
            time = real(k) * knobs.time_step
            half = time - HALF * knobs.time_step
            now = LaneInt()
            for e in range(edges):
                for i in range(LANES):
                    now[i] = now[i] + is_past(theta[i], corners[e, first + i].angle)
            for i in range(LANES):
                dz = real(0.0)
                if VERTICAL:
                    m = motions[0, first + i]
                    up = motions[1, first + i]
                    high = sample_index(up, sample_segment(up, half))
                    rise = base_velocity(up, half, pool[2, high], pool[0, high], pool[1, high])
                    dz = rise - rising[i]
                    rising[i] = rise
                else:
                    m = motions[first + i]
                place = sample_index(m, sample_segment(m, half))
                moving = base_velocity(m, half, pool[2, place], pool[0, place], pool[1, place])
                mid = now[i]
                by = mid - low[i]
                has_l, has_r = mid > 0, mid < last[i]
                before, behind = wp.where(has_l, mid - 1, mid), wp.where(has_r, mid + 1, mid)
                s, c = sine(in_range(theta[i])), cosine(in_range(theta[i]))
                xl, zl = turned_corner(corners[before, first + i], s, c)
                xm, zm = turned_corner(corners[mid, first + i], s, c)
                xr, zr = turned_corner(corners[behind, first + i], s, c)
                gl, gm, gr = moved_along(by, nl[i], nm[i], nr[i])
                hl, hm, hr = moved_along(by, fl[i], fm[i], fr[i])
                qx, qz, qt, ux, uz, uo, pl, tl, pm, tm, pr, tr, lo, gap, gap_l, gap_m, gap_r = step(
                    blocks[first + i], knobs, moving - base[i], dz,
                    xl, zl, xm, zm, xr, zr, has_l, has_r, x[i], z[i], theta[i],
                    vx[i], vz[i], omega[i], gl, hl, gm, hm, gr, hr, loss[i],
                )  # fmt: skip
                # The corner that was lowest at the start of the step tells the slide.
                s1, c1 = sine(in_range(qt)), cosine(in_range(qt))
                x1, _z1 = turned_corner(corners[mid, first + i], s1, c1)
                slid = qx + x1 - corners[mid, first + i].along
                live = mode[i] == RUNNING
                reach = blocks[first + i].reach
                limit = slack(knobs.time_step, knobs.gravity, reach, uo * uo, reach)
                way = knobs.time_step * (ux + uo * zm)
                glides = slides(way, knobs.time_step, knobs.gravity)
                watch(live, by, time, limit, has_l, has_r, pl, gap_l, pm, gap_m, pr, gap_r,
                    glides, since[i], apart_l[i], apart_m[i], apart_r[i], uplift_time[i],
                    moved[i], impacts[i])  # fmt: skip
                dv = moving - base[i]
                work = worked(dv, dz, vx[i] + ux, vz[i] + uz)
                given[i] = given[i] - wp.where(live, work, real(0.0))
                loss[i] = wp.where(live, lo, loss[i])
                base[i] = moving
                jerk = pulled(dv, dz, knobs.time_step * knobs.gravity)
                book(jerk, given[i], loss[i], jolt[i], supplied[i], taken[i], returned[i])
                keep(live, qx, qz, qt, ux, uz, uo, x[i], z[i], theta[i], vx[i], vz[i], omega[i])
                keep(live, pl, tl, pm, tm, pr, tr, nl[i], fl[i], nm[i], fm[i], nr[i], fr[i])
                low[i] = mid
                slide[i] = wp.where(live, slid, slide[i])
                deepest[i] = wp.where(live, larger(-gap, deepest[i]), deepest[i])
                steps[i] = steps[i] + wp.where(live, 1, 0)
                mode[i] = see(live, mode[i], time, qt, uo, slid, peak[i], left[i], right[i],
                    peak_time[i], peak_slide[i])  # fmt: skip
        past = time - until
        if rotations.shape[0] > 0:
            for i in range(LANES):
                rotations[sample, 0, first + i] = at_sample(mode[i], past, theta[i], omega[i])
        if places.shape[0] > 0:
            for i in range(LANES):
                places[sample, 0, 0, first + i] = at_sample(mode[i], past, x[i], vx[i])
                places[sample, 0, 1, first + i] = at_sample(mode[i], past, z[i], vz[i])
    for i in range(LANES):
        results[first + i] = Result(uplift_time[i], moved[i], loss[i], jolt[i], supplied[i],
            returned[i], deepest[i], impacts[i], mode[i], steps[i])  # fmt: skip
        sides[0, first + i] = left[i]
        sides[1, first + i] = right[i]
        leaves[0, first + i] = BlockResult(slide[i], peak[i], peak_time[i], peak_slide[i])
