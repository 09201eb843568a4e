"""What is seen of a lane in the plane, and what its run leaves behind: of all stepped engines."""

import warp as wp

from warprock.kernels.account import Account
from warprock.kernels.modes import RUNNING


@wp.struct
class BlockResult:
    """What one block's run leaves behind."""

    slide: real
    peak: real
    peak_time: real
    peak_slide: real


@wp.struct
class Result:
    """What one lane's run leaves behind."""

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
    """Where the kernel leaves what it finds.

    Attributes:
        results: Of every lane, shape [lane].
        blocks: Of every block, shape [block, lane].
        rotations: At the samples [rad], shape [sample, block, lane]; empty if not asked for.
        places: Centres x and z at the samples [m], shape [sample, block, 2, lane]; likewise.
    """

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
    places: wp.array4d(dtype=real)


@wp.struct
class Seen:
    """What is seen of a lane.

    Attributes:
        uplift_time: When a block first lifted [s]; 0 if one leans at the start, NEVER before.
        moved: When a block last moved [s].
        deepest: Deepest penetration so far [m].
        impacts: Impacts so far.
        mode: How the lane goes on, see modes.py.
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
    """What is seen of a lane before its first step."""
    zero = real(0.0)
    return Seen(uplift_time, zero, zero, 0, RUNNING, 0)


@wp.func
def observe_lane(live: bool, mode: int, depth: real, seen: wp.ref[Seen]):
    """Counts a step of a lane, if it still runs, and how deep it was and how the lane goes on.

    Args:
        live: Whether it still runs.
        mode: How it goes on.
        depth: Deepest penetration in the step [m], negative of a gap.
        seen: What is seen of the lane.
    """
    seen.deepest = wp.where(live, larger(depth, seen.deepest), seen.deepest)
    seen.steps += wp.where(live, 1, 0)
    seen.mode = wp.where(live, mode, seen.mode)


@wp.func
def start_peaks(theta: real) -> Peaks:
    """Those of a block that starts at a rotation [rad]."""
    return Peaks(size(theta), real(0.0), real(0.0))


@wp.func
def observe_peaks(live: bool, time: real, theta: real, slide: real, peaks: Peaks) -> Peaks:
    """Those of a block after a step that ends at a time [s], if its lane still runs.

    Args:
        live: Whether it does.
        time: End of the step [s].
        theta: Rotation then [rad].
        slide: Slide then [m].
        peaks: Those before.
    """
    higher = live and size(theta) > peaks.rotation
    return Peaks(
        wp.where(higher, smaller(size(theta), HALF_PI), peaks.rotation),
        wp.where(higher, time, peaks.time),
        wp.where(live, larger(size(slide), peaks.slide), peaks.slide),
    )


@wp.func
def result_of(seen: Seen, account: Account) -> Result:
    """What a lane leaves behind."""
    return Result(
        seen.uplift_time, seen.moved, account.loss, account.jolt, account.supplied,
        account.returned, seen.deepest, seen.impacts, seen.mode, seen.steps,
    )  # fmt: skip


@wp.func
def block_result(slide: real, peaks: Peaks) -> BlockResult:
    """What a block leaves behind that has slid by so much at the end [m]."""
    return BlockResult(slide, peaks.rotation, peaks.time, peaks.slide)


@wp.func
def at_sample(mode: int, past: real, value: real, rate: real) -> real:
    """A coordinate at a sample that a lane has passed by a time [s]; where it ended, its last one.

    The velocities of a lane that has ended go on changing and need not be finite.
    """
    back = larger(past, real(0.0)) * rate
    return value - wp.where(mode == RUNNING, back, real(0.0))
