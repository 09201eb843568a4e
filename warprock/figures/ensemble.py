"""The figure of an ensemble: the distribution of every cell, and how often its blocks fall."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.case.case import Case
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, BLUE, GREEN, ORANGE, VERMILION
from warprock.figures.sheet import headline, style, subplots
from warprock.running.case_run import CaseRun
from warprock.running.cells import QUANTILES, cell_table
from warprock.running.lane_table import PEAK_RATIO
from warprock.tables.cells import block_suffixes, value_name
from warprock.tables.swept import swept_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

BOXES = 40
"""Cells up to which each has a box; of more, bands are drawn."""
HALF_BOX = 0.28
"""Half of the width of a box, the next cell being 1 away."""
CELL_INCHES = 0.25
"""Width of a cell in a figure of many."""
NAMED = 40
"""Names that fit below the cells."""
GROUPS = 12
"""Outer values of the sweep up to which each has its name above its cells."""
UPRIGHT = 56
"""Letters of all names up to which they stand upright."""
BLOCK_COLORS = (BLUE, ORANGE, GREEN)
FALLEN: dict[str, Any] = {"facecolor": VERMILION, "alpha": 0.13, "linewidth": 0.0}
RATIO_LABEL = "peak rotation /\nslenderness angle [-]"


def draw_cells(run: CaseRun) -> Drawing:
    """Draws the quantiles of the peak rotation of each block, and the share that overturned.

    Args:
        run: The run of a case with an ensemble.
    """
    table = cell_table(run.lane_set, run.response)
    lanes = run.lane_set.lanes
    blocks = block_suffixes(lanes.block_count, stacked=lanes.stacked)
    with style():
        heights = [2.1] * len(blocks) + [1.4]
        wide = min(max(8.0, 2.0 + CELL_INCHES * len(table)), 13.0)
        size = (wide, 1.2 + sum(heights))
        figure, panels = subplots(len(heights), 1, size, height_ratios=heights, sharex=True)
        shown = list(panels[:, 0])
        for axes, (block, suffix), color in zip(
            shown, blocks.items(), itertools.cycle(BLOCK_COLORS), strict=False
        ):
            _draw_quantiles(axes, table, suffix, color)
            axes.set_ylabel(f"block {block}\n{RATIO_LABEL}" if block else RATIO_LABEL)
        _draw_shares(shown[-1], table)
        _name_cells(shown, run.case)
        title = _message(run.case, table, blocks)
        about = f"{run.case.title}\n{_explained(run, len(table))}"
        headline(figure, title, about)
    return Drawing("ensemble", figure, title, f"{run.case.title}. {title}.")


def _message(case: Case, table: pd.DataFrame, blocks: Mapping[str, str]) -> str:
    """Where most members overturn, or else where the median peak is largest."""
    share = np.nan_to_num(table["overturned"].to_numpy(float))
    most = int(np.argmax(share))
    if share[most] > 0.0:
        low, high = (
            100.0 * float(table[f"overturned_{end}"].iloc[most]) for end in ("low", "high")
        )
        return (
            f"Members overturn in {int(np.sum(share > 0.0))} of {len(table)} cells, most often at "
            f"{_cell(case, most)}: {100.0 * share[most]:.3g} % ({low:.3g} to {high:.3g} %)"
        )
    medians = {
        block: np.nan_to_num(table[f"{PEAK_RATIO}_median{end}"].to_numpy(float))
        for block, end in blocks.items()
    }
    block = max(blocks, key=lambda each: float(medians[each].max()))
    at = int(np.argmax(medians[block]))
    of = f"block {block}, " if block else ""
    return (
        f"No member overturns; the largest median of a peak is {medians[block][at]:.3g} of the "
        f"slenderness angle ({of}{_cell(case, at)})"
    )


def _cell(case: Case, number: int) -> str:
    """The values of a cell in words."""
    swept = swept_axes(case)
    if not swept:
        return case.name
    place = np.unravel_index(number, [axis.length for axis in swept])
    return ", ".join(value_name(axis, int(at)) for axis, at in zip(swept, place, strict=True))


def _explained(run: CaseRun, cells: int) -> str:
    drawn = (
        "box: quartiles, whiskers: 5 % and 95 %"
        if cells <= BOXES
        else "dark: quartiles, light: 5 % to 95 %"
    )
    return (
        f"{run.response.engine}, {run.case.members} members a cell; line: median, {drawn}, "
        "strip at the top: overturned"
    )


def _draw_quantiles(axes: Axes, table: pd.DataFrame, suffix: str, color: str) -> None:
    """Quantiles of the cells; those among overturned members end in a red strip at the top."""
    found = {name: table[f"{PEAK_RATIO}_{name}{suffix}"].to_numpy(float) for name in QUANTILES}
    every = np.concatenate(list(found.values()))
    finite = every[np.isfinite(every)]
    top = 1.08 * max(float(finite.max()), 1e-3) if len(finite) else 1.0
    axes.set_ylim(0.0, top)
    if np.isinf(every).any():
        ticks = [tick for tick in axes.get_yticks() if 0.0 <= tick <= 0.97 * top]
        axes.axhspan(top, 1.14 * top, **FALLEN)
        axes.set_yticks([*ticks, 1.07 * top], [*(f"{tick:.4g}" for tick in ticks), "overturned"])
        axes.get_yticklabels()[-1].set_color(VERMILION)
        axes.set_ylim(0.0, 1.14 * top)
    at = np.arange(len(table), dtype=np.float64)
    low, first, middle, third, high = (
        np.where(np.isinf(values), 1.07 * top, values) for values in found.values()
    )
    if len(table) > BOXES:
        axes.fill_between(at, low, high, color=color, alpha=0.2, linewidth=0.0)
        axes.fill_between(at, first, third, color=color, alpha=0.45, linewidth=0.0)
        axes.plot(at, middle, color=BLACK, linewidth=1.2)
        return
    axes.vlines(at, low, high, color=color, linewidth=1.3)
    axes.bar(
        at,
        third - first,
        2.0 * HALF_BOX,
        first,
        color=color,
        alpha=0.55,
        linewidth=0.8,
        edgecolor=color,
    )
    for ends in (low, high):
        axes.hlines(ends, at - 0.5 * HALF_BOX, at + 0.5 * HALF_BOX, color=color, linewidth=1.3)
    axes.hlines(middle, at - HALF_BOX, at + HALF_BOX, color=BLACK, linewidth=1.8)


def _draw_shares(axes: Axes, table: pd.DataFrame) -> None:
    """Share of the members that overturned, with its 95 % interval."""
    at = np.arange(len(table), dtype=np.float64)
    share, low, high = (
        100.0 * table[name].to_numpy(float)
        for name in ("overturned", "overturned_low", "overturned_high")
    )
    if len(table) > BOXES:
        axes.fill_between(at, low, high, color=VERMILION, alpha=0.25, linewidth=0.0)
        axes.plot(at, share, color=VERMILION, linewidth=1.3)
    else:
        axes.bar(at, share, 2.0 * HALF_BOX, color=VERMILION, alpha=0.45, linewidth=0.0)
        axes.vlines(at, low, high, color=VERMILION, linewidth=1.3)
    if not np.any(share > 0.0):
        axes.text(0.01, 0.8, "no member overturned", transform=axes.transAxes)
    axes.set_ylim(0.0, 100.0)
    axes.set_ylabel("overturned [%]\n(95 % interval)")


def _name_cells(panels: list[Axes], case: Case) -> None:
    """Names the cells below the last panel, and what their last axis leaves out above the first."""
    swept = swept_axes(case)
    bottom = panels[-1]
    count = int(np.prod([axis.length for axis in swept]))
    bottom.set_xlim(-0.6, count - 0.4)
    for axes in panels:
        axes.grid(visible=False, axis="x")
    if not swept:
        bottom.set_xticks([0], [case.name])
        return
    *outer, inner = swept
    names = [value_name(inner, at) for at in range(inner.length)]
    step = 1 if count <= NAMED else -(-2 * count // NAMED)
    shown = [at for at in range(count) if (at % inner.length) % step == 0]
    texts = [names[at % inner.length] for at in shown]
    upright = sum(map(len, texts)) <= UPRIGHT
    turn: dict[str, Any] = {} if upright else {"rotation": 40, "ha": "right", "va": "top"}
    bottom.set_xticks(shown, texts, rotation_mode="anchor", **turn)
    bottom.set_xlabel(inner.title)
    groups = list(itertools.product(*(range(axis.length) for axis in outer)))
    for number, place in enumerate(groups if len(groups) > 1 else []):
        if number:
            for axes in panels:
                axes.axvline(number * inner.length - 0.5, color="#999999", linewidth=0.8)
        if len(groups) <= GROUPS:
            text = ", ".join(value_name(axis, at) for axis, at in zip(outer, place, strict=True))
            panels[0].annotate(
                text.replace(", ", "\n"),
                ((number + 0.5) * inner.length - 0.5, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0, 3),
                textcoords="offset points",
                ha="center",
                fontsize=8.5,
            )
