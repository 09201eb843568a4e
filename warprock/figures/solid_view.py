"""Blocks in space as they are seen from a place far away: their faces in a picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.figures.palette import GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from warprock.model.solids import Face

Array = npt.NDArray[np.float64]

ELEVATION = np.deg2rad(22.0)
"""From how far above the horizon blocks are seen."""
DARKEST = 0.6
"""Light on a face that is seen edge on, over that of one that is seen from the front."""
TRIAD = 0.12
"""Length of the axes that are drawn beside blocks, over the width of the picture."""


class SolidView:
    """A view of blocks in space from far away.

    Args:
        azimuth: Where the reader stands [rad], from +x about the vertical towards +y.
    """

    def __init__(self, azimuth: float) -> None:
        """Sets up the axes of the picture."""
        c, s, up = np.cos(azimuth), np.sin(azimuth), ELEVATION
        self._axes = np.array([[-s, c, 0.0], [-np.sin(up) * c, -np.sin(up) * s, np.cos(up)]])
        self._near = np.array([np.cos(up) * c, np.cos(up) * s, np.sin(up)])

    def seen(self, points: Array) -> Array:
        """Where points in space lie in the picture, to the right and up [m]."""
        return np.asarray(points @ self._axes.T)

    def draw(
        self,
        axes: Axes,
        corners: Array,
        faces: Sequence[Sequence[Face]],
        colours: Sequence[str],
    ) -> None:
        """Draws blocks, those that are farther away first.

        Args:
            axes: Where.
            corners: Corners of the blocks [m], shape [block, corner, 3].
            faces: Of every block and face the numbers of its corners, counterclockwise from
                outside.
            colours: Of the blocks.
        """
        from matplotlib.collections import PolyCollection
        from matplotlib.colors import to_rgb

        drawn = []
        for own, sides, colour in zip(corners, faces, colours, strict=True):
            for face in sides:
                polygon = own[list(face)]
                arms = polygon - polygon[0]
                normal = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
                front = float(normal @ self._near / np.linalg.norm(normal))
                if front > 0.0:
                    light = DARKEST + (1.0 - DARKEST) * front
                    shade = tuple(light * part for part in to_rgb(colour))
                    drawn.append((float(polygon.mean(axis=0) @ self._near), polygon, shade))
        drawn.sort(key=lambda each: each[0])
        blocks = PolyCollection(
            [self.seen(polygon) for _, polygon, _ in drawn],
            facecolors=[shade for _, _, shade in drawn],
            edgecolors=GREY,
            linewidths=0.6,
        )
        axes.add_collection(blocks)

    def frame(self, axes: Axes, corners: Array) -> None:
        """Fits the picture to blocks and draws the axes of space beside them."""
        seen = self.seen(corners.reshape(-1, corners.shape[-1]))
        low, high = seen.min(axis=0), seen.max(axis=0)
        length = TRIAD * float((high - low).max())
        origin = low - np.array([1.2, 1.2]) * length
        for axis, name in enumerate("xyz"):
            tip = origin + length * self._axes[:, axis]
            axes.annotate(
                "", tip, origin, arrowprops={"arrowstyle": "->", "color": GREY, "lw": 1.0}
            )
            x, y = origin + 1.35 * (tip - origin)
            axes.text(x, y, name, fontsize=8.0, ha="center", va="center")
        axes.set_xlim(low[0] - 2.5 * length, high[0] + 0.5 * length)
        axes.set_ylim(low[1] - 2.5 * length, high[1] + 0.5 * length)
        axes.set_aspect("equal")
        axes.set_axis_off()
