"""The style that all figures share, and how they are written."""

from __future__ import annotations

import os
import pathlib
import re
import textwrap
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.figures.palette import BLACK as BLACK
from warprock.figures.palette import BLUE as BLUE
from warprock.figures.palette import ENGINE_MARKS as ENGINE_MARKS
from warprock.figures.palette import ENGINE_STYLES as ENGINE_STYLES
from warprock.figures.palette import GREEN as GREEN
from warprock.figures.palette import OLIVE as YELLOW
from warprock.figures.palette import ORANGE as ORANGE
from warprock.figures.palette import PURPLE as PURPLE
from warprock.figures.palette import SKY as SKY
from warprock.figures.palette import VERMILION as RED
from warprock.figures.palette import engine_marks as engine_marks
from warprock.run.files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]

DPI = 160
__all__ = ["RED", "YELLOW"]
SHORT_ROTATION_LABEL = "rotation /\nslenderness [-]"
TIME_LABEL = "time [s]"

FIGURE_TITLE: dict[str, Any] = {"x": 0.01, "ha": "left", "fontsize": 10.5}


_NUMBER = re.compile(r"\$\\mathdefault\{[^$a-zA-Z\\]*(\\times)?[^$a-zA-Z\\]*\}\$")
"""A number as Matplotlib writes it on a logarithmic axis, such as $\\mathdefault{10^{-3}}$."""


def _pyplot() -> Any:
    """Matplotlib's pyplot, drawing to files whatever screen it was set up for.

    A notebook names a screen in MPLBACKEND that Matplotlib may refuse where it is imported.
    """
    named = os.environ.pop("MPLBACKEND", None)
    try:
        import matplotlib

        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
    finally:
        if named is not None:
            os.environ["MPLBACKEND"] = named
    return plt


@contextmanager
def drawing() -> Iterator[Any]:
    """Matplotlib's pyplot with a style that is legible in print, for the block's duration."""
    plt = _pyplot()

    style: Any = {
        "font.size": 9.0,
        "axes.titlesize": 9.5,
        "axes.labelsize": 9.0,
        "legend.fontsize": 9.0,
        "xtick.labelsize": 8.5,
        "ytick.labelsize": 8.5,
        "axes.grid": True,
        "grid.color": "#DDDDDD",
        "grid.linewidth": 0.6,
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "savefig.dpi": DPI,
        "figure.dpi": DPI,
    }
    with plt.rc_context(style):
        yield plt


def save(figure: Figure, path: pathlib.Path) -> pathlib.Path:
    """Writes a figure as PNG, whole or not at all, and closes it.

    Texts are drawn as they are written: a label with two dollar signs is no formula. Only the
    numbers of a logarithmic axis, which Matplotlib writes itself, are.
    """
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        if text.get_text() and not _NUMBER.fullmatch(text.get_text()):
            text.set_parse_math(False)
    with replacing(path) as temporary, warnings.catch_warnings():
        # A letter that the font lacks is drawn as an empty box.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        figure.savefig(temporary, format="png", dpi=DPI)
    _pyplot().close(figure)
    return path


def panel_grid(
    plt: Any,
    count: int,
    *,
    columns: int,
    width: tuple[float, float],
    height: tuple[float, float],
    least_width: float = 0.0,
    labels: tuple[str, str],
    same_x: bool = True,
) -> tuple[Figure, Any]:
    """A panel for each of some groups, row by row, with one scale.

    Args:
        plt: What `drawing` yields.
        count: Groups.
        columns: Panels in a row, at most.
        width: Inches beside the panels, and of a panel.
        height: Inches above and below the panels, and of a panel.
        least_width: Inches across, at least.
        labels: What is drawn across and up.
        same_x: Whether all panels have the same scale across.

    Returns:
        The figure and its axes, shape [row, column], those without a group hidden.
    """
    across = min(columns, count)
    down = -(-count // across)
    figure, panels = plt.subplots(
        down,
        across,
        figsize=(max(least_width, width[0] + width[1] * across), height[0] + height[1] * down),
        sharex=same_x,
        sharey=True,
        squeeze=False,
        layout="constrained",
    )
    for axes in panels.flat[count:]:
        axes.set_visible(False)
    for axes in panels.flat[max(0, count - across) : count]:
        axes.xaxis.set_tick_params(labelbottom=True)
        axes.set_xlabel(labels[0])
    for axes in panels[:, 0]:
        axes.set_ylabel(labels[1])
    return figure, panels


def wrapped_title(figure: Figure, texts: Sequence[str], letters: int) -> None:
    """A title above a figure, each text in lines of so many letters an inch of its width."""
    width = int(letters * figure.get_figwidth())
    lines = [textwrap.fill(text, width) for text in texts]
    figure.suptitle("\n".join(lines), **FIGURE_TITLE)


def legend_below(figure: Figure, axes: Axes, *, columns: int = 4) -> None:
    """One legend for all panels, below them, so that it covers no curve."""
    handles, names = axes.get_legend_handles_labels()
    figure.legend(
        handles, names, loc="outside lower center", ncols=columns, frameon=False, handlelength=2.8
    )


def history(
    axes: Axes, times: Array, ratio: Array, engine: str, window: tuple[float, float] | None = None
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
