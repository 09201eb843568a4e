"""The figure of predictors: the function of two measures over the lanes, and losses of measures."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from warprock.analysis.predictors import Predictor, Predictors
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, BLUE, DARK, FALLEN, ORANGE
from warprock.figures.scales import logarithmic
from warprock.figures.sheet import headline, legend_below, style, subplots
from warprock.findings.intensities import measure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEVELS = (0.1, 0.5, 0.9)
"""Probabilities whose lines are drawn."""
POINTS = 80
MOST_LANES = 4000
"""Lanes that a figure shows at most: of more every so-many-th."""
AROUND = 1.04
"""Factor by which a panel reaches beyond its lanes."""
WRAP = 34


def draw_predictors(found: Predictors, title: str) -> list[Drawing]:
    """Draws the best two measures over the lanes, and the losses of all.

    Args:
        found: What was compared.
        title: What it says: the first sentence of its finding.

    Returns:
        One drawing.
    """
    known, pair = found.singles, found.pair
    with style():
        figure, panels = subplots(1, 2 if pair else 1, (10.4 if pair else 6.0, 4.0))
        plot_losses(panels[0, -1], found)
        if pair is not None:
            _draw_pair(panels[0, 0], found, pair)
            legend_below(figure, panels[0, 0], columns=3)
        about = f"{len(found.table):,} lanes, {found.records} records; limit state "
        about += f"{found.limit.text}. Losses are of records that the fit has not seen; lines: "
        about += "standard error of what lies between them and the best"
        headline(figure, title, about)
    texts = "; ".join(f"{_name(each)}: {each.loss:.3g}" for each in known)
    return [Drawing("predictors", figure, title, f"Losses of measures. {title}. {texts}.")]


def plot_losses(axes: Axes, found: Predictors, group: int = 0) -> None:
    """Draws the losses of measures alone, and of the best two.

    Args:
        axes: Where to.
        found: What was compared.
        group: Number of the group: 0, there is one.
    """
    assert group == 0
    rows = list(found.singles)
    best = rows[0]
    if found.pair is not None:
        rows.append(found.pair)
    rows.sort(key=lambda each: each.loss)
    for number, each in enumerate(rows):
        error = found.gain(best, each)[1]
        color = ORANGE if len(each.measures) == 2 else BLUE
        axes.plot((each.loss - error, each.loss + error), (number, number), color=color)
        axes.plot(each.loss, number, "o", color=color, markersize=6.0)
    axes.set_yticks(range(len(rows)), [textwrap.fill(_name(each), WRAP) for each in rows])
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set(xlabel="loss [-]", ylabel="")


def _name(each: Predictor) -> str:
    return " and ".join(measure(name).name for name in each.measures)


def _draw_pair(axes: Axes, found: Predictors, pair: Predictor) -> None:
    """Lanes over two measures, by what became of them, and lines of equal probability."""
    first, second = (measure(name) for name in pair.measures)
    step = max(1, len(found.table) // MOST_LANES)
    x, z = (found.table[name].to_numpy(dtype=np.float64) for name in pair.measures)
    for reached, color, mark, label in (
        (False, DARK, "o", "not reached"),
        (True, FALLEN, "x", "reached"),
    ):
        mine = np.flatnonzero(found.reached == reached)[::step]
        axes.plot(
            x[mine] * first.size,
            z[mine] * second.size,
            mark,
            color=color,
            markersize=3.5,
            markerfacecolor="none",
            linestyle="none",
            label=label,
        )
    grid_x, grid_z = (
        np.geomspace(each.min() / AROUND, each.max() * AROUND, POINTS) for each in (x, z)
    )
    across, up = np.meshgrid(grid_x, grid_z)
    lines = axes.contour(
        across * first.size,
        up * second.size,
        pair.probability(across, up),
        levels=LEVELS,
        colors=BLACK,
        linestyles=("dotted", "solid", "dashed"),
    )
    axes.clabel(lines, fmt=lambda level: f"{level:g}")
    logarithmic(axes.xaxis)
    logarithmic(axes.yaxis)
    axes.set(xlabel=textwrap.fill(first.label, WRAP + 10), ylabel=textwrap.fill(second.label, WRAP))
