"""What a run of single blocks and bodies in the plane leaves behind."""

import warp as wp

from warprock.kernels.event.block_state import Seen
from warprock.kernels.shape.stack_found import BlockResult


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


@wp.func
def result_of(seen: Seen, needed: real, mode: int) -> Result:
    """What a lane leaves behind."""
    return Result(
        seen.uplift_time, seen.rest_time, seen.loss, seen.deepest, needed, seen.impacts, mode,
        seen.steps,
    )  # fmt: skip


@wp.func
def block_result(slide: real, seen: Seen) -> BlockResult:
    """What its block leaves behind; the slide at the end [m]."""
    return BlockResult(slide, seen.peak, seen.peak_time, seen.peak_slide)
