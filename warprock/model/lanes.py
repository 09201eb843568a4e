"""Lanes: one scene and one parameter set each, as arrays whose first axis is the lane."""

from __future__ import annotations

import dataclasses
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from warprock.model import rocking
from warprock.model.assembly import Assemblies
from warprock.model.bodies import Bodies
from warprock.model.hold import Hold
from warprock.model.profiles import Profiles
from warprock.model.release import Release
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

_NO_ARRAYS = ("body", "profiles", "release", "restitution_given", "hold", "assembly")


@dataclasses.dataclass(frozen=True)
class Lanes:
    """Blocks and their starts, SI units, full dimensions.

    What belongs to a block has the shape [lane] where a lane is a single block, and [lane, block],
    lowest block first, where it is a stack; what belongs to a lane has the shape [lane].

    Attributes:
        width: Full width in the plane of rocking [m].
        height: Full height [m].
        depth: Full depth across the plane of rocking [m].
        density: [kg/m^3].
        friction: Coulomb friction coefficient between the block and what it stands on.
        chamfer: Width cut off each edge of a block [m]: its faces touch over their width less two
            chamfers; mass and moment of inertia are those of the full rectangle.
        offset: Distance of a block's centre to +x of the centre of what it stands on [m], along
            its face, at the start; of the lowest block nothing.
        rotation_start: Rotation at the start [rad], positive towards +x; released from rest.
        angular_restitution: Ratio of angular velocities after and before an impact on the base,
            shape [lane]; Housner's where the case prescribes none, of a body the smaller one of
            its sides. `housner` follows it and, where it is given, `event` in the plane; the other
            engines find it from their own laws.
        body: Bodies, where single blocks are no boxes; their width, height, depth and density are
            then those of the box around them, and say nothing of how they move.
        profiles: Blocks of stacks in the plane, where some are bodies; the width, height, depth and
            density of those are then of the box around them, up to their top.
        restitution_given: Whether the case prescribes the angular restitution, of all lanes.
        release: Velocities at the start, and attitudes of blocks that are thrown; None of blocks
            that are let go from rest.
        hold: What holds single blocks besides their base; None of free-standing ones.
        assembly: Assemblies of many blocks; the width, height and density are then of the box
            around those that can move, which says nothing of how they move.

    Example:
        >>> import warprock as wr
        >>> lanes = wr.expand_lanes(wr.load_case("free-b0")).lanes
        >>> lanes.slenderness_angle.round(4).tolist()
        [0.1974, 0.1799]
    """

    width: Array
    height: Array
    depth: Array
    density: Array
    friction: Array
    chamfer: Array
    offset: Array
    rotation_start: Array
    angular_restitution: Array
    body: Bodies | None = dataclasses.field(default=None, kw_only=True)
    profiles: Profiles | None = dataclasses.field(default=None, kw_only=True)
    restitution_given: bool = dataclasses.field(default=False, kw_only=True)
    release: Release | None = dataclasses.field(default=None, kw_only=True)
    hold: Hold | None = dataclasses.field(default=None, kw_only=True)
    assembly: Assemblies | None = dataclasses.field(default=None, kw_only=True)

    @property
    def lane_count(self) -> int:
        """Number of lanes."""
        return len(self.width)

    @property
    def stacked(self) -> bool:
        """Whether a lane is a stack, be it of one block."""
        return self.width.ndim == 2

    @property
    def spatial(self) -> bool:
        """Whether the blocks move in space, not in the plane of rocking alone."""
        return isinstance(self, SpatialLanes)

    @property
    def moving(self) -> str:
        """What a case does whose blocks are not let go from rest; empty where they are."""
        if self.release is None:
            return ""
        return "throws its blocks" if self.thrown else "starts its blocks with velocities"

    @property
    def thrown(self) -> bool:
        """Whether the blocks are thrown, so that they may fall on any of their faces."""
        return self.release is not None and self.release.thrown

    @property
    def held(self) -> tuple[str, ...]:
        """What holds the blocks besides their base, by the tables of a case."""
        return () if self.hold is None else self.hold.tables

    @property
    def bodies(self) -> bool:
        """Whether there are bodies, of which the box says nothing."""
        return self.body is not None or self.profiles is not None

    @property
    def on_points(self) -> bool:
        """Whether kernels of bodies run them; see `SceneKind`."""
        return self.bodies

    @property
    def contact_point_count(self) -> int:
        """Points that can touch at once: two of every block in the plane, all of a body.

        In space four of the lowest block, and eight between two faces that are turned.
        """
        if self.body is not None:
            return self.body.most_points
        if self.profiles is not None:
            return int(self.profiles.count.sum(axis=1).max())
        if self.spatial:
            return 4 + 8 * (self.block_count - 1)
        return 2 * self.block_count

    @property
    def block_count(self) -> int:
        """Blocks in a lane."""
        return self.width.shape[1] if self.stacked else 1

    @property
    def face_width(self) -> Array:
        """Width over which a block's faces touch others [m]; of a body that of its box."""
        return np.asarray(self.width - 2.0 * self.chamfer)

    @property
    def mass(self) -> Array:
        """Mass of the blocks [kg]."""
        if self.body is not None:
            return self._of_body(self.body.mass)
        if self.profiles is not None:
            return self.profiles.mass
        return np.asarray(self.density * self.width * self.height * self.depth)

    def _of_body(self, values: Array) -> Array:
        """Values of bodies or strips in the shape of those of blocks."""
        return values[:, None] if self.stacked else values

    @property
    def slenderness_angle(self) -> Array:
        """Critical angle of every block on a flat base [rad]; of bodies and strips the smaller one.

        Of a strip of wall it is the turn of the lower body at the unstable balance, of an assembly
        that of `model.assembly.Assembly`.
        """
        if self.assembly is not None:
            return self.assembly.slenderness_angle
        if self.body is not None:
            return self._of_body(self.body.slenderness_angles.min(axis=1))
        if self.profiles is not None:
            return np.asarray(self.profiles.slenderness_angles.min(axis=2))
        if self.hold is not None and self.hold.strip is not None:
            return self._of_body(self.hold.strip.critical.min(axis=1))
        return np.arctan2(self.face_width, self.height)

    @property
    def slenderness_angles(self) -> Array:
        """Critical angles of single blocks to -x and to +x [rad], shape [lane, 2]."""
        if self.body is not None:
            return self.body.slenderness_angles
        if self.hold is not None and self.hold.strip is not None:
            return self.hold.strip.critical
        return np.stack([self.slenderness_angle] * 2, axis=1)

    @property
    def frequency_parameter(self) -> Array:
        """Frequency parameter of single blocks [rad/s], of a body about its nearer end.

        Of an assembly that of a block whose diagonal is the assembly's reach.
        """
        if self.assembly is not None:
            return np.sqrt(0.75 * GRAVITY / (0.5 * self.assembly.reach))
        if self.body is not None:
            return self.body.frequency_parameter
        of_block = rocking.frequency_parameter(self.width, self.height)
        if self.hold is not None and self.hold.frame is not None:
            return of_block * self.hold.frame.frequency_factor
        if self.hold is not None and self.hold.strip is not None:
            return self.hold.strip.frequency_parameter
        return of_block

    @property
    def uplift_ratios(self) -> Array:
        """Base acceleration / g along x that lifts single blocks over either end, [lane, 2]."""
        if self.body is not None:
            return self.body.uplift_ratios
        if self.hold is not None and self.hold.strip is not None:
            return self.hold.strip.uplift_ratios
        return np.stack([self.face_width / self.height] * 2, axis=1)

    @property
    def face_depth(self) -> Array:
        """Depth over which a block's faces touch others [m]; in space chamfers run all around."""
        return np.asarray(self.depth - 2.0 * self.chamfer)

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """Some of the lanes, by slice or by number."""
        parts: dict[str, Any] = {name: each[lanes] for name, each in self.arrays.items()}
        if self.body is not None:
            parts["body"] = self.body.take(lanes)
        if self.profiles is not None:
            parts["profiles"] = self.profiles.take(lanes)
        if self.assembly is not None:
            parts["assembly"] = self.assembly.take(lanes)
        if self.release is not None:
            parts["release"] = self.release.take(lanes)
        if self.hold is not None:
            parts["hold"] = self.hold.take(lanes)
        return dataclasses.replace(self, **parts)

    @property
    def arrays(self) -> dict[str, Array]:
        """What is an array of the lanes itself, by the name of its field."""
        fields = (field.name for field in dataclasses.fields(self))
        return {name: getattr(self, name) for name in fields if name not in _NO_ARRAYS}


