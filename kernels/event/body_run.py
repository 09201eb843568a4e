"""Runs of the event step over bodies on contact points, LANES lanes a thread.

As event/block_run.py; in each step a lane looks up the corner that it turns about, or would tip
about, and the two beside it.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.event.block import Knobs
from warprock.kernels.event.block_run import BlockResult
from warprock.kernels.event.body import begin, look_ahead, step
from warprock.kernels.event.body_contact import Body
from warprock.kernels.event.body_view import View, edge_of, tips_about_second
from warprock.kernels.event.body_weight import rise, weight_in
from warprock.kernels.modes import FLAT, OVERTURNED, PIVOTING, STALLED
from warprock.kernels.motion import sample_index
from warprock.kernels.shape.above import Above, Motions
from warprock.kernels.shape.body import Corner, is_past, turned_x, turned_z


@wp.func
def starts_past(body: Body, angle: real) -> int:
    """1 where a body starts beyond a rotation, or at it and turns on; else 0."""
    turns_on = body.start == angle and body.spin > real(0.0)
    return wp.where(body.start > angle or turns_on, 1, 0)


@wp.func
def start_lane(
    lowest: Corner, body: Body, theta: wp.ref[real], vx: wp.ref[real], vz: wp.ref[real],
    omega: wp.ref[real], mode: wp.ref[int], cap: wp.ref[real], peak: wp.ref[real],
    uplift_time: wp.ref[real], rest_time: wp.ref[real],
):  # fmt: skip
    """Lets a body go at its rotation [rad], about a corner if it turns."""
    start = body.start
    flat = start == lowest.angle and body.spin == real(0.0)
    s, c = sine(start), cosine(start)
    vx = -body.spin * (turned_z(lowest.x, lowest.z, s, c) - body.radius)
    vz = body.spin * turned_x(lowest.x, lowest.z, s, c)
    omega = body.spin
    theta = start
    mode = wp.where(flat, FLAT, PIVOTING)
    cap = NEVER
    peak = size(start)
    uplift_time = wp.where(flat, NEVER, real(0.0))
    rest_time = wp.where(flat, real(0.0), NEVER)


@wp.func
def view_of(number: int, left: Corner, own: Corner, right: Corner, flat_right: bool) -> View:
    """A corner, its number, and those beside it; of the first and the last one itself."""
    low = wp.where(number > 0, larger(left.angle, -HALF_PI), -HALF_PI)
    return View(
        number, own.x, own.z, low, smaller(own.angle, HALF_PI),
        left.x, left.z, right.x, right.z, flat_right,
    )  # fmt: skip


@wp.func
def observe(
    going: bool, step_limit: int, mode0: int, slip0: real, time0: real, theta0: real, mode: int,
    slip: real, time: real, theta: real, slide: real, gap: real, turn: real, turn_time: real,
    tail: real, lost: real, deep: real, hit: bool, peak: wp.ref[real], peak_time: wp.ref[real],
    peak_slide: wp.ref[real], uplift_time: wp.ref[real], rest_time: wp.ref[real],
    loss: wp.ref[real], deepest: wp.ref[real], left: wp.ref[real], right: wp.ref[real],
    impacts: wp.ref[int], steps: wp.ref[int],
) -> int:  # fmt: skip
    """What a step adds to the response of one lane, as in event/block_run.py; its mode.

    Args:
        going: Whether the lane took part in it.
        step_limit: Steps that it may take, trials included.
        mode0, slip0, time0, theta0: State before the step.
        mode, slip, time, theta, slide, gap: State after it.
        turn: Turning point of the rotation in it [rad], zero where there was none.
        turn_time: Its time [s].
        tail: Time of the impacts that resting leaves out [s].
        lost: Energy lost in it per unit mass [J/kg].
        deep: Penetration at its end [m].
        hit: Whether an impact ended it.
        peak: Largest |theta| so far [rad]; all after it likewise.
    """
    apex = size(turn)
    highest = larger(size(theta), apex)
    lifts = mode0 == FLAT and mode < FLAT and uplift_time >= NEVER
    # A velocity step of the base lifts at the end of a step, an acceleration from its start: it
    # turns the body, or leaves it.
    lifted = wp.where(theta == theta0 and gap <= real(0.0), time, time0)
    rested = mode0 == FLAT and slip0 == real(0.0)
    rests = mode == FLAT and slip == real(0.0)
    higher = highest > peak
    peak_time = wp.where(higher, wp.where(apex >= highest, turn_time, time), peak_time)
    peak = larger(highest, peak)
    peak_slide = larger(size(slide), peak_slide)
    uplift_time = wp.where(lifts, lifted, uplift_time)
    rest_time = wp.where(rests, wp.where(rested, rest_time, time + tail), NEVER)
    loss = loss + lost
    deepest = larger(deep, deepest)
    left = larger(larger(-theta, -turn), left)
    right = larger(larger(theta, turn), right)
    impacts = impacts + wp.where(hit, 1, 0)
    steps = steps + wp.where(going, 1, 0)
    limited = going and steps >= step_limit
    return wp.where(limited and mode < OVERTURNED, STALLED, mode)


@wp.func
def remember(
    taken: bool, time: real, theta: real, slide: real, gap: real, vx: real, vz: real, omega: real,
    corner: int, begun: wp.ref[real], theta0: wp.ref[real], slide0: wp.ref[real],
    gap0: wp.ref[real], vx0: wp.ref[real], vz0: wp.ref[real], omega0: wp.ref[real],
    about: wp.ref[int],
):  # fmt: skip
    """Keeps the state that a step began with, and its corner, for samples that lie inside it."""
    begun = wp.where(taken, time, begun)
    theta0 = wp.where(taken, theta, theta0)
    slide0 = wp.where(taken, slide, slide0)
    gap0 = wp.where(taken, gap, gap0)
    vx0 = wp.where(taken, vx, vx0)
    vz0 = wp.where(taken, vz, vz0)
    omega0 = wp.where(taken, omega, omega0)
    about = wp.where(taken, corner, about)


@wp.func
def rotation_at(
    until: real, time: real, theta: real, begun: real, theta0: real, omega0: real
) -> real:
    """Rotation inside the last step, which began at a time with theta0 and omega0 [rad]."""
    tau = until - begun
    d = time - begun
    part = wp.where(d > real(0.0), tau / d, real(1.0))
    inside = theta0 + omega0 * tau + part * part * (theta - theta0 - omega0 * d)
    return wp.where(until < time, inside, theta)


@wp.func
def place_at(
    corner: Corner, radius: real, until: real, time: real, begun: real, theta: real,
    slide: real, gap: real, theta0: real, slide0: real, gap0: real, vx0: real, vz0: real,
    omega0: real,
):  # fmt: skip
    """Centre of mass inside the last step [m], from the slide and the gap of its corner.

    Args:
        corner: The corner.
        radius: Of its arc [m].
        until: The time asked for [s]; after the end of the step, that counts.
        time, begun: End and start of the step [s].
        theta, slide, gap: State at its end.
        theta0: State at its start; so all up to omega0.

    Returns:
        x and z.
    """
    inside = until < time
    d = time - begun
    tau = wp.where(inside, until - begun, d)
    part = wp.where(inside and d > real(0.0), tau / d, real(1.0))
    at = rotation_at(until, time, theta, begun, theta0, omega0)
    s0, c0 = sine(theta0), cosine(theta0)
    glide = vx0 + omega0 * (turned_z(corner.x, corner.z, s0, c0) - radius)
    climb = vz0 - omega0 * turned_x(corner.x, corner.z, s0, c0)
    bend = part * part
    slid = slide0 + tau * glide + bend * (slide - slide0 - d * glide)
    high = gap0 + tau * climb + bend * (gap - gap0 - d * climb)
    s1, c1 = sine(at), cosine(at)
    rolled = corner.along + radius * at
    return (
        slid + rolled - turned_x(corner.x, corner.z, s1, c1),
        high + radius - turned_z(corner.x, corner.z, s1, c1),
    )


@wp.struct
class Result:
    """What one lane's run leaves behind; `needed`: friction that its prescribed impacts ask for."""

    uplift_time: real
    rest_time: real
    loss: real
    deepest: real
    needed: real
    impacts: int
    mode: int
    steps: int


