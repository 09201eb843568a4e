"""The figure of an incremental dynamic analysis: its curves, and how capacities are distributed."""

from __future__ import annotations

import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.analysis.capacities import (
    FACTOR,
    FRACTILES,
    Capacities,
    fractile_curves,
    run_curves,
    unit_intensity,
)
from warprock.analysis.incremental import Analysis
from warprock.case.columns import input_meaning
from warprock.figures.plots import BLACK, BLUE, FIGURE_TITLE, ORANGE, RED, drawing, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

GROUPS = 6
"""Groups that a figure shows at most; the first ones."""
LINES = 200
"""Lanes of a group that are drawn one by one, at most; fractiles are of all."""
FALLEN_AT = 1.15
"""Where a curve that has fallen goes on, up the right edge of its panel."""
LIFTED = 1e-3
"""Rotation / slenderness angle from which on a block has moved."""
POINTS = 200
_STYLES = {0.16: (0, (4, 2)), 0.5: "-", 0.84: (0, (1.5, 1.2))}


def draw_analysis(
    path: pathlib.Path, found: Analysis, groups: Sequence[Capacities], intensity: str
) -> pathlib.Path:
    """Draws a row of two panels a group, the intensity up both.

    Args:
        path: File to write.
        found: The analysis.
        groups: Its capacities.
        intensity: The intensity measure.

    Returns:
        The file.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    shown = groups[:GROUPS]
    unit = unit_intensity(found, intensity)
    runs = run_curves(found, unit)
    with drawing() as plt:
        figure, grid = plt.subplots(
            len(shown),
            2,
            figsize=(8.4, 2.0 + 2.6 * len(shown)),
            sharex="col",
            sharey=True,
            squeeze=False,
            layout="constrained",
        )
        for (left, right), group in zip(grid, shown, strict=True):
            _draw_curves(left, [runs[lane] for lane in group.lanes])
            _draw_capacities(right, group)
            left.set_title(f"{group.group_text or 'all lanes'}: {_size(group)}", loc="left")
            left.set_ylabel(_label(intensity))
            left.set_yscale("log")
            left.set_ylim(*_range(runs))
            left.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            left.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            left.yaxis.set_minor_locator(NullLocator())
        grid[-1, 0].set_xlabel("largest rotation / slenderness angle [-]")
        grid[-1, 1].set_xlabel("share of lanes that have overturned [-]")
        handles, names = [], []
        for axes in grid[0]:
            for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
                handles.append(handle)
                names.append(name)
        figure.legend(handles, names, loc="outside lower center", ncols=3, frameon=False)
        more = "" if len(shown) == len(groups) else f"; {len(shown)} of {len(groups)} groups"
        name = found.plan.content["case"]["name"]
        figure.suptitle(
            f"Incremental dynamic analysis of {name}, {found.plan.engine}{more}\n"
            f"{len(found.curves):,} runs; a curve goes right where its block first fell",
            **FIGURE_TITLE,
        )
        return save(figure, path)


def _range(runs: Sequence[tuple[Array, Array]]) -> tuple[float, float]:
    """Intensities from the weakest that moves a block to a little above the last first fall."""
    moving = [float(at[ratio > LIFTED].min(initial=np.inf)) for at, ratio in runs]
    falls = [float(at[np.isinf(ratio)][0]) for at, ratio in runs if np.isinf(ratio).any()]
    top = max(float(at[-1]) for at, _ in runs if len(at))
    highest = 1.5 * max(falls) if falls else top
    lowest = min(moving) if np.isfinite(min(moving)) else 0.1 * top
    return 0.8 * min(lowest, 0.5 * highest), highest


def _size(group: Capacities) -> str:
    records = f", {group.records} records" if group.records < len(group.lanes) else ""
    return f"{len(group.lanes)} lanes{records}"


def _label(intensity: str) -> str:
    """Meaning and unit of the intensity measure."""
    if intensity == FACTOR:
        return "factor on the motion [-]"
    unit, text = input_meaning(intensity)
    name = {
        "peak_acceleration_m_s2": "peak base acceleration",
        "normalised_acceleration": "peak base acceleration\n/ (g tan(slenderness angle))",
        "scale": "factor on the record",
    }.get(intensity, text)
    return f"{name} [{unit.replace('^2', '²')}]"


def _draw_curves(axes: Axes, runs: Sequence[tuple[Array, Array]]) -> None:
    """Curves of single lanes up to their first fall, and fractiles of all."""
    step = max(1, len(runs) // LINES)
    for number, (at, ratio) in enumerate(runs[::step]):
        stop = int(np.argmax(np.isinf(ratio))) if np.isinf(ratio).any() else len(at)
        across, up = ratio[:stop], at[:stop]
        if stop < len(at):
            across, up = np.append(across, FALLEN_AT), np.append(up, at[stop])
        name = "one lane" if number == 0 else None
        axes.plot(across, up, color="#9A9A9A", linewidth=0.6, alpha=0.7, label=name, zorder=2)
    levels, fractiles = fractile_curves(runs)
    for share, values in zip(FRACTILES, fractiles, strict=True):
        axes.plot(
            np.where(np.isinf(values), FALLEN_AT, np.minimum(values, FALLEN_AT)),
            levels,
            color=RED,
            linestyle=_STYLES[share],
            linewidth=1.5,
            label=f"{share:.0%} of the lanes rotate less",
            zorder=3,
        )
    axes.set_xlim(0.0, FALLEN_AT)
    axes.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0, FALLEN_AT], ["0", "", "0.5", "", "1", "fell"])


def _draw_capacities(axes: Axes, group: Capacities) -> None:
    """Share of lanes that have overturned, the lognormal distribution, and its band."""
    known = np.sort(group.high[np.isfinite(group.high)])
    share = np.arange(1, len(known) + 1) / len(group.high)
    # At every capacity the share steps to the next.
    steps = np.repeat(np.append(0.0, share), 2)[1:-1]
    name = "lanes, at their first fall"
    axes.plot(steps, np.repeat(known, 2), color=BLACK, linewidth=1.0, label=name)
    low = float(np.min(np.where(group.low > 0.0, group.low, np.inf)))
    ends = np.concatenate([known, group.low[group.low > 0.0]])
    levels = np.geomspace(min(low, ends.min()), ends.max(), POINTS)
    if group.band is not None:
        axes.fill_betweenx(
            levels,
            *group.band.probabilities(levels),
            color=ORANGE,
            alpha=0.3,
            linewidth=0.0,
            label="5th to 95th percentile over records",
        )
    if group.fit.dispersion > 0.0:
        axes.plot(
            group.fit.probability(levels),
            levels,
            color=BLUE,
            linewidth=1.5,
            label="lognormal distribution",
        )
    else:
        axes.set_title(f"no distribution: {group.fit.verdict.value}", loc="left")
    axes.set_xlim(-0.02, 1.02)
