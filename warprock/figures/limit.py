"""The figure of limit analysis: assemblies in the mechanisms by which they collapse."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from warprock.analysis.load_limit import Collapse, LoadLimits
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLUE, DARK, GREY, PALE, VERMILION
from warprock.figures.sheet import headline, legend_below, style, subplots
from warprock.findings.numbers import even_selection, three

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_SHOWN = 4
"""Mechanisms that are drawn, an even selection of the lanes that stand."""
ACROSS = 2
"""Panels in a row."""
PANEL = (4.8, 3.6)
"""Width and height of a panel [inch]."""
MOVED = 0.12
"""Largest displacement of a centre of mass in the drawing, over the size of the assembly."""


def draw_limit(found: LoadLimits, title: str) -> list[Drawing]:
    """Draws the mechanisms of a few lanes that stand, or blocks alone where none does.

    Args:
        found: What `run_limits` returned.
        title: What came out, in one line.
    """
    lanes, places = np.arange(len(found.lane)), found.lane
    stands = np.array([each.stands for each in found.collapses])[places]
    first = np.unique(places[stands] if stands.any() else places, return_index=True)[1]
    chosen = (lanes[stands] if stands.any() else lanes)[np.sort(first)]
    shown = even_selection(chosen.tolist(), MOST_SHOWN)
    across = min(ACROSS, len(shown))
    rows = -(-len(shown) // across)
    with style():
        figure, panels = subplots(rows, across, (PANEL[0] * across, PANEL[1] * rows))
        for axes, lane in zip(panels.flat, shown, strict=False):
            collapse = found.collapses[places[lane]]
            _draw(axes, collapse)
            axes.set_title(_name(collapse, lane), fontsize=9.0)
        for axes in panels.flat[len(shown) :]:
            axes.set_visible(False)
        legend_below(figure, *panels.flat, columns=4)
        about = (
            f"{found.case.name}: blocks where they stand (outlines) and as the mechanism moves "
            "them, by the same scale in all joints; it has no size"
        )
        headline(figure, title, about)
    said = "; ".join(_name(found.collapses[places[lane]], lane) for lane in shown)
    return [Drawing("mechanism", figure, title, f"{title}. Mechanisms: {said}.")]


def _name(collapse: Collapse, lane: int) -> str:
    if not collapse.stands:
        return f"lane {lane}: does not stand"
    bound = " at most" if collapse.upper_bound else ""
    return f"lane {lane}: load factor{bound} {three(collapse.load_factor)}"


def _draw(axes: Axes, collapse: Collapse) -> None:
    """One assembly and its mechanism on axes of metres."""
    from matplotlib.collections import PolyCollection

    assembly = collapse.assembly
    scale = MOVED * float(assembly.size.max())
    arm = assembly.corners - assembly.centre[:, None]
    turned = np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
    velocity = collapse.velocity[:, None]
    moved = assembly.corners + scale * (velocity[..., :2] + velocity[..., 2:] * turned)
    free = ~assembly.fixed
    fixed = PolyCollection([*assembly.corners[~free]], facecolor=PALE, edgecolor=GREY)
    axes.add_collection(fixed)
    axes.add_collection(PolyCollection([*moved[free]], facecolor="#F4E8D0", edgecolor=DARK))
    outline = PolyCollection([*assembly.corners[free]], facecolor="none", edgecolor=GREY)
    outline.set_linewidth(0.6)
    axes.add_collection(outline)
    _mark_joints(axes, collapse, scale)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.margins(0.04)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")


def _mark_joints(axes: Axes, collapse: Collapse, scale: float) -> None:
    """Hinges as dots where joints that open stay closed, sliding joints as lines."""
    assembly, joints = collapse.assembly, collapse.assembly.joints
    second = joints.blocks[:, 1]
    arm = joints.ends - assembly.centre[second][:, None]
    turned = np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
    velocity = collapse.velocity[second][:, None]
    ends = joints.ends + scale * (velocity[..., :2] + velocity[..., 2:] * turned)
    opens, slides = collapse.opens, collapse.slides
    closed = np.argmin(collapse.parting, axis=1)
    hinges = ends[np.arange(joints.count), closed][opens]
    axes.plot(*hinges.T, "o", color=VERMILION, markersize=5.0, zorder=3, label="hinge")
    for place, line in enumerate(ends[slides]):
        label = "sliding joint" if place == 0 else None
        axes.plot(*line.T, color=BLUE, linewidth=2.5, zorder=3, label=label)
