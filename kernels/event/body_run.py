"""Runs of the event step over bodies on contact points, LANES lanes a thread.

As event/block_run.py; in each step a lane looks up the corner that it turns about, or would tip
about, and the two beside it.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.event.block import Knobs
from warprock.kernels.event.block_run import BlockResult, Found, Result, rotation_at
from warprock.kernels.event.body import begin, step
from warprock.kernels.event.body_contact import Body
from warprock.kernels.event.body_view import View, tips_about_second
from warprock.kernels.modes import FLAT, OVERTURNED, PIVOTING, STALLED
from warprock.kernels.motion import Motion, sample_index
from warprock.kernels.shape.body import Corner, is_past, turned_x, turned_z


@wp.func
def observe(
    limited: bool, mode0: int, slip0: real, time0: real, theta0: real, mode: int, slip: real,
    time: real, theta: real, slide: real, turn: real, turn_time: real, tail: real,
    peak: real, peak_time: real, peak_slide: real, uplift_time: real, rest_time: real,
):  # fmt: skip
    """What a step adds to the response of one lane, as in event/block_run.py.

    Args:
        limited: Whether the lane has used up its steps.
        mode0, slip0, time0, theta0: State before the step.
        mode, slip, time, theta, slide: State after it.
        turn: Turning point of the rotation in it [rad], zero where there was none.
        turn_time: Its time [s].
        tail: Time of the impacts that resting leaves out [s].
        peak: Largest |theta| so far [rad]; all after it likewise.

    Returns:
        mode, peak, peak_time, peak_slide, uplift_time, rest_time.
    """
    apex = size(turn)
    highest = larger(size(theta), apex)
    lifts = mode0 == FLAT and mode < FLAT and uplift_time >= NEVER
    # A velocity step of the base lifts at the end of a step, an acceleration from its start.
    lifted = wp.where(theta == theta0, time, time0)
    rested = mode0 == FLAT and slip0 == real(0.0)
    rests = mode == FLAT and slip == real(0.0)
    return (
        wp.where(limited and mode < OVERTURNED, STALLED, mode),
        larger(highest, peak),
        wp.where(highest > peak, wp.where(apex >= highest, turn_time, time), peak_time),
        larger(size(slide), peak_slide),
        wp.where(lifts, lifted, uplift_time),
        wp.where(rests, wp.where(rested, rest_time, time + tail), NEVER),
    )


@wp.func
def place_at(
    corner: Corner, radius: real, part: real, tau: real, d: real, at: real, slide: real, gap: real,
    theta0: real, slide0: real, gap0: real, vx0: real, vz0: real, omega0: real,
):  # fmt: skip
    """Centre of mass inside the last step [m], from the slide and the gap of its corner.

    Args:
        corner: The corner.
        radius: Of its arc [m].
        part: Part of the step that has passed.
        tau: Time since it began [s].
        d: Its length [s].
        at: Rotation at that time [rad].
        slide, gap: At the end of the step [m].
        theta0: State at its start; so all up to omega0.

    Returns:
        x and z.
    """
    s0, c0 = sine(theta0), cosine(theta0)
    glide = vx0 + omega0 * (turned_z(corner.x, corner.z, s0, c0) - radius)
    rise = vz0 - omega0 * turned_x(corner.x, corner.z, s0, c0)
    bend = part * part
    slid = slide0 + tau * glide + bend * (slide - slide0 - d * glide)
    high = gap0 + tau * rise + bend * (gap - gap0 - d * rise)
    s1, c1 = sine(at), cosine(at)
    rolled = corner.along + radius * at
    return (
        slid + rolled - turned_x(corner.x, corner.z, s1, c1),
        high + radius - turned_z(corner.x, corner.z, s1, c1),
    )


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
    knobs: Knobs,
    found: Found,
):
    """Runs LANES lanes a thread, which take their steps side by side."""
    first = wp.tid() * LANES
    # By names of their own: read off the struct they would keep the loop over lanes scalar.
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    places = found.places
    theta, slide, gap, vx, vz, omega, slip = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    time, base, cap, begun, theta0, omega0 = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    slide0, gap0, vx0, vz0 = Lane(), Lane(), Lane(), Lane()
    peak, peak_time, peak_slide, deepest = Lane(), Lane(), Lane(), Lane()
    uplift_time, rest_time, loss = Lane(), Lane(), Lane()
    segment, mode, impacts, steps = LaneInt(), LaneInt(), LaneInt(), LaneInt()
    corner, last, about = LaneInt(), LaneInt(), LaneInt()
    edges = corners.shape[0] - 1
    for i in range(LANES):
        for k in range(edges):
            angle = corners[k, first + i].angle
            corner[i] = corner[i] + is_past(starts[first + i], angle)
            last[i] = last[i] + is_past(HALF_PI, angle)
        flat = starts[first + i] == corners[corner[i], first + i].angle
        theta[i] = starts[first + i]
        mode[i] = wp.where(flat, FLAT, PIVOTING)
        cap[i] = NEVER
        peak[i] = size(starts[first + i])
        uplift_time[i] = wp.where(flat, NEVER, real(0.0))
        rest_time[i] = wp.where(flat, real(0.0), NEVER)
        about[i] = corner[i]
    end = sample_times[sample_times.shape[0] - 1]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        busy = int(1)
        while busy > 0:
            # In a loop of its own, so that runs without places do without it. A trial that is not
            # taken changes nothing, and the next one starts with the same.
            if places.shape[0] > 0:
                for i in range(LANES):
                    goes = mode[i] < OVERTURNED and time[i] < until
                    slide0[i] = wp.where(goes, slide[i], slide0[i])
                    gap0[i] = wp.where(goes, gap[i], gap0[i])
                    vx0[i] = wp.where(goes, vx[i], vx0[i])
                    vz0[i] = wp.where(goes, vz[i], vz0[i])
            for i in range(LANES):
                m = motions[first + i]
                place = sample_index(m, segment[i])
                going = mode[i] < OVERTURNED and time[i] < until
                count = steps[i] + wp.where(going, 1, 0)
                # Loaded before an `and`, which would branch around the load: no vector code then.
                spent = count >= blocks[first + i].step_limit
                lies = mode[i] == FLAT
                resting = lies and slip[i] == real(0.0)
                d, ti, passed, kick, a, dv = begin(
                    blocks[first + i], knobs, m, pool[0, place], pool[1, place], end, going,
                    resting, time[i], segment[i], omega[i], base[i], cap[i],
                )  # fmt: skip
                k = corner[i]
                k2 = wp.min(k + 1, last[i])
                tips = tips_about_second(
                    blocks[first + i], knobs.gravity, corners[k, first + i].x,
                    corners[k, first + i].z, corners[k2, first + i].x, corners[k2, first + i].z,
                    theta[i], slip[i], vx[i], dv, d,
                )  # fmt: skip
                second = lies and tips
                j = wp.where(second, k2, k)
                j0 = wp.max(j - 1, 0)
                j2 = wp.min(j + 1, last[i])
                view = View(
                    j, corners[j, first + i].x, corners[j, first + i].z,
                    wp.where(j > 0, larger(corners[j0, first + i].angle, -HALF_PI), -HALF_PI),
                    smaller(corners[j, first + i].angle, HALF_PI),
                    corners[j0, first + i].x, corners[j0, first + i].z,
                    corners[j2, first + i].x, corners[j2, first + i].z,
                    not second,
                )  # fmt: skip
                co, th, sl, ga, ux, uz, om, di, mo, ti, se, ba, ca, ap, at, lo, ta, hit, ok, dp = (
                    step(
                        blocks[first + i], knobs, view, going, d, ti, passed, kick, a, dv, k,
                        theta[i], slide[i], gap[i], vx[i], vz[i], omega[i], slip[i], mode[i],
                        time[i], segment[i], base[i], cap[i],
                    )
                )  # fmt: skip
                begun[i] = wp.where(ok, time[i], begun[i])
                theta0[i] = wp.where(ok, theta[i], theta0[i])
                omega0[i] = wp.where(ok, omega[i], omega0[i])
                about[i] = wp.where(ok, j, about[i])
                mo, pk, pt, ps, ut, rt = observe(
                    going and spent, mode[i], slip[i], time[i], theta[i], mo, di, ti, th, sl, ap,
                    at, ta, peak[i], peak_time[i], peak_slide[i], uplift_time[i], rest_time[i],
                )  # fmt: skip
                corner[i] = co
                theta[i] = th
                slide[i] = sl
                gap[i] = ga
                vx[i] = ux
                vz[i] = uz
                omega[i] = om
                slip[i] = di
                mode[i] = mo
                time[i] = ti
                segment[i] = se
                base[i] = ba
                cap[i] = ca
                peak[i] = pk
                peak_time[i] = pt
                peak_slide[i] = ps
                uplift_time[i] = ut
                rest_time[i] = rt
                loss[i] = loss[i] + lo
                deepest[i] = larger(dp, deepest[i])
                impacts[i] = impacts[i] + wp.where(hit, 1, 0)
                steps[i] = count
            busy = int(0)
            for i in range(LANES):
                busy = busy + wp.where(mode[i] < OVERTURNED and time[i] < until, 1, 0)
        if rotations.shape[0] > 0:
            for i in range(LANES):
                rotations[sample, 0, first + i] = rotation_at(
                    until, time[i], theta[i], begun[i], theta0[i], omega0[i]
                )
        if places.shape[0] > 0:
            for i in range(LANES):
                inside = until < time[i]
                d = time[i] - begun[i]
                tau = wp.where(inside, until - begun[i], d)
                part = wp.where(inside and d > real(0.0), tau / d, real(1.0))
                at = rotation_at(until, time[i], theta[i], begun[i], theta0[i], omega0[i])
                spot, level = place_at(
                    corners[about[i], first + i], blocks[first + i].radius, part, tau, d, at,
                    slide[i], gap[i], theta0[i], slide0[i], gap0[i], vx0[i], vz0[i], omega0[i],
                )  # fmt: skip
                places[sample, 0, 0, first + i] = spot
                places[sample, 0, 1, first + i] = level
    for i in range(LANES):
        results[first + i] = Result(
            uplift_time[i], rest_time[i], loss[i], deepest[i], impacts[i], mode[i], steps[i]
        )
        leaves[0, first + i] = BlockResult(slide[i], peak[i], peak_time[i], peak_slide[i])
