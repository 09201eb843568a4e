"""How the base of the oracle's block moves: along x, and upwards, too, knot by knot of both."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator

from warprock.model.motion import GroundMotions, Segment, SpatialMotions, StillBase, UprightMotions
from warprock.oracle.block_mechanics import Vector

_STILL = StillBase(1)


@dataclasses.dataclass(frozen=True)
class BaseSegment:
    """A stretch of one lane's motion between two knots of any direction.

    Attributes:
        start: Time at which it starts [s].
        stop: Time at which it stops [s]; may be infinite.
        velocity_step: Step of the base velocity at its start, along and upwards [m/s].
        acceleration: Acceleration of the base at a time inside it, along and upwards [m/s^2].
    """

    start: float
    stop: float
    velocity_step: Vector
    acceleration: Callable[[float], Vector]


def base_segments(motions: GroundMotions, lane: int) -> Iterator[BaseSegment]:
    """The motion of one lane's base in the plane, segment by segment."""
    if isinstance(motions, UprightMotions):
        along, upwards = motions.x.segments(lane), motions.z.segments(lane)
    else:
        assert not isinstance(motions, SpatialMotions)
        along, upwards = motions.segments(lane), _STILL.segments(0)
    at = above = 0
    time = 0.0
    while at < len(along) and above < len(upwards):
        one, other = along[at], upwards[above]
        stop = min(one.stop, other.stop)
        if stop > time or one.velocity_step or other.velocity_step:
            yield _intersect(one, other, time, stop)
        time = stop
        at, above = at + (one.stop == stop), above + (other.stop == stop)


def _intersect(along: Segment, upwards: Segment, start: float, stop: float) -> BaseSegment:
    """What two segments have in common; a velocity step belongs to the start of its own."""

    def acceleration(time: float) -> Vector:
        return along.acceleration(time), upwards.acceleration(time)

    step = tuple(each.velocity_step if each.start == start else 0.0 for each in (along, upwards))
    return BaseSegment(start, stop, (step[0], step[1]), acceleration)
