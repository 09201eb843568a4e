"""Figures 12 to 15 of the paper and the collapse of the stack: which curves go on which panel."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.figures.drawing import Drawing
from warprock.paper import plots_stack, plots_stack_peaks
from warprock.paper.conflicts_stack import (
    CEILING,
    OVERTURNED,
    analytical_peaks,
    peaks_of,
    read_printed,
)
from warprock.paper.printed import BLOCKS, GEOMETRIES, PAPER_COLUMNS, paper_columns
from warprock.paper.runs import (
    COLLAPSE,
    PULSE_ENSEMBLE,
    SINE_ENSEMBLE,
    STACK_PULSE,
    STACK_SINE,
    PaperRuns,
)
from warprock.paper.stack_runs import (
    REFERENCE_ANGLE,
    Cells,
    cell_rows,
    cells_of,
    inferred_tests,
    input_keys,
    peak_table,
)

Array = npt.NDArray[np.float64]

CURVES = (
    ("two-block", "acceleration", "equal-depths"),
    ("event", "displacement", "low-top"),
    ("impulse", "displacement", "low-top"),
    ("dem", "displacement", "low-top"),
)
"""Engine, reading and geometry of the curves of a panel."""
PULSE_WINDOW, SINE_WINDOW = (0.0, 3.0), (0.0, 2.0)
"""Windows of time [s]; the paper's Fig. 14 shows two seconds."""


def _histories(
    runs: PaperRuns, case: str, name: str, title: str, window: tuple[float, float]
) -> list[Drawing]:
    responses = runs.case(case)
    inputs = responses.lane_set.inputs
    curves = {}
    for engine, reading, geometry in CURVES:
        lanes = np.flatnonzero(
            (inputs["reading"] == reading)
            & (inputs["geometry"] == geometry)
            & (inputs["edges"] == "chamfered")
        )
        curves[engine] = responses[engine]["rotation"][lanes] / REFERENCE_ANGLE
    times = responses[CURVES[0][0]].times
    names = [f"{f:g} Hz, {a:g} mm" for f, a in input_keys()]
    return plots_stack.draw_stack_histories(name, title, times, names, curves, window)


def figure12(runs: PaperRuns) -> list[Drawing]:
    """Histories of both blocks under one cycle of sine."""
    title = "Two stacked blocks under one cycle of sine"
    return _histories(runs, STACK_PULSE, "fig12", title, PULSE_WINDOW)


def figure14(runs: PaperRuns) -> list[Drawing]:
    """Histories of both blocks under continuous sine, its first two seconds."""
    title = "Two stacked blocks under continuous sine, the first two seconds"
    return _histories(runs, STACK_SINE, "fig14", title, SINE_WINDOW)


def _boxes(cells: Cells, block: str) -> dict[str, list[Array]]:
    """Peaks of the members that stayed up, by geometry and input in the order of Table 8."""
    return {
        geometry: [cells.standing_ratio(cells.place(geometry, key), block) for key in input_keys()]
        for geometry in GEOMETRIES
    }


def _engine_points(table: pd.DataFrame, block: str) -> dict[str, Array]:
    """Peaks without spread that stand beside the boxes."""
    points = {"two-block": analytical_peaks(table, block)}
    for engine in ("event", "impulse", "dem"):
        points[engine] = peaks_of(table, engine, "displacement", "low-top", block, "chamfered")
    return points


def _levels() -> tuple[Array, list[str]]:
    """Normalised accelerations as printed in Table 8, and what the axis says of each input."""
    level = paper_columns("table8")["normalised_acceleration"]
    names = [f"{x:.2f}\n{f:g} Hz\n{a:g} mm" for x, (f, a) in zip(level, input_keys(), strict=True)]
    return level, names


def figure13(runs: PaperRuns) -> list[Drawing]:
    """Peaks under one cycle of sine over normalised acceleration."""
    cells, table = cells_of(runs, PULSE_ENSEMBLE), peak_table(runs, STACK_PULSE)
    level, names = _levels()
    panels = [
        plots_stack_peaks.Panel(
            block,
            _boxes(cells, block),
            _engine_points(table, block),
            {f"paper: {column}": read_printed(name, column) for column in PAPER_COLUMNS},
        )
        for block, name in zip(BLOCKS[::-1], ("table9", "table10"), strict=True)
    ]
    title = "Largest rotations under one cycle of sine"
    return [plots_stack_peaks.draw_stack_peaks("fig13", title, level, names, panels)]


def _imply_tops(column: str) -> Array:
    """What Table 11's errors against 90 deg say that a source had at the top; NaN elsewhere."""
    keys = input_keys()
    left = CEILING * (1.0 - 1e-2 * read_printed("table11", column))
    return np.array([left[i] if key in OVERTURNED else np.nan for i, key in enumerate(keys)])


def figure15(runs: PaperRuns) -> list[Drawing]:
    """Peaks under continuous sine over normalised acceleration."""
    cells, table = cells_of(runs, SINE_ENSEMBLE), peak_table(runs, STACK_SINE)
    level, names = _levels()
    fallen = [i for i, key in enumerate(input_keys()) if key in OVERTURNED]
    panels = []
    for block, name in zip(BLOCKS[::-1], ("table11", "table12"), strict=True):
        marks = {}
        for route in inferred_tests(runs, name, block):
            # A test in which the top block fell has no rotation that compares with ours.
            marks[f"test, by {route.column}"] = route.values.copy()
            marks[f"test, by {route.column}"][fallen] = np.nan
        if block == "top":
            marks |= {f"implied: {c}": _imply_tops(c) for c in ("analytical", "bullet", "vortex")}
        boxes, points = _boxes(cells, block), _engine_points(table, block)
        panels.append(plots_stack_peaks.Panel(block, boxes, points, marks, fallen))
    title = "Largest rotations under 10 s of continuous sine"
    return [plots_stack_peaks.draw_stack_peaks("fig15", title, level, names, panels)]


def collapse(runs: PaperRuns) -> list[Drawing]:
    """Shares of collapses and largest rotations over friction and chamfer."""
    table = cell_rows(cells_of(runs, COLLAPSE), "top")
    return [plots_stack_peaks.draw_collapse("collapse", table)]
