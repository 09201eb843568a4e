"""The vertical motion of the base of a body in the plane, if VERTICAL is true."""

import warp as wp

from warprock.kernels.motion.kinds import Motion, ground_at

Motions = wp.array2d(dtype=Motion) if VERTICAL else wp.array(dtype=Motion)
"""Motions of the base: along x, shape [lane]; with those upwards, shape [direction, lane],
see ALONG and UPWARDS in algebra/vectors.py."""


@wp.struct
class Above:
    """The vertical motion of the base of a lane, and its present segment.

    Attributes:
        motion: The motion.
        segment: Knots passed.
        value, slope: Sample of a record for `expand`.
    """

    motion: Motion
    segment: int
    value: real
    slope: real


@wp.func
def above_at(motion: Motion, segment: int, pool: wp.array2d(dtype=real)) -> Above:
    """The vertical motion in a segment, with the sample of a record at which that starts."""
    ground = ground_at(motion, segment, pool)
    return Above(motion, segment, ground.value, ground.slope)


@wp.func
def move_up(v: real, begun: bool, rise: wp.ref[real], rising: wp.ref[real]):
    """Sets the gain of the upward base velocity in a step, and that velocity, to v [m/s].

    `begun` says whether the base has begun to move.
    """
    rise = wp.where(begun, v - rising, real(0.0))
    rising = wp.where(begun, v, rising)
