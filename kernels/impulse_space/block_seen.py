"""What the impulse step shows of single blocks in space.

A block rocks while a corner has parted from the base, see parting.py. It lands once such a corner
carries again; an edge lands as one. It stands flat while two opposite corners carry, and its uplift
time is when it last did. It moves while it rocks or slides, see `slips`.
"""

import warp as wp

from warprock.kernels.impulse_space.block import Knobs, slips
from warprock.kernels.modes import BROKEN, OVERTURNED, RUNNING
from warprock.kernels.shape_space.block import Block, matrix_of, product, slide_of, turns_of


@wp.func
def glides(block: Block, knobs: Knobs, ux: real, uy: real, ox: real, oy: real, oz: real) -> bool:
    """Whether a block that stands flat slides, with the velocities u and o after a step."""
    x, y = fused_less(block.half_height, oy, ux), fused(block.half_height, ox, uy)
    turn = oz * (block.half_width + block.half_depth)
    return slips(product(x, y, turn, x, y, turn), knobs)


@wp.func
def stands(n0: real, n1: real, n2: real, n3: real) -> bool:
    """Whether a block stands flat: two opposite corners carry."""
    return smaller(n0, n3) > real(0.0) or smaller(n1, n2) > real(0.0)


@wp.func
def lifted_since(n1: real, n2: real, n3: real, n4: real, since: real, before: real) -> real:
    """Time since which a block has not stood flat [s], or NEVER; `before`, end of the last step."""
    return wp.where(stands(n1, n2, n3, n4), NEVER, smaller(since, before))


@wp.func
def observe_contacts(
    live: bool, time: real, landed: real, lowest: real, lifted: real, slides: bool,
    since: real, uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real],
    impacts: wp.ref[int], steps: wp.ref[int],
):  # fmt: skip
    """Whether a block moves, whether it lands, and how deep it is.

    Args:
        live: Whether the lane lives on.
        time: End of the step [s].
        landed: Corners that land.
        lowest: Lowest gap [m].
        lifted: Corners that have parted.
        slides: Whether it slides if it stands flat.
        since: Time since which it has not stood flat [s], or NEVER.
        uplift_time: Time at which it first lifted [s], or NEVER.
        moved: Last time at which a corner has parted, or the block slides [s].
        deepest: Deepest penetration [m].
        impacts: Landings.
        steps: Steps of a lane that lived on.
    """
    zero = real(0.0)
    rocks = live and lifted > zero
    uplift_time = wp.where(rocks, smaller(uplift_time, smaller(since, time)), uplift_time)
    moved = wp.where(rocks or (live and slides), time, moved)
    impacts = impacts + wp.where(live and landed > zero, 1, 0)
    steps = steps + wp.where(live, 1, 0)
    deepest = wp.where(live, larger(-lowest, deepest), deepest)


@wp.func
def observe_block(
    live: bool, time: real, block: Block, x: real, y: real, z: real, qx: real, qy: real, qz: real,
    qw: real, speed: real, slide_x: wp.ref[real], slide_y: wp.ref[real],
    peak: wp.ref[real], peak_time: wp.ref[real],
    peak_across: wp.ref[real], peak_tilt: wp.ref[real], peak_yaw: wp.ref[real],
    peak_slide: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """Peaks and slide of a block after a step, and whether its lane lives on.

    `speed` is a sum of its velocities, which is finite only if they are.
    """
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(qx, qy, qz, qw)
    tan_x, tan_y, tilt, yaw = turns_of(block, r13, r23, r33, qz, qw)
    away_x, away_y = slide_of(block, x, y, r11, r12, r13, r21, r22, r23, r31, r32)
    higher = live and tan_x > peak
    peak_time = wp.where(higher, time, peak_time)
    peak = wp.where(higher, tan_x, peak)
    peak_across = wp.where(live, larger(tan_y, peak_across), peak_across)
    peak_tilt = wp.where(live, larger(tilt, peak_tilt), peak_tilt)
    peak_yaw = wp.where(live, larger(yaw, peak_yaw), peak_yaw)
    slide_x = wp.where(live, away_x, slide_x)
    slide_y = wp.where(live, away_y, slide_y)
    peak_slide = wp.where(live, larger(dot(away_x, away_y, away_x, away_y), peak_slide), peak_slide)
    total = x + y + z + r33 + qw + speed
    found = wp.where(r33 <= real(0.0), OVERTURNED, RUNNING)
    mode = wp.where(live, wp.where(total - total == real(0.0), found, BROKEN), mode)
