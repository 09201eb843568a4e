"""The figure of what blocks bear that are led outwards: moment, and capacity as a spectrum."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from warprock.analysis.statics import EITHER, Statics
from warprock.analysis.statics_beside import Beside
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLUE, DARK, DASHES, FALLEN, GREY, SERIES
from warprock.figures.scales import logarithmic
from warprock.figures.sheet import headline, legend_below, style, subplots
from warprock.findings.capacity import capacity_table, weakest_sides
from warprock.findings.numbers import counted, even_selection

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CURVES = 8
"""Rows that are drawn, at most: an even selection."""
BEYOND = 1.1
"""Leans that are drawn, over the largest capacity; or twice the slenderness angle without one."""
DEGREES = 180.0 / np.pi
FELL_AT = 1.3
"""Rotation over capacity at which lanes that overturn are drawn."""


def draw_capacity(found: Statics, title: str) -> list[Drawing]:
    """Draws the moment over the rotation, and the multiplier over the displacement.

    Args:
        found: What blocks bear.
        title: What it says: the first sentence of its finding.

    Returns:
        One drawing.
    """
    rows = even_selection(range(len(found.lane)), CURVES)
    with style():
        figure, panels = subplots(1, 2, (9.6, 3.9))
        for number, row in enumerate(rows):
            _draw_row(panels[0, 0], panels[0, 1], found, row, number)
        for axes in panels.flat:
            axes.axhline(0.0, color=DARK, linewidth=0.8)
        panels[0, 0].set(
            xlabel="rotation [deg]", ylabel="moment that resists [kN m]", title="Moment"
        )
        panels[0, 1].set(
            xlabel="displacement of the centre of percussion [m]",
            ylabel="base acceleration [g]",
            title="Capacity of the equivalent system of one degree",
        )
        hold = found.lane_set.lanes.hold
        if len(rows) > 1 or (hold is not None and hold.ties is not None):
            legend_below(figure, panels[0, 0], columns=4)
        drawn = f"{len(rows)} of {len(found.lane)} curves" if len(rows) > 1 else "one block"
        headline(figure, title, f"{found.case.title}; statics, {drawn}; dots: where it falls")
    return [Drawing("capacity", figure, title, f"Moment and capacity of blocks. {title}.")]


def draw_beside(found: Statics, beside: Beside, title: str) -> Drawing:
    """Draws what became of lanes over how strong their motions are to their statics.

    Args:
        found: What blocks bear.
        beside: What became of them.
        title: What it says.

    Returns:
        The drawing: of every lane the side to which it goes first.
    """
    lanes = weakest_sides(capacity_table(found, beside))
    down = (lanes["outcome"] == "overturned").to_numpy()
    lean = lanes["rotation_capacity_ratio"].to_numpy()
    with style():
        figure, panels = subplots(1, 2, (9.6, 3.6), sharey=True)
        for axes, name, label in (
            (panels[0, 0], "base_multiplier_ratio", "largest base acceleration / (multiplier g)"),
            (panels[0, 1], "base_velocity_ratio", "largest base velocity / step that overturns"),
        ):
            across = lanes[name].to_numpy()
            axes.axvline(1.0, color=DARK, linewidth=0.8, label="statics")
            axes.plot(across[~down], lean[~down], "o", color=BLUE, label="stands", markersize=4.5)
            axes.plot(
                across[down], np.full(down.sum(), FELL_AT), "^", color=FALLEN, label="overturns"
            )
            logarithmic(axes.xaxis)
            axes.set_xlabel(f"{label} [-]")
        panels[0, 0].set_ylim(-0.05, FELL_AT + 0.1)
        panels[0, 0].set_ylabel("largest rotation /\nrotation capacity [-]")
        legend_below(figure, panels[0, 0])
        about = f"{found.case.title}: {counted(len(lanes), 'lane')} under their motions; "
        headline(figure, title, f"{about}rigid statics against dynamics (housner)")
    return Drawing("capacity-dynamics", figure, title, f"Statics against dynamics. {title}.")


def _draw_row(moments: Axes, spectra: Axes, found: Statics, row: int, number: int) -> None:
    """One row in both panels."""
    capacity = float(found.found.lean_capacity[row])
    angle = float(found.lane_set.lanes.slenderness_angle[found.lane[row]])
    most = BEYOND * capacity if capacity > 0.0 else 2.0 * angle
    curve = found.curve_of(row, most)
    side = str(found.side[row])
    name = f"lane {found.lane[row]}" + ("" if side == EITHER else f", to the {side}")
    color = SERIES[number % len(SERIES)]
    line = {"color": color, "linestyle": DASHES[number % len(DASHES)], "linewidth": 1.3}
    free = found.curve_without_ties(row, most)
    if free is not None:
        look: dict[str, Any] = {"color": GREY, "linewidth": 1.0, "zorder": 1.5}
        label = "without ties" if number == 0 else None
        moments.plot(free.lean * DEGREES, free.moment / 1e3, label=label, **look)
        spectra.plot(free.displacement, free.multiplier, **look)
    moments.plot(curve.lean * DEGREES, curve.moment / 1e3, label=name, **line)
    spectra.plot(curve.displacement, curve.multiplier, label=name, **line)
    if capacity > 0.0:
        moments.plot(capacity * DEGREES, 0.0, "o", color=color, markersize=4.0)
        at = float(found.found.displacement_capacity[row])
        spectra.plot(at, 0.0, "o", color=color, markersize=4.0)
