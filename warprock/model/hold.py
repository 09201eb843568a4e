"""What holds a block besides its base: a transverse wall that it leans against, and ties."""

from __future__ import annotations

import dataclasses
from typing import Self

import numpy as np
import numpy.typing as npt

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
class Hold:
    """What holds the blocks of lanes.

    Attributes:
        wall: Side at which a transverse wall stands, -1 or 1, shape [lane]; None without walls.
        rebound: Angular velocity with which a block leaves the wall over that with which it came,
            shape [lane].
        ties: Their ties; None without ties.
    """

    wall: Array | None = None
    rebound: Array | None = None
    ties: Ties | None = None

    @property
    def tables(self) -> tuple[str, ...]:
        """Tables of a case that say so."""
        parts = {"transverse_wall": self.wall, "tie": self.ties}
        return tuple(name for name, part in parts.items() if part is not None)

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """What holds some of the lanes, by slice or by number."""
        ties = self.ties
        if ties is not None:
            parts = {f.name: getattr(ties, f.name)[lanes] for f in dataclasses.fields(ties)}
            ties = Ties(**parts)
        return dataclasses.replace(
            self,
            wall=None if self.wall is None else self.wall[lanes],
            rebound=None if self.rebound is None else self.rebound[lanes],
            ties=ties,
        )
