"""Runs of the Housner step over lanes: packed for the CPU, plain for any device."""

import warp as wp

from warprock.kernels.housner.block import Block, step
from warprock.kernels.instance import LANE_WIDTH
from warprock.kernels.modes import OVERTURNED, RESTING, ROCKING, STALLED
from warprock.kernels.motion import Motion, sample_index


@wp.struct
class Result:
    """What one lane's run leaves behind."""

    theta: real
    time: real
    peak: real
    peak_time: real
    uplift_time: real
    rest_time: real
    loss: real
    needed: real
    impacts: int
    mode: int
    steps: int


Lane = wp.types.vector(length=LANE_WIDTH, dtype=real)
LaneInt = wp.types.vector(length=LANE_WIDTH, dtype=int)


@wp.kernel
def packed(
    blocks: wp.array(dtype=Block),
    motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=real),
    sample_times: wp.array(dtype=real),
    results: wp.array(dtype=Result),
    rotations: wp.array2d(dtype=real),
):
    """Runs packs of LANE_WIDTH lanes, all lanes of a pack in step with each other."""
    first = wp.tid() * LANE_WIDTH
    theta = Lane()
    omega = Lane()
    side = Lane()
    time = Lane()
    segment = LaneInt()
    mode = LaneInt()
    peak = Lane()
    peak_time = Lane()
    uplift_time = Lane()
    rest_time = Lane()
    loss = Lane()
    impacts = LaneInt()
    cap = Lane()
    needed = Lane()
    steps = LaneInt()
    for i in range(LANE_WIDTH):
        theta[i] = starts[first + i]
        side[i] = sign_of(theta[i])
        mode[i] = wp.where(theta[i] == real(0.0), RESTING, ROCKING)
        peak[i] = size(theta[i])
        cap[i] = NEVER
        uplift_time[i] = wp.where(theta[i] == real(0.0), NEVER, real(0.0))
        rest_time[i] = wp.where(theta[i] == real(0.0), real(0.0), NEVER)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        busy = int(1)
        while busy > 0:
            busy = int(0)
            for i in range(LANE_WIDTH):
                m = motions[first + i]
                place = sample_index(m, segment[i])
                going = mode[i] < OVERTURNED and time[i] < until
                steps[i] = steps[i] + wp.where(going, 1, 0)
                th, om, si, ti, se, mo, pk, pt, ut, rt, lo, im, ca, ne = step(
                    blocks[first + i], m, pool[0, place], pool[1, place], until,
                    theta[i], omega[i], side[i], time[i], segment[i], mode[i],
                    peak[i], peak_time[i], uplift_time[i], rest_time[i], loss[i], impacts[i],
                    cap[i], needed[i],
                )  # fmt: skip
                # A lane that waits for others takes no step, not even one of length zero.
                theta[i] = wp.where(going, th, theta[i])
                omega[i] = wp.where(going, om, omega[i])
                side[i] = wp.where(going, si, side[i])
                time[i] = wp.where(going, ti, time[i])
                segment[i] = wp.where(going, se, segment[i])
                mo = wp.where(
                    steps[i] >= blocks[first + i].step_limit and mo < OVERTURNED, STALLED, mo
                )
                mode[i] = wp.where(going, mo, mode[i])
                peak[i] = wp.where(going, pk, peak[i])
                peak_time[i] = wp.where(going, pt, peak_time[i])
                uplift_time[i] = wp.where(going, ut, uplift_time[i])
                rest_time[i] = wp.where(going, rt, rest_time[i])
                loss[i] = wp.where(going, lo, loss[i])
                impacts[i] = wp.where(going, im, impacts[i])
                cap[i] = wp.where(going, ca, cap[i])
                needed[i] = wp.where(going, ne, needed[i])
            for i in range(LANE_WIDTH):
                busy = busy + wp.where(mode[i] < OVERTURNED and time[i] < until, 1, 0)
        if rotations.shape[0] > 0:
            for i in range(LANE_WIDTH):
                rotations[sample, first + i] = theta[i]
    for i in range(LANE_WIDTH):
        result = Result()
        result.theta = theta[i]
        result.time = time[i]
        result.peak = peak[i]
        result.peak_time = peak_time[i]
        result.uplift_time = uplift_time[i]
        result.rest_time = rest_time[i]
        result.loss = loss[i]
        result.needed = needed[i]
        result.impacts = impacts[i]
        result.mode = mode[i]
        result.steps = steps[i]
        results[first + i] = result


@wp.kernel
def plain(
    blocks: wp.array(dtype=Block),
    motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=real),
    sample_times: wp.array(dtype=real),
    results: wp.array(dtype=Result),
    rotations: wp.array2d(dtype=real),
):
    """Runs one lane a thread, on any device."""
    lane = wp.tid()
    block = blocks[lane]
    m = motions[lane]
    theta = starts[lane]
    flat = theta == real(0.0)
    omega = real(0.0)
    side = sign_of(theta)
    time = real(0.0)
    segment = int(0)
    mode = int(wp.where(flat, RESTING, ROCKING))
    peak = size(theta)
    peak_time = real(0.0)
    uplift_time = real(wp.where(flat, NEVER, real(0.0)))
    rest_time = real(wp.where(flat, real(0.0), NEVER))
    loss = real(0.0)
    impacts = int(0)
    cap = NEVER
    needed = real(0.0)
    steps = int(0)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while mode < OVERTURNED and time < until:
            steps += 1
            place = sample_index(m, segment)
            th, om, si, ti, se, mo, pk, pt, ut, rt, lo, im, ca, ne = step(
                block, m, pool[0, place], pool[1, place], until,
                theta, omega, side, time, segment, mode,
                peak, peak_time, uplift_time, rest_time, loss, impacts, cap, needed,
            )  # fmt: skip
            theta = th
            omega = om
            side = si
            time = ti
            segment = se
            mode = wp.where(steps >= block.step_limit and mo < OVERTURNED, STALLED, mo)
            peak = pk
            peak_time = pt
            uplift_time = ut
            rest_time = rt
            loss = lo
            impacts = im
            cap = ca
            needed = ne
        if rotations.shape[0] > 0:
            rotations[sample, lane] = theta
    result = Result()
    result.theta = theta
    result.time = time
    result.peak = peak
    result.peak_time = peak_time
    result.uplift_time = uplift_time
    result.rest_time = rest_time
    result.loss = loss
    result.needed = needed
    result.impacts = impacts
    result.mode = mode
    result.steps = steps
    results[lane] = result
