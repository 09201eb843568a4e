"""What is seen of Housner's block, and what its run leaves behind."""

import warp as wp


@wp.struct
class Seen:
    """What is seen of a lane so far.

    Attributes:
        peak: Largest |rotation| [rad].
        peak_time: When it was [s].
        uplift_time: Time of the first uplift [s]; NEVER before.
        rest_time: Time since when the block rests [s]; NEVER while it does not.
        loss: Sum of omega^2 (1 - eta^2) over the impacts [rad^2/s^2].
        impacts: Impacts.
        steps: Steps taken.
    """

    peak: real
    peak_time: real
    uplift_time: real
    rest_time: real
    loss: real
    impacts: int
    steps: int


@wp.struct
class FrictionSeen:
    """What is seen of a lane, and the friction needed; on compliant ground `loss` is in J."""

    peak: real
    peak_time: real
    uplift_time: real
    rest_time: real
    loss: real
    needed: real
    impacts: int
    steps: int


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
