"""The figure of an incremental dynamic analysis: its curves, and how capacities are distributed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.analysis.capacities import (
    FRACTILES,
    Capacities,
    fractile_curves,
    run_curves,
    unit_intensity,
)
from warprock.analysis.incremental import Analysis
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, BLUE, GREY, ORANGE
from warprock.figures.scales import logarithmic
from warprock.figures.sheet import headline, legend_below, style, subplots
from warprock.findings.intensities import Measure, measure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

GROUPS = 6
"""Groups that a figure shows at most; the first ones."""
LINES = 200
"""Lanes of a group that are drawn one by one, at most; fractiles are of all."""
FALLEN_AT = 1.15
"""Where a curve that has fallen goes on, along the upper edge of its panel."""
LIFTED = 1e-3
"""Rotation / slenderness angle from which on a block has moved."""
POINTS = 200
_STYLES: dict[float, Any] = {0.16: (0, (4, 2)), 0.5: "-", 0.84: (0, (1.5, 1.2))}


def draw_analysis(
    found: Analysis, groups: Sequence[Capacities], intensity: str, title: str
) -> list[Drawing]:
    """Draws a row of two panels a group, the intensity across both.

    Args:
        found: The analysis.
        groups: Its capacities.
        intensity: The intensity measure.
        title: What it says: the first sentence of its finding.

    Returns:
        One drawing.
    """
    shown = groups[:GROUPS]
    measured = measure(intensity)
    runs = run_curves(found, unit_intensity(found, intensity) * measured.size)
    with style():
        size = (9.6, 0.9 + 2.9 * len(shown))
        figure, grid = subplots(len(shown), 2, size, sharex=True, sharey="col")
        for (left, right), group in zip(grid, shown, strict=True):
            logarithmic(left.xaxis)
            _draw_curves(left, [runs[lane] for lane in group.lanes])
            _draw_capacities(right, group, measured)
            left.set_title(f"{group.group_text or 'all lanes'}: {_size(group)}")
            right.set_title(_distribution(group, measured))
            left.set_ylabel("largest rotation /\nslenderness angle [-]")
            right.set_ylabel("share of lanes fallen [-]")
            left.set_xlim(*_range(runs))
        for axes in grid[-1]:
            axes.set_xlabel(measured.label)
        legend_below(figure, *grid[0], columns=3)
        more = "" if len(shown) == len(groups) else f"; {len(shown)} of {len(groups)} groups"
        about = (
            f"{found.plan.content['case']['name']}, {found.plan.engine}: {len(found.curves):,} "
            f"runs{more}. Left: a curve goes up where its block first falls. Right: intensities "
            "at the first fall"
        )
        headline(figure, title, about)
    fits = "; ".join(f"{g.group_text or 'all lanes'}: {_distribution(g, measured)}" for g in groups)
    alt = f"Incremental dynamic analysis over {measured.name}. {title}. {fits}."
    return [Drawing("ida", figure, title, alt)]


def plot_analysis(
    axes: Axes, found: Analysis, groups: Sequence[Capacities], intensity: str, group: int = 0
) -> None:
    """Draws the curves of one group of lanes up to their first fall, and their fractiles.

    Args:
        axes: Where to.
        found: The analysis.
        groups: Its capacities.
        intensity: The intensity measure.
        group: Number of the group, from 0.
    """
    measured, mine = measure(intensity), groups[group]
    runs = run_curves(found, unit_intensity(found, intensity) * measured.size)
    logarithmic(axes.xaxis)
    _draw_curves(axes, [runs[lane] for lane in mine.lanes])
    axes.set_xlim(*_range(runs))
    axes.set(xlabel=measured.label, ylabel="largest rotation / slenderness angle [-]")
    axes.set_title(f"{mine.group_text or 'all lanes'}: {_size(mine)}")
    axes.legend()


def _distribution(group: Capacities, measured: Measure) -> str:
    """Median and dispersion of the capacities, or why there are none."""
    if not group.fit.dispersion > 0.0:
        return f"no distribution: {group.fit.verdict.value}"
    return f"median {measured.text(group.fit.median)}, dispersion {group.fit.dispersion:.2f}"


def _range(runs: Sequence[tuple[Array, Array]]) -> tuple[float, float]:
    """Intensities from the weakest that moves a block to a little above the last first fall."""
    moving = [float(at[ratio > LIFTED].min(initial=np.inf)) for at, ratio in runs]
    falls = [float(at[np.isinf(ratio)][0]) for at, ratio in runs if np.isinf(ratio).any()]
    top = max(float(at[-1]) for at, _ in runs if len(at))
    highest = 1.3 * max(falls) if falls else top
    lowest = min(moving) if np.isfinite(min(moving)) else 0.1 * top
    return 0.8 * min(lowest, 0.5 * highest), highest


def _size(group: Capacities) -> str:
    records = f"{group.records} record{'s' * (group.records > 1)}"
    return f"{len(group.lanes)} lanes" + (f", {records}" * (group.records < len(group.lanes)))


def _draw_curves(axes: Axes, runs: Sequence[tuple[Array, Array]]) -> None:
    """Curves of single lanes up to their first fall, and fractiles of all."""
    step = max(1, len(runs) // LINES)
    for number, (at, ratio) in enumerate(runs[::step]):
        stop = int(np.argmax(np.isinf(ratio))) if np.isinf(ratio).any() else len(at)
        up, across = ratio[:stop], at[:stop]
        if stop < len(at):
            up, across = np.append(up, FALLEN_AT), np.append(across, at[stop])
        name = "one lane" if number == 0 else None
        axes.plot(across, up, color=GREY, linewidth=0.6, alpha=0.7, label=name, zorder=2)
    levels, fractiles = fractile_curves(runs)
    for share, values in zip(FRACTILES, fractiles, strict=True):
        axes.plot(
            levels,
            np.where(np.isinf(values), FALLEN_AT, np.minimum(values, FALLEN_AT)),
            color=BLUE,
            linestyle=_STYLES[share],
            linewidth=1.5,
            label=f"{share:.0%} of the lanes rotate less",
            zorder=3,
        )
    axes.set_ylim(0.0, FALLEN_AT)
    axes.set_yticks([0.0, 0.25, 0.5, 0.75, 1.0, FALLEN_AT], ["0", "", "0.5", "", "1", "fallen"])


def _draw_capacities(axes: Axes, group: Capacities, measured: Measure) -> None:
    """Share of lanes that have overturned, the lognormal distribution, and its band."""
    known = np.sort(group.high[np.isfinite(group.high)])
    share = np.arange(1, len(known) + 1) / len(group.high)
    # At every capacity the share steps to the next.
    steps = np.repeat(np.append(0.0, share), 2)[1:-1]
    at = np.repeat(known, 2) * measured.size
    axes.plot(at, steps, color=BLACK, linewidth=1.0, label="lanes, at their first fall")
    ends = np.concatenate([known, group.low[group.low > 0.0]])
    levels = np.geomspace(0.9 * ends.min(), 1.1 * ends.max(), POINTS)
    across = levels * measured.size
    if group.band is not None:
        name = "5th to 95th percentile over records"
        between = group.band.probabilities(levels)
        axes.fill_between(across, *between, color=ORANGE, alpha=0.3, linewidth=0.0, label=name)
    if group.fit.dispersion > 0.0:
        probability, name = group.fit.probability(levels), "lognormal distribution"
        axes.plot(across, probability, color=ORANGE, linewidth=1.8, label=name)
    axes.set_ylim(-0.02, 1.02)
