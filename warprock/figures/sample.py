"""Figure of a case whose lanes are drawn from distributions: peak rotation over each input."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.case.case import Case
from warprock.case.values import LaneValues
from warprock.figures.drawing import Drawing
from warprock.figures.outcomes import FAR, RAISED, Peaks, read_peaks
from warprock.figures.palette import BLUE, GREEN, ORANGE, VERMILION
from warprock.figures.peaks import PEAK_LABEL
from warprock.figures.scales import logarithmic
from warprock.figures.sheet import headline, legend_below, style, subplots
from warprock.model.response import Outcome
from warprock.model.words import lane_count_text
from warprock.running.case_run import CaseRun
from warprock.tables.swept import DrawnInput, drawn_inputs

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_DOTS = 3000
"""Lanes that one panel can show. Of more, the first of every cell are: those lie as evenly as all,
which every third point of a Sobol' sequence would not."""

COLUMNS = 2
PANEL_HEIGHT = 3.0

COLORS: dict[int, str] = {
    Outcome.AT_REST: BLUE,
    Outcome.ROCKING: GREEN,
    Outcome.OVERTURNED: VERMILION,
    Outcome.SLID_OFF: ORANGE,
    FAR: VERMILION,
}


def draw_sample_peaks(run: CaseRun, block: int | None = None) -> Drawing:
    """Peak rotation of the lanes over every input that was drawn, one panel each.

    Args:
        run: The run.
        block: Which block of stacks, the lowest is 0; None for single blocks.
    """
    peaks = read_peaks(run, block)
    count = len(peaks.ratio)
    # A sample is the fastest axis of its case.
    draws = run.case.axes[-1].length
    lanes = np.arange(count)
    lanes = lanes[lanes % draws < max(1, MOST_DOTS * draws // count)]
    inputs = drawn_inputs(run.case)
    values = LaneValues(run.case, range(count))
    columns = min(COLUMNS, len(inputs))
    rows = -(-len(inputs) // columns)
    with style():
        figure, grid = subplots(rows, columns, (9.6, PANEL_HEIGHT * rows + 1.2), sharey=True)
        for axes in grid.flat[len(inputs) :]:
            axes.set_visible(False)
        for number, (axes, drawn) in enumerate(zip(grid.flat, inputs, strict=False)):
            across = _across(axes, values, drawn)[lanes]
            for code, (name, marker, filled) in peaks.outcomes.items():
                here = peaks.outcome[lanes] == code
                raised = code in RAISED
                label = f"{name}: {lane_count_text(int(np.sum(peaks.outcome == code)))}"
                axes.plot(
                    across[here],
                    np.full(int(here.sum()), peaks.raised_at)
                    if raised
                    else peaks.ratio[lanes][here],
                    linestyle="none",
                    marker=marker,
                    markersize=3.0,
                    markeredgewidth=0.7,
                    color=COLORS[code],
                    markerfacecolor=COLORS[code] if filled else "none",
                    label=label if np.any(peaks.outcome == code) else None,
                )
            peaks.scale(axes)
            if number % columns == 0:
                axes.set_ylabel(PEAK_LABEL)
        legend_below(figure, grid[0, 0], columns=2)
        title, about = peaks.message(block), _about(run, block, count, len(lanes), peaks)
        headline(figure, title, about)
    name = "peaks" if block is None else f"peaks-block-{block + 1}"
    return Drawing(name, figure, title, f"{about}. {title}.".replace("\n", ". "))


def _across(axes: Axes, values: LaneValues, drawn: DrawnInput) -> npt.NDArray[Any]:
    """Where the lanes lie along a panel, whose abscissa is set up for it."""
    axes.set_xlabel(drawn.title)
    if drawn.names is not None:
        axes.set_xticks(range(len(drawn.names)), drawn.names)
        return values.texts(drawn.key)[1]
    if drawn.logarithmic:
        logarithmic(axes.xaxis)
    return values.numbers(drawn.key) / drawn.unit_size


def _about(run: CaseRun, block: int | None, count: int, shown: int, peaks: Peaks) -> str:
    of = "" if block is None else f" of block {block + 1}"
    lines = [f"{run.case.name}, {run.response.engine}: peak rotation{of} of {count} lanes"]
    if shown < count:
        lines.append(f"{shown} of them shown, the first of every sample")
    if peaks.raised.any():
        lines.append("what overturned, slid off or was falling is marked at the top")
    unusable = int(np.sum(peaks.outcome < 0))
    if unusable:
        lines.append(f"lanes without a usable number: {unusable}")
    return "\n".join(lines)


def sampled(case: Case) -> bool:
    """Whether the lanes of a case are drawn from distributions."""
    return any(axis.sample is not None for axis in case.axes)
