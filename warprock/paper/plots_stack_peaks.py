"""Largest rotations of two stacked blocks: ensembles against printed values, and collapses."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, BLUE, GREEN, ORANGE, PALE, PURPLE, SKY, VERMILION
from warprock.figures.sheet import headline, legend_below, panel_title, style, subplots
from warprock.paper.printed import PAPER_NAMES, REFERENCE_DEGREES

Array = npt.NDArray[np.float64]

BOX_COLORS = {"printed": ORANGE, "low-top": SKY}
BOX_NAMES = {
    "printed": "ensemble of event: geometry as printed",
    "low-top": "ensemble of event: equal depths, top 0.55 m high",
}
_HOLLOW: dict[str, Any] = {"markerfacecolor": "none", "markeredgewidth": 1.4, "markersize": 7.0}
POINT_STYLES: dict[str, dict[str, Any]] = {
    "two-block": {"marker": "s", "color": GREEN, "markersize": 4.5},
    "event": {"marker": "_", "color": BLUE, "markersize": 11.0, "markeredgewidth": 2.0},
    "impulse": {"marker": "_", "color": VERMILION, "markersize": 11.0, "markeredgewidth": 2.0},
    "dem": {"marker": "_", "color": BLACK, "markersize": 11.0, "markeredgewidth": 2.0},
    "paper: analytical": {"marker": "s", "color": GREEN} | _HOLLOW,
    "paper: bullet": {"marker": "^", "color": VERMILION} | _HOLLOW,
    "paper: vortex": {"marker": "v", "color": PURPLE} | _HOLLOW,
    "paper: dem": {"marker": "D", "color": BLUE} | _HOLLOW,
    "implied: analytical": {"marker": "s", "color": GREEN} | _HOLLOW,
    "implied: bullet": {"marker": "^", "color": VERMILION} | _HOLLOW,
    "implied: vortex": {"marker": "v", "color": PURPLE} | _HOLLOW,
    "test, by analytical": {"marker": "*", "color": BLACK, "markersize": 9.0},
    "test, by bullet": {"marker": "x", "color": BLACK, "markersize": 7.0, "markeredgewidth": 1.6},
}
POINT_NAMES = {
    "two-block": "two-block: acceleration drive, equal depths",
    "event": "event without spread, top 0.55 m high",
    "impulse": "impulse without spread, top 0.55 m high",
    "dem": "dem without spread, top 0.55 m high",
    **{f"paper: {name}": f"paper: {title}" for name, title in PAPER_NAMES.items()},
    **{f"implied: {name}": f"paper: {title}, inferred" for name, title in PAPER_NAMES.items()},
    "test, by analytical": "test, inferred by the analytical errors",
    "test, by bullet": "test, inferred by Bullet's errors",
}
BOX_WIDTH = 0.17
POINTS_FROM, POINTS_TO = -0.02, 0.43
"""Between which distances from an input's place its marks are drawn."""


@dataclasses.dataclass(frozen=True)
class Panel:
    """What is drawn for one block.

    Attributes:
        block: "top" or "bottom".
        boxes: Peaks of members that stayed up, by geometry, one array an input.
        engines: Our peaks without spread, by engine, shape [input].
        marks: Printed or inferred peaks by name, NaN where there is none, shape [input].
        fallen: Numbers of the inputs under which the top block fell in the test.
    """

    block: str
    boxes: Mapping[str, Sequence[Array]]
    engines: Mapping[str, Array]
    marks: Mapping[str, Array]
    fallen: Sequence[int] = ()


def draw_stack_peaks(
    stem: str,
    title: str,
    level: Array,
    names: Sequence[str],
    panels: Sequence[Panel],
) -> Drawing:
    """Ensembles as boxes and single values as marks, inputs in the order of their acceleration.

    Args:
        stem: Name of the drawing.
        title: What is drawn.
        level: Normalised acceleration of every input, which orders them.
        names: What the axis says of every input.
        panels: One a block.
    """
    order = np.argsort(level, kind="stable")
    place = np.empty(len(order))
    place[order] = np.arange(len(order))
    most = max(len(group) for panel in panels for box in panel.boxes.values() for group in box)
    with style():
        figure, grid = subplots(
            len(panels),
            1,
            (10.4, 4.1 * len(panels) + 1.2),
            sharex=True,
        )
        for axes, panel in zip(grid[:, 0], panels, strict=True):
            _draw_boxes(axes, panel, place)
            _draw_points(axes, panel, place)
            for index in panel.fallen:
                text = "in the test\nthe top fell"
                axes.text(
                    place[index] + 0.2,
                    0.98,
                    text,
                    transform=axes.get_xaxis_transform(),
                    ha="center",
                    va="top",
                    fontsize=8.5,
                )
            panel_title(axes, f"{panel.block} block")
            axes.set_ylabel(f"largest rotation / {REFERENCE_DEGREES} deg [-]")
            axes.set_ylim(0.0, (1.15 if panel.fallen else 1.0) * axes.get_ylim()[1])
            for edge in np.arange(len(order) - 1) + 0.5:
                axes.axvline(edge, color=PALE, linewidth=0.8)
            axes.grid(visible=False, axis="x")
        grid[-1, 0].set_xticks(np.arange(len(order)), [names[i] for i in order])
        grid[-1, 0].set_xlim(-0.5, len(order) - 0.5)
        grid[-1, 0].set_xlabel(
            f"peak acceleration / (g tan({REFERENCE_DEGREES} deg)) as printed in Table 8 [-]; "
            "frequency and amplitude of the base"
        )
        legend_below(figure, grid[0, 0], columns=3)
        said = _message(panels)
        about = f"{title}: boxes hold half of {most} members, whiskers 5 to 95 %"
        headline(figure, said, about)
    return Drawing(stem, figure, said, f"{about}. {said}.")


