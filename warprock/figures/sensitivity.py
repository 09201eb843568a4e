"""The figure of Sobol' indices."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np

from warprock.analysis.sensitivity import Sensitivity
from warprock.figures.plots import (
    BLUE,
    ORANGE,
    drawing,
    legend_below,
    panel_grid,
    save,
    wrapped_title,
)

PANELS = 12
"""Groups that a figure shows at most; the first ones."""
COLUMNS = 3
_LETTERS = 13
"""Letters of a title in an inch of its figure."""
_BARS = (("first_order", "first order: alone", BLUE, -0.2), ("total", "total", ORANGE, 0.2))


def draw_sensitivity(path: pathlib.Path, found: Sensitivity) -> pathlib.Path:
    """Draws the indices of every group as bars, with their bands.

    Args:
        path: File to write.
        found: The indices.

    Returns:
        The file.
    """
    groups = found.groups.head(PANELS)
    inputs = list(dict.fromkeys(found.rows["input"]))
    with drawing() as plt:
        figure, panels = panel_grid(
            plt,
            len(groups),
            columns=COLUMNS,
            width=(2.6, 3.6),
            height=(1.7, 0.7 + 0.42 * len(inputs)),
            labels=("share of the variance [-]", ""),
        )
        for axes, group in zip(panels.flat, groups["group"], strict=False):
            _draw_group(axes, found, str(group), inputs)
        legend_below(figure, panels.flat[0], columns=2)
        lanes = int(groups["lanes"].iloc[0])
        about = (
            f"Sobol' indices of {found.of}; {found.run.response.engine}, {lanes:,} lanes a panel; "
            "lines: 5th to 95th percentile over resampled rows of the design"
        )
        wrapped_title(figure, (found.run.case.title, about), _LETTERS)
        return save(figure, path)


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
    axes.axvline(0.0, color="#666666", linewidth=0.8)
    axes.set_title(group, loc="left")
