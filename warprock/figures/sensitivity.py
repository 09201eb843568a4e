"""The figure of Sobol' indices."""

from __future__ import annotations

from typing import Any

import numpy as np

from warprock.analysis.sensitivity import Sensitivity
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLUE, DARK, ORANGE
from warprock.figures.sheet import headline, legend_below, panel_grid, style

PANELS = 12
"""Groups that a figure shows at most; the first ones."""
COLUMNS = 3
_BARS = (
    ("first_order", "first order: by this input alone", BLUE, -0.2),
    ("total", "total: with all that it takes part in", ORANGE, 0.2),
)


def draw_sensitivity(found: Sensitivity, title: str) -> list[Drawing]:
    """Draws the indices of every group as bars, with their bands.

    Args:
        found: The indices.
        title: What it says: the first sentence of their finding.

    Returns:
        One drawing.
    """
    groups = found.groups.head(PANELS)
    inputs = list(dict.fromkeys(found.rows["input"]))
    with style():
        figure, panels = panel_grid(
            len(groups),
            columns=COLUMNS,
            width=(2.6, 3.6),
            height=(1.0, 0.7 + 0.42 * len(inputs)),
            labels=("share of the variance [-]", ""),
        )
        for axes, group in zip(panels.flat, groups["group"], strict=False):
            _draw_group(axes, found, str(group), inputs)
        legend_below(figure, panels.flat[0], columns=2)
        lanes = int(groups["lanes"].iloc[0])
        about = (
            f"{found.run.case.title}\nSobol' indices of {found.of}; {found.run.response.engine}, "
            f"{lanes:,} lanes a panel; lines: 5th to 95th percentile over resampled rows of the "
            "design"
        )
        headline(figure, title, about)
    return [
        Drawing("sensitivity", figure, title, f"Bars of Sobol' indices of {found.of}. {title}.")
    ]


def plot_sensitivity(axes: Any, found: Sensitivity, group: int = 0) -> None:
    """Draws the indices of one group as bars, with their bands.

    Args:
        axes: Where to.
        found: The indices.
        group: Number of the group, from 0.
    """
    inputs = list(dict.fromkeys(found.rows["input"]))
    _draw_group(axes, found, str(found.groups["group"].iloc[group]), inputs)
    axes.set_xlabel("share of the variance [-]")
    axes.legend()


def _draw_group(axes: Any, found: Sensitivity, group: str, inputs: list[str]) -> None:
    mine = found.rows[found.rows["group"] == group].set_index("input").loc[inputs]
    places = np.arange(len(inputs))
    for column, name, color, shift in _BARS:
        values = mine[column].to_numpy(dtype=float)
        ends = np.stack([values - mine[f"{column}_p05"], mine[f"{column}_p95"] - values])
        axes.barh(
            places + shift,
            values,
            height=0.36,
            color=color,
            label=name,
            xerr=np.maximum(ends, 0.0),
            error_kw={"elinewidth": 0.9, "capsize": 2.0},
        )
    axes.set_yticks(places, inputs)
    axes.set_ylim(len(inputs) - 0.5, -0.5)
    axes.axvline(0.0, color=DARK, linewidth=0.8)
    axes.set_title(group)
