"""What holds a block, and the ground below its support, as boxes that move."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from warprock.figures.palette import DARK, FALLEN, GREY, PALE, SERIES
from warprock.model.pose import quaternion
from warprock.model.tie_states import TieState
from warprock.model.turning import rotate
from warprock.running.scene_motion import SceneMotion
from warprock.running.scene_parts import Look, Part

Array = npt.NDArray[np.float64]

COLOURS = {
    Look.WALL: PALE,
    Look.ANCHOR: DARK,
    Look.COLUMN: SERIES[0],
    Look.BEAM: GREY,
    Look.TIE: "#000000",
    Look.LOAD: FALLEN,
}
THIN = 0.012
"""Thickness of a line as a box over the height of the block."""
GONE = 1e-6
"""Thickness of a tie that is broken, over that of other lines."""
SHARE = {TieState.SLACK: 0.4, TieState.TAUT: 1.0, TieState.YIELDING: 1.8, TieState.BROKEN: GONE}
"""Thickness of a tie by what it does, over that of other lines."""
GAP = 1.2
"""Height between a support and the ground below it over that of the base."""


@dataclasses.dataclass(frozen=True)
class Solid:
    """A box that moves.

    Attributes:
        name: What it is, in words.
        colour: As #RRGGBB.
        sizes: Full width, depth and height [m], shape [sample, 3].
        places: Its middle [m], shape [sample, 3].
        turns: Quaternions (x, y, z, w), shape [sample, 4].
    """

    name: str
    colour: str
    sizes: Array
    places: Array
    turns: Array

    @property
    def rigid(self) -> bool:
        """Whether it keeps its size, but for round-off."""
        return bool(np.allclose(self.sizes, self.sizes[0], rtol=1e-9, atol=0.0))

    def ends(self, sample: int) -> tuple[Array, Array]:
        """The middles of its lower and its upper face [m]."""
        up = rotate(self.turns[sample], np.array([0.0, 0.0, 0.5 * self.sizes[sample, 2]]))
        return self.places[sample] - up, self.places[sample] + up


def solids(motion: SceneMotion, thickness: float) -> Iterator[Solid]:
    """Boxes of what a scene shows besides its blocks and its base.

    Args:
        motion: The lane.
        thickness: Of its base as it is shown [m].
    """
    if motion.ground is not None:
        side, count = 2.0 * motion.reach, len(motion.times)
        sizes = np.tile([side, side, thickness], (count, 1))
        down = np.array([0.0, 0.0, (1.5 + GAP) * thickness])
        upright = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
        yield Solid("ground", PALE, sizes, motion.ground - down, upright)
    numbers: dict[Look, int] = {}
    for part in motion.parts:
        numbers[part.look] = numbers.get(part.look, 0) + 1
        yield _solid(f"{part.look} {numbers[part.look]}", part, motion)


def _solid(name: str, part: Part, motion: SceneMotion) -> Solid:
    points, depth = motion.places_of(part), float(motion.sizes[0, 1])
    up = points[:, -1] - points[:, 0]
    long = np.linalg.norm(up, axis=-1)
    if points.shape[1] == 2:
        thin = np.full(len(points), THIN * float(motion.sizes[0, 2]))
        if part.states is not None:
            thin = thin * np.array([SHARE[TieState(state)] for state in part.states])
        wide, deep = thin, thin
    else:
        wide = np.linalg.norm(points[:, 1] - points[:, 0], axis=-1)
        deep = np.full(len(points), depth)
    middle = np.insert(points.mean(axis=1), 1, 0.0, axis=-1)
    angle, nothing = np.arctan2(up[:, 0], up[:, 1]), np.zeros(len(points))
    turns = quaternion(np.stack([nothing, angle, nothing], axis=-1))
    return Solid(name, COLOURS[part.look], np.stack([wide, deep, long], axis=-1), middle, turns)
