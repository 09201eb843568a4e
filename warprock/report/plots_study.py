"""The sensitivity study: what a knob does to the error, and what it costs."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

from warprock.report.plots import BLUE, FIGURE_TITLE, RED, drawing, legend_below, save

MARKS: dict[str, tuple[str, str]] = {"impulse": (RED, "^"), "direct": (BLUE, "v")}
"""Colour and marker of every engine."""
ERRORS = (("error_5s_ratio", "first 5 s", True), ("error_run_ratio", "whole run (20 s)", False))
"""Column, name, and whether its marks are filled."""


def draw_study(path: pathlib.Path, rows: Sequence[Mapping[str, Any]]) -> pathlib.Path:
    """Errors above, CPU time below, a column of panels a knob.

    Args:
        path: File to write.
        rows: Those of `reproduce_study.run_study`; the larger error of the lanes is drawn.
    """
    knobs = list(dict.fromkeys((row["knob"], row["knob_title"]) for row in rows))
    with drawing() as plt:
        figure, grid = plt.subplots(
            2,
            len(knobs),
            figsize=(2.6 * len(knobs) + 0.4, 5.6),
            sharex="col",
            sharey="row",
            layout="constrained",
            squeeze=False,
        )
        figure.suptitle(
            "Free rocking of B0, one knob of Table 2 at a time; the others stay at 240 frames a "
            "second, 200 sub-steps (*: 20), a margin of 1e-6 m\nand 10 sweeps. Error against "
            "Housner, the larger of both heights, and CPU time. `direct` has no margin and no "
            "sweeps.",
            **FIGURE_TITLE,
        )
        for column, (knob, name) in enumerate(knobs):
            mine = [row for row in rows if row["knob"] == knob]
            _draw_knob(grid[0, column], grid[1, column], mine)
            grid[1, column].set_xlabel(name)
        grid[0, 0].set_ylabel("largest |rotation - Housner's| /\nslenderness angle [-]")
        grid[1, 0].set_ylabel("CPU time for 20 s of one\nblock on one core [s]")
        legend_below(figure, grid[0, 0], columns=2)
        return save(figure, path)


def _draw_knob(upper: Any, lower: Any, rows: Sequence[Mapping[str, Any]]) -> None:
    values = sorted({row["value"] for row in rows})
    for engine in dict.fromkeys(row["source"] for row in rows):
        color, marker = MARKS[engine]
        mine = [[r for r in rows if (r["source"], r["value"]) == (engine, v)] for v in values]
        for column, name, filled in ERRORS:
            upper.plot(
                values,
                [max(row[column] for row in cells) for cells in mine],
                label=f"{engine}, {name}",
                color=color,
                marker=marker,
                markerfacecolor=color if filled else "white",
                linestyle="-" if filled else (0, (4, 2)),
                linewidth=1.2,
            )
        seconds = [cells[0]["cpu_s"] for cells in mine]
        lower.plot(values, seconds, color=color, marker=marker, linewidth=1.2)
    for axes in (upper, lower):
        axes.set_xscale("log")
        axes.set_yscale("log")
    lower.set_xticks(values, [f"{value:g}" for value in values])
    lower.minorticks_off()
