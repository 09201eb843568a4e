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
        value, slope: What `series` takes of a record.
    """

    motion: Motion
    segment: int
    value: real
    slope: real
