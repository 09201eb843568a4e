"""Figures of free rocking, and the styles of the paper's programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.figures.drawing import Drawing
from warprock.figures.palette import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    engine_marks,
)
from warprock.figures.sheet import (
    SHORT_ROTATION_LABEL,
    TIME_LABEL,
    headline,
    legend_below,
    panel_title,
    style,
    subplots,
)
from warprock.paper.printed import INFERRED_NAMES

Array = npt.NDArray[np.float64]

ENGINE_STYLES: dict[str, dict[str, Any]] = {
    name: {"color": engine_marks(name)[0], "linewidth": width, "linestyle": line, "zorder": order}
    for name, width, line, order in (
        ("housner", 1.8, "-", 2),
        ("impulse", 1.1, (0, (4, 2)), 3),
        ("oracle", 1.0, ":", 4),
    )
}
"""Lines of rotation histories."""

READING_COLORS = {"displacement": BLUE, "acceleration": ORANGE, "double-size": GREEN}


PAPER_STYLES: dict[str, dict[str, Any]] = {
    "analytical": {"marker": "s", "color": GREEN},
    "bullet": {"marker": "^", "color": VERMILION},
    "vortex": {"marker": "v", "color": PURPLE},
    "dem": {"marker": "D", "color": SKY},
    INFERRED_NAMES[0]: {"marker": "*", "color": BLACK, "markersize": 9.0},
    INFERRED_NAMES[1]: {"marker": "x", "color": PURPLE},
}


def history(
    axes: Any, times: Array, ratio: Array, engine: str, window: tuple[float, float] | None = None
) -> None:
    """Draws one rotation history, normalised, in the style of its engine.

    Args:
        axes: Where to.
        times: [s], shape [sample].
        ratio: Rotation / slenderness angle, shape [sample].
        engine: Name of the engine, for style and legend.
        window: First and last time to draw [s]; None draws all.
    """
    shown = slice(None) if window is None else (times >= window[0]) & (times <= window[1])
    axes.plot(times[shown], ratio[shown], label=engine, **ENGINE_STYLES[engine])


def apart(ratios: Mapping[str, Array]) -> float:
    """Largest difference of an engine from Housner / slenderness angle, of one panel."""
    others = [ratio for engine, ratio in ratios.items() if engine != "housner"]
    return max(float(np.nanmax(np.abs(ratio - ratios["housner"]))) for ratio in others)


def draw_free_response(
    stem: str,
    times: Array,
    panels: Sequence[tuple[str, dict[str, Array]]],
) -> Drawing:
    """Free response of B0: one pair of panels (response, residual) a height (Fig. 4a).

    Args:
        stem: Name of the drawing.
        times: [s], shape [sample].
        panels: Title and rotation ratios by engine, `housner` among them, shape [sample] each.
    """
    with style():
        figure, grid = subplots(
            2 * len(panels),
            1,
            (8.4, 3.6 * len(panels) + 0.4),
            sharex=True,
            height_ratios=[2.4, 1.0] * len(panels),
        )
        for index, (title, ratios) in enumerate(panels):
            response, residual = grid[2 * index, 0], grid[2 * index + 1, 0]
            for engine, ratio in ratios.items():
                history(response, times, ratio, engine)
                if engine != "housner":
                    residual.plot(
                        times, ratio - ratios["housner"], label=engine, **ENGINE_STYLES[engine]
                    )
            panel_title(response, title)
            response.set_ylabel(SHORT_ROTATION_LABEL)
            residual.set_ylabel("impulse minus\nhousner [-]")
        grid[-1, 0].set_xlabel(TIME_LABEL)
        grid[-1, 0].set_xlim(times[0], times[-1])
        legend_below(figure, grid[0, 0])
        most = max(apart(ratios) for _, ratios in panels)
        title = f"impulse follows Housner to {most:.2g} of the slenderness angle"
        about = (
            f"Free rocking for {times[-1]:g} s; below each history the difference of the engines"
        )
        headline(figure, title, about)
    return Drawing(stem, figure, title, f"{about}. {title}.")


COLUMNS, DURATION = 3, 5.0
"""Panels of Fig. 5 in a row, and the time that is drawn [s]."""


def draw_free_panels(
    stem: str,
    times: Array,
    panels: Sequence[tuple[str, dict[str, Array]]],
) -> Drawing:
    """Free responses in a grid, each with its residual below (Fig. 5).

    Args:
        stem: Name of the drawing.
        times: [s], shape [sample].
        panels: Title and rotation ratios by engine, `housner` among them, in reading order.
    """
    rows = -(-len(panels) // COLUMNS)
    window = (0.0, DURATION)
    shown = times <= DURATION + 1e-9
    with style():
        figure, grid = subplots(
            2 * rows,
            COLUMNS,
            (9.6, 2.9 * rows + 0.4),
            sharex=True,
            height_ratios=[2.2, 1.0] * rows,
        )
        for index, (title, ratios) in enumerate(panels):
            row, column = divmod(index, COLUMNS)
            response, residual = grid[2 * row, column], grid[2 * row + 1, column]
            for engine, ratio in ratios.items():
                history(response, times, ratio, engine, window)
                if engine != "housner":
                    difference = (ratio - ratios["housner"])[shown]
                    residual.plot(times[shown], 1e3 * difference, **ENGINE_STYLES[engine])
            panel_title(response, title)
            if column == 0:
                response.set_ylabel(SHORT_ROTATION_LABEL)
                residual.set_ylabel("impulse minus\nhousner [10⁻³]")
            if row == rows - 1:
                residual.set_xlabel(TIME_LABEL)
        grid[0, 0].set_xlim(0.0, DURATION)
        legend_below(figure, grid[0, 0])
        found = [(apart({e: r[shown] for e, r in ratios.items()}), name) for name, ratios in panels]
        most, where = max(found)
        title = f"impulse follows Housner to {most:.2g} of the slenderness angle ({where})"
        about = f"Free rocking for {DURATION:g} s; below each history the difference of the engines"
        headline(figure, title, about)
    return Drawing(stem, figure, title, f"{about}. {title}.")
