"""Runs of the event step over lanes, LANES lanes a thread: a pack on the CPU, one on any device.

Every lane has its own clock and ends its steps where its events are; a sample inside a step is
read off the parabola that the step follows, so that histories do not change the run.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.event.block import Knobs, look_ahead, step
from warprock.kernels.event.block_contact import Block, lower_corner
from warprock.kernels.event.block_rocking import rotation_after
from warprock.kernels.event.block_roll import roll
from warprock.kernels.modes import FLAT, FLYING, OVERTURNED, PIVOTING, STALLED
from warprock.kernels.motion import Motion, sample_index


@wp.func
def observe(
    going: bool, step_limit: int, mode0: int, slip0: real, time0: real, mode: int, slip: real,
    time: real, theta: real, slide: real, apex: real, apex_time: real, tail: real, lost: real,
    deep: real, hit: bool, peak: wp.ref[real], peak_time: wp.ref[real], peak_slide: wp.ref[real],
    uplift_time: wp.ref[real], rest_time: wp.ref[real], loss: wp.ref[real],
    deepest: wp.ref[real], impacts: wp.ref[int], steps: wp.ref[int],
) -> int:  # fmt: skip
    """What a step adds to the response of one lane; its mode. With 0 the state before it.

    Args:
        going: Whether the lane took part in it.
        step_limit: Steps that it may take, trials included.
        mode0, mode: Contact of the block.
        slip0, slip: Direction in which it slides, 0 where it does not.
        time0, time: Time [s].
        theta: Rotation [rad].
        slide: Slide along the base [m].
        apex: Turning point of |theta| inside the step [rad], zero where there was none.
        apex_time: Its time [s].
        tail: Time of the impacts that resting leaves out [s].
        lost: Energy lost in it per unit mass [J/kg].
        deep: Penetration at its end [m].
        hit: Whether an impact ended it.
        peak, peak_time: Largest |theta| so far [rad] and its time [s].
        peak_slide: Largest |slide| so far [m].
        uplift_time: Time at which the block first left its flat state [s].
        rest_time: Time since when it rests [s].
        loss, deepest, impacts, steps: Their sums, and the deepest penetration, so far.
    """
    highest = larger(size(theta), apex)
    lifts = mode0 == FLAT and mode < FLAT and uplift_time >= NEVER
    # A velocity step of the base lifts at the end of a step, an acceleration from its start.
    lifted = wp.where(theta == real(0.0), time, time0)
    rested = mode0 == FLAT and slip0 == real(0.0)
    rests = mode == FLAT and slip == real(0.0)
    higher = highest > peak
    peak_time = wp.where(higher, wp.where(apex >= highest, apex_time, time), peak_time)
    peak = larger(highest, peak)
    peak_slide = larger(size(slide), peak_slide)
    uplift_time = wp.where(lifts, lifted, uplift_time)
    rest_time = wp.where(rests, wp.where(rested, rest_time, time + tail), NEVER)
    loss = loss + lost
    deepest = larger(deep, deepest)
    impacts = impacts + wp.where(hit, 1, 0)
    steps = steps + wp.where(going, 1, 0)
    limited = going and steps >= step_limit
    return wp.where(limited and mode < OVERTURNED, STALLED, mode)


@wp.func
def remember(
    taken: bool, time: real, theta: real, omega: real,
    k2: real, k3: real, k4: real, k5: real, k6: real,
    begun: wp.ref[real], theta0: wp.ref[real], omega0: wp.ref[real], c2: wp.ref[real],
    c3: wp.ref[real], c4: wp.ref[real], c5: wp.ref[real], c6: wp.ref[real],
):  # fmt: skip
    """Keeps how a step began, and the polynomial that it follows, for samples that lie inside."""
    begun = wp.where(taken, time, begun)
    theta0 = wp.where(taken, theta, theta0)
    omega0 = wp.where(taken, omega, omega0)
    c2 = wp.where(taken, k2, c2)
    c3 = wp.where(taken, k3, c3)
    c4 = wp.where(taken, k4, c4)
    c5 = wp.where(taken, k5, c5)
    c6 = wp.where(taken, k6, c6)


@wp.func
def remember_place(
    live: bool, slide: real, gap: real, vx: real, vz: real,
    slide0: wp.ref[real], gap0: wp.ref[real], vx0: wp.ref[real], vz0: wp.ref[real],
):  # fmt: skip
    """Keeps the place with which a step begins, for samples that lie inside it.

    In a loop over lanes of its own, so that runs without places do without it.
    """
    slide0 = wp.where(live, slide, slide0)
    gap0 = wp.where(live, gap, gap0)
    vx0 = wp.where(live, vx, vx0)
    vz0 = wp.where(live, vz, vz0)


@wp.func
def rotation_at(
    until: real, time: real, theta: real, begun: real, theta0: real, omega0: real,
    c2: real, c3: real, c4: real, c5: real, c6: real,
) -> real:  # fmt: skip
    """Rotation inside the last step [rad]: on the polynomial that it followed from its start on."""
    inside = rotation_after(theta0, omega0, c2, c3, c4, c5, c6, until - begun)
    return wp.where(until < time, inside, theta)


@wp.func
def place_at(
    block: Block, until: real, time: real, begun: real, at: real, slide: real, gap: real,
    theta0: real, slide0: real, gap0: real, vx0: real, vz0: real, omega0: real,
):  # fmt: skip
    """Centre of mass inside the last step [m], from the slide and the gap of the lower corner.

    Args:
        block: The block.
        until: The time asked for [s]; after the end of the step, that counts.
        time, begun: End and start of the step [s].
        at: Rotation at that time [rad].
        slide, gap: Of the lower corner at the end of the step [m].
        theta0: State at its start; so all up to omega0.

    Returns:
        x and z.
    """
    inside = until < time
    d = time - begun
    tau = wp.where(inside, until - begun, d)
    part = wp.where(inside and d > real(0.0), tau / d, real(1.0))
    side0 = sign_of(wp.where(theta0 != real(0.0), theta0, omega0))
    x0, z0 = lower_corner(block, sine(side0 * theta0), cosine(theta0))
    glide = vx0 + omega0 * z0
    rise = vz0 - side0 * omega0 * x0
    bend = part * part
    slid = slide0 + tau * glide + bend * (slide - slide0 - d * glide)
    high = gap0 + tau * rise + bend * (gap - gap0 - d * rise)
    side = sign_of(at)
    x1, z1 = lower_corner(block, sine(side * at), cosine(at))
    return slid + side * (block.half_width - x1), high - z1


@wp.func
def pivoting(block: Block, theta: real, omega: real):
    """Velocity of the centre of a block that turns about its lower corner [m/s]."""
    side = sign_of(wp.where(theta != real(0.0), theta, omega))
    x, z = lower_corner(block, sine(side * theta), cosine(theta))
    # Zero is added so that no number is -0.
    return -omega * z + real(0.0), side * omega * x + real(0.0)


@wp.struct
class BlockResult:
    """What the run of one block leaves behind."""

    slide: real
    peak: real
    peak_time: real
    peak_slide: real


@wp.struct
class Result:
    """What one lane's run leaves behind."""

    uplift_time: real
    rest_time: real
    loss: real
    deepest: real
    impacts: int
    mode: int
    steps: int


