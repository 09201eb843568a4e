"""The figure of blocks in space: how far they leave the plane of rocking."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, BLUE, DASHES, ORANGE, PURPLE
from warprock.figures.scales import at_least, plain
from warprock.figures.sheet import TIME_LABEL, headline, legend_below, style, subplots
from warprock.model.lanes import SpatialLanes
from warprock.model.response import Response
from warprock.model.words import lane_count_text
from warprock.running.case_run import CaseRun

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

ROWS = 4
"""Lanes that the figure shows at most, spread evenly over those of the histories."""
LETTERS = 58
"""Letters of a line above the widest panel: no name of a lane reaches the next one."""
CAP = 1.5
"""Rotation / slenderness angle at which curves are cut: a fallen block would squash the others."""


LEAST_RATIO, LEAST_YAW = 1e-2, 0.5
"""Least heights of panels, as a rotation ratio and as a yaw [deg]: less would be round-off."""


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
    of = f" of block {lanes.block_count}, the highest" if lanes.stacked else ""
    found = [_histories(lanes, int(numbers[at]), response, int(at)) for at in picked]
    with style():
        size = (10.5, 0.8 + 2.0 * len(picked) + extra)
        figure, grid = subplots(len(picked), 3, size, width_ratios=(2.2, 1.2, 1.4), sharex="col")
        for row, name, (in_plane, across, yaw) in zip(grid, names, found, strict=True):
            _draw_rotations(row[0], response.times, in_plane, across)
            row[0].set_title(name)
            row[1].plot(in_plane, across, color=BLUE, linewidth=0.7)
            row[1].plot(in_plane[:1], across[:1], "o", color=BLACK, markersize=4.0)
            row[1].set_ylabel("across the plane [-]")
            row[2].plot(response.times, yaw, color=PURPLE)
            row[2].set_ylabel("yaw [deg]")
            for axes, least in zip(row, (LEAST_RATIO, LEAST_RATIO, LEAST_YAW), strict=True):
                at_least(axes, least)
        grid[0, 1].set_title("path of the axis; dot: start")
        grid[0, 2].set_title("turn about the vertical")
        for axes, label in zip(grid[-1], (TIME_LABEL, "in the plane [-]", TIME_LABEL), strict=True):
            axes.set_xlabel(label)
        legend_below(figure, grid[0, 0], columns=2)
        title = _message(found, of)
        whole = lane_count_text(run.case.lane_count)
        shown = whole if len(picked) == run.case.lane_count else f"{len(picked)} of {whole}"
        about = (
            f"{run.case.title}; {run.response.engine}, {shown}; rotations are over the slenderness "
            "angle of their direction"
        )
        headline(figure, title, about)
    return Drawing("space", figure, title, f"{run.case.title}. {title}.")


def _message(found: list[tuple[Array, Array, Array]], of: str) -> str:
    """How far the blocks leave the plane of rocking, and how far they turn."""
    out = max(float(np.nanmax(np.abs(across), initial=0.0)) for _, across, _ in found)
    turn = max(float(np.nanmax(np.abs(yaw - yaw[0]), initial=0.0)) for _, _, yaw in found)
    across, about = (plain(float(f"{value:.2g}")) for value in (out, turn))
    return (
        f"Out of the plane of rocking the lanes shown rotate by up to {across} of the slenderness "
        f"angle{of}; about the vertical they turn by up to {about} deg"
    )


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
    axes.plot(times, in_plane, color=BLUE, linewidth=1.6, label="in the plane of rocking")
    look = {"color": ORANGE, "linestyle": DASHES[1], "linewidth": 1.2}
    axes.plot(times, across, label="across it", **look)
    axes.set_ylabel("rotation /\nslenderness angle [-]")
