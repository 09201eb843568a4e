"""Ground motions of a batch of lanes: analytic waveforms and sampled records, in one place.

A waveform is a module of its own: its class, what a kernel follows it by, and how it comes from
what a user writes. `lane_motion` says what they have in common.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Any, Self, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from warprock.model.harmonic import HarmonicMotions, harmonic_motions
from warprock.model.lane_motion import (
    Array,
    Control,
    LaneMotions,
    Lanes,
    MotionKind,
    Segment,
    StillBase,
    Waveform,
)
from warprock.model.modulated import (
    ModulatedMotions,
    mavroeidis_papageorgiou_motions,
    modulated_peak_acceleration,
)
from warprock.model.record_motion import RecordMotions
from warprock.model.ricker import (
    RICKER_HALF_LENGTH,
    RickerMotions,
    ricker_motions,
    ricker_peak_acceleration,
)

__all__ = [
    "RICKER_HALF_LENGTH",
    "ComposedMotions",
    "Control",
    "GroundMotions",
    "HarmonicMotions",
    "ModulatedMotions",
    "MotionKind",
    "PlanarMotions",
    "RecordMotions",
    "RickerMotions",
    "Segment",
    "SpatialMotions",
    "StillBase",
    "UprightMotions",
    "Waveform",
    "harmonic_motions",
    "mavroeidis_papageorgiou_motions",
    "modulated_peak_acceleration",
    "no_motion",
    "ricker_motions",
    "ricker_peak_acceleration",
]

PlanarMotions: TypeAlias = LaneMotions
"""Motions of one direction, of any waveform."""


class ComposedMotions:
    """Motions of a base that translates along several axes: one of each, all of one kind.

    The fields of its dataclasses are the motions, named by their axes.
    """

    @property
    def axes(self) -> str:
        """The axes that the base moves along, in the order of `components`."""
        return "".join(field.name for field in dataclasses.fields(cast(Any, self)))

    @property
    def components(self) -> tuple[PlanarMotions, ...]:
        """The motions along the axes."""
        return tuple(getattr(self, axis) for axis in self.axes)

    def with_parts(self, change: Callable[[PlanarMotions], PlanarMotions]) -> Self:
        """The same with another motion in the place of each."""
        parts = {axis: change(getattr(self, axis)) for axis in self.axes}
        return type(self)(**parts)

    @property
    def kind(self) -> MotionKind:
        """Family of the motions."""
        return self.components[0].kind

    @property
    def lane_count(self) -> int:
        """Number of lanes."""
        return self.components[0].lane_count

    @property
    def start(self) -> Array:
        """Time at which the first of the directions starts to move [s]."""
        return np.asarray(np.min([part.start for part in self.components], axis=0))

    def take(self, lanes: Lanes) -> Self:
        """The motions of some lanes."""
        return self.with_parts(lambda part: part.take(lanes))

    def compact(self) -> Self:
        """The same motions, without what they do not use."""
        return self.with_parts(lambda part: part.compact())

    @property
    def knot_count(self) -> npt.NDArray[np.int32] | int:
        """Samples of the records of all directions."""
        return sum(part.knot_count for part in self.components)

    @property
    def knot_interval(self) -> Array | float:
        """Shortest time between two samples of a record in any direction [s]."""
        return functools.reduce(np.minimum, [part.knot_interval for part in self.components])

    @property
    def end(self) -> Array:
        """Time at which the base has come to its last motion in all directions [s]."""
        return np.asarray(np.max([part.end for part in self.components], axis=0))

    def scaled(self, factors: Array) -> Self:
        """The motions times a factor, in all directions, with the knots that they had."""
        return self.with_parts(lambda part: part.scaled(factors))


@dataclasses.dataclass(frozen=True)
class SpatialMotions(ComposedMotions):
    """Motions of a base that translates in space.

    Attributes:
        x: Along +x, in the plane of rocking.
        y: Along +y, across it.
        z: Upwards.
    """

    x: PlanarMotions
    y: PlanarMotions
    z: PlanarMotions


@dataclasses.dataclass(frozen=True)
class UprightMotions(ComposedMotions):
    """Motions of a base that translates in the plane of rocking.

    Attributes:
        x: Along +x.
        z: Upwards.
    """

    x: PlanarMotions
    z: PlanarMotions


GroundMotions = PlanarMotions | UprightMotions | SpatialMotions


def no_motion(like: PlanarMotions) -> PlanarMotions:
    """A base that stays where it is, in the family of other motions and with their knots."""
    return like.scaled(np.zeros(like.lane_count))