@wp.struct
class Found:
    """Where the answers go; `sides`: largest rotations to -x and to +x [rad], shape [2, lane]."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
    places: wp.array4d(dtype=real)
    sides: wp.array2d(dtype=real)


Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)


ASKED = wp.constant(1)
DONE = wp.constant(2)
"""What a lane at rest does before a step in which its base may let it go: look ahead."""


@wp.kernel
def run_lanes(
    blocks: wp.array(dtype=Body), corners: wp.array2d(dtype=Corner),
    motions: Motions, pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, which take their steps side by side."""
    first = wp.tid() * LANES
    # By names of their own: read off the struct they would keep the loop over lanes scalar.
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    sides = found.sides
    places = found.places
    theta, slide, gap, vx, vz, omega, slip = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    time, base, cap, begun, theta0, omega0 = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    slide0, gap0, vx0, vz0 = Lane(), Lane(), Lane(), Lane()
    peak, peak_time, peak_slide, deepest = Lane(), Lane(), Lane(), Lane()
    uplift_time, rest_time, loss, needed = Lane(), Lane(), Lane(), Lane()
    left, right = Lane(), Lane()
    segment, mode, impacts, steps = LaneInt(), LaneInt(), LaneInt(), LaneInt()
    corner, last, about, risen, rising = LaneInt(), LaneInt(), LaneInt(), LaneInt(), Lane()
    look = LaneInt()
    for i in range(LANES):
        for k in range(corners.shape[0] - 1):
            corner[i] = corner[i] + starts_past(blocks[first + i], corners[k, first + i].angle)
            last[i] = last[i] + is_past(HALF_PI, corners[k, first + i].angle)
        about[i] = corner[i]
        start_lane(corners[corner[i], first + i], blocks[first + i], theta[i], vx[i], vz[i],
            omega[i], mode[i], cap[i], peak[i], uplift_time[i], rest_time[i])  # fmt: skip
    end = sample_times[sample_times.shape[0] - 1]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        busy, looking = int(1), int(0)
        while busy > 0:
            if looking > 0:
                for i in range(LANES):
                    above = Above()
                    if VERTICAL:
                        m = motions[0, first + i]
                        up = motions[1, first + i]
                        high = sample_index(up, risen[i])
                        above = Above(up, risen[i], pool[0, high], pool[1, high])
                    else:
                        m = motions[first + i]
                    place = sample_index(m, segment[i])
                    lower = corners[corner[i], first + i]
                    other = corners[wp.min(corner[i] + 1, last[i]), first + i]
                    edge = edge_of(blocks[first + i], lower.x, lower.z, other.x, other.z,
                        sine(theta[i]), cosine(theta[i]))  # fmt: skip
                    most = look_ahead(blocks[first + i], knobs.gravity, edge, m, pool[0, place],
                        pool[1, place], end, time[i], segment[i], above)  # fmt: skip
                    cap[i] = wp.where(look[i] == ASKED, smaller(most, cap[i]), cap[i])
                    look[i] = wp.where(look[i] == ASKED, DONE, look[i])
            for i in range(LANES):
                above = Above()
                if VERTICAL:
                    m = motions[0, first + i]
                    up = motions[1, first + i]
                    high = sample_index(up, risen[i])
                    above = Above(up, risen[i], pool[0, high], pool[1, high])
                else:
                    m = motions[first + i]
                place = sample_index(m, segment[i])
                going = mode[i] < OVERTURNED and time[i] < until
                d, ti, passed, kick, a, dv, more = begin(
                    blocks[first + i], knobs, m, pool[0, place], pool[1, place], end, going,
                    mode[i], slip[i], time[i], segment[i], omega[i], base[i], cap[i], above,
                )  # fmt: skip
                weight = weight_in(knobs.gravity, above, ti, d, rising[i])
                ahead = wp.min(corner[i] + 1, last[i])
                tips = tips_about_second(
                    blocks[first + i], knobs.gravity, weight, corners[corner[i], first + i],
                    corners[ahead, first + i], theta[i], slip[i], vx[i], dv, d,
                )  # fmt: skip
                second = mode[i] == FLAT and tips
                k = wp.where(second, ahead, corner[i])
                view = view_of(
                    k, corners[wp.max(k - 1, 0), first + i], corners[k, first + i],
                    corners[wp.min(k + 1, last[i]), first + i], not second,
                )  # fmt: skip
                (
                    co, th, sl, ga, ux, uz, om, di, mo, ti, se, ba, ca, ap, at, lo, ta, hit, ok, dp,
                    ne, asks,
                ) = step(
                    blocks[first + i], knobs, weight, view, going, look[i] == DONE, d, ti, passed,
                    kick, a, dv, more, corner[i], theta[i], slide[i], gap[i], vx[i], vz[i],
                    omega[i], slip[i], mode[i], time[i], segment[i], base[i], cap[i])  # fmt: skip
                remember(ok, time[i], theta[i], slide[i], gap[i], vx[i], vz[i], omega[i], k,
                    begun[i], theta0[i], slide0[i], gap0[i], vx0[i], vz0[i], omega0[i],
                    about[i])  # fmt: skip
                rise(ok, weight, rising[i], risen[i])
                mo = observe(
                    going, blocks[first + i].step_limit, mode[i], slip[i], time[i], theta[i], mo,
                    di, ti, th, sl, ga, ap, at, ta, lo, dp, hit, peak[i], peak_time[i],
                    peak_slide[i], uplift_time[i], rest_time[i], loss[i], deepest[i], left[i],
                    right[i], impacts[i], steps[i])  # fmt: skip
                needed[i] = larger(ne, needed[i])
                look[i] = wp.where(asks, ASKED, wp.where(ok, 0, look[i]))
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
            busy, looking = int(0), int(0)
            for i in range(LANES):
                busy = busy + wp.where(mode[i] < OVERTURNED and time[i] < until, 1, 0)
                looking = looking + wp.where(look[i] == ASKED, 1, 0)
        if rotations.shape[0] > 0:
            for i in range(LANES):
                at = rotation_at(until, time[i], theta[i], begun[i], theta0[i], omega0[i])
                rotations[sample, 0, first + i] = at
        if places.shape[0] > 0:
            for i in range(LANES):
                spot, level = place_at(corners[about[i], first + i], blocks[first + i].radius,
                    until, time[i], begun[i], theta[i], slide[i], gap[i], theta0[i], slide0[i],
                    gap0[i], vx0[i], vz0[i], omega0[i])  # fmt: skip
                places[sample, 0, 0, first + i] = spot
                places[sample, 0, 1, first + i] = level
    for i in range(LANES):
        results[first + i] = Result(uplift_time[i], rest_time[i], loss[i], deepest[i], needed[i],
            impacts[i], mode[i], steps[i])  # fmt: skip
        sides[0, first + i] = left[i]
        sides[1, first + i] = right[i]
        leaves[0, first + i] = BlockResult(slide[i], peak[i], peak_time[i], peak_slide[i])
