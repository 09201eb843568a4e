"""What the run of Housner's block leaves behind."""

import warp as wp


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