@wp.struct
class Found:
    """Where the answers go."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
    places: wp.array4d(dtype=real)


Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)


PATIENCE = 5
"""Half rounds without events that lanes may lose, over the lanes that still run, until all that
wait take a step with events: what such a step costs."""


@wp.func
def start_lane(
    start: real, rate: real, block: Block, theta: wp.ref[real], vx: wp.ref[real], vz: wp.ref[real],
    omega: wp.ref[real], mode: wp.ref[int], cap: wp.ref[real], peak: wp.ref[real],
    uplift_time: wp.ref[real], rest_time: wp.ref[real],
):  # fmt: skip
    """Lets a block go at a rotation [rad] with a rate [rad/s]."""
    flat = start == real(0.0) and rate == real(0.0)
    along, up = pivoting(block, start, rate)
    theta = start
    omega = rate
    vx = along
    vz = up
    mode = wp.where(flat, FLAT, PIVOTING)
    cap = NEVER
    peak = size(start)
    uplift_time = wp.where(flat, NEVER, real(0.0))
    rest_time = wp.where(flat, real(0.0), NEVER)


@wp.func
def move_on(
    time1: real, theta1: real, omega1: real, slid: real, lost: real, apex: real, apex_time: real,
    time: wp.ref[real], theta: wp.ref[real], omega: wp.ref[real], peak: wp.ref[real],
    peak_time: wp.ref[real], slide: wp.ref[real], peak_slide: wp.ref[real], loss: wp.ref[real],
):  # fmt: skip
    """What a step without events adds to the response of one lane: see `observe`."""
    highest = larger(size(theta1), apex)
    peak_time = wp.where(highest > peak, wp.where(apex >= highest, apex_time, time1), peak_time)
    peak = larger(highest, peak)
    time = time1
    theta = theta1
    omega = omega1
    slide = slide + slid
    peak_slide = larger(size(slide), peak_slide)
    loss = loss + lost


@wp.func
def waits(mode: int, slip: real, cap: real) -> int:
    """1 where a lane's next step may have events: it slides on a corner, flies or is tried anew."""
    drags = mode == PIVOTING and slip != real(0.0)
    return wp.where(drags or mode == FLYING or cap < NEVER, 1, 0)


