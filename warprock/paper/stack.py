"""Section 6 of the paper, two stacked blocks: its tables, recomputed beside what it prints.

One number for an input of a stack can be neither right nor wrong, so that every printed number is
also placed in the distribution of an ensemble.
"""

from __future__ import annotations

import itertools
import pathlib
from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.figures.drawing import Drawing, write_drawings
from warprock.paper import stack_figures as figures
from warprock.paper.conflicts_stack import OVERTURNED, StackEvidence
from warprock.paper.printed import (
    BLOCKS,
    GEOMETRIES,
    PAPER_COLUMNS,
    REFERENCE_DEGREES,
    as_number,
    paper_columns,
)
from warprock.paper.runs import (
    COLLAPSE,
    ENSEMBLE_ENGINE,
    PULSE_ENSEMBLE,
    SINE_ENSEMBLE,
    STACK_ENGINES_OF,
    STACK_PULSE,
    STACK_SINE,
    PaperRuns,
    Reproduction,
    Row,
    write_rows,
    written_number,
)
from warprock.paper.stack_runs import (
    INPUTS,
    cell_rows,
    cells_of,
    inferred_tests,
    peak_table,
)

Array = npt.NDArray[np.float64]

ENSEMBLE = f"{ENSEMBLE_ENGINE}-ensemble"
"""Source of the rows of an ensemble; their peak is the median."""
BLOCK_OF = {"table9": "top", "table10": "bottom", "table11": "top", "table12": "bottom"}
LOWER_FRICTION = "contact.friction=0.6"
"""Friction at which the velocity steps slip further, to see how much that matters."""


def _row(
    target: str, block: str, source: str, inputs: Mapping[Any, Any], ratio: float | None
) -> Row:
    return {
        "target": target,
        "frequency_hz": written_number(inputs["frequency_hz"]),
        "amplitude_mm": written_number(inputs["amplitude_mm"]),
        "reading": inputs["reading"],
        "source": source,
        "peak_rotation_ratio": ratio,
        "block": block,
        "geometry": inputs.get("geometry"),
        "edges": inputs.get("edges"),
    }


_MORE = ("peak_slide_mm", "outcome")


def _engine_rows(target: str, runs: PaperRuns, case: str, block: str) -> list[Row]:
    """Peaks of the engines, one row a lane and engine."""
    table = peak_table(runs, case)
    found = table[table["block"] == block].to_dict("records")
    return [
        _row(target, block, row["source"], row, row["peak_rotation_ratio"])
        | {name: row[name] for name in _MORE}
        for row in found
    ]


_DISTRIBUTION = (
    *("members", "collapsed_share", "collapsed_low", "collapsed_high"),
    *("low_5", "quartile_low", "quartile_high", "high_95"),
)
"""Columns of `cell_rows` that the rows of an ensemble carry beside their median."""


def _ensemble_rows(target: str, runs: PaperRuns, case: str, block: str) -> list[Row]:
    """The distribution of every cell, one row a cell."""
    found = cell_rows(cells_of(runs, case), block).to_dict("records")
    reading = {"reading": "displacement", "edges": "chamfered"}
    return [
        _row(target, block, ENSEMBLE, reading | row, row["median"])
        | {name: row[name] for name in _DISTRIBUTION}
        for row in found
    ]


def _places(runs: PaperRuns, case: str, block: str, inputs: Mapping[Any, Any], value: float) -> Row:
    """The percentile of a number in the ensemble of each geometry; None where there is none."""
    cells = cells_of(runs, case)
    key = (float(inputs["frequency_hz"]), float(inputs["amplitude_mm"]))
    return {
        f"percentile_{geometry}": None
        if np.isnan(value)
        else cells.percentile(cells.place(geometry, key), block, value)
        for geometry in GEOMETRIES
    }


