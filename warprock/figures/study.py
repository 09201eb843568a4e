"""A study of settings: rotations, what a setting does to the error, and what it costs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.figures.drawing import Drawing
from warprock.figures.palette import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    engine_marks,
)
from warprock.figures.scales import logarithmic, plain
from warprock.figures.sheet import (
    SHORT_ROTATION_LABEL,
    TIME_LABEL,
    headline,
    legend_below,
    panel_title,
    style,
    subplots,
)
from warprock.tables.study import setting_name

Array = npt.NDArray[np.float64]

_COLORS = (VERMILION, BLUE, GREEN, ORANGE, PURPLE, SKY)
_DASHES: tuple[Any, ...] = ((0, (4, 2)), (0, (1.5, 1.2)), (0, (6, 1.5, 1.5, 1.5)), "-")
ERRORS = (("error_5s_ratio", "first 5 s", True), ("error_run_ratio", "whole run", False))
"""Column, name, and whether its marks are filled."""
_LEAST = 1e-6
"""Smallest difference from Housner's that is drawn."""
LATE = 0.6
"""Part of a run after which it is enlarged: there the settings differ most."""


def draw_study(
    name: str, rows: Sequence[Mapping[str, Any]], title: str, duration: float, said: str
) -> Drawing:
    """Errors above, CPU time below, a column of panels a setting.

    Args:
        name: Name of the drawing.
        rows: Those of `study.StudyRun.table`; the larger error of the lanes is drawn.
        title: Title of the case.
        duration: Length of the run [s].
        said: What it says: the first sentence of its finding.
    """
    settings = list(dict.fromkeys((row["setting"], row["unit"]) for row in rows))
    engines = list(dict.fromkeys(row["engine"] for row in rows))
    with style():
        size = (max(2.4 * len(settings) + 0.6, 5.0), 5.2)
        figure, grid = subplots(2, len(settings), size, sharex="col", sharey="row")
        for (setting, unit), upper, lower in zip(settings, *grid, strict=True):
            mine = [row for row in rows if row["setting"] == setting]
            _draw_setting(upper, lower, mine, engines)
            lower.set_xlabel(setting_name(setting, unit))
        grid[0, 0].set_ylabel("largest |rotation - Housner's| /\nslenderness angle [-]")
        grid[1, 0].set_ylabel(f"CPU time for {duration:g} s of\none lane on one core [s]")
        legend_below(figure, grid[0, 0], columns=2)
        about = (
            f"{title}\nAll other settings stay where the case has them (dotted line). Error "
            "against Housner, the largest of the lanes where he holds; CPU time"
        )
        headline(figure, said, about)
    return Drawing(name, figure, said, f"{title}. {said}.")


def _draw_setting(
    upper: Any, lower: Any, rows: Sequence[Mapping[str, Any]], engines: Sequence[str]
) -> None:
    values = sorted({row["value"] for row in rows})
    for engine in engines:
        color, marker = engine_marks(engine)
        runs: dict[float, list[Mapping[str, Any]]] = {}
        for row in rows:
            if row["engine"] == engine:
                runs.setdefault(row["value"], []).append(row)
        for column, name, filled in ERRORS:
            upper.plot(
                sorted(runs),
                [_largest(runs[value], column) for value in sorted(runs)],
                label=f"{engine}, {name}",
                color=color,
                marker=marker,
                markerfacecolor=color if filled else "white",
                linestyle="-" if filled else (0, (4, 2)),
                linewidth=1.2,
            )
        seconds = [runs[value][0]["cpu_s"] for value in sorted(runs)]
        lower.plot(sorted(runs), seconds, color=color, marker=marker, linewidth=1.2)
    for axes in (upper, lower):
        for own in {row["value"] for row in rows if row["baseline"]}:
            axes.axvline(own, color=GREY, linestyle=":", linewidth=1.0, zorder=1)
        if values[0] > 0.0:
            logarithmic(axes.xaxis)
        logarithmic(axes.yaxis)
    lower.set_xticks(values, [plain(value) for value in values])
    lower.set_xticks([], minor=True)


