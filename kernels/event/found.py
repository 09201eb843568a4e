"""Results of a run of single blocks and bodies in the plane."""

import warp as wp

from warprock.kernels.event.block.state import Seen
from warprock.kernels.shape.stack_found import BlockResult


@wp.struct
class Result:
    """Results of one lane; `needed` is the friction that its prescribed impacts need."""

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
    """The results of a lane."""
    return Result(
        seen.uplift_time, seen.rest_time, seen.loss, seen.deepest, needed, seen.impacts, mode,
        seen.steps,
    )  # fmt: skip


@wp.func
def block_result(slide: real, seen: Seen) -> BlockResult:
    """The results of its block, from the slide at the end [m]."""
    return BlockResult(slide, seen.peak, seen.peak_time, seen.peak_slide)
