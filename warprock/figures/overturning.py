"""The figure of an overturning map."""

from __future__ import annotations

import pathlib
from typing import TYPE_CHECKING

import numpy as np

from warprock.analysis.overturning import Codes, Mode, OverturningMap
from warprock.figures.plots import BLACK, drawing, panel_grid, save, wrapped_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLORS: dict[Mode, str] = {
    Mode.SAFE: "#FFFFFF",
    Mode.WITH_IMPACT: "#E69F00",
    Mode.WITHOUT_IMPACT: "#56B4E9",
    Mode.NO_NUMBER: "#BBBBBB",
    Mode.UNDECIDED: "#CC79A7",
}
NAMES: dict[Mode, str] = {
    Mode.SAFE: "does not overturn",
    Mode.WITH_IMPACT: "overturns after one or more impacts (mode 1)",
    Mode.WITHOUT_IMPACT: "overturns without an impact (mode 2)",
    Mode.NO_NUMBER: "no usable number",
    Mode.UNDECIDED: "undecided: the run is too short",
}
ROWS = 600
"""Cells up a panel: finer than what is printed."""
COLUMNS = 3
_LETTERS = 15
"""Letters of a title in an inch of its figure."""


def draw_map(path: pathlib.Path, found: OverturningMap) -> pathlib.Path:
    """Draws the modes of every group in a panel of its own.

    Args:
        path: File to write.
        found: A map whose boundaries have been found.

    Returns:
        The file.
    """
    count = len(found.groups)
    with drawing() as plt:
        figure, panels = panel_grid(
            plt,
            count,
            columns=COLUMNS,
            width=(1.0, 3.4),
            height=(1.9, 3.3),
            least_width=5.6,
            labels=("ωₚ / p [-]", "aₚ / (g tan \N{GREEK SMALL LETTER ALPHA}) [-]"),
        )
        for number, axes in enumerate(panels.flat[:count]):
            _draw_group(axes, found, number)
        shown = [mode for mode in Mode if np.any(found.mode == mode)]
        handles = [
            plt.Rectangle((0, 0), 1, 1, facecolor=COLORS[mode], edgecolor="#888888")
            for mode in shown
        ]
        names = [NAMES[mode] for mode in shown]
        for axes in panels.flat[:count]:
            for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
                if name not in names:
                    handles.append(handle)
                    names.append(name)
        figure.legend(
            handles, names, loc="outside lower center", ncols=2 if count > 1 else 1, frameon=False
        )
        wrapped_title(figure, _titles(found), _LETTERS)
        return save(figure, path)


def _titles(found: OverturningMap) -> tuple[str, str]:
    lanes = found.run.lane_set.inputs
    eta = sorted({f"{value:.3g}" for value in lanes["angular_restitution"]})
    tangents = sorted({f"{np.tan(value):.3g}" for value in lanes["slenderness_angle_rad"]})
    of_pulse = "across: pulse frequency ωₚ over the block's p; up: its peak acceleration"
    return (
        f"{found.run.case.title}; {found.run.response.engine}, tan \N{GREEK SMALL LETTER ALPHA} = "
        f"{', '.join(tangents)}, angular velocity kept at an impact: {', '.join(eta)}",
        f"{of_pulse}; grid of {len(lanes):,} lanes, {len(found.boundaries):,} boundaries to "
        f"{found.tolerance:g} of their height",
    )


def _draw_group(axes: Axes, found: OverturningMap, group: int) -> None:
    """Areas of one group, its boundaries, and the closed form where there is one."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    across = found.frequency_ratio[group]
    low, high = found.strength[group].min(), found.strength[group].max()
    up = np.linspace(low, high, ROWS)
    axes.pcolormesh(
        across,
        up,
        _filled(found, group, up),
        cmap=ListedColormap([COLORS[mode] for mode in Mode]),
        norm=BoundaryNorm(np.arange(len(Mode) + 1) - 0.5, len(Mode)),
        shading="nearest",
        rasterized=True,
    )
    mine = found.boundaries[found.boundaries["group"] == found.groups[group]]
    axes.plot(
        mine["frequency_ratio"],
        mine["acceleration_ratio"],
        ".",
        color=BLACK,
        markersize=2.5,
        label="boundary, found by halving",
    )
    form = found.closed_form(group)
    if form is not None:
        label = "closed form of a slender block, no impact"
        axes.plot(across, form[1], "--", color="#D55E00", linewidth=1.2, label=label)
    axes.set_xlim(across.min(), across.max())
    axes.set_ylim(low, high)
    axes.grid(visible=False)
    axes.set_title(found.groups[group] or "all lanes", loc="left")


def _filled(found: OverturningMap, group: int, up: np.ndarray) -> Codes:
    """Mode at some strengths of every column, from its boundaries, shape [strength, frequency]."""
    codes = {mode.text: int(mode) for mode in Mode}
    filled = np.empty((len(up), found.mode.shape[1]), dtype=np.int8)
    rows = found.boundaries[found.boundaries["group"] == found.groups[group]]
    for column, ratio in enumerate(found.frequency_ratio[group]):
        mode = found.mode[group, column]
        known = mode[mode != Mode.NO_NUMBER]
        filled[:, column] = known[0] if len(known) else Mode.NO_NUMBER
        mine = rows[rows["frequency_ratio"] == ratio]
        for at, above in zip(mine["acceleration_ratio"], mine["above"], strict=True):
            filled[up >= at, column] = codes[above]
    return filled
