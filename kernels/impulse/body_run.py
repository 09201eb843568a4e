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
from warprock.kernels.motion import Motion, base_velocity, sample_index, sample_segment
from warprock.kernels.parting import slack, slides
from warprock.kernels.shape.block import observe
from warprock.kernels.shape.body import Corner, is_past, turned_x, turned_z
from warprock.kernels.shape.body_seen import moved_along, moved_parts, watch
from warprock.kernels.shape.stack_found import BlockResult, Found, Result, at_sample

Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)


@wp.kernel
def run_lanes(
    blocks: wp.array(dtype=Body),
    corners: wp.array2d(dtype=Corner),
    motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=real),
    sample_times: wp.array(dtype=real),
    sides: wp.array2d(dtype=real),
    knobs: Knobs,
    found: Found,
):
    """Runs LANES lanes a thread, all at the same time."""
    first = wp.tid() * LANES
    # By names of their own: read off the struct they would keep the loop over lanes scalar.
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    places = found.places
    x, z, theta, vx, vz, omega = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    nl, fl, nm, fm, nr, fr = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    loss, base, slide = Lane(), Lane(), Lane()
    given, jolt, supplied, taken, returned = Lane(), Lane(), Lane(), Lane(), Lane()
    peak, peak_time, peak_slide, deepest = Lane(), Lane(), Lane(), Lane()
    left, right = Lane(), Lane()
    uplift_time, moved, since = Lane(), Lane(), Lane()
    impacts, mode, steps = LaneInt(), LaneInt(), LaneInt()
    apart_l, apart_m, apart_r, low, last = LaneInt(), LaneInt(), LaneInt(), LaneInt(), LaneInt()
    edges = corners.shape[0] - 1
    for i in range(LANES):
        th = starts[first + i]
        theta[i] = th
        for k in range(edges):
            low[i] = low[i] + is_past(th, corners[k, first + i].angle)
        for k in range(edges):
            last[i] = last[i] + wp.where(corners[k, first + i].angle < NEVER, 1, 0)
        s, c = sine(th), cosine(th)
        corner = corners[low[i], first + i]
        z[i] = -turned_z(corner.x, corner.z, s, c)
        vz[i] = HALF * knobs.time_step * knobs.gravity
        # On an edge the lowest corner counts as its first one; the second has its share by statics.
        flat = th == corner.angle
        ahead = wp.where(flat, wp.min(low[i] + 1, edges), low[i])
        foot = turned_x(corner.x, corner.z, s, c)
        x[i] = corner.along - foot
        length = corners[ahead, first + i].along - corner.along
        share = larger(smaller(-foot / wp.where(flat, length, real(1.0)), real(1.0)), real(0.0))
        share = wp.where(flat, share, real(0.0))
        nm[i] = (real(1.0) - share) * HALF * knobs.time_step * knobs.gravity
        nr[i] = share * HALF * knobs.time_step * knobs.gravity
        peak[i] = size(th)
        uplift_time[i] = wp.where(flat, NEVER, real(0.0))
        mode[i] = RUNNING
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
                m = motions[first + i]
                # Field by field: four float32 loaded at once would keep the loop scalar.
                body = Body()
                body.inverse_inertia = blocks[first + i].inverse_inertia
                body.friction = blocks[first + i].friction
                body.reach = blocks[first + i].reach
                place = sample_index(m, sample_segment(m, half))
                moving = base_velocity(m, half, pool[2, place], pool[0, place], pool[1, place])
                mid = now[i]
                by = mid - low[i]
                has_l, has_r = mid > 0, mid < last[i]
                before, behind = wp.where(has_l, mid - 1, mid), wp.where(has_r, mid + 1, mid)
                s, c = sine(in_range(theta[i])), cosine(in_range(theta[i]))
                xl = turned_x(corners[before, first + i].x, corners[before, first + i].z, s, c)
                zl = turned_z(corners[before, first + i].x, corners[before, first + i].z, s, c)
                xm = turned_x(corners[mid, first + i].x, corners[mid, first + i].z, s, c)
                zm = turned_z(corners[mid, first + i].x, corners[mid, first + i].z, s, c)
                xr = turned_x(corners[behind, first + i].x, corners[behind, first + i].z, s, c)
                zr = turned_z(corners[behind, first + i].x, corners[behind, first + i].z, s, c)
                gl, gm, gr = moved_along(by, nl[i], nm[i], nr[i])
                hl, hm, hr = moved_along(by, fl[i], fm[i], fr[i])
                al, am, ar = moved_parts(by, apart_l[i], apart_m[i], apart_r[i])
                qx, qz, qt, ux, uz, uo, pl, tl, pm, tm, pr, tr, lo, gap, gap_l, gap_m, gap_r = step(
                    body, knobs, moving - base[i], xl, zl, xm, zm, xr, zr, has_l, has_r,
                    x[i], z[i], theta[i], vx[i], vz[i], omega[i], gl, hl, gm, hm, gr, hr, loss[i],
                )  # fmt: skip
                # The corner that was lowest at the start of the step tells the slide.
                s1, c1 = sine(in_range(qt)), cosine(in_range(qt))
                slid = (
                    qx
                    + turned_x(corners[mid, first + i].x, corners[mid, first + i].z, s1, c1)
                    - corners[mid, first + i].along
                )
                mo, pk, pt, ps = observe(
                    mode[i], time, qt, uo, slid, peak[i], peak_time[i], peak_slide[i]
                )
                live = mode[i] == RUNNING
                limit = slack(
                    knobs.time_step, knobs.gravity, body.reach, uo * uo, body.reach
                )  # fmt: skip
                glides = slides(
                    knobs.time_step * (ux + uo * zm), knobs.time_step, knobs.gravity
                )  # fmt: skip
                nowl, nowm, nowr, waits, up, mv, landed = watch(
                    time, limit, has_l, has_r, pl, gap_l, pm, gap_m, pr, gap_r, glides,
                    since[i], al, am, ar, uplift_time[i], moved[i],
                )  # fmt: skip
                since[i] = waits
                apart_l[i] = nowl
                apart_m[i] = nowm
                apart_r[i] = nowr
                uplift_time[i] = wp.where(live, up, uplift_time[i])
                moved[i] = wp.where(live, mv, moved[i])
                impacts[i] = impacts[i] + wp.where(live, landed, 0)
                x[i] = wp.where(live, qx, x[i])
                z[i] = wp.where(live, qz, z[i])
                theta[i] = wp.where(live, qt, theta[i])
                dv = moving - base[i]
                given[i] = given[i] - wp.where(live, HALF * dv * (vx[i] + ux), real(0.0))
                vx[i] = wp.where(live, ux, vx[i])
                vz[i] = wp.where(live, uz, vz[i])
                omega[i] = wp.where(live, uo, omega[i])
                nl[i] = wp.where(live, pl, nl[i])
                fl[i] = wp.where(live, tl, fl[i])
                nm[i] = wp.where(live, pm, nm[i])
                fm[i] = wp.where(live, tm, fm[i])
                nr[i] = wp.where(live, pr, nr[i])
                fr[i] = wp.where(live, tr, fr[i])
                low[i] = mid
                loss[i] = wp.where(live, lo, loss[i])
                base[i] = moving
                book(dv, given[i], loss[i], jolt[i], supplied[i], taken[i], returned[i])
                slide[i] = wp.where(live, slid, slide[i])
                peak[i] = wp.where(live, pk, peak[i])
                left[i] = larger(-theta[i], left[i])
                right[i] = larger(theta[i], right[i])
                peak_time[i] = wp.where(live, pt, peak_time[i])
                peak_slide[i] = wp.where(live, ps, peak_slide[i])
                deepest[i] = wp.where(live, larger(-gap, deepest[i]), deepest[i])
                steps[i] = steps[i] + wp.where(live, 1, 0)
                mode[i] = wp.where(live, mo, mode[i])
        past = time - until
        if rotations.shape[0] > 0:
            for i in range(LANES):
                rotations[sample, 0, first + i] = at_sample(mode[i], past, theta[i], omega[i])
        if places.shape[0] > 0:
            for i in range(LANES):
                places[sample, 0, 0, first + i] = at_sample(mode[i], past, x[i], vx[i])
                places[sample, 0, 1, first + i] = at_sample(mode[i], past, z[i], vz[i])
    for i in range(LANES):
        results[first + i] = Result(
            uplift_time[i], moved[i], loss[i], jolt[i], supplied[i], returned[i], deepest[i],
            impacts[i], mode[i], steps[i],
        )  # fmt: skip
        sides[0, first + i] = left[i]
        sides[1, first + i] = right[i]
        leaves[0, first + i] = BlockResult(slide[i], peak[i], peak_time[i], peak_slide[i])