@dataclasses.dataclass(frozen=True)
class SpatialLanes(Lanes):
    """Blocks in space: x in the plane of rocking, y across it, z upwards.

    A block starts turned by its yaw about the vertical. It leans about an axis in its own bottom
    face: by its rotation towards its own +x, by its rotation across towards its own +y. Its lowest
    corner is `gap_start` above the place where it would stand if the block were flat. In a stack a
    block that leans otherwise than the one below is turned about the lowest corner of what their
    faces share, and blocks that lean alike stand as one.

    A centre of mass beside the middle of the box moves the corners as seen from it; the moments of
    inertia about it remain those of the uniform box. Slenderness angles are those of the weaker
    side, to whose edge the centre of mass is nearer.

    A body starts at rest in the axes in which it was described; the origin of the ground is below
    its centre of mass, and its offsets of the centre are nothing.

    Attributes:
        rotation_across_start: Rotation towards +y at the start [rad].
        yaw_start: Turn about the vertical at the start [rad], positive from +x to +y.
        gap_start: Height of the lowest corner above what it stands on at the start [m], >= 0.
        centre_offset_x: Distance of the centre of mass from the middle, along the width [m].
        centre_offset_y: The same along the depth [m].
        offset_across: Distance of a block's middle to +y of the middle of what it stands on [m];
            of the lowest block nothing.
    """

    rotation_across_start: Array
    yaw_start: Array
    gap_start: Array
    centre_offset_x: Array
    centre_offset_y: Array
    offset_across: Array

    @property
    def slenderness_angle(self) -> Array:
        """Critical angle of every block about the nearer edge at the ends of its width [rad].

        Of an assembly it is that of `model.assembly.Assembly`, along and across.
        """
        if self.assembly is not None:
            return self.assembly.slenderness_angle
        if self.body is not None:
            return self._of_body(self.body.slenderness_angles.min(axis=1))
        return np.arctan2(self.face_width - 2.0 * np.abs(self.centre_offset_x), self.height)

    @property
    def slenderness_angle_across(self) -> Array:
        """Critical angle of every block about the nearer edge at the ends of its depth [rad]."""
        if self.assembly is not None:
            return self.assembly.slenderness_angle
        if self.body is not None:
            return self._of_body(self.body.slenderness_angles_across.min(axis=1))
        return np.arctan2(self.face_depth - 2.0 * np.abs(self.centre_offset_y), self.height)


def as_stacks(lanes: Lanes) -> Lanes:
    """The lanes with a block axis: a single block is a stack of one."""
    if lanes.stacked:
        return lanes
    parts: dict[str, Any] = {
        name: each[:, None] for name, each in lanes.arrays.items() if name != "angular_restitution"
    }
    return dataclasses.replace(lanes, **parts)
