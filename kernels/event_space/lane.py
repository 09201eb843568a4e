"""What runs of the event step in space know of lanes, blocks or stacks."""

import warp as wp

from warprock.kernels.motion import Motion
from warprock.kernels.vectors import Vector


@wp.struct
class Knobs:
    """What the lanes have in common."""

    gravity: real


@wp.struct
class Lane:
    """One lane: its longest step [s], the rise it rests from [m], its largest number of steps."""

    longest_step: real
    rest_gap: real
    step_limit: int


@wp.struct
class Limits:
    """What a step needs to know of one lane besides its block: gravity [m/s^2], and see `Lane`."""

    gravity: real
    longest_step: real
    rest_gap: real


@wp.struct
class BaseMotion:
    """Motion of a lane's base along x, y and z.

    Value and slope are the acceleration [m/s^2] and how it rises [m/s^3] from the knots passed, of
    records.
    """

    x: Motion
    y: Motion
    z: Motion
    value: Vector
    slope: Vector
