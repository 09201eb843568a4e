"""When the ends of an interface have parted, landed or slid.

An end is a corner of a block that stands on the ground, or one end of the stretch that two faces
share. After each step it is known whether an end carries, how wide it gapes and how fast it slips.
But even the ends of a block at rest gape and slip a little. Sweeps that stop before they have
converged let ends hop by parts of g dt^2. And a corner that a block turns about hops by parts of
R (omega dt)^2: the step follows the chord, not the arc. Therefore

    an end has *parted* once it gapes by more than `FALLS` g dt^2 + `ARCS` R (omega dt)^2;
    it has *landed*, which is an impact, once it carries again after it had parted;
    a block has *lifted* when an end parts; its uplift time is when that end last carried;
    it *moves* while an end is parted, or slips faster than `CREEP` g dt.

All these bounds vanish with the step. A swing whose corners move slower than FALLS g dt does not
count as a swing: it would end within a few steps.
"""

import warp as wp

from warprock.kernels.shape.stack_found import Seen

FALLS = real(2.0)
"""Gap of an end that may still stand, over g dt^2: what one step of falling makes of it, and what
the one before left. Sweeps that end early leave less than half of g dt^2."""
ARCS = real(8.0)
"""Gap of an end that a block turns about, over the square of its step along the arc and its
radius: the arc's chord rises by half of that, and falls back slowly where the block turns so fast
that it is about to leave the ground."""
CREEP = real(0.1)
"""Speed of an end that may still stick, over g dt: sweeps that end early leave less."""
GRAIN = by_precision(1.0e-14, 1.0e-6)
"""Gap that is round-off, over the lengths that it is a difference of."""


@wp.func
def slack(dt: real, gravity: real, reach: real, square: real, length: real) -> real:
    """The widest gap of an end that has not parted [m].

    Args:
        dt: Time step [s].
        gravity: Acceleration of gravity [m/s^2].
        reach: At least the distance of an end from the centre of the block [m].
        square: Square of the angular velocity [rad^2/s^2], of both bodies the sum.
        length: Lengths that a gap is a difference of [m].
    """
    return fused(dt * dt, fused(ARCS * reach, square, FALLS * gravity), GRAIN * length)


@wp.struct
class Bearing:
    """What an end carries in a step, and how wide it gapes after it [m]."""

    carried: real
    gap: real


@wp.struct
class Parting:
    """The two ends of an interface, kept from step to step.

    Attributes:
        since: Time since which the one or the other has carried nothing [s], or NEVER; 0 at first.
        left, right: 1 where the end at -x, at +x has parted and not landed since, else 0.
    """

    since: real
    left: int
    right: int


@wp.func
def observe_ends(
    live: bool, time: real, limit: real, slips: bool, left: Bearing, right: Bearing,
    parting: wp.ref[Parting], seen: wp.ref[Seen],
):  # fmt: skip
    """What a step shows of the two ends of an interface: uplift, motion and impacts of a lane.

    Args:
        live: Whether the lane still runs.
        time: End of the step [s].
        limit: Gap beyond which an end has parted [m], see `slack`.
        slips: Whether the interface slides, see `slides`.
        left, right: The end at -x and the end at +x.
        parting: The same two, before the step and then after it.
        seen: What is seen of the lane.
    """
    zero = real(0.0)
    open1 = left.carried <= zero
    open2 = right.carried <= zero
    waits = wp.where(open1 or open2, smaller(parting.since, time), NEVER)
    lands1 = wp.where(live and parting.left > 0 and left.carried > zero, 1, 0)
    lands2 = wp.where(live and parting.right > 0 and right.carried > zero, 1, 0)
    now1 = wp.where(left.gap > limit or (parting.left > 0 and open1), 1, 0)
    now2 = wp.where(right.gap > limit or (parting.right > 0 and open2), 1, 0)
    gapes = live and now1 + now2 > 0
    lifted = smaller(seen.uplift_time, smaller(waits, time))
    seen.uplift_time = wp.where(gapes, lifted, seen.uplift_time)
    seen.moved = wp.where(gapes or (live and slips), time, seen.moved)
    seen.impacts = seen.impacts + lands1 + lands2
    parting.since = waits
    parting.left = now1
    parting.right = now2


@wp.func
def slides(way: real, dt: real, gravity: real) -> bool:
    """Whether an interface that slips by a way [m] in a step slides."""
    return size(way) > CREEP * gravity * dt * dt
