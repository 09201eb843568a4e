"""The vertical motion of the base of a body in the plane, where there is one (VERTICAL)."""

import warp as wp

from warprock.kernels.motion import Motion

Motions = wp.array2d(dtype=Motion) if VERTICAL else wp.array(dtype=Motion)
"""Motions of the base: along x, [lane]; with those upwards, [direction, lane]."""


@wp.struct
class Above:
    """The vertical motion of a lane's base, and where it stands.

    Attributes:
        motion: The motion.
        segment: Knots of it that are passed.
        value, slope: What `expand` takes of a record.
    """

    motion: Motion
    segment: int
    value: real
    slope: real


@wp.func
def move_up(v: real, begun: bool, rise: wp.ref[real], rising: wp.ref[real]):
    """Moves a base on to an upward velocity v: its gain in the step, and the velocity [m/s].

    `begun` says whether the base moves yet.
    """
    rise = wp.where(begun, v - rising, real(0.0))
    rising = wp.where(begun, v, rising)
