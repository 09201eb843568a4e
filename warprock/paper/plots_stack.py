"""Histories of two stacked blocks (Figs. 12 and 14)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLUE, GREY, PURPLE, VERMILION
from warprock.figures.sheet import TIME_LABEL, headline, legend_below, panel_title, style, subplots
from warprock.paper.printed import BLOCKS, REFERENCE_DEGREES

Array = npt.NDArray[np.float64]

STACK_STYLES: dict[str, dict[str, Any]] = {
    "two-block": {"color": GREY, "linewidth": 2.4, "linestyle": "-", "zorder": 2},
    "event": {"color": BLUE, "linewidth": 1.4, "linestyle": "-", "zorder": 3},
    "impulse": {"color": VERMILION, "linewidth": 1.0, "linestyle": (0, (4, 2)), "zorder": 4},
    "dem": {"color": PURPLE, "linewidth": 1.0, "linestyle": (0, (6, 1.5, 1.5, 1.5)), "zorder": 5},
}
STACK_NAMES = {
    "two-block": "two-block: analytical, acceleration drive, equal depths",
    "event": "event: displacement drive, top 0.55 m high",
    "impulse": "impulse: displacement drive, top 0.55 m high",
    "dem": "dem: displacement drive, top 0.55 m high, springs of Table 5",
}
"""What the legend says of each engine, with the reading it is drawn for."""
RATIO_LABEL = f"rotation /\n{REFERENCE_DEGREES} deg [-]"


COLUMNS = 2


def draw_stack_histories(
    stem: str,
    title: str,
    times: Array,
    names: Sequence[str],
    curves: Mapping[str, Array],
    window: tuple[float, float],
) -> list[Drawing]:
    """Rotations of both blocks by engine: a figure a block, the top one first, a panel an input.

    Args:
        stem: Name of the drawing of the top block; that of the other ends with its name.
        title: What is drawn.
        times: [s], shape [sample].
        names: Name of every input.
        curves: Rotation / 9.85 deg by engine, shape [input, block, sample].
        window: First and last time to draw [s].
    """
    shown = (times >= window[0]) & (times <= window[1] + 1e-9)
    rows = -(-len(names) // COLUMNS)
    drawings = []
    for number, block in enumerate(reversed(BLOCKS)):
        mine = {engine: ratio[:, BLOCKS.index(block), shown] for engine, ratio in curves.items()}
        with style():
            figure, grid = subplots(rows, COLUMNS, (9.6, 1.9 * rows + 0.6), sharex=True)
            for axes in grid.flat[len(names) :]:
                axes.set_visible(False)
            for at, (name, axes) in enumerate(zip(names, grid.flat, strict=False)):
                for engine, ratio in mine.items():
                    look = STACK_STYLES[engine]
                    axes.plot(times[shown], ratio[at], label=STACK_NAMES[engine], **look)
                panel_title(axes, name)
            for axes in grid[:, 0]:
                axes.set_ylabel(RATIO_LABEL)
            for axes in grid[-1]:
                axes.set_xlabel(TIME_LABEL)
                axes.set_xlim(*window)
            figure.align_ylabels(grid[:, 0])
            legend_below(figure, grid[0, 0], columns=1)
            said = _message(block, names, mine)
            about = f"{title}, {block} block"
            headline(figure, said, about)
        name = f"{stem}-{block}" if number else stem
        drawings.append(Drawing(name, figure, said, f"{about}. {said}."))
    return drawings


def _message(block: str, names: Sequence[str], curves: Mapping[str, Array]) -> str:
    """Where a block rotates furthest, by engine; curves of shape [input, sample]."""
    peaks = {name: np.nanmax(np.abs(curve), axis=-1) for name, curve in curves.items()}
    at = int(np.argmax(np.max(list(peaks.values()), axis=0)))
    found = ", ".join(f"{peak[at]:.2f} ({engine})" for engine, peak in peaks.items())
    return f"At {names[at]} the {block} block rotates furthest: {found} of {REFERENCE_DEGREES} deg"
