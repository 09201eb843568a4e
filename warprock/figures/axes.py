"""Plots on one pair of axes, a caller's own or new ones: what a script puts together itself."""

from __future__ import annotations

import contextlib
import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from warprock.case.input_columns import input_meaning
from warprock.errors import InputError, did_you_mean, list_allowed
from warprock.figures.outcomes import RAISED, read_peaks
from warprock.figures.palette import BLUE, DASHES, FALLEN, GREY
from warprock.figures.sheet import TIME_LABEL, style
from warprock.model.response import Outcome, Response
from warprock.running.case_run import CaseRun

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes

ROTATION = "rotation / slenderness angle [-]"
PEAK = f"peak {ROTATION}"
FALLEN_BEYOND = 1.5
"""Rotation ratio at which the history of a block that falls leaves its axes."""
LETTERS = 100
"""Letters of a line of a title."""


def require_axes(ax: Any) -> None:
    """Refuses what is not None and no axes of Matplotlib.

    Raises:
        InputError: It is neither.
    """
    from matplotlib.axes import Axes

    if ax is not None and not isinstance(ax, Axes):
        raise InputError("ax", "", ax, "must be axes of Matplotlib or None")


def plot_history(run: CaseRun, response: Response, lane: int, ax: Axes | None = None) -> Axes:
    """Rotation over the slenderness angle of one lane, of a stack a curve a block.

    Args:
        run: The run.
        response: The lane alone, with its history.
        lane: Its number.
        ax: Where to; new axes where None.

    Returns:
        The axes.
    """
    if ax is None:
        with _own_axes(
            f"{run.case.name}, {response.engine}, lane {lane}: rotation over time"
        ) as own:
            return plot_history(run, response, lane, own)
    angles = np.atleast_1d(run.lane_set.lanes.slenderness_angle[lane])
    rotations = np.atleast_2d(response["rotation"][0])
    for block, (rotation, angle) in enumerate(zip(rotations, angles, strict=True)):
        of = f", block {block + 1}" * (len(angles) > 1)
        label = f"lane {lane}{of}, {response.engine}"
        dashes = DASHES[block % len(DASHES)]
        ax.plot(response.times, rotation / angle, label=label, linestyle=dashes)
    if response["outcome"][0] == Outcome.OVERTURNED:
        # Up to a quarter of a turn: what comes before would be flat.
        ax.set_ylim(-FALLEN_BEYOND, FALLEN_BEYOND)
    ax.set(xlabel=TIME_LABEL, ylabel=ROTATION)
    if len(ax.lines) > 1:
        ax.legend()
    return ax


def plot_peaks(
    run: CaseRun, table: pd.DataFrame, x: str | None = None, ax: Axes | None = None
) -> Axes:
    """Peak rotation over the slenderness angle of every lane, marked by what became of it.

    Of a stack it is that of the block which rotates furthest. Lanes that fell are marked above all
    others, whatever they reached.

    Args:
        run: The run.
        table: Its lane table.
        x: Column across; the first input that differs between lanes where None, or their number.
        ax: Where to; new axes where None.

    Returns:
        The axes.

    Raises:
        InputError: The table has no such column, or it holds no numbers.
    """
    across = _column_across(run, table, x)
    values, peaks = table[across].to_numpy(dtype=np.float64), read_peaks(run)
    if ax is None:
        with _own_axes(f"{run.case.name}, {run.response.engine}: {peaks.message()}") as own:
            return plot_peaks(run, table, across, own)
    for code, (name, marker, filled) in peaks.outcomes.items():
        rows = peaks.outcome == code
        if not rows.any():
            continue
        raised = code in RAISED
        color = FALLEN if raised else BLUE
        at = f" (drawn at {peaks.raised_at:g})" * raised
        ax.plot(
            values[rows],
            np.full(int(rows.sum()), peaks.raised_at) if raised else peaks.ratio[rows],
            linestyle="none",
            marker=marker,
            color=color,
            markerfacecolor=color if filled else "none",
            label=f"{name}{at}: {int(rows.sum()):,}",
        )
    unit, meaning = input_meaning(across)
    ax.set(xlabel=f"{meaning} [{unit.replace('^2', '²')}]", ylabel=PEAK)
    ax.set_ylim(bottom=min(-0.03 * peaks.top, ax.get_ylim()[0]))
    ax.axhline(1.0, color=GREY, linewidth=0.8, zorder=1.0)
    ax.legend()
    return ax


def _column_across(run: CaseRun, table: pd.DataFrame, x: str | None) -> str:
    """The column that lies across."""
    numbers = [str(name) for name in table.select_dtypes("number").columns]
    if x is None:
        inputs = [name for name in map(str, run.lane_set.inputs.columns) if name in numbers]
        differing = (name for name in inputs if table[name].nunique() > 1)
        return next(differing, "lane")
    if x not in numbers:
        allowed = (
            f"must be a column of numbers: {list_allowed(x, numbers)}{did_you_mean(x, numbers)}"
        )
        raise InputError("x", "", x, allowed)
    return x


@contextlib.contextmanager
def _own_axes(title: str) -> Iterator[Axes]:
    """Axes in a figure of its own that the screen, or the notebook, of the caller shows."""
    import matplotlib.pyplot as plt

    with style():
        _, axes = plt.subplots(figsize=(7.2, 3.8), layout="constrained")
        axes.set_title("\n".join(textwrap.wrap(title, LETTERS)))
        yield axes
