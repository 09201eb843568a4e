"""Lanes: one scene and one parameter set each, as arrays whose first axis is the lane."""

from __future__ import annotations

import dataclasses
from typing import Self

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class Lanes:
    """Single blocks and their starts, SI units, full dimensions, shape [lane] each.

    Attributes:
        width: Full width in the plane of rocking [m].
        height: Full height [m].
        depth: Full depth across the plane of rocking [m].
        density: [kg/m^3].
        friction: Coulomb friction coefficient between block and base.
        angular_restitution: Ratio of angular velocities after and before an impact on the base;
            used by `housner` only, the contact engines find it from their contact laws.
        rotation_start: Rotation at the start [rad], positive towards +x; released from rest.
    """

    width: Array
    height: Array
    depth: Array
    density: Array
    friction: Array
    angular_restitution: Array
    rotation_start: Array

    @property
    def lane_count(self) -> int:
        """Number of lanes."""
        return len(self.width)

    @property
    def slenderness_angle(self) -> Array:
        """Critical angle [rad], shape [lane]."""
        return np.arctan2(self.width, self.height)

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """Some of the lanes, by slice or by number."""
        parts = {f.name: getattr(self, f.name)[lanes] for f in dataclasses.fields(self)}
        return dataclasses.replace(self, **parts)
