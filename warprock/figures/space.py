"""The figure of blocks in space: how far they leave the plane of rocking."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLUE, ORANGE, PURPLE
from warprock.figures.sheet import TIME_LABEL, headline, style, subplots
from warprock.model.lanes import SpatialLanes
from warprock.model.response import Response
from warprock.run.case_run import CaseRun

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

ROWS = 4
"""Lanes that the figure shows at most, spread evenly over those of the histories."""
LETTERS = 58
"""Letters of a line above the widest panel: no name of a lane reaches the next one."""
CAP = 1.5
"""Rotation / slenderness angle at which curves are cut: a fallen block would squash the others."""


def draw_space(
    run: CaseRun,
    numbers: npt.NDArray[np.intp],
    titles: list[str],
    response: Response,
) -> Drawing:
    """Rotations in and across the plane of rocking, the path of the axis, and the yaw.

    Of a stack the highest block is drawn.

    Args:
        run: The run.
        numbers: Numbers of the lanes, shape [row].
        titles: Their names.
        response: Their histories.
    """
    lanes = run.lane_set.lanes
    assert isinstance(lanes, SpatialLanes)
    picked = np.unique(np.linspace(0, len(numbers) - 1, min(ROWS, len(numbers))).astype(np.intp))
    names = [textwrap.fill(titles[at] or f"lane {numbers[at]}", LETTERS) for at in picked]
    extra = 0.17 * sum(name.count("\n") for name in names)
    block = f" of block {lanes.block_count}, the highest" if lanes.stacked else ""
    with style():
        figure, grid = subplots(
            len(picked),
            3,
            (10.5, 1.1 + 2.0 * len(picked) + extra),
            width_ratios=(2.2, 1.0, 1.4),
            sharex="col",
        )
        for row, name, at in zip(grid, names, picked, strict=True):
            in_plane, across, yaw = _histories(lanes, int(numbers[at]), response, int(at))
            _draw_rotations(row[0], response.times, in_plane, across)
            row[0].set_title(name, loc="left")
            row[1].plot(in_plane, across, color=BLUE, linewidth=0.7)
            row[1].set_ylabel("across the plane [-]")
            row[2].plot(response.times, yaw, color=PURPLE, linewidth=0.9)
            row[2].set_ylabel("yaw [deg]")
        grid[0, 1].set_title("path of the axis", loc="left")
        grid[0, 2].set_title("turn about the vertical", loc="left")
        grid[-1, 0].set_xlabel(TIME_LABEL)
        grid[-1, 1].set_xlabel("in the plane [-]")
        grid[-1, 2].set_xlabel(TIME_LABEL)
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower left", ncols=2, frameon=False)
        title = f"{run.case.title}: motion out of the plane of rocking{block}"
        about = f"{len(picked)} of {len(numbers)} lanes"
        headline(figure, title, about)
    return Drawing("space", figure, title, f"{about}. {title}.")


def _histories(
    lanes: SpatialLanes, number: int, response: Response, at: int
) -> tuple[Array, Array, Array]:
    """Rotations / slenderness angles of their directions, and the yaw [deg], shape [sample]."""
    width, depth = lanes.face_width[number], lanes.face_depth[number]
    height = lanes.height[number]
    parts = [response[name][at] for name in ("rotation", "rotation_across", "yaw")]
    if lanes.stacked:
        width, depth, height = width[-1], depth[-1], height[-1]
        parts = [part[-1] for part in parts]
    along, across = np.arctan2(width, height), np.arctan2(depth, height)
    cut = (np.where(np.abs(p) > CAP, np.nan, p) for p in (parts[0] / along, parts[1] / across))
    in_plane, out_of_plane = cut
    return in_plane, out_of_plane, np.rad2deg(parts[2])


def _draw_rotations(axes: Axes, times: Array, in_plane: Array, across: Array) -> None:
    axes.plot(times, in_plane, color=BLUE, linewidth=0.9, label="in the plane of rocking")
    axes.plot(times, across, color=ORANGE, linewidth=0.9, label="across it")
    axes.set_ylabel("rotation /\nslenderness angle [-]")
