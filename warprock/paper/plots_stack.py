"""Histories of two stacked blocks (Figs. 12 and 14)."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.figures.plots import (
    BLACK,
    BLUE,
    FIGURE_TITLE,
    ORANGE,
    RED,
    TIME_LABEL,
    drawing,
    legend_below,
    save,
)
from warprock.paper.printed import BLOCKS, REFERENCE_DEGREES

Array = npt.NDArray[np.float64]

STACK_STYLES: dict[str, dict[str, Any]] = {
    "two-block": {"color": BLACK, "linewidth": 1.5, "linestyle": "-", "zorder": 2},
    "event": {"color": BLUE, "linewidth": 1.4, "linestyle": "-", "zorder": 3},
    "impulse": {"color": RED, "linewidth": 1.0, "linestyle": (0, (4, 2)), "zorder": 4},
    "dem": {"color": ORANGE, "linewidth": 1.0, "linestyle": (0, (6, 1.5, 1.5, 1.5)), "zorder": 5},
}
STACK_NAMES = {
    "two-block": "two-block: analytical, acceleration drive, equal depths",
    "event": "event: displacement drive, top 0.55 m high",
    "impulse": "impulse: displacement drive, top 0.55 m high",
    "dem": "dem: displacement drive, top 0.55 m high, springs of Table 5",
}
"""What the legend says of each engine, with the reading it is drawn for."""
RATIO_LABEL = f"rotation /\n{REFERENCE_DEGREES} deg [-]"


def draw_stack_histories(
    path: pathlib.Path,
    title: str,
    times: Array,
    names: Sequence[str],
    curves: Mapping[str, Array],
    window: tuple[float, float],
) -> pathlib.Path:
    """Rotations of both blocks by engine: a row an input, a column a block, the top one first.

    Args:
        path: File to write.
        title: Title of the figure.
        times: [s], shape [sample].
        names: Name of every input.
        curves: Rotation / 9.85 deg by engine, shape [input, block, sample].
        window: First and last time to draw [s].
    """
    shown = (times >= window[0]) & (times <= window[1] + 1e-9)
    with drawing() as plt:
        figure, grid = plt.subplots(
            len(names),
            len(BLOCKS),
            figsize=(9.6, 1.5 * len(names) + 1.0),
            sharex=True,
            layout="constrained",
            squeeze=False,
        )
        figure.suptitle(title, **FIGURE_TITLE)
        for row, name in enumerate(names):
            for column, block in enumerate(reversed(BLOCKS)):
                axes = grid[row, column]
                for engine, ratio in curves.items():
                    axes.plot(
                        times[shown],
                        ratio[row, BLOCKS.index(block)][shown],
                        label=STACK_NAMES[engine],
                        **STACK_STYLES[engine],
                    )
                axes.set_title(f"{name}: {block} block", loc="left")
            grid[row, 0].set_ylabel(RATIO_LABEL)
        for axes in grid[-1]:
            axes.set_xlabel(TIME_LABEL)
            axes.set_xlim(*window)
        legend_below(figure, grid[0, 0], columns=1)
        return save(figure, path)