def _largest(rows: Sequence[Mapping[str, Any]], column: str) -> float:
    """Largest number of a column where Housner holds; NaN, which is not drawn, without one."""
    known = [float(row[column]) for row in rows if row["holds"] and row[column] is not None]
    return max((value for value in known if math.isfinite(value)), default=math.nan)


def draw_histories(
    name: str,
    title: str,
    times: Array,
    reference: Array,
    histories: Mapping[tuple[str, str, float], Array],
) -> Drawing:
    """Rotation of one lane over time, a row of panels an engine and setting (Fig. 4b to i).

    The last column is the largest difference from Housner's so far, which lines on top of one
    another hide.

    Args:
        name: Name of the drawing.
        title: What is drawn.
        times: [s], shape [sample].
        reference: Housner's rotation / slenderness angle, shape [sample].
        histories: Engine, setting and value -> the same of that run.
    """
    panels: dict[tuple[str, str], list[tuple[float, Array]]] = {}
    for (engine, setting, value), ratio in histories.items():
        panels.setdefault((engine, setting), []).append((value, ratio))
    late = float(times[0] + LATE * (times[-1] - times[0]))
    windows = ((float(times[0]), float(times[-1])), (late, float(times[-1])))
    with style():
        size = (12.6, 1.9 * len(panels) + 0.3)
        figure, grid = subplots(len(panels), len(windows) + 1, size, sharex="col")
        for row, ((engine, setting), curves) in zip(grid, panels.items(), strict=True):
            for axes, window in zip(row[:-1], windows, strict=True):
                _draw_window(axes, window, times, reference, curves)
            for number, (_, ratio) in enumerate(curves):
                away = np.maximum.accumulate(np.abs(ratio - reference))
                row[-1].plot(times, np.where(away > 0.0, away, np.nan), **_line(number))
            logarithmic(row[-1].yaxis)
            row[-1].set_ylim(_LEAST, 1.0)
            row[-1].set_xlim(*windows[0])
            row[-1].set_ylabel("largest |difference|\nso far [-]")
            panel_title(row[0], f"{engine}, {setting}")
            row[0].set_ylabel(SHORT_ROTATION_LABEL)
            handles, names = row[0].get_legend_handles_labels()
            row[-1].legend(handles, names, loc="center left", bbox_to_anchor=(1.0, 0.5))
        for axes in grid[-1]:
            axes.set_xlabel(TIME_LABEL)
        farthest = {key: float(np.abs(ratio - reference).max()) for key, ratio in histories.items()}
        (engine, setting, value), most = max(farthest.items(), key=lambda item: item[1])
        said = (
            f"{engine} with {setting} {plain(value)} strays furthest from Housner: by "
            f"{most:.2g} of the slenderness angle"
        )
        headline(figure, said, title)
    return Drawing(name, figure, said, f"{title}. {said}.")


def _draw_window(
    axes: Any,
    window: tuple[float, float],
    times: Array,
    reference: Array,
    curves: Sequence[tuple[float, Array]],
) -> None:
    """Curves within a window of time [s], Housner's wide and grey below them."""
    shown = (times >= window[0]) & (times <= window[1])
    axes.plot(times[shown], reference[shown], label="housner", color=GREY, linewidth=2.2)
    for number, (value, ratio) in enumerate(curves):
        axes.plot(times[shown], ratio[shown], label=plain(value), **_line(number))
    axes.set_xlim(*window)


def _line(number: int) -> dict[str, Any]:
    """Style of the curve of a value by its number in the list."""
    return {
        "color": _COLORS[number % len(_COLORS)],
        "linestyle": _DASHES[number % len(_DASHES)],
        "linewidth": 1.1,
    }
