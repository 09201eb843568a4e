"""The figure of fragility functions: curves, bands, and the lanes they were fitted to."""

from __future__ import annotations

import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.analysis.fragility import Curve
from warprock.case.columns import input_meaning
from warprock.figures.plots import (
    BLUE,
    FIGURE_TITLE,
    GREEN,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    drawing,
    panel_grid,
    save,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

COLORS = (SKY, GREEN, ORANGE, RED, BLUE, PURPLE)
DOTS = 12
"""Points that lanes are gathered into, where there are more intensities than that."""
PANELS = 12
"""Groups that a figure shows at most; the first ones."""
COLUMNS = 3
POINTS = 200


def draw_curves(path: pathlib.Path, curves: Sequence[Curve], intensity: str) -> pathlib.Path:
    """Draws every group's fragility functions in a panel of its own.

    Args:
        path: File to write.
        curves: The curves, those of a group behind one another.
        intensity: Column of the intensity measure.

    Returns:
        The file.
    """
    groups: dict[str, list[Curve]] = {}
    for curve in curves:
        groups.setdefault(curve.group_text, []).append(curve)
    shown = dict(list(groups.items())[:PANELS])
    with drawing() as plt:
        figure, panels = panel_grid(
            plt,
            len(shown),
            columns=COLUMNS,
            width=(1.2, 3.6),
            height=(1.4, 2.7),
            least_width=6.4,
            labels=(_axis_label(intensity), "probability [-]"),
            same_x=False,
        )
        for axes, (group, mine) in zip(panels.flat, shown.items(), strict=False):
            _draw_group(axes, mine)
            axes.set_title(group or "all lanes", loc="left", fontsize=9)
        handles, labels = panels.flat[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(4, len(labels)))
        more = "" if len(shown) == len(groups) else f"; {len(shown)} of {len(groups)} groups"
        figure.suptitle(f"Fragility{more}\n{_explained(curves)}", **FIGURE_TITLE)
        return save(figure, path)


def _axis_label(intensity: str) -> str:
    """Meaning and unit of the column of the intensity measure; its name where it has none."""
    unit, text = input_meaning(intensity)
    if text == input_meaning("")[1]:
        return intensity
    name = text.split(",")[0]
    return name if unit == "-" else f"{name} [{unit.replace('^2', '²')}]"


def _explained(curves: Sequence[Curve]) -> str:
    """What the lines, bands and dots are, and how many lanes stand behind them."""
    lanes = int(curves[0].seen.count.sum())
    records = curves[0].seen.record_count
    same = len({(int(c.seen.count.sum()), c.seen.record_count) for c in curves}) == 1
    size = f"{lanes:,} lanes under {records:,} records" if records < lanes else f"{lanes:,} lanes"
    size += " in each panel" if same else " or more"
    what = "records" if records < lanes else "lanes"
    band = f"; band: 5th to 95th percentile over {what}" if _banded(curves) else ""
    return f"line: lognormal function{band}\ndots: share of lanes; {size}{_not_counted(curves)}"


def _not_counted(curves: Sequence[Curve]) -> str:
    """How many lanes are in doubt or left out; empty where none is."""
    most = max(curve.in_doubt for curve in curves)
    groups = {curve.group_text: sum(curve.left_out.values()) for curve in curves}
    doubt = f"\nin doubt: up to {most:,} lanes" if most else ""
    left = sum(groups.values())
    return doubt + (f"{', ' if doubt else chr(10)}left out: {left:,} lanes" if left else "")


def _banded(curves: Sequence[Curve]) -> bool:
    return any(curve.band is not None for curve in curves)


def _draw_group(axes: Axes, curves: Sequence[Curve]) -> None:
    """One group: a colour a limit state."""
    low = min(float(curve.seen.intensity.min()) for curve in curves)
    high = max(float(curve.seen.intensity.max()) for curve in curves)
    intensity = np.geomspace(low / 1.05, high * 1.05, POINTS)
    for number, curve in enumerate(curves):
        color = COLORS[number % len(COLORS)]
        at, share = gathered(curve)
        axes.plot(at, share, "o", color=color, markersize=3.0, alpha=0.8)
        if curve.band is not None:
            axes.fill_between(
                intensity,
                *curve.band.probabilities(intensity),
                color=color,
                alpha=0.2,
                linewidth=0.0,
            )
        if curve.fit.dispersion > 0.0:
            probability = curve.fit.probability(intensity)
            axes.plot(intensity, probability, color=color, linewidth=1.5, label=curve.limit.text)
        else:
            name = f"{curve.limit.text} ({curve.fit.verdict.value})"
            axes.plot([], [], "o", color=color, markersize=3.0, label=name)
    axes.set_xscale("log")
    axes.set_ylim(-0.03, 1.03)
    axes.grid(visible=True, alpha=0.3)


def gathered(curve: Curve) -> tuple[Array, Array]:
    """Intensities and the share of lanes that reached the limit state there, shape [dot].

    Intensities that several lanes share are a dot each; where there are more than `DOTS`, lanes of
    neighbouring intensities are gathered, as many in each dot, at their geometric mean.
    """
    seen = curve.seen
    at, which = np.unique(seen.intensity, return_inverse=True)
    if len(at) > DOTS:
        order = np.argsort(seen.intensity, kind="stable")
        before = np.cumsum(seen.count[order]) - seen.count[order]
        which = np.empty(len(order), dtype=np.intp)
        which[order] = np.minimum(DOTS * before / seen.count.sum(), DOTS - 1).astype(np.intp)
    count = np.bincount(which, weights=seen.count)
    share = np.bincount(which, weights=seen.reached) / count
    return np.exp(np.bincount(which, weights=seen.count * np.log(seen.intensity)) / count), share