def _message(panels: Sequence[Panel]) -> str:
    """How many values of the paper lie within the whiskers of an ensemble."""
    inside, known = 0, 0
    for panel in panels:
        for values in panel.marks.values():
            for index, value in enumerate(values):
                if np.isfinite(value):
                    groups = [box[index] for box in panel.boxes.values() if len(box[index])]
                    ends = [np.quantile(group, (0.05, 0.95)) for group in groups]
                    known += 1
                    inside += any(low <= value <= high for low, high in ends)
    return f"{inside} of {known} values from the paper lie within 5 to 95 % of an ensemble of ours"


def _draw_boxes(axes: Any, panel: Panel, place: Array) -> None:
    for number, (geometry, groups) in enumerate(panel.boxes.items()):
        at = place - 0.36 + number * (BOX_WIDTH + 0.03)
        kept = [i for i, group in enumerate(groups) if len(group)]
        drawn = axes.boxplot(
            [groups[i] for i in kept],
            positions=at[kept],
            widths=BOX_WIDTH,
            whis=(5, 95),
            showfliers=False,
            patch_artist=True,
            manage_ticks=False,
            label=BOX_NAMES[geometry],
            medianprops={"color": BLACK},
        )
        for box in drawn["boxes"]:
            box.set_facecolor(BOX_COLORS[geometry])


def _draw_points(axes: Any, panel: Panel, place: Array) -> None:
    points = {**panel.engines, **panel.marks}
    for number, (name, values) in enumerate(points.items()):
        at = place + POINTS_FROM + number * (POINTS_TO - POINTS_FROM) / (len(points) - 1)
        axes.plot(at, values, linestyle="none", label=POINT_NAMES[name], **POINT_STYLES[name])


def draw_collapse(stem: str, table: pd.DataFrame) -> Drawing:
    """Share of members that collapse over friction and chamfer, a panel an input.

    Every cell also says how far the top block rotates in 95 % of its members.

    Args:
        stem: Name of the drawing.
        table: Rows with `frequency_hz`, `amplitude_mm`, `amplitude`, `friction_1`,
            `chamfer_1_mm`, `members`, `collapsed_share` and `high_95`.
    """
    panels = list(table.groupby(["frequency_hz", "amplitude_mm", "amplitude"], sort=False))
    columns = len(panels) // 2
    with style():
        figure, grid = subplots(
            2,
            columns,
            (3.4 * columns + 1.0, 7.2),
            sharex=True,
            sharey=True,
        )
        image: Any = None
        for axes, ((frequency, amplitude, scale), rows) in zip(grid.flat, panels, strict=True):
            image = _draw_shares(axes, rows)
            panel_title(axes, f"{frequency:g} Hz, {amplitude:g} mm ({scale})")
        for axes in grid[-1]:
            axes.set_xlabel("chamfer [mm]")
        for axes in grid[:, 0]:
            axes.set_ylabel("friction of both faces [-]")
        figure.colorbar(image, ax=grid, label="share of members that collapse [-]", shrink=0.7)
        usable = table["collapsed_share"].dropna()
        said = (
            f"Between {100.0 * usable.min():.0f} and {100.0 * usable.max():.0f} % of the stacks "
            "collapse, by friction, chamfer and motion"
        )
        about = (
            "Two stacked blocks under 10 s of sine, geometry as printed, "
            f"{int(table['members'].max())} members a cell. Upper number: share of them that "
            "collapses; lower: 95 % quantile of the top block's largest rotation / "
            f"{REFERENCE_DEGREES} deg"
        )
        headline(figure, said, about)
    return Drawing(stem, figure, said, f"{about}. {said}.")


def _draw_shares(axes: Any, rows: pd.DataFrame) -> Any:
    share = rows.pivot(index="friction_1", columns="chamfer_1_mm", values="collapsed_share")
    far = rows.pivot(index="friction_1", columns="chamfer_1_mm", values="high_95")
    image = axes.imshow(share, origin="lower", aspect="auto", cmap="YlOrRd", vmin=0.0, vmax=1.0)
    for (i, j), value in np.ndenumerate(share.to_numpy()):
        most = far.to_numpy()[i, j]
        text = f"{100 * value:.0f} %\n" + (f"{most:.2f}" if np.isfinite(most) else "fell")
        axes.text(
            *(j, i, "not\nusable" if np.isnan(value) else text),
            ha="center",
            va="center",
            fontsize=8.0,
            color="white" if value > 0.6 else BLACK,
        )
    axes.set_xticks(range(share.shape[1]), [f"{c:g}" for c in share.columns])
    axes.set_yticks(range(share.shape[0]), [f"{f:g}" for f in share.index])
    axes.grid(visible=False)
    return image
