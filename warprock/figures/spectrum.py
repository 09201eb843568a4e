"""The figure of rocking spectra."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from warprock.analysis.spectrum import Spectrum
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLUE, DASHES, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION
from warprock.figures.sheet import headline, legend_below, panel_grid, style
from warprock.model.response import USABLE, Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLORS = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY)
FALLEN_AT = 1.2
"""Where blocks that overturned are marked, above all that stood."""
COLUMNS = 2
LABELS = ("2π / p [s]: larger blocks to the right", "peak rotation / slenderness angle [-]")
"""What is drawn across and up."""


def draw_spectrum(found: Spectrum, title: str) -> list[Drawing]:
    """Draws every group of curves in a panel of its own.

    Args:
        found: The spectra.
        title: What it says: the first sentence of their finding.

    Returns:
        One drawing.
    """
    count = len(found.groups)
    with style():
        figure, panels = panel_grid(
            count,
            columns=COLUMNS,
            width=(1.4, 5.2),
            height=(1.2, 3.2),
            least_width=8.0,
            labels=LABELS,
        )
        for number, axes in enumerate(panels.flat[:count]):
            _draw_group(axes, found, number)
        legend_below(figure, panels.flat[0], columns=3 * min(COLUMNS, count))
        about = (
            f"{found.run.case.title}; {found.run.response.engine}, {len(found.period):,} blocks, "
            "a curve a slenderness angle; angular velocity kept at an impact: "
            f"{_restitution(found)}; crosses in the upper strip: blocks that overturned"
        )
        headline(figure, title, about)
    return [Drawing("spectrum", figure, title, f"Rocking spectra. {title}. {about}.")]


def plot_spectrum(axes: Axes, found: Spectrum, group: int = 0) -> None:
    """Draws the curves of one group, crosses for blocks that overturned.

    Args:
        axes: Where to.
        found: The spectra.
        group: Number of the group, from 0.
    """
    _draw_group(axes, found, group)
    axes.set(xlabel=LABELS[0], ylabel=LABELS[1])
    axes.legend()


def _restitution(found: Spectrum) -> str:
    """The angular restitution in words: the numbers of the case, or Housner's closed form."""
    if not found.run.lane_set.scene.restitution_given:
        return "Housner's closed form"
    known = found.run.lane_set.inputs["angular_restitution"]
    return ", ".join(sorted({f"{value:.3g}" for value in known}))


def _draw_group(axes: Axes, found: Spectrum, group: int) -> None:
    """The curves of one group; a curve is broken where its blocks overturned."""
    fell = found.run.response["outcome"] == Outcome.OVERTURNED
    usable = np.isin(found.run.response["status"], USABLE)
    drawn = np.where(fell | ~usable, np.nan, found.ratio)
    for number, (curve, lanes) in enumerate(zip(found.curves, found.lanes[group], strict=True)):
        color = COLORS[number % len(COLORS)]
        style = DASHES[(number // len(COLORS)) % len(DASHES)]
        name = f"slenderness {curve}"
        at = found.period[lanes]
        line: dict[str, Any] = {"color": color, "linestyle": style, "linewidth": 1.3, "label": name}
        # Dots, too: a block that stands between two that fell has no line.
        axes.plot(at, drawn[lanes], marker=".", markersize=2.5, **line)
        high = FALLEN_AT + 0.035 * number
        gone = lanes[fell[lanes] & usable[lanes]]
        if len(gone):
            up = np.full(len(gone), high)
            axes.plot(found.period[gone], up, "x", color=color, markersize=3.0, clip_on=False)
    axes.axhline(1.0, color=GREY, linewidth=0.8, linestyle=":")
    top = FALLEN_AT + 0.035 * len(found.curves)
    largest = float(np.nanmax(drawn[found.lanes].ravel(), initial=0.0))
    anything_fell = bool(np.any(fell[found.lanes]))
    axes.set_ylim(0.0, top if anything_fell or largest > 0.5 else 1.15 * max(largest, 1e-3))
    if anything_fell:
        ticks = np.linspace(0.0, 1.0, 6)
        middle = 0.5 * (FALLEN_AT + top)
        axes.set_yticks([*ticks, middle], [*(f"{tick:g}" for tick in ticks), "overturned"])
    axes.set_xlim(found.period.min(), found.period.max())
    axes.set_title(found.groups[group])
