"""Stacks in space that move in one vertical plane: which they are, and the same in that plane.

A stack is its own mirror image in a vertical plane if its blocks are turned alike, the plane is
parallel to their sides and holds their centres, and they start flat and from rest. If the base
moves in that plane, too, the mirror image of a motion is a motion of the same stack. So where the
law of contact has one solution the motion stays in the plane, and the equations of the plane give
it.
"""

from __future__ import annotations

import dataclasses
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import GroundMotions, PlanarMotions, SpatialMotions, UprightMotions

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.intp]

ROUND_OFF = 1e-12
"""Part of a size, or of a motion, up to which what leads out of the plane is round-off, as that of
the cosine of a right angle."""


@dataclasses.dataclass(frozen=True)
class Coplanar:
    """The lanes of a batch that move in one vertical plane.

    Attributes:
        within: Which lanes these are, shape [lane].
        across: Which of them move along the depth of their blocks, not the width, shape [lane].
        upwards: Which of them stand on a base that moves upwards, too, shape [lane].
        direction: Angle from +x to the side of the blocks in that plane [rad], shape [lane].
    """

    within: Mask
    across: Mask
    upwards: Mask
    direction: Array

    @property
    def unit(self) -> Array:
        """Unit vectors along x and y of those planes, exact along the axes, shape [lane, 2]."""
        found = np.stack([np.cos(self.direction), np.sin(self.direction)], axis=-1)
        return np.where(np.abs(found) <= ROUND_OFF, 0.0, found)

    @property
    def nearer_x(self) -> Mask:
        """Which lanes move along x more than along y, whose motion tells theirs best."""
        return np.asarray(np.abs(self.unit[:, 0]) >= np.sqrt(0.5))

    @property
    def lots(self) -> list[Rows]:
        """Numbers of the lanes within, by lots that one kernel and one motion can run."""
        if not self.within.any():
            return []
        kinds = [
            self.within & (self.upwards == upwards) & (self.nearer_x == nearer)
            for upwards in (False, True)
            for nearer in (True, False)
        ]
        return [np.flatnonzero(kind) for kind in kinds if kind.any()]


def no_plane(lanes: Lanes) -> Coplanar:
    """That no stack of a batch moves in one vertical plane."""
    none = np.zeros(lanes.lane_count, dtype=bool)
    return Coplanar(none, none, none, np.zeros(len(none)))


def find_coplanar(lanes: Lanes, motions: GroundMotions) -> Coplanar:
    """Finds the stacks of a batch that move in one vertical plane; none of any other batch.

    Args:
        lanes: The lanes.
        motions: Their ground motions.
    """
    if not (
        isinstance(lanes, SpatialLanes)
        and isinstance(motions, SpatialMotions)
        and lanes.stacked
        and lanes.assembly is None
        and lanes.release is None
        and not lanes.bodies
    ):
        return no_plane(lanes)
    within, across = np.zeros((2, lanes.lane_count), dtype=bool)
    starts = (
        lanes.rotation_start, lanes.rotation_across_start, lanes.gap_start, lanes.centre_offset_x,
        lanes.centre_offset_y, lanes.yaw_start - lanes.yaw_start[:, :1],
    )  # fmt: skip
    straight = np.all([np.all(part == 0.0, axis=1) for part in starts], axis=0)
    direction = lanes.yaw_start[:, 0].copy()
    for turn in (0.0, 0.5 * np.pi):
        angle = lanes.yaw_start[:, 0] + turn
        s, c = np.sin(angle)[:, None], np.cos(angle)[:, None]
        beside = np.abs(c * lanes.offset_across - s * lanes.offset)
        fits = straight & ~within & np.all(beside <= ROUND_OFF * lanes.width, axis=1)
        fits &= _moves_along(motions.x, motions.y, angle)
        across |= fits & (turn > 0.0)
        direction[fits] = angle[fits]
        within |= fits
    return Coplanar(within, across, within & motions.z.moves, direction)


def _moves_along(x: PlanarMotions, y: PlanarMotions, angle: Array) -> Mask:
    """Whether bases move in the vertical plane at an angle from +x [rad], shape [lane]."""
    s, c = np.sin(angle), np.cos(angle)
    one, other = x.scaled(s), y.scaled(c)
    same = np.ones(len(angle), dtype=bool)
    for field in dataclasses.fields(cast(Any, x)):
        parts = (np.asarray(getattr(part, field.name)) for part in (one, other, x, y))
        a, b, whole_a, whole_b = parts
        if field.name.startswith("pool_") or a.shape[:1] != same.shape:
            same &= np.array_equal(a, b)
        else:
            size = np.maximum(np.abs(whole_a), np.abs(whole_b))
            same &= (a == b) | (np.abs(a - b) <= ROUND_OFF * size)
    alone = (~y.moves | (np.abs(c) <= ROUND_OFF)) & (~x.moves | (np.abs(s) <= ROUND_OFF))
    return np.asarray(same | alone)


_PLANAR = tuple(field.name for field in dataclasses.fields(Lanes))


def in_their_plane(
    lanes: SpatialLanes, motions: SpatialMotions, found: Coplanar, rows: Rows
) -> tuple[Lanes, PlanarMotions | UprightMotions]:
    """Some lanes that move in one vertical plane as lanes of the plane, and their motions.

    Args:
        lanes: All lanes.
        motions: Their ground motions.
        found: Which move in a plane.
        rows: Numbers of lanes of one of its `lots`.
    """
    some, base = lanes.take(rows), motions.take(rows)
    side, (c, s) = found.across[rows, None], found.unit[rows].T
    arrays = some.arrays.items()
    parts: dict[str, Any] = {name: each for name, each in arrays if name in _PLANAR}
    parts["width"] = np.where(side, some.depth, some.width)
    parts["depth"] = np.where(side, some.width, some.depth)
    parts["offset"] = c[:, None] * some.offset + s[:, None] * some.offset_across
    along = base.x.scaled(1.0 / c) if found.nearer_x[rows].all() else base.y.scaled(1.0 / s)
    return Lanes(**parts), UprightMotions(along, base.z) if found.upwards[rows].any() else along
