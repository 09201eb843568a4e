"""The figure of a body from a mesh: what it stands on, and how far it leans before it falls."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from warprock.bodies.body import Body
from warprock.bodies.footing import DIRECTIONS, hull_of
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, BLUE, DARK, DASHES, GREY, ORANGE, PALE, VERMILION
from warprock.figures.sheet import headline, legend_below, style, subplots

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_body(body: Body, said: str) -> list[Drawing]:
    """Draws the footprint of a body beside its slenderness angle by direction.

    Args:
        body: The body.
        said: What it came to, in one line.

    Returns:
        One drawing.
    """
    with style():
        figure, panels = subplots(1, 2, (9.6, 4.6))
        footprint, right = panels[0]
        place = right.get_subplotspec()
        right.remove()
        polar = figure.add_subplot(place, projection="polar")
        _draw_footprint(footprint, body)
        _draw_directions(polar, body)
        legend_below(figure, footprint, polar, columns=3)
        about = _about(body)
        headline(figure, said, about)
    return [Drawing("body", figure, said, f"Footprint and slenderness angle. {said}. {about}.")]


def _about(body: Body) -> str:
    """What is drawn."""
    tolerance = f"{1e3 * body.tolerance:.3g} mm"
    return (
        f"{body.mass:.3g} kg, centre of mass {body.base.height:.3g} m above the ground; "
        f"{len(body.base.polygon)} points within {tolerance} of the ground, "
        f"{len(body.contacts) - len(body.base.polygon)} above that touch it as the body leans\n"
        "right: as far as the body leans in that direction, in a plane"
    )


def _draw_footprint(axes: Axes, body: Body) -> None:
    """The body from above, what it stands on, its centre, and the weakest direction."""
    outline, base = hull_of(body.hull[:, :2]), body.base.polygon
    axes.fill(*outline.T, facecolor=PALE, edgecolor=GREY, linewidth=0.8, label="body from above")
    axes.fill(*base.T, facecolor=BLUE, alpha=0.25, linewidth=0)
    axes.plot(*_closed(base).T, color=BLUE, marker="o", markersize=3.5, label="on the ground")
    raised = body.contacts[body.contacts[:, 2] > -body.base.height]
    if len(raised):
        name = "above it: touch as it leans"
        axes.plot(
            *raised[:, :2].T, "o", color=BLUE, markersize=3.5, markerfacecolor="none", label=name
        )
    axes.plot(
        0.0, 0.0, "+", color=BLACK, markersize=12, markeredgewidth=1.8, label="centre of mass"
    )
    weak = body.weakest
    end = _reach(body, weak) * np.array([math.cos(weak), math.sin(weak)])
    axes.plot([0.0, end[0]], [0.0, end[1]], color=VERMILION, label="weakest direction")
    axes.set_title("From above")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.05)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")


def _draw_directions(axes: Any, body: Body) -> None:
    """Slenderness angles around the body."""
    around = np.linspace(-math.pi, math.pi, DIRECTIONS + 1)
    over = np.array([fall.lean for fall in body.turns_over(*around)])
    kinds = (
        (over, "turns over", ORANGE, DASHES[1]),
        (body.base.in_plane(around), "lifts off: slenderness angle", BLUE, DASHES[0]),
    )
    for angles, name, color, dashes in kinds:
        axes.plot(around, np.degrees(angles), color=color, linestyle=dashes, label=name)
    weak = body.weakest
    lean = math.degrees(body.turns_over(weak)[0].lean)
    axes.plot([weak, weak], [0.0, lean], color=VERMILION)
    axes.set_title("Lean by direction")
    axes.set_ylim(0.0, None)
    axes.yaxis.get_major_locator().base.set_params(nbins=4)
    axes.yaxis.set_major_formatter("{x:g}°")
    axes.tick_params(axis="y", labelcolor=DARK)
    axes.set_rlabel_position(math.degrees(weak) + 180.0)


def _reach(body: Body, direction: float) -> float:
    """Distance from below the centre to where the base ends in a direction [m]."""
    return body.base.height * math.tan(float(body.base.in_space(np.array([direction]))[0]))


def _closed(polygon: Any) -> Any:
    """A polygon with its first corner at its end, too."""
    return np.vstack([polygon, polygon[:1]])
