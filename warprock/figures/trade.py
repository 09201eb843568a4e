"""What accuracy costs: error and CPU time of every engine's settings, a panel a scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, engine_marks
from warprock.figures.scales import logarithmic
from warprock.figures.sheet import headline, style, subplots
from warprock.settings.engines import EXACT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ERROR_LIMITS = (1e-8, 2.0)
"""Errors drawn; smaller and larger ones stand at the edge."""

COLUMNS = 3


def draw_trade(table: pd.DataFrame, scenes: Mapping[str, str], said: str) -> list[Drawing]:
    """Draws a trade table: error across, cost upwards, the front of those that can slide as a band.

    Args:
        table: Rows of `measure.trade.run_trade`.
        scenes: What each scene is.
        said: What it came to, in one line.

    Returns:
        One drawing.
    """
    names = list(dict.fromkeys(table["scene"]))
    columns = min(COLUMNS, len(names) + 1)
    rows = -(-(len(names) + 1) // columns)
    with style():
        size = (3.8 * columns, 3.6 * rows)
        figure, grid = subplots(rows, columns, size, sharex=True, sharey=True)
        panels = grid.ravel()
        for axes, name in zip(panels, names, strict=False):
            _draw_scene(axes, table[table["scene"] == name])
            axes.set_title(f"{name}: {_folded(scenes[name])}", fontsize=8.5)
            axes.tick_params(labelbottom=True, labelleft=True)
        for axes in panels[len(names) :]:
            axes.axis("off")
        for row in grid:
            row[0].set_ylabel("CPU seconds for a simulated second\nof one block, one worker")
        for axes in panels[max(0, len(names) - columns) : len(names)]:
            axes.set_xlabel("largest error / slenderness angle [-]")
        _legend(panels[len(names)], table)
        about = (
            "What accuracy costs, a mark a setting: to the left is more accurate, further down is "
            "faster"
        )
        headline(figure, said, about)
    return [Drawing("trade", figure, said, f"{about}. {said}.")]


def _drawn_errors(table: pd.DataFrame) -> npt.NDArray[np.float64]:
    return np.asarray(np.clip(table["error_max"].to_numpy(float), *ERROR_LIMITS))


def _draw_scene(axes: Axes, table: pd.DataFrame) -> None:
    """All rows of a scene; a line is the front of an engine, the band that of those that slide."""
    logarithmic(axes.xaxis)
    logarithmic(axes.yaxis)
    axes.set_xlim(ERROR_LIMITS[0] / 1.6, ERROR_LIMITS[1] * 1.6)
    front = _front(table[~table["engine"].isin(EXACT)])
    if len(front):
        band: dict[str, Any] = {"color": "#CCCCCC", "linewidth": 6.0, "zorder": 1}
        axes.plot(*_extended(front), solid_capstyle="butt", drawstyle="steps-post", **band)
    for engine, group in table.groupby("engine", sort=False):
        color, marker = engine_marks(str(engine))
        axes.plot(*_points(_front(group)), color=color, linewidth=0.9, zorder=2)
        for precision, part in group.groupby("precision"):
            axes.plot(
                _drawn_errors(part),
                part["cpu_s_per_simulated_s"],
                linestyle="none",
                marker=marker,
                markersize=5.0,
                color=color,
                markerfacecolor=color if precision == "float64" else "white",
                markeredgewidth=0.9,
                zorder=3,
            )


def _front(table: pd.DataFrame) -> pd.DataFrame:
    """Rows that no other one beats in both error and cost, the most accurate first."""
    ordered = table.sort_values(["error_max", "cpu_s_per_simulated_s"])
    costs = ordered["cpu_s_per_simulated_s"]
    return ordered[costs < costs.cummin().shift(1, fill_value=np.inf)]


def _points(front: pd.DataFrame) -> tuple[Any, Any]:
    return _drawn_errors(front), front["cpu_s_per_simulated_s"].to_numpy(float)


def _extended(front: pd.DataFrame) -> tuple[Any, Any]:
    """A front on to the right edge: what meets a small error meets a large one."""
    errors, costs = _points(front)
    return np.append(errors, ERROR_LIMITS[1] * 1.6), np.append(costs, costs[-1])


def _folded(text: str) -> str:
    """A text in two lines, where it has a comma to break behind."""
    head, comma, tail = text.partition(", ")
    return f"{head}{comma.strip()}\n{tail}" if comma else text


def _legend(axes: Axes, table: pd.DataFrame) -> None:
    """Colours and markers, in a panel of their own."""
    from matplotlib.lines import Line2D

    handles = []
    for engine in dict.fromkeys(table["engine"]):
        color, marker = engine_marks(engine)
        style: dict[str, Any] = {"color": color, "marker": marker, "markersize": 6.0}
        handles.append(Line2D([], [], label=f"{engine} and its own front", linewidth=0.9, **style))
    hollow: dict[str, Any] = {"color": BLACK, "marker": "o", "linestyle": "none"}
    handles += [
        Line2D([], [], label="filled: float64", **hollow),
        Line2D([], [], label="hollow: float32", markerfacecolor="white", **hollow),
        Line2D([], [], label="the cheapest whose blocks can slide", color="#CCCCCC", linewidth=6.0),
        Line2D([], [], label="left edge: 10⁻⁸ or less", linestyle="none"),
    ]
    axes.legend(handles=handles, loc="upper left")
