"""Results of a run of blocks in space, of all engines.

Rotations are kept as tangents, which need no trigonometric function. The host converts them to
angles.
"""

import warp as wp


@wp.struct
class BlockResult:
    """Results of one block.

    Attributes:
        qz, qw: Twist of the attitude at the end.
        slide_x, slide_y: Slide at the end, in the axes of the body below [m].
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
    """Results of one lane.

    Attributes:
        uplift_time: Time of the first uplift [s], NEVER without one.
        moved: Last time at which a block moved [s].
        loss: Energy lost [J].
        deepest: Deepest penetration of a corner [m].
        impacts: Landings.
        mode: How the lane ended; see modes.py.
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
    """Arrays of results.

    Attributes:
        results: Results of every lane, shape [lane].
        blocks: Results of every block, shape [block, lane].
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
    """Observed response of a block up to its time; fields as in `BlockResult`."""

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
    """Observed response of a block before its first step; see `turns_of`."""
    zero = real(0.0)
    return Peaks(zero, zero, along, zero, across, tilt, zero, zero)


@wp.func
def observe_turns(
    live: bool, time: real, along: real, across: real, tilt: real, yaw: real, p: Peaks
) -> Peaks:
    """Peaks of the rotations of a block after a step, if its lane still runs; see `turns_of`."""
    higher = live and along > p.rotation
    return Peaks(
        p.slide_x, p.slide_y, wp.where(higher, along, p.rotation), wp.where(higher, time, p.time),
        wp.where(live, larger(across, p.across), p.across),
        wp.where(live, larger(tilt, p.tilt), p.tilt), wp.where(live, larger(yaw, p.yaw), p.yaw),
        p.slide,
    )  # fmt: skip


@wp.func
def observe_slide(live: bool, x: real, y: real, square: real, p: Peaks) -> Peaks:
    """Slide of a block after a step [m], and the peak of its square, if its lane still runs."""
    return Peaks(
        wp.where(live, x, p.slide_x), wp.where(live, y, p.slide_y), p.rotation, p.time, p.across,
        p.tilt, p.yaw, wp.where(live, larger(square, p.slide), p.slide),
    )  # fmt: skip


@wp.func
def block_result(qz: real, qw: real, p: Peaks) -> BlockResult:
    """The results of a block, from the twist of its attitude."""
    return BlockResult(
        qz, qw, p.slide_x, p.slide_y, p.rotation, p.time, p.across, p.tilt, p.yaw, p.slide
    )  # fmt: skip