def _pulse_table(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
    """Tables 9 and 10: peaks under one cycle of sine."""
    block = BLOCK_OF[target]
    rows = _engine_rows(target, runs, STACK_PULSE, block)
    rows += _ensemble_rows(target, runs, PULSE_ENSEMBLE, block)
    for printed in paper_columns(target).records:
        for name in PAPER_COLUMNS:
            value = float(printed[name])
            inputs = printed | {"reading": "as printed"}
            ratio = None if np.isnan(value) else value
            places = _places(runs, PULSE_ENSEMBLE, block, printed, value)
            rows.append(_row(target, block, f"paper-{name}", inputs, ratio) | places)
    return Reproduction(rows, [write_rows(rows, folder / f"{target}.csv")])


def _sine_table(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
    """Tables 11 and 12: errors under continuous sine, and the tests that they imply."""
    block = BLOCK_OF[target]
    rows = _engine_rows(target, runs, STACK_SINE, block)
    rows += _ensemble_rows(target, runs, SINE_ENSEMBLE, block)
    tests = inferred_tests(runs, target, block)
    for index, printed in enumerate(paper_columns(target).records):
        key = (float(printed["frequency_hz"]), float(printed["amplitude_mm"]))
        fell = block == "top" and key in OVERTURNED
        for name in PAPER_COLUMNS:
            row = _row(target, block, f"paper-{name}", printed | {"reading": "as printed"}, None)
            number = as_number(printed[name])
            row["abs_error_pct"] = None if np.isnan(number) else number
            if printed[name] == "collapsed":
                row["why"] = "printed as collapsed"
            elif fell:
                row["why"] = f"against 90 deg / {REFERENCE_DEGREES} deg: the block fell in the test"
            rows.append(row)
        for route in tests:
            value = float(route.values[index])
            inputs = printed | {"reading": route.reading, "geometry": route.geometry}
            ratio = None if np.isnan(value) else value
            row = _row(target, block, "inferred-experiment", inputs, ratio)
            row |= _places(runs, SINE_ENSEMBLE, block, printed, value)
            row["why"] = route.why(index)
            rows.append(row)
    return Reproduction(rows, [write_rows(rows, folder / f"{target}.csv")])


def _collapse(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
    """Shares of members that collapse, over friction, chamfer and amplitude."""
    cells = cells_of(runs, COLLAPSE)
    rows = []
    for block in BLOCKS:
        for cell in cell_rows(cells, block).to_dict("records"):
            inputs = cell | {"reading": "displacement", "geometry": "printed"}
            rows.append(
                _row(target, block, ENSEMBLE, inputs, cell["median"])
                | {name: cell[name] for name in _DISTRIBUTION}
                | {
                    "friction": cell["friction_1"],
                    "chamfer_mm": cell["chamfer_1_mm"],
                    "amplitude": cell["amplitude"],
                }
            )
    drawings = figures.collapse(runs)
    files = [write_rows(rows, folder / f"{target}.csv"), *write_drawings(drawings, folder)]
    return Reproduction(rows, files, drawings=drawings)


def _figure(
    draw: Callable[[PaperRuns], list[Drawing]],
) -> Callable[[str, PaperRuns, pathlib.Path], Reproduction]:
    """A maker that draws a figure and gives the rows of its cases, both blocks."""

    def make(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
        folder.mkdir(parents=True, exist_ok=True)
        rows: list[Row] = []
        for block in BLOCKS:
            case, *ensembles = STACK_ENGINES_OF[target]
            rows += _engine_rows(target, runs, case, block)
            for name in ensembles:
                rows += _ensemble_rows(target, runs, name, block)
        drawings = draw(runs)
        files = [write_rows(rows, folder / f"{target}.csv"), *write_drawings(drawings, folder)]
        return Reproduction(rows, files, drawings=drawings)

    return make


STACK_MAKERS: dict[str, Callable[[str, PaperRuns, pathlib.Path], Reproduction]] = {
    "table9": _pulse_table,
    "table10": _pulse_table,
    "table11": _sine_table,
    "table12": _sine_table,
    "fig12": _figure(figures.figure12),
    "fig13": _figure(figures.figure13),
    "fig14": _figure(figures.figure14),
    "fig15": _figure(figures.figure15),
    "collapse": _collapse,
}
"""Target -> what makes its rows and files."""


def run_stack(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
    """Makes the rows and files of a target of stacks."""
    return STACK_MAKERS[target](target, runs, folder)


def stack_evidence(runs: PaperRuns, cases: Collection[str]) -> StackEvidence:
    """What the conflicts on stacks need of the runs, of those cases that a target has run."""
    pulse = STACK_PULSE in cases
    return StackEvidence(
        pulse=peak_table(runs, STACK_PULSE) if pulse else None,
        sine=peak_table(runs, STACK_SINE) if STACK_SINE in cases else None,
        smoother=peak_table(runs, STACK_PULSE, LOWER_FRICTION) if pulse else None,
        places=_all_places(runs) if PULSE_ENSEMBLE in cases else None,
        tests=_both_tests(runs) if SINE_ENSEMBLE in cases else None,
        collapse=cell_rows(cells_of(runs, COLLAPSE), "top") if COLLAPSE in cases else None,
    )


def _both_tests(runs: PaperRuns) -> dict[str, tuple[Array, Array]]:
    """The tests behind Tables 11 and 12 by block and route."""
    found = {}
    for name in ("table11", "table12"):
        by_analytical, by_bullet = inferred_tests(runs, name, BLOCK_OF[name])
        found[BLOCK_OF[name]] = (by_analytical.values, by_bullet.values)
    return found


def _all_places(runs: PaperRuns) -> pd.DataFrame:
    """Percentiles of the engines' values of Tables 9 and 10 in the ensembles, and their spread."""
    cells = cells_of(runs, PULSE_ENSEMBLE)
    rows = []
    for name, geometry in itertools.product(("table9", "table10"), GEOMETRIES):
        block = BLOCK_OF[name]
        found = cell_rows(cells, block)
        spread = (found["high_95"] - found["low_5"]) / found["median"]
        for printed in paper_columns(name).records:
            place = cells.place(geometry, (printed[INPUTS[0]], printed[INPUTS[1]]))
            rows += [
                {
                    "geometry": geometry,
                    "block": block,
                    "source": source,
                    "percentile": cells.percentile(place, block, float(printed[source])),
                    "spread": spread[place],
                }
                for source in PAPER_COLUMNS[1:]
            ]
    return pd.DataFrame(rows)
