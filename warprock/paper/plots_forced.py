"""Figures of forced rocking: histories (Figs. 7 and 10) and trends of the peaks (8 and 11)."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.figures.plots import (
    ENGINE_STYLES,
    FIGURE_TITLE,
    SHORT_ROTATION_LABEL,
    TIME_LABEL,
    drawing,
    history,
    legend_below,
    save,
)
from warprock.paper.plots_free import PAPER_STYLES, READING_COLORS
from warprock.paper.printed import PAPER_NAMES, READING_NAMES

Array = npt.NDArray[np.float64]
Window = tuple[float, float]

Panel = tuple[str, Mapping[str, Array]]
"""Title of an input and rotation ratio by source (an engine or a reading), shape [sample]."""


def draw_windows(
    path: pathlib.Path,
    title: str,
    times: Array,
    panels: Sequence[Panel],
    windows: Sequence[Window],
    levels: Sequence[float] | None = None,
) -> pathlib.Path:
    """Histories by engine, one row an input, one column a window of time.

    Args:
        path: File to write.
        title: Title of the figure.
        times: [s], shape [sample].
        panels: One a row, by engine.
        windows: First and last time of every column [s].
        levels: A rotation ratio to mark in every row, the inferred maximum of the test.
    """
    with drawing() as plt:
        figure, grid = plt.subplots(
            len(panels),
            len(windows),
            figsize=(9.6, 1.75 * len(panels) + 0.9),
            sharex="col",
            sharey="row",
            layout="constrained",
            squeeze=False,
        )
        figure.suptitle(title, **FIGURE_TITLE)
        figure.get_layout_engine().set(wspace=0.04)
        for row, (name, ratios) in enumerate(panels):
            for column, window in enumerate(windows):
                axes = grid[row, column]
                for engine, ratio in ratios.items():
                    history(axes, times, ratio, engine, window)
                if levels is not None:
                    _mark_level(axes, levels[row])
                axes.set_xlim(*window)
                if column == 0:
                    axes.set_ylabel(SHORT_ROTATION_LABEL)
                    axes.set_title(name, loc="left")
        for axes in grid[-1]:
            axes.set_xlabel(TIME_LABEL)
        legend_below(figure, grid[0, 0])
        return save(figure, path)


def _mark_level(axes: Any, level: float) -> None:
    for sign, label in ((1.0, "test maximum, inferred from Table 7"), (-1.0, None)):
        axes.axhline(sign * level, color="#777777", linewidth=0.9, linestyle="-.", label=label)


def draw_readings(
    path: pathlib.Path,
    title: str,
    times: Array,
    panels: Sequence[Panel],
    windows: Sequence[Window],
) -> pathlib.Path:
    """Housner's histories of all readings over each other, one row an input.

    Args:
        path: File to write.
        title: Title of the figure.
        times: [s], shape [sample].
        panels: One a row, by reading.
        windows: First and last time of every column [s].
    """
    styles = dict(zip(READING_COLORS, ("-", (0, (5, 1.5)), (0, (1.5, 1.0))), strict=True))
    with drawing() as plt:
        figure, grid = plt.subplots(
            len(panels),
            len(windows),
            figsize=(9.6, 1.75 * len(panels) + 0.9),
            sharex="col",
            sharey="row",
            layout="constrained",
            squeeze=False,
        )
        figure.suptitle(title, **FIGURE_TITLE)
        figure.get_layout_engine().set(wspace=0.04)
        for row, (name, ratios) in enumerate(panels):
            for column, (first, last) in enumerate(windows):
                axes = grid[row, column]
                shown = (times >= first) & (times <= last)
                for reading, ratio in ratios.items():
                    axes.plot(
                        times[shown],
                        ratio[shown],
                        color=READING_COLORS[reading],
                        linestyle=styles[reading],
                        linewidth=1.3,
                        label=READING_NAMES[reading],
                    )
                axes.set_xlim(first, last)
                if column == 0:
                    axes.set_ylabel(SHORT_ROTATION_LABEL)
                    axes.set_title(name, loc="left")
        for axes in grid[-1]:
            axes.set_xlabel(TIME_LABEL)
        legend_below(figure, grid[0, 0], columns=3)
        return save(figure, path)


def draw_trends(
    path: pathlib.Path,
    title: str,
    peaks: pd.DataFrame,
    paper: Mapping[str, Array],
    axes_of_acceleration: Sequence[tuple[str, Array]],
) -> pathlib.Path:
    """Peak rotation ratio over normalised base acceleration (Figs. 8 and 11).

    Args:
        path: File to write.
        title: Title of the figure.
        peaks: Rows with `reading`, `source` and `peak_rotation_ratio`, the six inputs of Table 4
            in order within each reading and source.
        paper: Six printed or inferred values by name; NaN where there is none.
        axes_of_acceleration: Label and normalised acceleration of the six inputs, a panel each.
    """
    with drawing() as plt:
        figure, grid = plt.subplots(
            1,
            len(axes_of_acceleration),
            figsize=(9.6, 5.4),
            sharey=True,
            layout="constrained",
            squeeze=False,
        )
        figure.suptitle(title, **FIGURE_TITLE)
        for axes, (label, acceleration) in zip(grid[0], axes_of_acceleration, strict=True):
            order = np.argsort(acceleration)
            for (reading, source), rows in peaks.groupby(["reading", "source"], sort=False):
                axes.plot(
                    acceleration[order],
                    rows["peak_rotation_ratio"].to_numpy(dtype=float)[order],
                    label=f"{source}, {READING_NAMES[str(reading)]}",
                    color=READING_COLORS[str(reading)],
                    linestyle=ENGINE_STYLES[str(source)]["linestyle"],
                    linewidth=1.5,
                )
            for name, values in paper.items():
                style = {"markersize": 7.0} | PAPER_STYLES[name]
                axes.plot(
                    acceleration,
                    values,
                    linestyle="none",
                    markerfacecolor="none",
                    markeredgewidth=1.3,
                    label=f"paper: {PAPER_NAMES[name]}" if name in PAPER_NAMES else name,
                    zorder=5,
                    **style,
                )
            axes.set_xlabel(label)
            axes.set_ylim(bottom=0.0)
        grid[0, 0].set_ylabel("peak rotation / slenderness angle [-]")
        legend_below(figure, grid[0, 0], columns=2)
        return save(figure, path)
