"""The figure of an overturning map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from warprock.analysis.overturning import Codes, Mode, OverturningMap
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, GREY, ORANGE, PURPLE, SKY, VERMILION
from warprock.figures.sheet import headline, legend_below, panel_grid, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLORS: dict[Mode, str] = {
    Mode.SAFE: "#FFFFFF",
    Mode.WITH_IMPACT: ORANGE,
    Mode.WITHOUT_IMPACT: SKY,
    Mode.NO_NUMBER: "#BBBBBB",
    Mode.UNDECIDED: PURPLE,
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


LABELS = (
    "pulse frequency / frequency parameter, ωₚ / p [-]",
    "peak acceleration of the pulse\n/ (g tan \N{GREEK SMALL LETTER ALPHA}) [-]",
)
"""What is drawn across and up."""


def draw_map(found: OverturningMap, title: str) -> list[Drawing]:
    """Draws the modes of every group in a panel of its own.

    Args:
        found: A map whose boundaries have been found.
        title: What it says: the first sentence of its finding.

    Returns:
        One drawing.
    """
    count = len(found.groups)
    with style():
        figure, panels = panel_grid(
            count,
            columns=COLUMNS,
            width=(1.0, 3.4),
            height=(1.3, 3.3),
            least_width=5.6,
            labels=LABELS,
        )
        for number, axes in enumerate(panels.flat[:count]):
            _draw_group(axes, found, number)
        _name_modes(panels[0, 0], found)
        legend_below(figure, *panels.flat[:count], columns=2 if count > 1 else 1)
        about = _about(found)
        headline(figure, title, about)
    return [Drawing("map", figure, title, f"Overturning map. {title}. {about}.")]


def plot_map(axes: Axes, found: OverturningMap, group: int = 0) -> None:
    """Draws the modes of one group, and its boundaries.

    Args:
        axes: Where to.
        found: A map whose boundaries have been found.
        group: Number of the group, from 0.
    """
    _draw_group(axes, found, group)
    _name_modes(axes, found)
    axes.set(xlabel=LABELS[0], ylabel=LABELS[1])
    axes.legend()


def _name_modes(axes: Axes, found: OverturningMap) -> None:
    """Gives a legend the colours of the modes that there are."""
    from matplotlib.patches import Rectangle

    for mode in Mode:
        if np.any(found.mode == mode) or mode.text in set(found.boundaries.get("above", ())):
            patch = Rectangle((0.0, 0.0), 0.0, 0.0, facecolor=COLORS[mode], edgecolor=GREY)
            name = NAMES[mode]
            if found.run.lane_set.lanes.assembly is not None:
                name = name.replace("overturn", "collapse")
            patch.set_label(name)
            axes.add_patch(patch)


def _about(found: OverturningMap) -> str:
    lanes = found.run.lane_set.inputs
    kept = ""
    if "angular_restitution" in lanes:
        eta = sorted({f"{value:.3g}" for value in lanes["angular_restitution"]})
        kept = f", angular velocity kept at an impact: {', '.join(eta)}"
    tangents = sorted({f"{np.tan(value):.3g}" for value in lanes["slenderness_angle_rad"]})
    return (
        f"{found.run.case.title}; {found.run.response.engine}, tan \N{GREEK SMALL LETTER ALPHA} = "
        f"{', '.join(tangents)}{kept}\n"
        f"grid of {len(lanes):,} lanes, {len(found.boundaries):,} boundaries to "
        f"{found.accuracy:g} of their strength"
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
        axes.plot(across, form[1], "--", color=VERMILION, linewidth=1.2, label=label)
    if across.min() < across.max():
        axes.set_xlim(across.min(), across.max())
    axes.set_ylim(low, high)
    axes.grid(visible=False)
    axes.set_title(found.groups[group] or "all lanes")


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
