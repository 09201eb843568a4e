"""Histories of two stacked blocks (Figs. 12 and 14)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, BLUE, ORANGE, VERMILION
from warprock.figures.sheet import TIME_LABEL, headline, legend_below, style, subplots
from warprock.paper.printed import BLOCKS, REFERENCE_DEGREES

Array = npt.NDArray[np.float64]

STACK_STYLES: dict[str, dict[str, Any]] = {
    "two-block": {"color": BLACK, "linewidth": 1.5, "linestyle": "-", "zorder": 2},
    "event": {"color": BLUE, "linewidth": 1.4, "linestyle": "-", "zorder": 3},
    "impulse": {"color": VERMILION, "linewidth": 1.0, "linestyle": (0, (4, 2)), "zorder": 4},
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
    stem: str,
    title: str,
    times: Array,
    names: Sequence[str],
    curves: Mapping[str, Array],
    window: tuple[float, float],
) -> Drawing:
    """Rotations of both blocks by engine: a row an input, a column a block, the top one first.

    Args:
        stem: Name of the drawing.
        title: What is drawn.
        times: [s], shape [sample].
        names: Name of every input.
        curves: Rotation / 9.85 deg by engine, shape [input, block, sample].
        window: First and last time to draw [s].
    """
    shown = (times >= window[0]) & (times <= window[1] + 1e-9)
    with style():
        figure, grid = subplots(
            len(names),
            len(BLOCKS),
            (9.6, 1.5 * len(names) + 1.0),
            sharex=True,
        )
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
                axes.set_title(f"{name}: {block} block")
            grid[row, 0].set_ylabel(RATIO_LABEL)
        for axes in grid[-1]:
            axes.set_xlabel(TIME_LABEL)
            axes.set_xlim(*window)
        legend_below(figure, grid[0, 0], columns=1)
        said = _message(names, curves)
        headline(figure, said, title)
    return Drawing(stem, figure, said, f"{title}. {said}.")


def _message(names: Sequence[str], curves: Mapping[str, Array]) -> str:
    """Where the top block rotates furthest, by engine."""
    peaks = {
        name: np.nanmax(np.abs(c[:, BLOCKS.index("top")]), axis=-1) for name, c in curves.items()
    }
    at = int(np.argmax(np.max(list(peaks.values()), axis=0)))
    found = ", ".join(f"{peak[at]:.2f} ({engine})" for engine, peak in peaks.items())
    return f"At {names[at]} the top block rotates furthest: {found} of {REFERENCE_DEGREES} deg"
