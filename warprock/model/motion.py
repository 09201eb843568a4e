"""Ground motions of a batch of lanes: analytic waveforms and sampled records, in one place.

A waveform is a module of its own: its class, what a kernel follows it by, and how it comes from
what a user writes. `lane_motion` says what they have in common.
"""

from __future__ import annotations

import dataclasses
from typing import Self, TypeAlias

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


@dataclasses.dataclass(frozen=True)
class SpatialMotions:
    """Motions of a base that translates in space: one motion of each direction, all of one kind.

    Attributes:
        x: Along +x, in the plane of rocking.
        y: Along +y, across it.
        z: Upwards.
    """

    x: PlanarMotions
    y: PlanarMotions
    z: PlanarMotions

    @property
    def components(self) -> tuple[PlanarMotions, PlanarMotions, PlanarMotions]:
        """The motions along x, y and z."""
        return self.x, self.y, self.z

    @property
    def kind(self) -> MotionKind:
        """Family of the motions."""
        return self.x.kind

    @property
    def lane_count(self) -> int:
        """Number of lanes."""
        return self.x.lane_count

    @property
    def start(self) -> Array:
        """Time at which the first of the directions starts to move [s]."""
        return np.asarray(np.min([part.start for part in self.components], axis=0))

    def take(self, lanes: Lanes) -> Self:
        """The motions of some lanes."""
        return dataclasses.replace(
            self, x=self.x.take(lanes), y=self.y.take(lanes), z=self.z.take(lanes)
        )

    def compact(self) -> Self:
        """The same motions, without what they do not use."""
        x, y, z = (part.compact() for part in self.components)
        return dataclasses.replace(self, x=x, y=y, z=z)

    @property
    def knot_count(self) -> npt.NDArray[np.int32] | int:
        """Samples of the records of all directions."""
        return sum(part.knot_count for part in self.components)

    @property
    def knot_interval(self) -> Array | float:
        """Shortest time between two samples of a record in any direction [s]."""
        x, y, z = (part.knot_interval for part in self.components)
        return np.minimum(np.minimum(x, y), z)

    @property
    def end(self) -> Array:
        """Time at which the base has come to its last motion in all directions [s]."""
        return np.asarray(np.max([part.end for part in self.components], axis=0))

    def scaled(self, factors: Array) -> Self:
        """The motions times a factor, in all directions, with the knots that they had."""
        x, y, z = (part.scaled(factors) for part in self.components)
        return dataclasses.replace(self, x=x, y=y, z=z)


GroundMotions = PlanarMotions | SpatialMotions


def no_motion(like: PlanarMotions) -> PlanarMotions:
    """A base that stays where it is, in the family of other motions and with their knots."""
    return like.scaled(np.zeros(like.lane_count))
