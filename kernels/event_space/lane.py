"""Inputs of a lane in runs of the event step in space, of blocks, bodies and stacks."""

import warp as wp

from warprock.kernels.algebra.vectors import Vector
from warprock.kernels.motion.kinds import Motion

Knots = wp.types.vector(length=3, dtype=int)
"""Knots of the motion passed, along x, y and z."""


@wp.struct
class Knobs:
    """Settings that all lanes share."""

    gravity: real


@wp.struct
class Lane:
    """One lane: longest step [s]; rise below which a corner closes [m]; largest number of steps."""

    longest_step: real
    rest_gap: real
    step_limit: int


@wp.struct
class Limits:
    """What a step needs of one lane besides its block: gravity [m/s^2], and see `Lane`."""

    gravity: real
    longest_step: real
    rest_gap: real


@wp.struct
class BaseMotion:
    """Motion of a lane's base along x, y and z.

    Value and slope are the acceleration [m/s^2] of a record at the last knot passed, and its slope
    [m/s^3] up to the next.
    """

    x: Motion
    y: Motion
    z: Motion
    value: Vector
    slope: Vector
