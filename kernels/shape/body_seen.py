"""Observed response of a body on contact points: the lowest corner and its two neighbours.

As contact/parting.py for the two ends of an interface: a corner has *parted* once its gap exceeds
`slack`, and has *landed*, an impact, once it carries again after it had parted. A body stands on
an edge while two of its corners are closed. It has *lifted* once fewer are, and it *moves* while
that is so, or while it slips.
"""

import warp as wp

from warprock.kernels.shape.stack_found import Seen


@wp.func
def shift_corners(by: int, left: real, middle: real, right: real):
    """Numbers of three corners after the lowest one has moved on by `by` corners to +x.

    A corner that comes into view gets zero.
    """
    zero = real(0.0)
    on, back = by == 1, by == -1
    return (
        wp.where(on, middle, wp.where(by == 0, left, zero)),
        wp.where(on, right, wp.where(back, left, wp.where(by == 0, middle, zero))),
        wp.where(back, middle, wp.where(by == 0, right, zero)),
    )


@wp.func
def shift_parted(by: int, left: int, middle: int, right: int):
    """Parted flags of three corners, likewise; a corner that comes into view has parted."""
    on, back = by == 1, by == -1
    return (
        wp.where(on, middle, wp.where(by == 0, left, 1)),
        wp.where(on, right, wp.where(back, left, wp.where(by == 0, middle, 1))),
        wp.where(back, middle, wp.where(by == 0, right, 1)),
    )


@wp.func
def update_parted(is_there: bool, was: int, n: real, gap: real, limit: real):
    """Whether a corner has parted after a step, 1 or 0, and whether it has landed."""
    zero = real(0.0)
    now = wp.where(gap > limit or (was > 0 and n <= zero), 1, 0)
    lands = wp.where(is_there and was > 0 and n > zero, 1, 0)
    return wp.where(is_there, now, 1), lands


@wp.struct
class Corners:
    """The lowest corner and its neighbours to -x and to +x after a step.

    Attributes:
        has_left, has_right: 1 if there is a neighbour to -x, to +x, else 0.
        left, middle, right: Normal impulses of the corners.
        gap_left, gap_middle, gap_right: Their gaps after the step [m].
    """

    has_left: int
    has_right: int
    left: real
    middle: real
    right: real
    gap_left: real
    gap_middle: real
    gap_right: real


@wp.struct
class CornerParting:
    """What is kept of the lowest corner and its neighbours from step to step.

    Attributes:
        since: Time since which fewer than two of them carry [s], or NEVER; 0 at first.
        left, middle, right: 1 if a corner has parted and not landed since, else 0.
    """

    since: real
    left: int
    middle: int
    right: int


@wp.func
def observe_corners(
    live: bool, by: int, time: real, limit: real, slips: bool, corners: Corners,
    parting: wp.ref[CornerParting], seen: wp.ref[Seen],
):  # fmt: skip
    """Updates uplift, motion and impacts of a lane by the three corners after a step.

    Args:
        live: Whether the lane still runs.
        by: Number of corners to +x by which the lowest one has moved since the last step.
        time: End of the step [s].
        limit: Gap beyond which a corner has parted [m].
        slips: Whether the body slides.
        corners: The corners.
        parting: What is kept of the corners; updated.
        seen: Observed response of the lane; updated.
    """
    zero = real(0.0)
    carry = wp.where(corners.left > zero, 1, 0) + wp.where(corners.middle > zero, 1, 0)
    carry = carry + wp.where(corners.right > zero, 1, 0)
    waits = wp.where(carry < 2, smaller(parting.since, time), NEVER)
    was_l, was_m, was_r = shift_parted(by, parting.left, parting.middle, parting.right)
    now_l, lands_l = update_parted(
        corners.has_left > 0, was_l, corners.left, corners.gap_left, limit
    )
    now_m, lands_m = update_parted(True, was_m, corners.middle, corners.gap_middle, limit)
    now_r, lands_r = update_parted(
        corners.has_right > 0, was_r, corners.right, corners.gap_right, limit
    )
    gapes = live and now_l + now_m + now_r > 1
    lifted = smaller(seen.uplift_time, smaller(waits, time))
    seen.uplift_time = wp.where(gapes, lifted, seen.uplift_time)
    seen.moved = wp.where(gapes or (live and slips), time, seen.moved)
    seen.impacts = seen.impacts + wp.where(live, lands_l + lands_m + lands_r, 0)
    parting.since = waits
    parting.left = now_l
    parting.middle = now_m
    parting.right = now_r
