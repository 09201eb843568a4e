"""What a run of blocks in space leaves behind: the same of all engines.

Rotations are kept as tangents, which need no trigonometric function; the host turns them into
angles.
"""

import warp as wp


@wp.struct
class BlockResult:
    """What one block's run leaves behind.

    Attributes:
        qz, qw: Twist of the attitude at the end.
        slide_x, slide_y: Slide at the end, in the axes of what the block stands on [m].
        peak, peak_time: Tangent of the largest rotation in the plane of rocking and its time [s].
        peak_across: Tangent of the largest rotation across it.
        peak_tilt: Square of the tangent of the largest tilt.
        peak_yaw: Tangent of half of the largest yaw since the start.
        peak_slide: Square of the largest slide [m^2].
    """

    qz: real
    qw: real
    slide_x: real
    slide_y: real
    peak: real
    peak_time: real
    peak_across: real
    peak_tilt: real
    peak_yaw: real
    peak_slide: real


@wp.struct
class Result:
    """What one lane's run leaves behind.

    Attributes:
        uplift_time: First departure from the flat state [s], NEVER without one.
        moved: Last time at which a block moved [s].
        loss: Energy lost [J].
        deepest: Deepest penetration of a corner [m].
        impacts: Landings.
        mode: What became of the lane; the engine's own numbers.
        steps: Steps taken.
    """

    uplift_time: real
    moved: real
    loss: real
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
        attitudes: Quaternions at the samples, shape [sample, block, 4, lane]; empty if not asked
            for.
        places: Centres of mass x, y and z at the samples [m], shape [sample, block, 3, lane];
            likewise.
    """

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    attitudes: wp.array4d(dtype=real)
    places: wp.array4d(dtype=real)


@wp.struct
class Peaks:
    """What is seen of a block up to now; its fields are those of `BlockResult`."""

    slide_x: real
    slide_y: real
    rotation: real
    time: real
    across: real
    tilt: real
    yaw: real
    slide: real


@wp.func
def start_peaks(along: real, across: real, tilt: real) -> Peaks:
    """What is seen of a block before its first step; see `turns_of`."""
    zero = real(0.0)
    return Peaks(zero, zero, along, zero, across, tilt, zero, zero)


@wp.func
def observe_turns(
    live: bool, time: real, along: real, across: real, tilt: real, yaw: real, p: Peaks
) -> Peaks:
    """Peaks of how far a block has turned after a step, if its lane lives on; see `turns_of`."""
    higher = live and along > p.rotation
    return Peaks(
        p.slide_x, p.slide_y, wp.where(higher, along, p.rotation), wp.where(higher, time, p.time),
        wp.where(live, larger(across, p.across), p.across),
        wp.where(live, larger(tilt, p.tilt), p.tilt), wp.where(live, larger(yaw, p.yaw), p.yaw),
        p.slide,
    )  # fmt: skip


@wp.func
def observe_slide(live: bool, x: real, y: real, square: real, p: Peaks) -> Peaks:
    """Slide of a block after a step [m], if its lane lives on, and its square."""
    return Peaks(
        wp.where(live, x, p.slide_x), wp.where(live, y, p.slide_y), p.rotation, p.time, p.across,
        p.tilt, p.yaw, wp.where(live, larger(square, p.slide), p.slide),
    )  # fmt: skip


@wp.func
def block_result(qz: real, qw: real, p: Peaks) -> BlockResult:
    """What a block leaves behind whose attitude has this twist."""
    return BlockResult(
        qz, qw, p.slide_x, p.slide_y, p.rotation, p.time, p.across, p.tilt, p.yaw, p.slide
    )  # fmt: skip
