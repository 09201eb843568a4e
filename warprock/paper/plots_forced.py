"""Figures of forced rocking: histories (Figs. 7 and 10) and trends of the peaks (8 and 11)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.figures.drawing import Drawing
from warprock.figures.palette import DARK
from warprock.figures.sheet import (
    SHORT_ROTATION_LABEL,
    TIME_LABEL,
    headline,
    legend_below,
    panel_title,
    style,
    subplots,
)
from warprock.paper.plots_free import ENGINE_STYLES, PAPER_STYLES, READING_COLORS, apart, history
from warprock.paper.printed import PAPER_NAMES, READING_NAMES

Array = npt.NDArray[np.float64]
Window = tuple[float, float]

Panel = tuple[str, Mapping[str, Array]]
"""Title of an input and rotation ratio by source (an engine or a reading), shape [sample]."""


def draw_windows(
    stem: str,
    title: str,
    times: Array,
    panels: Sequence[Panel],
    windows: Sequence[Window],
    levels: Sequence[float] | None = None,
) -> Drawing:
    """Histories by engine, one row an input, one column a window of time.

    Args:
        stem: Name of the drawing.
        title: What is drawn.
        times: [s], shape [sample].
        panels: One a row, by engine.
        windows: First and last time of every column [s].
        levels: A rotation ratio to mark in every row, the inferred maximum of the test.
    """
    with style():
        figure, grid = _panel_grid(panels, windows)
        for row, (_name, ratios) in enumerate(panels):
            for axes, window in zip(grid[row], windows, strict=True):
                for engine, ratio in ratios.items():
                    history(axes, times, ratio, engine, window)
                if levels is not None:
                    _mark_level(axes, levels[row])
        legend_below(figure, grid[0, 0])
        (most, where), (part, at) = _largest(panels), _farthest(panels)
        said = (
            f"The block rotates furthest at {where}: {most:.2f} of the slenderness angle; impulse "
            f"and housner part by up to {part:.2g} ({at})"
        )
        headline(figure, said, title)
    return Drawing(stem, figure, said, f"{title}. {said}.")


def _panel_grid(panels: Sequence[Panel], windows: Sequence[Window]) -> tuple[Any, Any]:
    """A figure with a row of axes for each panel and a column for each window, all labelled."""
    rows, columns = len(panels), len(windows)
    figure: Any
    figure, grid = subplots(rows, columns, (9.6, 1.75 * rows + 0.9), sharex="col", sharey="row")
    # Space between columns: the last time of one does not touch the first of the next.
    figure.get_layout_engine().set(wspace=0.04)
    for row, (name, _ratios) in zip(grid, panels, strict=True):
        row[0].set_ylabel(SHORT_ROTATION_LABEL)
        panel_title(row[0], name)
    for axes, window in zip(grid[-1], windows, strict=True):
        axes.set_xlim(*window)
        axes.set_xlabel(TIME_LABEL)
    return figure, grid


def _largest(panels: Sequence[Panel]) -> tuple[float, str]:
    """The largest rotation ratio of Housner's block, and its input."""
    return max((float(np.nanmax(np.abs(ratios["housner"]))), name) for name, ratios in panels)


def _farthest(panels: Sequence[Panel]) -> tuple[float, str]:
    """The largest difference of an engine from Housner, and its input."""
    return max((apart(ratios), name) for name, ratios in panels)


def _mark_level(axes: Any, level: float) -> None:
    for sign, label in ((1.0, "test maximum, inferred from Table 7"), (-1.0, None)):
        axes.axhline(sign * level, color=DARK, linewidth=0.9, linestyle="-.", label=label)


def draw_readings(
    stem: str,
    title: str,
    times: Array,
    panels: Sequence[Panel],
    windows: Sequence[Window],
) -> Drawing:
    """Housner's histories of all readings over each other, one row an input.

    Args:
        stem: Name of the drawing.
        title: What is drawn.
        times: [s], shape [sample].
        panels: One a row, by reading.
        windows: First and last time of every column [s].
    """
    styles = dict(zip(READING_COLORS, ("-", (0, (5, 1.5)), (0, (1.5, 1.0))), strict=True))
    with style():
        figure, grid = _panel_grid(panels, windows)
        for row, (_name, ratios) in enumerate(panels):
            for axes, (first, last) in zip(grid[row], windows, strict=True):
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
        legend_below(figure, grid[0, 0], columns=3)
        spans = []
        for name, ratios in panels:
            largest = [float(np.nanmax(np.abs(ratio))) for ratio in ratios.values()]
            spans.append((max(largest) - min(largest), min(largest), max(largest), name))
        _, low, high, name = max(spans)
        said = (
            f"The reading of the base motion decides: at {name} the peak is {low:.2f} to "
            f"{high:.2f} of the slenderness angle"
        )
        headline(figure, said, title)
    return Drawing(stem, figure, said, f"{title}. {said}.")


def draw_trends(
    stem: str,
    title: str,
    peaks: pd.DataFrame,
    paper: Mapping[str, Array],
    axes_of_acceleration: Sequence[tuple[str, Array]],
) -> Drawing:
    """Peak rotation ratio over normalised base acceleration (Figs. 8 and 11).

    Args:
        stem: Name of the drawing.
        title: What is drawn.
        peaks: Rows with `reading`, `source` and `peak_rotation_ratio`, the six inputs of Table 4
            in order within each reading and source.
        paper: Six printed or inferred values by name; NaN where there is none.
        axes_of_acceleration: Label and normalised acceleration of the six inputs, a panel each.
    """
    with style():
        figure, grid = subplots(
            1,
            len(axes_of_acceleration),
            (9.6, 5.4),
            sharey=True,
        )
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
                look = {"markersize": 7.0} | PAPER_STYLES[name]
                axes.plot(
                    acceleration,
                    values,
                    linestyle="none",
                    markerfacecolor="none",
                    markeredgewidth=1.3,
                    label=f"paper: {PAPER_NAMES[name]}" if name in PAPER_NAMES else name,
                    zorder=5,
                    **look,
                )
            axes.set_xlabel(label)
            axes.set_ylim(bottom=0.0)
        grid[0, 0].set_ylabel("peak rotation / slenderness angle [-]")
        legend_below(figure, grid[0, 0], columns=2)
        said = _spread_of_readings(peaks)
        headline(figure, said, title)
    return Drawing(stem, figure, said, f"{title}. {said}.")


def _spread_of_readings(peaks: pd.DataFrame) -> str:
    """What the readings, and what the engines, do to the peaks."""
    every = peaks.assign(number=peaks.groupby(["reading", "source"]).cumcount())
    table = every.pivot(
        index=["number", "reading"], columns="source", values="peak_rotation_ratio"
    ).astype(float)
    engines = float((table.max(axis=1) - table.min(axis=1)).max())
    by_reading = table.mean(axis=1).unstack("reading")
    readings = float((by_reading.max(axis=1) - by_reading.min(axis=1)).max())
    return (
        f"The reading of the base motion moves a peak by up to {readings:.2g} of the slenderness "
        f"angle, the engine by up to {engines:.1g}"
    )
