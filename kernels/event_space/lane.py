"""Inputs of a lane in runs of the event step in space, of blocks, bodies and stacks."""

import warp as wp

from warprock.kernels.algebra.vectors import Vector, X, Y, Z
from warprock.kernels.motion.kinds import Motion, ground_at

Knots = wp.types.vector(length=3, dtype=int)
"""Knots of the motion passed, along x, y and z."""

LIGHTER = real(0.125)
"""Weight of a ramp of the base's velocity over the one before; weights are velocities."""
LIGHTEST = by_precision(1.0e-6, 1.0e-4)
"""The least weight of a ramp, over the velocity step."""


@wp.struct
class Knobs:
    """Settings that all lanes share."""

    gravity: real


@wp.struct
class Lane:
    """One lane: longest step [s]; rise below which a corner closes [m]; largest number of steps.

    rebound, slow: of a stack, see `Rebound` in event_space/stack/contact.py.
    """

    longest_step: real
    rest_gap: real
    step_limit: int
    if BOUNCES:
        rebound: real
        slow: real


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


@wp.func
def base_motion(motions: wp.array2d(dtype=Motion), lane: int) -> BaseMotion:
    """Motion of the base of a lane, without samples of a record."""
    return BaseMotion(motions[X, lane], motions[Y, lane], motions[Z, lane], Vector(), Vector())


@wp.func
def read_samples(base: BaseMotion, knots: Knots, pool: wp.array2d(dtype=real)) -> BaseMotion:
    """The same motion with the samples of its records at the last knots passed."""
    x = ground_at(base.x, knots[X], pool)
    y = ground_at(base.y, knots[Y], pool)
    z = ground_at(base.z, knots[Z], pool)
    value = Vector(x.value, y.value, z.value)
    return BaseMotion(base.x, base.y, base.z, value, Vector(x.slope, y.slope, z.slope))
