"""Runs of two_block/stack.py, one lane a thread on any device.

A step evaluates its own series at the samples inside it, so that histories do not change the run.
"""

import warp as wp

from warprock.kernels.lane.modes import RUNNING, STALLED
from warprock.kernels.launch.instance import BRANCHES
from warprock.kernels.motion.kinds import Motion, expand, ground_at, knot_step, knot_time
from warprock.kernels.motion.series import Series, value_of
from warprock.kernels.two_block.stack import check_state, reopen_contacts, start_lane, step, strike
from warprock.kernels.two_block.stack_mechanics import Block, Lane, Stack
from warprock.kernels.two_block.stack_series import motion_series

FLAGS = f"{BRANCHES['cpu_compiler_flags']} -fno-slp-vectorize"
"""Without this flag the compiler packs two sums of a dependent chain into one vector. They then
wait for one another, and a step takes a fifth longer."""
wp.set_module_options(BRANCHES | {"cpu_compiler_flags": FLAGS})

LANES = 1
"""Lanes that a thread runs."""


@wp.struct
class Knobs:
    """Settings that all lanes share: the length of the run [s]."""

    duration: real


@wp.struct
class BlockResult:
    """Results of one block."""

    peak: real
    peak_time: real


@wp.struct
class Result:
    """Results of one lane."""

    uplift_time: real
    rest_time: real
    loss: real
    impacts: int
    outside: int
    resting: int
    mode: int
    steps: int


@wp.struct
class Found:
    """Arrays of results."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)


@wp.func
def base_series(m: Motion, segment: int, time: real, sample: real, slope: real) -> Series:
    """Taylor coefficients of the acceleration of the base."""
    a, zero = expand(m, segment, time, sample, slope), real(0.0)
    return Series(a.a0, a.a1, a.a2, a.a3, a.a4, a.a5, a.a6, a.a7, a.a8, zero, zero)


LOWER, UPPER = 0, 1
"""Numbers of the blocks."""


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block),
    lanes: wp.array(dtype=Lane),
    motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real),
    knobs: Knobs,
    found: Found,
):
    """Runs one lane a thread."""
    lane = wp.tid()
    m = motions[lane]
    stack = Stack(blocks[LOWER, lane], blocks[UPPER, lane], lanes[lane])
    s = start_lane(stack)
    s = check_state(stack, s, real(0.0))
    samples = wp.where(found.rotations.shape[0] > 0, sample_times.shape[0], 0)
    sample = int(0)
    steps = int(0)
    while s.mode == RUNNING and s.time < knobs.duration:
        knot = knot_time(m, s.segment)
        if s.time >= knot:
            dv = knot_step(m, s.segment)
            s.segment = s.segment + 1
            s.regrip = 1
            if dv != real(0.0):
                ground = ground_at(m, s.segment, pool)
                a = base_series(m, s.segment, s.time, ground.value, ground.slope)
                flat = s.ground == real(0.0)
                glued = s.interface == real(0.0)
                s = strike(stack, s, flat, glued, dv, a[0])
        else:
            ground = ground_at(m, s.segment, pool)
            a = base_series(m, s.segment, s.time, ground.value, ground.slope)
            if s.regrip == 1:
                s = reopen_contacts(stack, s, a[0])
            x1, x2 = motion_series(stack, s.ground, s.interface, s.rotation, s.rate, a)
            begin = s.time
            s = step(stack, s, a, smaller(knot, knobs.duration), x1, x2)
            while sample < samples and sample_times[sample] <= s.time:
                tau = sample_times[sample] - begin
                found.rotations[sample, LOWER, lane] = value_of(x1, tau)
                found.rotations[sample, UPPER, lane] = value_of(x2, tau)
                sample += 1
            steps += 1
            if steps >= stack.lane.step_limit and s.mode == RUNNING:
                s.mode = STALLED
    while sample < samples:
        found.rotations[sample, LOWER, lane] = s.rotation[0]
        found.rotations[sample, UPPER, lane] = s.rotation[1]
        sample += 1
    for k in range(2):
        block = BlockResult()
        block.peak = s.peak[k]
        block.peak_time = s.peak_time[k]
        found.blocks[k, lane] = block
    result = Result()
    result.uplift_time = s.uplift_time
    result.rest_time = s.rest_time
    result.loss = s.loss
    result.impacts = s.impacts
    result.outside = s.outside
    result.resting = wp.where(s.ground == real(0.0) and s.interface == real(0.0), 1, 0)
    result.mode = s.mode
    result.steps = steps
    found.results[lane] = result
