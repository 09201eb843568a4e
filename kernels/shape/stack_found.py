"""What a run of a stack leaves behind: the same of all stepped engines."""

import warp as wp


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
    """Where the kernel leaves what it finds."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
