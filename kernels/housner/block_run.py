"""Runs of the Housner step over lanes, LANES lanes a thread: a pack on the CPU, one on any device.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.housner.block import Block, step
from warprock.kernels.modes import OVERTURNED, RESTING, ROCKING, STALLED
from warprock.kernels.motion import Motion, sample_index


@wp.struct
class BlockResult:
    """What the run of one block leaves behind."""

    peak: real
    peak_time: real


@wp.struct
class Result:
    """What one lane's run leaves behind."""

    uplift_time: real
    rest_time: real
    loss: real
    needed: real
    impacts: int
    mode: int
    steps: int


@wp.struct
class Found:
    """Where the answers go."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)


Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)


@wp.kernel
def run_lanes(
    blocks: wp.array(dtype=Block),
    motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=real),
    rates: wp.array(dtype=real),
    sample_times: wp.array(dtype=real),
    found: Found,
):
    """Runs LANES lanes a thread, which take their steps side by side."""
    pack, _one = wp.tid()
    first = pack * LANES
    block_of = wp.array(ptr=blocks.ptr, shape=(blocks.shape[0],), dtype=Block)
    motion_of = wp.array(ptr=motions.ptr, shape=(motions.shape[0],), dtype=Motion)
    # By names of their own: read off the struct they would keep the loop over lanes scalar.
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
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
    for i in range(LANES):
        theta[i] = starts[first + i]
        omega[i] = rates[first + i]
        side[i] = sign_of(wp.where(theta[i] == real(0.0), omega[i], theta[i]))
        rests = theta[i] == real(0.0) and omega[i] == real(0.0)
        mode[i] = wp.where(rests, RESTING, ROCKING)
        peak[i] = size(theta[i])
        cap[i] = NEVER
        uplift_time[i] = wp.where(rests, NEVER, real(0.0))
        rest_time[i] = wp.where(rests, real(0.0), NEVER)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        busy = int(1)
        while busy > 0:
            busy = int(0)
            for i in range(LANES):
                m = motion_of[first + i]
                place = sample_index(m, segment[i])
                going = mode[i] < OVERTURNED and time[i] < until
                steps[i] = steps[i] + wp.where(going, 1, 0)
                th, om, si, ti, se, mo, pk, pt, ut, rt, lo, im, ca, ne = step(
                    block_of[first + i], m, pool[0, place], pool[1, place], until,
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
                    steps[i] >= block_of[first + i].step_limit and mo < OVERTURNED, STALLED, mo
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
            for i in range(LANES):
                busy = busy + wp.where(mode[i] < OVERTURNED and time[i] < until, 1, 0)
        if rotations.shape[0] > 0:
            for i in range(LANES):
                rotations[sample, 0, first + i] = theta[i]
    for i in range(LANES):
        results[first + i] = Result(
            uplift_time[i], rest_time[i], loss[i], needed[i], impacts[i], mode[i], steps[i]
        )
        leaves[0, first + i] = BlockResult(peak[i], peak_time[i])
