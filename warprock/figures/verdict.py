"""The figure of a verdict: the block under weaker and stronger motions, and its neighbours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from warprock.analysis.verdict import Verdict
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, BLUE, FALLEN, GREY
from warprock.figures.scales import logarithmic
from warprock.figures.sheet import headline, legend_below, style, subplots
from warprock.model.response import FALLEN_NAMES, USABLE_NAMES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FALLEN_AT = 1.15
"""Where runs that fell are marked, above all that stood."""


def draw_verdict(found: Verdict, title: str) -> list[Drawing]:
    """Draws the block at every factor on its motion, and its neighbours.

    Args:
        found: The verdict.
        title: What it says: the first sentence of its finding.
    """
    with style():
        figure, panels = subplots(1, 1, (7.2, 3.6))
        plot_verdict(panels[0, 0], found)
        panels[0, 0].get_legend().remove()
        legend_below(figure, panels[0, 0])
        about = (
            f"{found.run.case.title}; {found.run.response.engine}. Crosses in the upper strip: it "
            "fell; the dotted line is the motion as it is"
        )
        headline(figure, title, about)
    alt = f"Largest rotation over the factor on the motion. {title}."
    return [Drawing("verdict", figure, title, alt)]


def plot_verdict(axes: Axes, found: Verdict, group: int = 0) -> None:
    """Draws the block at every factor on its motion, and its neighbours.

    Args:
        axes: Where to.
        found: The verdict.
        group: Number of the group: 0, there is one.
    """
    assert group == 0
    curves = found.ladder.curves
    for table, factor, color, marker, size, name in (
        (found.neighbours, "motion_factor", GREY, "o", 2.5, "a neighbour"),
        (curves.sort_values("factor"), "factor", BLUE, "o", 4.0, "the block"),
    ):
        usable = table["status"].isin(USABLE_NAMES)
        fell = usable & table["outcome"].isin(FALLEN_NAMES)
        stood = table[usable & ~fell]
        line = "-" if table is not found.neighbours else ""
        axes.plot(
            stood[factor],
            np.minimum(stood["peak_rotation_ratio"], 1.08),
            marker=marker,
            markersize=size,
            color=color,
            linestyle=line,
            linewidth=0.8,
            label=name,
        )
        high = FALLEN_AT if table is not found.neighbours else FALLEN_AT + 0.07
        axes.plot(
            table[fell][factor],
            np.full(int(fell.sum()), high),
            "x",
            color=FALLEN if table is not found.neighbours else GREY,
            markersize=size + 1.0,
            label=f"{name}, fallen",
        )
    axes.axvline(1.0, color=BLACK, linestyle=":", linewidth=1.0)
    axes.axhline(1.1, color=BLACK, linewidth=0.6)
    logarithmic(axes.xaxis)
    axes.set(xlabel="factor on the motion [-]", ylim=(-0.03, 1.3))
    axes.set_ylabel("largest rotation /\nslenderness angle [-]")
    axes.legend()
