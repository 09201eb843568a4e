"""The figure of yearly rates: the hazard, the fragility functions, and which motions contribute."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.analysis.groups import group_text
from warprock.analysis.lognormal import Verdict
from warprock.analysis.risk import Risk, allowed_hazard, contribution_edges
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, DASHES, SERIES
from warprock.figures.scales import logarithmic
from warprock.figures.sheet import headline, legend_below, style, subplots
from warprock.findings.intensities import measure
from warprock.findings.risk import once_in

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

SHOWN = 6
"""Functions that a figure shows at most; the first ones."""
POINTS = 200


def draw_risk(
    risks: Sequence[Risk], age: float | None, unlikely: float, title: str
) -> list[Drawing]:
    """Draws the hazard, the functions, and which intensities make their rates.

    Args:
        risks: The rates.
        age: How long the objects have stood [years]; None where that is not asked.
        unlikely: Chance of having stood below which a hazard is ruled out.
        title: What it says: the first sentence of their finding.

    Returns:
        One drawing of three panels; none where there is no rate to draw.
    """
    known = [each for each in risks if each.function.fit.verdict is Verdict.FITTED][:SHOWN]
    if not known:
        return []
    measured = measure(known[0].hazard.measure)
    edges = contribution_edges(known)
    with style():
        figure, panels = subplots(1, 3, (12.0, 3.6))
        hazard, functions, parts = panels[0]
        at = np.geomspace(edges[0], edges[-1], POINTS)
        rate = known[0].hazard.rate(at)
        hazard.plot(at * measured.size, rate, color=BLACK, label="hazard")
        for number, risk in enumerate(known):
            look: dict[str, Any] = {"color": SERIES[number % len(SERIES)], "label": name_of(risk)}
            look |= {"linestyle": DASHES[number % len(DASHES)]}
            if age is not None:
                allowed = allowed_hazard(risk.function.fit, at, age, unlikely)
                hazard.plot(at * measured.size, allowed, **look)
            functions.plot(at * measured.size, risk.function.fit.probability(at), **look)
            _draw_parts(parts, risk, edges, measured.size, **look)
        hazard.set_ylim(0.3 * rate.min(), 3.0 * rate.max())
        logarithmic(hazard.yaxis)
        for axes, label in (
            (hazard, "rate of exceedance [1/year]"),
            (functions, "probability [-]"),
            (parts, "share of the rate [-]"),
        ):
            logarithmic(axes.xaxis)
            axes.set(xlabel=textwrap.fill(measured.label, 34), ylabel=label)
            axes.set_xlim(edges[0] * measured.size, edges[-1] * measured.size)
        functions.set_ylim(-0.03, 1.03)
        parts.set_ylim(bottom=0.0)
        legend_below(figure, hazard, functions)
        about = "Left: the hazard; middle: fragility functions; right: which motions make the rate"
        if age is not None:
            about += (
                f"\nLeft, coloured: above these rates an object would have stood for {age:,.6g} "
                f"years with a chance of less than {100.0 * unlikely:g} %"
            )
        headline(figure, title, about)
    rates = "; ".join(f"{name_of(risk)}: {once_in(1.0 / risk.rate)}" for risk in known)
    alt = f"Hazard, fragility functions and contributions to the yearly rate. {title}. {rates}."
    return [Drawing("risk", figure, title, alt)]


def bare_risk(risk: Risk) -> Drawing | None:
    """Which motions make a rate, without a title, for a page that has one; None without a fit."""
    if risk.function.fit.verdict is not Verdict.FITTED:
        return None
    with style():
        figure, panels = subplots(1, 1, (7.2, 2.4))
        plot_risk(panels[0, 0], [risk])
        panels[0, 0].set_title("")
        panels[0, 0].set_ylim(bottom=0.0)
    return Drawing("motions", figure, "Motions", "Which motions make the yearly rate.")


def plot_risk(axes: Axes, risks: Sequence[Risk], group: int = 0) -> None:
    """Draws which intensities make one of the rates.

    Args:
        axes: Where to.
        risks: The rates.
        group: Number of the rate, from 0.
    """
    risk = risks[group]
    measured = measure(risk.hazard.measure)
    logarithmic(axes.xaxis)
    axes.set(xlabel=measured.label, ylabel="share of the rate [-]", title=name_of(risk))
    if risk.function.fit.verdict is Verdict.FITTED:
        _draw_parts(axes, risk, contribution_edges([risk]), measured.size, color=SERIES[0])


def name_of(risk: Risk) -> str:
    """A rate in words: what tells its function from others, and the limit state."""
    return ": ".join(filter(None, (group_text(risk.function.name), risk.function.limit)))


def _draw_parts(axes: Axes, risk: Risk, edges: Array, size: float, **look: Any) -> None:
    """The share of a rate that each range of intensities makes, as steps."""
    axes.stairs(risk.between(edges) / risk.rate, edges * size, **look)
