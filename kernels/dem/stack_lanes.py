"""What becomes of lanes of soft-spring blocks, in the plane and in space."""

import warp as wp

from warprock.kernels.modes import RUNNING, SLID_OFF

PIVOT = real(0.75)
"""Place up to which faces that have parted gape, from the middle, over the way to the end. Of five
sub-contacts only the last one then carries, which is when a rigid block lifts; of many, the
resultant has moved by 0.92 of the way. In space the end is the corner that is pressed most."""
APART = real(-1.0)
"""What an interface that has parted keeps for the time since which it gapes."""


@wp.func
def passes_left(until: real, steps: int, dt: real, mode: int) -> int:
    """Steps that a lane has to take to reach a time; may be one too many."""
    left = (until - real(steps) * dt) / dt
    running = mode == RUNNING and left > real(0.0)
    return wp.where(running, int(wp.ceil(wp.where(running, left, real(0.0)))) + 1, 0)


@wp.func
def time_past(until: real, steps: int, dt: real, mode: int) -> real:
    """Time by which a lane that still runs has passed a sample [s]."""
    return wp.where(mode == RUNNING, larger(real(steps) * dt - until, real(0.0)), real(0.0))


@wp.func
def observe_faces(
    live: bool, time: real, overlap: real, tilt: real, shared: real, slips: bool,
    since: wp.ref[real], uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real],
    impacts: wp.ref[int], mode: wp.ref[int],
):  # fmt: skip
    """Whether an interface rocks or slides, whether it has landed, and whether it is still there.

    Args:
        live: Whether the lane still runs.
        time: Time [s].
        overlap: Depth to which the faces overlap in the middle of what they share [m].
        tilt: By how much it is deeper at the end, or corner, where it is deepest [m].
        shared: How much they share.
        slips: Whether the faces slip.
        since: Time since which the middle gapes [s]: APART once it has parted, NEVER if closed.
        uplift_time: Time at which the lane first lifted [s], or NEVER.
        moved: Last time at which it moved [s].
        deepest: Deepest overlap so far [m].
        impacts: Interfaces that have landed.
        mode: How the lane goes on.
    """
    zero = real(0.0)
    gapes = overlap <= zero
    was = since < zero
    apart = gapes and (was or overlap + PIVOT * tilt <= zero)
    opened = wp.where(gapes, smaller(since, time), NEVER)
    lifts = live and apart and not was
    uplift_time = wp.where(lifts, smaller(uplift_time, opened), uplift_time)
    moved = wp.where(live and (apart or (slips and not gapes)), time, moved)
    impacts = impacts + wp.where(live and was and not gapes, 1, 0)
    since = wp.where(live, wp.where(apart, APART, opened), since)
    deepest = wp.where(live and shared > zero, larger(overlap + tilt, deepest), deepest)
    mode = wp.where(live and shared <= zero, SLID_OFF, mode)
