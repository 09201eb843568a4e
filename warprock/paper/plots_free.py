"""Figures of free rocking, and the styles of the paper's programs."""

from __future__ import annotations

import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from warprock.paper.printed import INFERRED_NAMES

if TYPE_CHECKING:
    pass

from warprock.figures.plots import (
    BLACK,
    BLUE,
    ENGINE_STYLES,
    FIGURE_TITLE,
    GREEN,
    ORANGE,
    PURPLE,
    RED,
    SHORT_ROTATION_LABEL,
    SKY,
    TIME_LABEL,
    Array,
    drawing,
    history,
    legend_below,
    save,
)

READING_COLORS = {"displacement": BLUE, "acceleration": ORANGE, "slip": GREEN}


PAPER_STYLES: dict[str, dict[str, Any]] = {
    "analytical": {"marker": "s", "color": GREEN},
    "bullet": {"marker": "^", "color": RED},
    "vortex": {"marker": "v", "color": PURPLE},
    "dem": {"marker": "D", "color": SKY},
    INFERRED_NAMES[0]: {"marker": "*", "color": BLACK, "markersize": 9.0},
    INFERRED_NAMES[1]: {"marker": "x", "color": PURPLE},
}


def draw_free_response(
    path: pathlib.Path,
    times: Array,
    panels: Sequence[tuple[str, dict[str, Array]]],
) -> pathlib.Path:
    """Free response of B0: one pair of panels (response, residual) a height (Fig. 4a).

    Args:
        path: File to write.
        times: [s], shape [sample].
        panels: Title and rotation ratios by engine, `housner` among them, shape [sample] each.
    """
    with drawing() as plt:
        figure, grid = plt.subplots(
            2 * len(panels),
            1,
            figsize=(7.4, 3.6 * len(panels) + 0.4),
            sharex=True,
            height_ratios=[2.4, 1.0] * len(panels),
            layout="constrained",
        )
        for index, (title, ratios) in enumerate(panels):
            response, residual = grid[2 * index], grid[2 * index + 1]
            for engine, ratio in ratios.items():
                history(response, times, ratio, engine)
                if engine != "housner":
                    residual.plot(
                        times, ratio - ratios["housner"], label=engine, **ENGINE_STYLES[engine]
                    )
            response.set_title(f"{title}; residual: impulse minus housner", loc="left")
            response.set_ylabel(SHORT_ROTATION_LABEL)
            residual.set_ylabel("residual [-]")
            residual.ticklabel_format(axis="y", style="sci", scilimits=(-2, 2))
        grid[-1].set_xlabel(TIME_LABEL)
        grid[-1].set_xlim(times[0], times[-1])
        legend_below(figure, grid[0])
        return save(figure, path)


def draw_free_panels(
    path: pathlib.Path,
    times: Array,
    panels: Sequence[tuple[str, dict[str, Array]]],
    *,
    columns: int = 3,
    duration: float = 5.0,
) -> pathlib.Path:
    """Free responses in a grid, each with its residual below (Fig. 5).

    Args:
        path: File to write.
        times: [s], shape [sample].
        panels: Title and rotation ratios by engine, `housner` among them, in reading order.
        columns: Panels in a row.
        duration: Time that is drawn [s].
    """
    rows = -(-len(panels) // columns)
    window = (0.0, duration)
    shown = times <= duration + 1e-9
    with drawing() as plt:
        figure, grid = plt.subplots(
            2 * rows,
            columns,
            figsize=(9.6, 2.9 * rows + 0.4),
            sharex=True,
            height_ratios=[2.2, 1.0] * rows,
            layout="constrained",
            squeeze=False,
        )
        for index, (title, ratios) in enumerate(panels):
            row, column = divmod(index, columns)
            response, residual = grid[2 * row, column], grid[2 * row + 1, column]
            for engine, ratio in ratios.items():
                history(response, times, ratio, engine, window)
                if engine != "housner":
                    difference = (ratio - ratios["housner"])[shown]
                    residual.plot(times[shown], 1e3 * difference, **ENGINE_STYLES[engine])
            response.set_title(title, loc="left")
            if column == 0:
                response.set_ylabel(SHORT_ROTATION_LABEL)
                residual.set_ylabel("residual\n[10⁻³]")
            if row == rows - 1:
                residual.set_xlabel(TIME_LABEL)
        grid[0, 0].set_xlim(0.0, duration)
        figure.suptitle("Free rocking; residual: impulse minus housner", **FIGURE_TITLE)
        legend_below(figure, grid[0, 0])
        return save(figure, path)
