"""The figure of Sobol' indices."""

from __future__ import annotations

import pathlib
import textwrap
from typing import Any

import numpy as np

from warprock.report.plots import BLUE, FIGURE_TITLE, ORANGE, drawing, legend_below, save
from warprock.sensitivity import Sensitivity

PANELS = 12
"""Groups that a figure shows at most; the first ones."""
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
    columns = min(3, len(groups))
    rows = -(-len(groups) // columns)
    width = 2.6 + 3.6 * columns
    with drawing() as plt:
        figure, panels = plt.subplots(
            rows,
            columns,
            figsize=(width, 1.7 + rows * (0.7 + 0.42 * len(inputs))),
            sharex=True,
            sharey=True,
            squeeze=False,
            layout="constrained",
        )
        for number, axes in enumerate(panels.flat):
            axes.set_visible(number < len(groups))
            if number < len(groups):
                group = groups.iloc[number]
                _draw_group(axes, found, str(group["group"]), inputs)
        for number in range(max(0, len(groups) - columns), len(groups)):
            panels.flat[number].xaxis.set_tick_params(labelbottom=True)
            panels.flat[number].set_xlabel("share of the variance [-]")
        legend_below(figure, panels.flat[0], columns=2)
        lanes = int(groups["lanes"].iloc[0])
        about = (
            f"Sobol' indices of {found.of}; {found.run.response.engine}, {lanes:,} lanes a panel; "
            "lines: 5th to 95th percentile over resampled rows of the design"
        )
        lines = [
            textwrap.fill(text, int(_LETTERS * width)) for text in (found.run.case.title, about)
        ]
        figure.suptitle("\n".join(lines), **FIGURE_TITLE)
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