@wp.kernel
def run_lanes(
    blocks: wp.array(dtype=Block), motions: wp.array(dtype=Motion), pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=real), rates: wp.array(dtype=real), sample_times: wp.array(dtype=real),
    knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, which take their steps side by side."""
    pack, _one = wp.tid()
    first = pack * LANES
    block_of = wp.array(ptr=blocks.ptr, shape=(blocks.shape[0],), dtype=Block)
    motion_of = wp.array(ptr=motions.ptr, shape=(motions.shape[0],), dtype=Motion)
    # By names of their own: read off the struct they would keep the loop over lanes scalar.
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    places = found.places
    theta, slide, gap, vx, vz, omega, slip = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    time, base, cap, begun, theta0, omega0 = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    slide0, gap0, vx0, vz0, c2, c3, c4 = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    c5, c6, peak, peak_time, peak_slide = Lane(), Lane(), Lane(), Lane(), Lane()
    deepest, uplift_time, rest_time, loss = Lane(), Lane(), Lane(), Lane()
    segment, mode, impacts, steps, due = LaneInt(), LaneInt(), LaneInt(), LaneInt(), LaneInt()
    for i in range(LANES):
        start_lane(starts[first + i], rates[first + i], block_of[first + i], theta[i], vx[i], vz[i],
            omega[i], mode[i], cap[i], peak[i], uplift_time[i], rest_time[i])  # fmt: skip
    end = sample_times[sample_times.shape[0] - 1]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        busy, lost_rounds = int(1), int(0)
        while busy > 0:
            if places.shape[0] > 0:
                for i in range(LANES):
                    live = mode[i] < OVERTURNED and time[i] < until
                    remember_place(live, slide[i], gap[i], vx[i], vz[i],
                        slide0[i], gap0[i], vx0[i], vz0[i])  # fmt: skip
            busy, waiting, resting = int(0), int(0), int(0)
            for i in range(LANES):
                goes = wp.where(mode[i] < OVERTURNED and time[i] < until, 1, 0)
                lies = wp.where(mode[i] == FLAT and slip[i] == real(0.0), 1, 0)
                busy = busy + goes
                waiting = waiting + goes * due[i]
                resting = resting + goes * due[i] * lies
            patient = waiting < busy and 2 * (lost_rounds + waiting) < PATIENCE * busy
            lost_rounds = wp.where(patient, lost_rounds + waiting, 0)
            if patient:
                for i in range(LANES):
                    m = motion_of[first + i]
                    place = sample_index(m, segment[i])
                    limit = block_of[first + i].step_limit
                    going = mode[i] < OVERTURNED and time[i] < until and due[i] == 0
                    th, om, ux, uz, ti, se, ba, sl, lo, ap, at, ok, k2, k3, k4, k5, k6 = roll(
                        block_of[first + i], knobs, m, pool[0, place], pool[1, place],
                        pool[3, place], end, going, theta[i], vx[i], vz[i], omega[i], slip[i],
                        mode[i], time[i], segment[i], base[i])  # fmt: skip
                    remember(ok, time[i], theta[i], omega[i], k2, k3, k4, k5, k6, begun[i],
                        theta0[i], omega0[i], c2[i], c3[i], c4[i], c5[i], c6[i])  # fmt: skip
                    move_on(ti, th, om, sl, lo, ap, at, time[i], theta[i], omega[i], peak[i],
                        peak_time[i], slide[i], peak_slide[i], loss[i])  # fmt: skip
                    vx[i] = ux
                    vz[i] = uz
                    segment[i] = se
                    base[i] = ba
                    steps[i] = steps[i] + wp.where(ok, 1, 0)
                    due[i] = wp.where(going and not ok, 1, due[i])
                    mode[i] = wp.where(ok and steps[i] >= limit, STALLED, mode[i])
            if resting > 0 and not patient:
                for i in range(LANES):
                    m = motion_of[first + i]
                    place = sample_index(m, segment[i])
                    most = look_ahead(block_of[first + i], m, pool[0, place], pool[1, place], end,
                        time[i], segment[i])  # fmt: skip
                    rests = mode[i] == FLAT and slip[i] == real(0.0)
                    cap[i] = wp.where(rests and due[i] == 1, smaller(most, cap[i]), cap[i])
            if waiting > 0 and not patient:
                for i in range(LANES):
                    m = motion_of[first + i]
                    place = sample_index(m, segment[i])
                    limit = block_of[first + i].step_limit
                    going = mode[i] < OVERTURNED and time[i] < until and due[i] == 1
                    (
                        th, sl, ga, ux, uz, om, di, mo, ti, se, ba, ca, ap, at, lo, ta, hit, ok, dp,
                        k2, k3, k4, k5, k6,
                    ) = step(
                        block_of[first + i], knobs, m, pool[0, place], pool[1, place], end, going,
                        theta[i], slide[i], gap[i], vx[i], vz[i], omega[i], slip[i], mode[i],
                        time[i], segment[i], base[i], cap[i])  # fmt: skip
                    remember(ok, time[i], theta[i], omega[i], k2, k3, k4, k5, k6, begun[i],
                        theta0[i], omega0[i], c2[i], c3[i], c4[i], c5[i], c6[i])  # fmt: skip
                    mo = observe(
                        going, limit, mode[i], slip[i], time[i], mo, di, ti, th, sl, ap, at, ta, lo,
                        dp, hit, peak[i], peak_time[i], peak_slide[i], uplift_time[i], rest_time[i],
                        loss[i], deepest[i], impacts[i], steps[i])  # fmt: skip
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
                    due[i] = wp.where(going, waits(mo, di, ca), due[i])
        if rotations.shape[0] > 0:
            for i in range(LANES):
                rotations[sample, 0, first + i] = rotation_at(until, time[i], theta[i], begun[i],
                    theta0[i], omega0[i], c2[i], c3[i], c4[i], c5[i], c6[i])  # fmt: skip
        if places.shape[0] > 0:
            for i in range(LANES):
                at = rotation_at(until, time[i], theta[i], begun[i],
                    theta0[i], omega0[i], c2[i], c3[i], c4[i], c5[i], c6[i])  # fmt: skip
                spot, level = place_at(block_of[first + i], until, time[i], begun[i], at, slide[i],
                    gap[i], theta0[i], slide0[i], gap0[i], vx0[i], vz0[i], omega0[i])  # fmt: skip
                places[sample, 0, 0, first + i] = spot
                places[sample, 0, 1, first + i] = level
    for i in range(LANES):
        results[first + i] = Result(uplift_time[i], rest_time[i], loss[i], deepest[i], impacts[i],
            mode[i], steps[i])  # fmt: skip
        leaves[0, first + i] = BlockResult(slide[i], peak[i], peak_time[i], peak_slide[i])
