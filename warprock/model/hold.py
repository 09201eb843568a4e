"""What acts on a block besides its base: a wall that it leans against, ties, a load on top."""

from __future__ import annotations

import dataclasses
from typing import Self, TypeVar

import numpy as np
import numpy.typing as npt

from warprock.model.strip import Strip
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

SIDES = {"left": -1.0, "right": 1.0}
"""Sides of a block: at -x and at +x."""


def three_impacts(slenderness_angle: Array) -> Array:
    """Rebound of a block that comes back on its base and on a transverse wall [-].

    Its angular momentum is kept about the other corner of its base, about its top corner at the
    wall, and about the first corner again, each time as one moment of inertia over the next:

        -(1 - (3/2) sin^2 a)^2 (1 - (3/2) cos^2 a).

    No rebound is left from cos^2(a) = 2/3 on, where the block is not slender. Sorrentino, AlShawa
    and Decanini (2011) are cited for this product; their text has not been at hand.

    Args:
        slenderness_angle: a [rad].
    """
    s, c = np.sin(slenderness_angle) ** 2, np.cos(slenderness_angle) ** 2
    return np.asarray(np.maximum(-((1.0 - 1.5 * s) ** 2) * (1.0 - 1.5 * c), 0.0))


@dataclasses.dataclass(frozen=True)
class Ties:
    """Ties of single blocks, shape [lane, tie] each.

    Attributes:
        side: Side of the block that the tie is at, -1 or 1.
        height: Height of its point above the base of the block [m].
        stiffness: [N/m].
        slack: Elongation before it pulls [m].
        prestress: Force in it while the block rests [N].
        yield_force: [N]; infinite where it does not yield.
        ultimate_elongation: Elongation, beyond the slack, at which it breaks [m]; infinite where it
            does not.
        pushes: Whether it gives compression, too.
    """

    side: Array
    height: Array
    stiffness: Array
    slack: Array
    prestress: Array
    yield_force: Array
    ultimate_elongation: Array
    pushes: npt.NDArray[np.bool_]

    @property
    def count(self) -> int:
        """Ties of a lane."""
        return int(self.side.shape[1])

    @property
    def free_length(self) -> Array:
        """Elongation from the state at rest at which a tie has no force [m]."""
        return np.asarray(self.slack - self.prestress / self.stiffness)


@dataclasses.dataclass(frozen=True)
class TopLoad:
    """Loads on the top of single blocks, shape [lane] each; forces, without inertia.

    Attributes:
        weight: Downwards [N].
        eccentricity: Distance of the weight to +x of the middle of the top [m].
        thrust: Along the base, towards +x [N].
        stays: Whether the weight keeps its place while the block turns; else it moves with it.
    """

    weight: Array
    eccentricity: Array
    thrust: Array
    stays: npt.NDArray[np.bool_]


@dataclasses.dataclass(frozen=True)
class Frame:
    """Columns capped by a beam: equal blocks that rock as one, shape [lane] each.

    With g the mass of the beam over that of all columns, and alpha, p and eta of a column, the
    frame rocks as a block of the same slenderness with

        p sqrt((1 + 2 g) / (1 + 3 g)),
        eta = (1 - (3/2) sin^2 alpha + 3 g cos(2 alpha)) / (1 + 3 g)

    (Makris and Vassiliou 2013).

    Attributes:
        columns: How many there are.
        mass_ratio: g [-].
    """

    columns: Array
    mass_ratio: Array

    @property
    def frequency_factor(self) -> Array:
        """Frequency parameter over that of a column [-]."""
        return np.asarray(np.sqrt((1.0 + 2.0 * self.mass_ratio) / (1.0 + 3.0 * self.mass_ratio)))

    @property
    def inertia_factor(self) -> Array:
        """Twice its kinetic energy / angular velocity^2, over the inertia of a column [-]."""
        return np.asarray(self.columns * (1.0 + 3.0 * self.mass_ratio))

    def angular_restitution(self, slenderness_angle: Array) -> Array:
        """Ratio of angular velocities after and before an impact [-]."""
        beam = 3.0 * self.mass_ratio * np.cos(2.0 * slenderness_angle)
        column = 1.0 - 1.5 * np.sin(slenderness_angle) ** 2
        return np.asarray((column + beam) / (1.0 + 3.0 * self.mass_ratio))


@dataclasses.dataclass(frozen=True)
class Bed:
    """Compliant ground below single blocks, which presses and does not pull, shape [lane] each.

    Attributes:
        stiffness: A unit of area [N/m^3].
        damping: A unit of area [N s/m^3].
    """

    stiffness: Array
    damping: Array

    def sunk(self, width: Array, depth: Array, mass: Array) -> Array:
        """How deep blocks lie in it at rest [m], of full widths and depths [m] and masses [kg]."""
        return np.asarray(mass * GRAVITY / (self.stiffness * width * depth))

    def fastest_rate(self, width: Array, height: Array, depth: Array, mass: Array) -> Array:
        """A bound of the rates of blocks on it [rad/s]: of their swings, of how they die out.

        A force at an end of the base moves that end as if it had at least a quarter of the mass
        of the block: 1 / m + b^2 / (m (b^2 + h^2) / 3 + m h^2), with half sizes.
        """
        lightness = (1.0 + width**2 / ((width**2 + height**2) / 3.0 + height**2)) / mass
        area = width * depth
        swing = np.sqrt(self.stiffness * area * lightness)
        return np.asarray(np.maximum(swing, self.damping * area * lightness))


@dataclasses.dataclass(frozen=True)
class Hold:
    """What holds the blocks of lanes.

    Attributes:
        wall: Side at which a transverse wall stands, -1 or 1, shape [lane]; None without walls.
        rebound: Angular velocity with which a block leaves the wall over that with which it came,
            shape [lane].
        ties: Their ties; None without ties.
        load: Loads on their tops; None without loads.
        frame: Frames of which the blocks are columns; None of blocks that stand alone.
        strip: Strips of wall that the blocks are; None of blocks in one piece.
        bed: Compliant ground below them; None of blocks on a rigid base.
    """

    wall: Array | None = None
    rebound: Array | None = None
    ties: Ties | None = None
    load: TopLoad | None = None
    frame: Frame | None = None
    strip: Strip | None = None
    bed: Bed | None = None

    @property
    def tables(self) -> tuple[str, ...]:
        """Tables of a case that say so."""
        parts = {
            "transverse_wall": self.wall,
            "tie": self.ties,
            "top_load": self.load,
            "frame": self.frame,
            "strip": self.strip,
            "ground": self.bed,
        }
        return tuple(name for name, part in parts.items() if part is not None)

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """What holds some of the lanes, by slice or by number."""
        return dataclasses.replace(
            self,
            wall=None if self.wall is None else self.wall[lanes],
            rebound=None if self.rebound is None else self.rebound[lanes],
            ties=None if self.ties is None else _take(self.ties, lanes),
            load=None if self.load is None else _take(self.load, lanes),
            frame=None if self.frame is None else _take(self.frame, lanes),
            strip=None if self.strip is None else self.strip.take(lanes),
            bed=None if self.bed is None else _take(self.bed, lanes),
        )


OfLanes = TypeVar("OfLanes", Ties, TopLoad, Frame, Bed)


def _take(parts: OfLanes, lanes: slice | npt.NDArray[np.intp]) -> OfLanes:
    """What belongs to some of the lanes."""
    names = [field.name for field in dataclasses.fields(parts)]
    return dataclasses.replace(parts, **{name: getattr(parts, name)[lanes] for name in names})
