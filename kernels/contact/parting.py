"""When the ends of an interface have parted, landed or slid.

An end is a corner of a block on the ground, or one end of the overlap of two faces. After each step
the scheme knows whether an end carries, its gap and its slip velocity. But even at rest ends have a
small gap and a small slip. Sweeps that stop before convergence make ends hop by a part of g dt^2.
A pivot hops by a part of R (omega dt)^2, since the step follows the chord and not the arc.
Therefore

    an end has *parted* once its gap exceeds `FALLS` g dt^2 + `ARCS` R (omega dt)^2;
    it has *landed*, which is an impact, once it carries again after it had parted;
    a block has *lifted* when an end parts; the uplift time is when that end last carried;
    it *moves* while an end is parted, or slips faster than `CREEP` g dt.

All these bounds vanish with the step. A swing whose corners move more slowly than FALLS g dt does
not count as one: it would end within a few steps.
"""

import warp as wp

from warprock.kernels.shape.stack_found import Seen

FALLS = real(2.0)
"""Largest gap of an end that still stands, over g dt^2: the fall of one step plus the gap left by
the step before. Sweeps that end early leave less than half of g dt^2."""
ARCS = real(8.0)
"""Largest gap of a pivot, over R (omega dt)^2. The chord of the arc rises by half of that. It falls
back slowly if the block turns so fast that it is about to leave the ground."""
CREEP = real(0.1)
"""Largest slip velocity of an end that sticks, over g dt: sweeps that end early leave less."""
GRAIN = by_precision(1.0e-14, 1.0e-6)
"""Round-off of a gap, over the lengths of which the gap is a difference."""


@wp.func
def slack(dt: real, gravity: real, reach: real, square: real, length: real) -> real:
    """The largest gap of an end that has not parted [m].

    Args:
        dt: Time step [s].
        gravity: Acceleration of gravity [m/s^2].
        reach: At least the distance of an end from the centre of the block [m].
        square: Square of the angular velocity [rad^2/s^2]; the sum of those of both bodies.
        length: Lengths of which a gap is a difference [m].
    """
    return fused(dt * dt, fused(ARCS * reach, square, FALLS * gravity), GRAIN * length)


@wp.struct
class Bearing:
    """Impulse that an end carries in a step, and its gap after the step [m]."""

    carried: real
    gap: real


@wp.struct
class Parting:
    """The two ends of an interface, kept from step to step.

    Attributes:
        since: Time since which at least one end carries nothing [s], or NEVER; 0 at first.
        left, right: 1 if the end at -x, at +x has parted and not landed since, else 0.
    """

    since: real
    left: int
    right: int


@wp.func
def observe_ends(
    live: bool, time: real, limit: real, slips: bool, left: Bearing, right: Bearing,
    parting: wp.ref[Parting], seen: wp.ref[Seen],
):  # fmt: skip
    """Updates uplift, motion and impacts of a lane by the two ends of an interface after a step.

    Args:
        live: Whether the lane still runs.
        time: End of the step [s].
        limit: Gap beyond which an end has parted [m], see `slack`.
        slips: Whether the interface slides, see `slides`.
        left, right: The end at -x and the end at +x.
        parting: What is kept of both ends; updated.
        seen: Observed response of the lane; updated.
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
    """Whether an interface slides that slips by a distance `way` [m] in a step."""
    return size(way) > CREEP * gravity * dt * dt
