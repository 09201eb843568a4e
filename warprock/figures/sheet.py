"""The style sheet of all figures: its texts, its panels, its legends, its title and its numbers."""

from __future__ import annotations

import contextlib
import os
import pathlib
import sys
import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHEET = pathlib.Path(__file__).with_suffix(".mplstyle")

SHORT_ROTATION_LABEL = "rotation /\nslend. angle [-]"
TIME_LABEL = "time [s]"

TITLE: dict[str, Any] = {"fontsize": 11.0, "fontweight": "bold", "color": "#000000"}
ABOUT: dict[str, Any] = {"fontsize": 9.0, "color": "#444444"}
TITLE_LETTERS, ABOUT_LETTERS = 10.6, 15.0
"""Letters of a title, and of the lines below it, that fit in an inch."""
LINE = 1.3
"""Height of a line of text over the size of its letters."""
POINTS = 72.0
"""Points in an inch."""
MARGIN = 0.08
"""Inches left free around a title."""


@contextlib.contextmanager
def style() -> Iterator[None]:
    """Matplotlib with the style of `sheet.mplstyle` alone, for the block's duration.

    A notebook names a screen in MPLBACKEND that Matplotlib may refuse where it is imported; one
    that it has stays that of the notebook.
    """
    first, named = "matplotlib" not in sys.modules, os.environ.pop("MPLBACKEND", None)
    try:
        import matplotlib.style
    finally:
        if named is not None:
            os.environ["MPLBACKEND"] = named
    if first and named is not None:
        with contextlib.suppress(ValueError):
            matplotlib.rcParams["backend"] = named
    with matplotlib.style.context(str(SHEET), after_reset=True):
        yield


def subplots(rows: int, columns: int, size: tuple[float, float], **ask: Any) -> tuple[Figure, Any]:
    """A figure of panels, without a title yet.

    Args:
        rows: Panels down.
        columns: Panels across.
        size: Width and height [inch], without the title.
        **ask: What else `Figure.subplots` takes.

    Returns:
        The figure, which no screen shows and nobody has to close, and its axes, shape
        [row, column].
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **ask)


def panel_title(axes: Axes, title: str) -> None:
    """Names a panel at its upper left; nothing else is written there.

    Told where its title lies, Matplotlib does not look for it each time it draws the panel.

    Args:
        axes: The panel, with no numbers at its upper edge and none above its scale.
        title: Its name.
    """
    axes.set_title(title, y=1.0)


def headline(figure: Figure, title: str, about: str) -> None:
    """Puts what a figure says above it, and below that, smaller, what is drawn.

    The figure grows by the height of both, so that no panel shrinks.

    Args:
        figure: The figure.
        title: What it says.
        about: What is drawn, and how it is to be read; a line a line.
    """
    width = figure.get_figwidth()
    inside = width - 2.0 * MARGIN
    said = textwrap.wrap(title, int(TITLE_LETTERS * inside))
    explained = [
        line
        for each in about.split("\n")
        for line in textwrap.wrap(each, int(ABOUT_LETTERS * inside))
    ]
    upper = len(said) * LINE * TITLE["fontsize"] / POINTS
    lower = len(explained) * LINE * ABOUT["fontsize"] / POINTS
    head = upper + lower + 2.0 * MARGIN
    height = figure.get_figheight() + head
    figure.set_figheight(height)
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0.0, 0.0, 1.0, 1.0 - head / height))
    for lines, down, look in (
        (said, MARGIN, TITLE),
        (explained, MARGIN + upper, ABOUT),
    ):
        figure.text(
            MARGIN / width,
            1.0 - down / height,
            "\n".join(lines),
            va="top",
            ha="left",
            linespacing=LINE / 1.2,
            in_layout=False,
            **look,
        )


def panel_grid(
    count: int,
    *,
    columns: int,
    width: tuple[float, float],
    height: tuple[float, float],
    least_width: float = 0.0,
    labels: tuple[str, str],
) -> tuple[Figure, Any]:
    """A panel for each of some groups, row by row, with one scale.

    Args:
        count: Groups.
        columns: Panels in a row, at most.
        width: Inches beside the panels, and of a panel.
        height: Inches above and below the panels, and of a panel.
        least_width: Inches across, at least.
        labels: What is drawn across and up.

    Returns:
        The figure and its axes, shape [row, column], those without a group hidden.
    """
    across = min(columns, count)
    down = -(-count // across)
    size = (max(least_width, width[0] + width[1] * across), height[0] + height[1] * down)
    figure, panels = subplots(down, across, size, sharex=True, sharey=True)
    for axes in panels.flat[count:]:
        axes.set_visible(False)
    for axes in panels.flat[max(0, count - across) : count]:
        axes.xaxis.set_tick_params(labelbottom=True)
        axes.set_xlabel(labels[0])
    for axes in panels[:, 0]:
        axes.set_ylabel(labels[1])
    return figure, panels


def legend_below(figure: Figure, *panels: Axes, columns: int = 4) -> None:
    """One legend for all panels, below them, so that it covers no curve.

    Args:
        figure: The figure.
        panels: Where its curves are; a name that several of them have stands once.
        columns: Names side by side at most; fewer where they are wider than the figure.
    """
    found: dict[str, Any] = {}
    for axes in panels:
        for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
            found.setdefault(name, handle)
    for count in range(columns, 0, -1):
        legend = figure.legend(
            list(found.values()), list(found), loc="outside lower center", ncols=count
        )
        if count == 1 or legend.get_window_extent().width <= figure.bbox.width:
            return
        legend.remove()
