"""Observed response of a lane in the plane and results of its run, of all stepped engines."""

import warp as wp

from warprock.kernels.lane.account import Account
from warprock.kernels.lane.modes import RUNNING


@wp.struct
class BlockResult:
    """Results of one block."""

    slide: real
    peak: real
    peak_time: real
    peak_slide: real


@wp.struct
class Result:
    """Results of one lane."""

    uplift_time: real
    moved: real
    loss: real
    jolt: real
    supplied: real
    returned: real
    deepest: real
    impacts: int
    mode: int
    steps: int


@wp.struct
class Found:
    """Arrays of results.

    Attributes:
        results: Results of every lane, shape [lane].
        blocks: Results of every block, shape [block, lane].
        rotations: At the samples [rad], shape [sample, block, lane]; empty if not asked for.
        places: Centres x and z at the samples [m], shape [sample, block, 2, lane]; likewise.
    """

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
    places: wp.array4d(dtype=real)


@wp.struct
class Seen:
    """Observed response of a lane up to its time.

    Attributes:
        uplift_time: Time of the first uplift [s]; 0 if a block leans at the start, NEVER before.
        moved: Time of the last motion [s].
        deepest: Deepest penetration so far [m].
        impacts: Impacts so far.
        mode: How the lane stands, see modes.py.
        steps: Steps so far.
    """

    uplift_time: real
    moved: real
    deepest: real
    impacts: int
    mode: int
    steps: int


@wp.struct
class Peaks:
    """Largest |rotation| of a block so far [rad], its time [s], and the largest |slide| [m]."""

    rotation: real
    time: real
    slide: real


@wp.func
def start_seen(uplift_time: real) -> Seen:
    """Observed response of a lane before its first step."""
    zero = real(0.0)
    return Seen(uplift_time, zero, zero, 0, RUNNING, 0)


@wp.func
def observe_lane(live: bool, mode: int, depth: real, seen: wp.ref[Seen]):
    """Updates steps, penetration and mode of a lane after a step, if it still runs.

    Args:
        live: Whether it still runs.
        mode: Its mode after the step.
        depth: Deepest penetration in the step [m]; a gap counts as negative.
        seen: Observed response of the lane.
    """
    seen.deepest = wp.where(live, larger(depth, seen.deepest), seen.deepest)
    seen.steps += wp.where(live, 1, 0)
    seen.mode = wp.where(live, mode, seen.mode)


@wp.func
def start_peaks(theta: real) -> Peaks:
    """Peaks of a block at its start, from its rotation [rad]."""
    return Peaks(size(theta), real(0.0), real(0.0))


@wp.func
def observe_peaks(live: bool, time: real, theta: real, slide: real, peaks: Peaks) -> Peaks:
    """Peaks of a block after a step that ends at a time [s], if its lane still runs.

    Args:
        live: Whether it does.
        time: End of the step [s].
        theta: Rotation then [rad].
        slide: Slide then [m].
        peaks: Peaks before.
    """
    higher = live and size(theta) > peaks.rotation
    return Peaks(
        wp.where(higher, smaller(size(theta), HALF_PI), peaks.rotation),
        wp.where(higher, time, peaks.time),
        wp.where(live, larger(size(slide), peaks.slide), peaks.slide),
    )


@wp.func
def result_of(seen: Seen, account: Account) -> Result:
    """The results of a lane."""
    return Result(
        seen.uplift_time, seen.moved, account.loss, account.jolt, account.supplied,
        account.returned, seen.deepest, seen.impacts, seen.mode, seen.steps,
    )  # fmt: skip


@wp.func
def block_result(slide: real, peaks: Peaks) -> BlockResult:
    """The results of a block, from its slide at the end [m]."""
    return BlockResult(slide, peaks.rotation, peaks.time, peaks.slide)


@wp.func
def at_sample(mode: int, past: real, value: real, rate: real) -> real:
    """A coordinate at a sample, from the value a time `past` [s] later; once ended, the last one.

    The velocities of a lane that has ended may change and need not be finite.
    """
    back = larger(past, real(0.0)) * rate
    return value - wp.where(mode == RUNNING, back, real(0.0))
