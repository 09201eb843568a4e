"""The figure of fragility functions: curves, bands, medians, and the lanes they were fitted to."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.analysis.fragility import Curve
from warprock.analysis.limits import Limit
from warprock.analysis.lognormal import Observations
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION, VIOLET
from warprock.figures.scales import logarithmic
from warprock.figures.sheet import headline, style, subplots
from warprock.findings.fits import WHY_NONE
from warprock.findings.intensities import Measure, measure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

COLORS = (SKY, GREEN, ORANGE, VERMILION, BLUE, PURPLE, VIOLET)
DOTS = 12
"""Points that lanes are gathered into, where there are more intensities than that."""
GROUPS = 8
"""Groups that a figure shows at most, a row of panels each; the first ones."""
COLUMNS = 4
POINTS = 200
LETTERS = 12.0
"""Letters of a label that fit in an inch."""


def draw_curves(curves: Sequence[Curve], intensity: str, title: str) -> list[Drawing]:
    """Draws every fragility function in a panel of its own, so that no band hides another.

    Args:
        curves: The curves, those of a group behind one another.
        intensity: Column of the intensity measure.
        title: What it says: the first sentence of their finding.

    Returns:
        One drawing: a row of panels a group, a column a limit state.
    """
    groups = groups_of(curves)
    shown, measured = groups[:GROUPS], measure(intensity)
    limits = max(map(len, shown))
    columns = 2 if len(shown) == 1 and limits == 4 else min(limits, COLUMNS)
    rows = -(-limits // columns)
    wide = {1: 6.4, 2: 4.0}.get(columns, 3.0)
    with style():
        size = (0.6 + wide * columns, 0.6 + 2.3 * rows * len(shown))
        figure, grid = subplots(rows * len(shown), columns, size, sharey=True)
        for number, mine in enumerate(shown):
            panels = grid[rows * number : rows * (number + 1)]
            for axes in panels.flat[len(mine) :]:
                axes.set_visible(False)
            for axes in panels[:, 0]:
                axes.set_ylabel("probability [-]")
            for at, axes in enumerate(panels.flat[: len(mine)]):
                _draw_panel(axes, mine, at, measured)
                if number == len(shown) - 1 and at + columns >= len(mine):
                    axes.set_xlabel(textwrap.fill(measured.label, int(LETTERS * wide)))
        more = "" if len(shown) == len(groups) else f"; {len(shown)} of {len(groups)} groups"
        headline(figure, title, f"{_explained(curves)}{more}")
    medians = ", ".join(
        f"{f'{c.group_text}: ' if c.group_text else ''}{_name(c.limit)} {_median(c, measured)}"
        for c in curves
    )
    alt = f"Fragility functions over {measured.name}. {title}. {medians}."
    return [Drawing("fragility", figure, title, alt)]


def plot_curves(axes: Axes, curves: Sequence[Curve], intensity: str, group: int = 0) -> None:
    """Draws the fragility functions of one group over one another, with the lanes as dots.

    Args:
        axes: Where to.
        curves: The curves of all groups.
        intensity: Column of the intensity measure.
        group: Number of the group, from 0.
    """
    mine, measured = groups_of(curves)[group], measure(intensity)
    seen = [curve.seen.intensity for curve in mine]
    ends = min(map(np.min, seen)) / 1.05, max(map(np.max, seen)) * 1.05
    at = np.geomspace(*ends, POINTS)
    logarithmic(axes.xaxis)
    for number, curve in enumerate(mine):
        color = COLORS[number % len(COLORS)]
        label = f"{_name(curve.limit)}: {_median(curve, measured)}"
        dots, share = gathered(curve.seen)
        line = curve.fit.probability(at) if curve.fit.dispersion > 0.0 else np.full_like(at, np.nan)
        axes.plot(at * measured.size, line, color=color, label=label)
        axes.plot(dots * measured.size, share, "o", color=color, markersize=3.5)
    axes.set(xlabel=measured.label, ylabel="probability [-]", ylim=(-0.03, 1.03))
    axes.set_xlim(ends[0] * measured.size, ends[1] * measured.size)
    axes.set_title(mine[0].group_text)
    axes.legend()


def groups_of(curves: Sequence[Curve]) -> list[list[Curve]]:
    """The curves of each group, in their order."""
    groups: dict[str, list[Curve]] = {}
    for curve in curves:
        groups.setdefault(curve.group_text, []).append(curve)
    return list(groups.values())


def _name(limit: Limit) -> str:
    """A limit state in words."""
    return limit.text if limit.ratio is None else f"rotation {limit.name} of the slenderness angle"


def _median(curve: Curve, measured: Measure) -> str:
    """The median and the dispersion of a function, or why there is none."""
    fit = curve.fit
    if not fit.dispersion > 0.0:
        return f"no function: {WHY_NONE.get(fit.verdict.value, fit.verdict.value)}"
    return f"median {measured.text(fit.median)}, dispersion {fit.dispersion:.2f}"


def _explained(curves: Sequence[Curve]) -> str:
    """What the lines, bands and dots are, and how many lanes stand behind them."""
    lanes = int(curves[0].seen.count.sum())
    records = curves[0].seen.record_count
    same = len({(int(c.seen.count.sum()), c.seen.record_count) for c in curves}) == 1
    size = f"{lanes:,} lanes"
    if records < lanes:
        size += f" under {records:,} record{'s' * (records != 1)}"
    size += " in each panel" if same else " or more"
    what = "records" if records < lanes else "lanes"
    banded = any(curve.band is not None for curve in curves)
    band = f"; band: 5th to 95th percentile over {what}" if banded else ""
    lines = f"Line: lognormal function (grey: the other limit states){band}; dotted: its median"
    return f"{lines}; dots: share of lanes\n{size}{_not_counted(curves)}"


def _not_counted(curves: Sequence[Curve]) -> str:
    """How many lanes are in doubt or left out; empty where none is."""
    most = max(curve.in_doubt for curve in curves)
    left = sum({c.group_text: sum(c.left_out.values()) for c in curves}.values())
    doubt = f"; in doubt: up to {most:,} lanes" if most else ""
    return doubt + (f"; left out: {left:,} lanes" if left else "")


def _draw_panel(axes: Axes, curves: Sequence[Curve], number: int, measured: Measure) -> None:
    """One limit state of a group in its colour, the functions of the others in grey."""
    low = min(float(curve.seen.intensity.min()) for curve in curves)
    high = max(float(curve.seen.intensity.max()) for curve in curves)
    intensity = np.geomspace(low / 1.05, high * 1.05, POINTS)
    across = intensity * measured.size
    logarithmic(axes.xaxis)
    for other in curves:
        if other.fit.dispersion > 0.0 and other is not curves[number]:
            axes.plot(across, other.fit.probability(intensity), color=GREY, linewidth=0.7)
    curve, color = curves[number], COLORS[number % len(COLORS)]
    if curve.band is not None:
        ends = curve.band.probabilities(intensity)
        axes.fill_between(across, *ends, color=color, alpha=0.25, linewidth=0.0)
    if curve.fit.dispersion > 0.0:
        axes.plot(across, curve.fit.probability(intensity), color=color, linewidth=1.8)
        median = curve.fit.median * measured.size
        if across[0] <= median <= across[-1]:
            axes.plot([median, median], [0.0, 0.5], ":", color="black", linewidth=1.1)
            axes.plot(median, 0.5, "D", color="black", markersize=3.5)
    at, share = gathered(curve.seen)
    axes.plot(at * measured.size, share, "o", color=color, markersize=4.0, markeredgecolor="white")
    axes.set_xlim(across[0], across[-1])
    axes.set_ylim(-0.03, 1.03)
    # The name of a group stands once, above its first panel, and may be as long as the row.
    group = f"{curve.group_text}\n" if curve.group_text and number == 0 else ""
    axes.set_title(f"{group}{_name(curve.limit)}\n{_median(curve, measured)}")


def gathered(seen: Observations) -> tuple[Array, Array]:
    """Intensities and the share of lanes that reached the limit state there, shape [dot].

    Intensities that several lanes share are a dot each; where there are more than `DOTS`, lanes of
    neighbouring intensities are gathered, as many in each dot, at their geometric mean.
    """
    at, which = np.unique(seen.intensity, return_inverse=True)
    if len(at) > DOTS:
        order = np.argsort(seen.intensity, kind="stable")
        before = np.cumsum(seen.count[order]) - seen.count[order]
        which = np.empty(len(order), dtype=np.intp)
        which[order] = np.minimum(DOTS * before / seen.count.sum(), DOTS - 1).astype(np.intp)
    count = np.bincount(which, weights=seen.count)
    share = np.bincount(which, weights=seen.reached) / count
    return np.exp(np.bincount(which, weights=seen.count * np.log(seen.intensity)) / count), share
