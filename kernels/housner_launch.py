"""Runs of the Housner step over lanes: packed for the CPU, plain for any device."""

from typing import Any

import warp as wp

from warprock.kernels.instance import LANE_WIDTH, kernel_module, module_options

real: Any
PRECISION: str
MOTION: str

wp.set_module_options(module_options())
scalar = kernel_module("scalar", precision=PRECISION)
motion = kernel_module("motion", precision=PRECISION, motion=MOTION)
housner = kernel_module("housner", precision=PRECISION, motion=MOTION)
sign_of, size = scalar.sign_of, scalar.size
Motion, sample_index = motion.Motion, motion.sample_index
Block, step = housner.Block, housner.step

RESTING = 0
ROCKING = 1
OVERTURNED = 2
STALLED = 4
NEVER = real(1.0e30)


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
    steps = LaneInt()
    for l in range(LANE_WIDTH):
        theta[l] = starts[first + l]
        side[l] = sign_of(theta[l])
        mode[l] = wp.where(theta[l] == real(0.0), RESTING, ROCKING)
        peak[l] = size(theta[l])
        cap[l] = NEVER
        uplift_time[l] = wp.where(theta[l] == real(0.0), NEVER, real(0.0))
        rest_time[l] = wp.where(theta[l] == real(0.0), real(0.0), NEVER)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        busy = int(1)
        while busy > 0:
            busy = int(0)
            for l in range(LANE_WIDTH):
                m = motions[first + l]
                place = sample_index(m, segment[l])
                going = mode[l] < OVERTURNED and time[l] < until
                steps[l] = steps[l] + wp.where(going, 1, 0)
                th, om, si, ti, se, mo, pk, pt, ut, rt, lo, im, ca = step(
                    blocks[first + l], m, pool[0, place], pool[1, place], until,
                    theta[l], omega[l], side[l], time[l], segment[l], mode[l],
                    peak[l], peak_time[l], uplift_time[l], rest_time[l], loss[l], impacts[l], cap[l],
                )  # fmt: skip
                theta[l] = th
                omega[l] = om
                side[l] = si
                time[l] = ti
                segment[l] = se
                mode[l] = wp.where(
                    steps[l] >= blocks[first + l].step_limit and mo < OVERTURNED, STALLED, mo
                )
                peak[l] = pk
                peak_time[l] = pt
                uplift_time[l] = ut
                rest_time[l] = rt
                loss[l] = lo
                impacts[l] = im
                cap[l] = ca
            for l in range(LANE_WIDTH):
                busy = busy + wp.where(mode[l] < OVERTURNED and time[l] < until, 1, 0)
        if rotations.shape[0] > 0:
            for l in range(LANE_WIDTH):
                rotations[sample, first + l] = theta[l]
    for l in range(LANE_WIDTH):
        result = Result()
        result.theta = theta[l]
        result.time = time[l]
        result.peak = peak[l]
        result.peak_time = peak_time[l]
        result.uplift_time = uplift_time[l]
        result.rest_time = rest_time[l]
        result.loss = loss[l]
        result.impacts = impacts[l]
        result.mode = mode[l]
        result.steps = steps[l]
        results[first + l] = result


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
    cap = real(NEVER)
    steps = int(0)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while mode < OVERTURNED and time < until:
            steps += 1
            place = sample_index(m, segment)
            th, om, si, ti, se, mo, pk, pt, ut, rt, lo, im, ca = step(
                block, m, pool[0, place], pool[1, place], until,
                theta, omega, side, time, segment, mode,
                peak, peak_time, uplift_time, rest_time, loss, impacts, cap,
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
    result.impacts = impacts
    result.mode = mode
    result.steps = steps
    results[lane] = result
