"""Runs of the event step over lanes, LANES lanes a thread: a pack on the CPU, one on any device.

Every lane has its own clock and ends its steps where its events are; a sample inside a step is
read off the parabola that the step follows, so that histories do not change the run.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.event.block import Knobs, step
from warprock.kernels.event.block_contact import Block, lower_corner
from warprock.kernels.modes import FLAT, OVERTURNED, PIVOTING, STALLED
from warprock.kernels.motion import Motion, sample_index


@wp.func
def observe(
    limited: bool, mode0: int, slip0: real, time0: real, mode: int, slip: real, time: real,
    theta: real, slide: real, apex: real, apex_time: real, tail: real,
    peak: real, peak_time: real, peak_slide: real, uplift_time: real, rest_time: real,
):  # fmt: skip
    """What a step adds to the response of one lane; with 0 the state before it.

    Args:
        limited: Whether the lane has used up its steps.
        mode, mode0: Contact of the block.
        slip, slip0: Direction in which it slides, 0 where it does not.
        time, time0: Time [s].
        theta: Rotation [rad].
        slide: Slide along the base [m].
        apex: Turning point of |theta| inside the step [rad], zero where there was none.
        apex_time: Its time [s].
        tail: Time of the impacts that resting leaves out [s].
        peak, peak_time: Largest |theta| so far [rad] and its time [s].
        peak_slide: Largest |slide| so far [m].
        uplift_time: Time at which the block first left its flat state [s].
        rest_time: Time since when it rests [s].

    Returns:
        mode, peak, peak_time, peak_slide, uplift_time, rest_time.
    """
    zero = real(0.0)
    highest = larger(size(theta), apex)
    lifts = mode0 == FLAT and mode < FLAT and uplift_time >= NEVER
    # A velocity step of the base lifts at the end of a step, an acceleration from its start.
    lifted = wp.where(theta == zero, time, time0)
    rested = mode0 == FLAT and slip0 == zero
    rests = mode == FLAT and slip == zero
    return (
        wp.where(limited and mode < OVERTURNED, STALLED, mode),
        larger(highest, peak),
        wp.where(highest > peak, wp.where(apex >= highest, apex_time, time), peak_time),
        larger(size(slide), peak_slide),
        wp.where(lifts, lifted, uplift_time),
        wp.where(rests, wp.where(rested, rest_time, time + tail), NEVER),
    )


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
    block: Block, part: real, tau: real, d: real, at: real, slide: real, gap: real,
    theta0: real, slide0: real, gap0: real, vx0: real, vz0: real, omega0: real,
):  # fmt: skip
    """Centre of mass inside the last step [m], from the slide and the gap of the lower corner.

    Args:
        block: The block.
        part: Part of the step that has passed.
        tau: Time since it began [s].
        d: Its length [s].
        at: Rotation at that time [rad].
        slide, gap: Of the lower corner at the end of the step [m].
        theta0: State at its start; so all up to omega0.

    Returns:
        x and z.
    """
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


@wp.kernel
def run_lanes(
    blocks: wp.array(dtype=Block), motions: wp.array(dtype=Motion), pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=real), rates: wp.array(dtype=real), sample_times: wp.array(dtype=real),
    knobs: Knobs, found: Found,
):  # fmt: skip
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
    for i in range(LANES):
        flat = starts[first + i] == real(0.0) and rates[first + i] == real(0.0)
        theta[i] = starts[first + i]
        omega[i] = rates[first + i]
        along, up = pivoting(blocks[first + i], theta[i], omega[i])
        vx[i] = along
        vz[i] = up
        mode[i] = wp.where(flat, FLAT, PIVOTING)
        cap[i] = NEVER
        peak[i] = size(starts[first + i])
        uplift_time[i] = wp.where(flat, NEVER, real(0.0))
        rest_time[i] = wp.where(flat, real(0.0), NEVER)
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
                th, sl, ga, ux, uz, om, di, mo, ti, se, ba, ca, ap, at, lo, ta, hit, ok, dp = step(
                    blocks[first + i], knobs, m, pool[0, place], pool[1, place], end, going,
                    theta[i], slide[i], gap[i], vx[i], vz[i], omega[i], slip[i], mode[i],
                    time[i], segment[i], base[i], cap[i],
                )  # fmt: skip
                begun[i] = wp.where(ok, time[i], begun[i])
                theta0[i] = wp.where(ok, theta[i], theta0[i])
                omega0[i] = wp.where(ok, omega[i], omega0[i])
                mo, pk, pt, ps, ut, rt = observe(
                    going and spent, mode[i], slip[i], time[i], mo, di, ti, th, sl, ap, at, ta,
                    peak[i], peak_time[i], peak_slide[i], uplift_time[i], rest_time[i],
                )  # fmt: skip
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
                    blocks[first + i], part, tau, d, at, slide[i], gap[i], theta0[i], slide0[i],
                    gap0[i], vx0[i], vz0[i], omega0[i],
                )  # fmt: skip
                places[sample, 0, 0, first + i] = spot
                places[sample, 0, 1, first + i] = level
    for i in range(LANES):
        results[first + i] = Result(
            uplift_time[i], rest_time[i], loss[i], deepest[i], impacts[i], mode[i], steps[i]
        )
        leaves[0, first + i] = BlockResult(slide[i], peak[i], peak_time[i], peak_slide[i])
