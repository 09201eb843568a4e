"""The picture of a block on its base, and how far it leans before it falls."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.case.lanes import LaneSet
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, BLUE, DARK, GREY, PALE, VERMILION
from warprock.figures.sheet import style, subplots

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

SIZE = (3.1, 4.0)
"""Width and height [inch]."""


def draw_object(lane_set: LaneSet, title: str) -> Drawing:
    """Draws the block of the first lane in its plane: as it stands, and at the edge of falling.

    Args:
        lane_set: The lanes.
        title: What it is.
    """
    lanes = lane_set.lanes.take(np.array([0]))
    width, height = float(lanes.width[0]), float(lanes.height[0])
    if lanes.body is None:
        outline = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * [width, height]
        base, centre = np.array([-0.5 * width, 0.5 * width]), 0.5 * height
    else:
        outline = np.asarray(lanes.body.outline(lanes.height)[0])
        outline = outline[:, [0, -1]]
        base, centre = np.asarray(lanes.body.base_ends[0]), float(lanes.body.centre_height[0])
    corners = outline + np.array([0.0, centre])
    lean = math.atan2(float(base[1]), centre)
    with style():
        figure, panels = subplots(1, 1, SIZE)
        axes = panels[0, 0]
        _draw(axes, corners, float(base[1]), centre, lean)
        axes.set_aspect("equal")
        axes.set(xlabel="[m]", ylabel="height [m]")
        axes.locator_params(axis="x", nbins=3)
    angle = f"{math.degrees(lean):.3g} degrees"
    alt = f"{title}: {width:.3g} m wide and {height:.3g} m high; it falls where it leans by {angle}"
    return Drawing("object", figure, title, f"{alt}.")


def _draw(axes: Axes, corners: Array, edge: float, centre: float, lean: float) -> None:
    """The block, its centre of mass, and where it is at the edge of falling."""
    turn = np.array([[math.cos(lean), math.sin(lean)], [-math.sin(lean), math.cos(lean)]])
    pivot = np.array([edge, 0.0])
    tilted = (corners - pivot) @ turn.T + pivot
    axes.fill(*tilted.T, facecolor="none", edgecolor=GREY, linestyle="--", linewidth=1.0)
    axes.fill(*corners.T, facecolor=PALE, edgecolor=BLACK, linewidth=1.2)
    axes.plot(0.0, centre, "+", color=BLUE, markersize=11, markeredgewidth=2.0)
    axes.plot(*pivot, "o", color=VERMILION, markersize=4)
    reach = np.concatenate([corners, tilted])[:, 0]
    ends = reach.min() - 0.15, reach.max() + 0.15
    axes.plot(ends, (0.0, 0.0), color=DARK, linewidth=2.0)
    axes.set_xlim(*ends)
    axes.set_ylim(-0.04 * corners[:, 1].max(), 1.08 * float(np.max(tilted[:, 1])))
