"""What a run of a body in the plane leaves behind, the same of engines that step."""

import warp as wp

from warprock.kernels.shape.stack_found import BlockResult, Result


@wp.struct
class Found:
    """As that of stacks, and `sides`: largest rotations to -x and to +x [rad], shape [2, lane]."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
    places: wp.array4d(dtype=real)
    sides: wp.array2d(dtype=real)
