"""What holds a block, and what supports its base, in the moving picture of a lane."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.figures.palette import BLUE, DARK, FALLEN, GREY, PALE
from warprock.model.tie_states import TieState
from warprock.running.scene_motion import SceneMotion
from warprock.running.scene_parts import Look, Part

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

FACES: dict[Look, dict[str, Any]] = {
    Look.WALL: {"facecolor": PALE, "edgecolor": GREY, "hatch": "//", "zorder": 1.2},
    Look.COLUMN: {"facecolor": BLUE, "edgecolor": "black", "zorder": 2.0},
    Look.BEAM: {"facecolor": GREY, "edgecolor": "black", "zorder": 2.1},
}
"""How quadrilaterals look."""
TIES: dict[TieState, dict[str, Any]] = {
    TieState.SLACK: {"linewidth": 1.0, "linestyle": (0, (4, 3)), "color": DARK},
    TieState.TAUT: {"linewidth": 2.0, "linestyle": "-", "color": "black"},
    TieState.YIELDING: {"linewidth": 3.0, "linestyle": "-", "color": FALLEN},
}
"""How ties look, but for broken ones, which are gone."""


class HeldView:
    """Artists of the parts that hold a block in the plane."""

    def __init__(self, axes: Axes, motion: SceneMotion, off: Array) -> None:
        """Makes them.

        Args:
            axes: Where they are drawn.
            motion: The lane.
            off: What the view goes along with [m], shape [sample, 3].
        """
        self._parts = motion.parts
        self._places = [motion.places_of(part) - off[:, None, [0, 2]] for part in motion.parts]
        self.artists = [_artist(axes, part) for part in self._parts]

    @property
    def ends(self) -> Array:
        """All places where they come to, along x and z [m], shape [place, 2]."""
        return np.concatenate([np.empty((0, 2)), *(p.reshape(-1, 2) for p in self._places)])

    def show(self, sample: int) -> None:
        """Puts them where they are at a sample."""
        for part, places, artist in zip(self._parts, self._places, self.artists, strict=True):
            points = places[sample]
            if part.look in FACES:
                artist.set_xy(points)
            elif part.look is Look.LOAD:
                artist.set_positions(points[0], points[1])
            else:
                artist.set_data(points[:, 0], points[:, 1])
            if part.states is not None:
                state = TieState(part.states[sample])
                artist.set_visible(state is not TieState.BROKEN)
                artist.set(**TIES.get(state, {}))


def _artist(axes: Axes, part: Part) -> Any:
    """What draws a part, which is not yet in its place."""
    from matplotlib.patches import FancyArrowPatch, Polygon

    if part.look in FACES:
        return axes.add_patch(Polygon(np.zeros((4, 2)), linewidth=0.8, **FACES[part.look]))
    if part.look is Look.LOAD:
        style: dict[str, Any] = {
            "arrowstyle": "-|>",
            "mutation_scale": 14.0,
            "shrinkA": 0.0,
            "shrinkB": 0.0,
        }
        look: dict[str, Any] = {"color": FALLEN, "linewidth": 2.0, "zorder": 3.0}
        return axes.add_patch(FancyArrowPatch((0.0, 0.0), (1.0, 1.0), **style, **look))
    width, order = (4.0, 1.3) if part.look is Look.ANCHOR else (2.0, 2.5)
    return axes.plot([], [], color=DARK, linewidth=width, zorder=order, solid_capstyle="butt")[0]
