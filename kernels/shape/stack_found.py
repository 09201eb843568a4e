"""What a run in the plane leaves behind: the same of all stepped engines."""

import warp as wp

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


@wp.func
def at_sample(mode: int, past: real, value: real, rate: real) -> real:
    """A coordinate at a sample that a lane has passed by a time [s]; where it ended, its last one.

    The velocities of a lane that has ended go on changing and need not be finite.
    """
    back = larger(past, real(0.0)) * rate
    return value - wp.where(mode == RUNNING, back, real(0.0))
