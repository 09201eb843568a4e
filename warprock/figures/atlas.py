"""Figures of the atlas of extremes: one a map, a panel an engine and precision."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, ORANGE, VERMILION
from warprock.figures.scales import plain
from warprock.figures.sheet import headline, style, subplots

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]

LEVELS = (1e-4, 1e-3, 1e-2, 1e-1)
"""Bounds of the classes of error; a last class is above all of them."""
CLASS_NAMES = ("below 0.0001", "0.0001 to 0.001", "0.001 to 0.01", "0.01 to 0.1", "above 0.1")
CLASS_COLORS = ("#1B7837", "#7FBF7B", "#FEE08B", "#C2A5CF", "#762A83")
NOTHING_COLOR = "#E6E6E6"
QUANTILE = 0.9
TICKS, ALL_NAMED = 6, 9
"""Values named along an axis, at most, and values up to which all are."""


@dataclasses.dataclass(frozen=True)
class Quantity:
    """What the colours of a figure tell.

    Attributes:
        column: Column of the table.
        name: What nine lanes in ten of a cell stay below, in words.
        levels: Bounds of the classes; a last class is above all of them.
        names: Names of the classes.
        nothing: Name of the cells that have none.
        reference: Whether lanes count that a reference answers, without a number too.
    """

    column: str
    name: str
    levels: tuple[float, ...]
    names: tuple[str, ...]
    nothing: str
    reference: bool


ERROR = Quantity(
    "error", "error / slenderness angle", LEVELS, CLASS_NAMES, "not compared", reference=True
)
PENETRATION = Quantity(
    "penetration",
    "penetration / height of the block",
    (1e-8, 1e-6, 1e-4, 1e-2),
    ("below 10⁻⁸", "10⁻⁸ to 10⁻⁶", "10⁻⁶ to 0.0001", "0.0001 to 0.01", "above 0.01"),
    "no lane that may be used",
    reference=False,
)

MARKS: dict[str, tuple[str, dict[str, Any]]] = {
    "grew": (
        "over 1 % of energy gained, base still",
        {"marker": "x", "color": BLACK, "markersize": 4.5, "markeredgewidth": 1.1},
    ),
    "refused": (
        "no number: the status says so",
        {"marker": "o", "color": ORANGE, "markersize": 5.0, "markeredgecolor": BLACK},
    ),
    "absurd": (
        "absurd number, status ok",
        {"marker": "s", "color": VERMILION, "markersize": 5.5, "markeredgecolor": "white"},
    ),
}
"""What at least one lane of a cell did: name in the legend, and mark."""


def draw_maps(
    table: pd.DataFrame, maps: list[tuple[str, str, str, str]], labels: Mapping[str, str]
) -> list[Drawing]:
    """Draws every map that the table holds.

    Args:
        table: Lanes, as `measure.atlas.run_atlas` returns them.
        maps: Name of a map, its title, and its columns across and up; one entry a figure.
        labels: Axis labels by column.

    Returns:
        Two drawings a map: errors and penetrations.
    """
    drawings = []
    for name, title, across, up in maps:
        rows = table[table["map"] == name]
        if len(rows):
            stem = f"{name}-{up.split('_')[0]}"
            for quantity, end in ((ERROR, ""), (PENETRATION, "-penetration")):
                columns = (across, up)
                drawings.append(draw_map(f"{stem}{end}", rows, title, columns, labels, quantity))
    return drawings


def draw_map(
    name: str,
    rows: pd.DataFrame,
    title: str,
    columns: tuple[str, str],
    labels: Mapping[str, str],
    quantity: Quantity = ERROR,
) -> Drawing:
    """Draws one map: colour is what nine lanes in ten stay below, marks are any lane's.

    Args:
        name: Name of the drawing.
        rows: Lanes of the map.
        title: What is put through what.
        columns: Columns across and up; a lane without the one across is drawn at all its values.
        labels: Axis labels by column.
        quantity: What the colours tell.
    """
    engines, precisions = list(rows["engine"].unique()), list(rows["precision"].unique())
    places = [np.sort(rows[column].dropna().unique()).astype(float) for column in columns]
    # Where no engine drawn has the knob, one column stands for all of its values.
    places = [values if len(values) else np.array([np.nan]) for values in places]
    with style():
        size = (1.4 + 3.9 * len(precisions), 1.5 + 1.75 * len(engines))
        figure, grid = subplots(len(engines), len(precisions), size, sharex=True, sharey=True)
        fewest = []
        for engine, row in zip(engines, grid, strict=True):
            for precision, axes in zip(precisions, row, strict=True):
                part = rows[(rows["engine"] == engine) & (rows["precision"] == precision)]
                fewest.append(_draw_panel(axes, part, columns, places, quantity))
                knob = "" if part[columns[0]].notna().any() else f", no {_knob(columns[0], labels)}"
                axes.set_title(f"{engine}{knob}, {precision}, {len(part)} lanes")
        for axes in grid[-1]:
            _name_places(axes.xaxis, places[0])
            axes.set_xlabel(labels[columns[0]])
        _name_places(grid[0, 0].yaxis, places[1])
        figure.supylabel(labels[columns[1]], fontsize=9.0)
        _explain(figure, quantity)
        lasting = _span(rows["duration_s"].min(), rows["duration_s"].max())
        said = _message(rows, quantity)
        about = (
            f"{title[0].upper()}{title[1:]}; runs of {lasting} s\n"
            f"colour: {quantity.name} that nine lanes in ten stay below; marks: one lane "
            f"or more ({_span(min(fewest), max(fewest))} lanes a cell)"
        )
        headline(figure, said, about)
    return Drawing(name, figure, said, f"Map of extremes: {title}. {said}.")


def _message(rows: pd.DataFrame, quantity: Quantity) -> str:
    """What nine lanes in ten stay below, from the best engine to the worst."""
    counted = rows[rows["compared"]] if quantity.reference else rows
    ends = counted.groupby("engine", sort=False)[quantity.column].apply(
        lambda column: (column.fillna(np.inf) if quantity.reference else column.dropna()).quantile(
            QUANTILE, interpolation="higher"
        )
    )
    ends = ends.dropna().sort_values()
    if not len(ends):
        return f"No lane of this map has an {quantity.name}"
    named = [f"{_short(end)} ({name})" for name, end in ends.items() if np.isfinite(end)]
    lost = [str(name) for name, end in ends.items() if np.isinf(end)]
    shown = ", ".join(named[:1] + named[1:][-1:])
    none = f"; more than one lane in ten of {', '.join(lost)} has no number" if lost else ""
    what = f"{quantity.name[0].upper()}{quantity.name[1:]}"
    return f"{what}, all cells together: nine lanes in ten below {shown or 'no number'}{none}"


def cells(
    rows: pd.DataFrame,
    columns: tuple[str, str],
    places: list[Array],
    quantity: Quantity = ERROR,
) -> dict[str, npt.NDArray[Any]]:
    """What becomes of the lanes at every pair of values.

    Args:
        rows: Lanes of one engine and precision.
        columns: Columns across and up.
        places: Their values.
        quantity: What is looked for.

    Returns:
        Its column (the quantile; NaN where there is none), `count`, `grew`, `refused` and
        `absurd` (whether any lane did), shape [up, across] each.
    """
    shape = (len(places[1]), len(places[0]))
    found: dict[str, npt.NDArray[Any]] = {quantity.column: np.full(shape, np.nan)}
    found["count"] = np.zeros(shape, dtype=np.int64)
    found |= {name: np.zeros(shape, dtype=np.bool_) for name in MARKS}
    for pair, part in rows.groupby(list(columns), dropna=False):
        x, y = np.asarray(pair, dtype=np.float64)
        at_y = int(np.searchsorted(places[1], y))
        at_x = slice(None) if np.isnan(x) else int(np.searchsorted(places[0], x))
        values = part[quantity.column].dropna()
        if quantity.reference:
            values = part[quantity.column][part["compared"]].fillna(np.inf)
        if len(values):
            found[quantity.column][at_y, at_x] = values.quantile(QUANTILE, interpolation="higher")
        found["count"][at_y, at_x] = len(part)
        found["grew"][at_y, at_x] = part["grew"].any()
        found["refused"][at_y, at_x] = (~part["usable"]).any()
        found["absurd"][at_y, at_x] = part["absurd"].any()
    return found


def _draw_panel(
    axes: Axes,
    rows: pd.DataFrame,
    columns: tuple[str, str],
    places: list[Array],
    quantity: Quantity,
) -> int:
    """Draws the cells of one engine and precision; returns the fewest lanes of a cell."""
    from matplotlib.colors import ListedColormap

    found = cells(rows, columns, places, quantity)
    kinds = np.digitize(found[quantity.column], quantity.levels).astype(float)
    kinds[np.isnan(found[quantity.column])] = np.nan
    axes.set_facecolor(NOTHING_COLOR)
    axes.grid(visible=False)
    axes.pcolormesh(
        np.arange(len(places[0]) + 1) - 0.5,
        np.arange(len(places[1]) + 1) - 0.5,
        np.ma.masked_invalid(kinds),
        cmap=ListedColormap(list(CLASS_COLORS)),
        vmin=-0.5,
        vmax=len(CLASS_COLORS) - 0.5,
        edgecolors="white",
        linewidth=0.4,
    )
    for name, (_, look) in MARKS.items():
        at_y, at_x = np.nonzero(found[name])
        axes.plot(at_x, at_y, linestyle="none", **look)
    counts = found["count"]
    return int(counts[counts > 0].min())


def _name_places(axis: Any, values: Array) -> None:
    """Names some of the values of an axis whose cells are as wide as one another."""
    count = len(values) if len(values) <= ALL_NAMED else TICKS
    shown = np.unique(np.linspace(0, len(values) - 1, count).round().astype(int))
    axis.set_ticks(shown, [_short(values[at]) for at in shown])


def _span(low: float, high: float) -> str:
    return _short(low) if low == high else f"{_short(low)} to {_short(high)}"


def _short(value: float) -> str:
    """Two digits, without an exponent where plain digits do; NaN is any value."""
    if np.isnan(value):
        return "any"
    return plain(float(f"{value:.1e}"))


def _knob(column: str, labels: Mapping[str, str]) -> str:
    return labels[column].split(" [")[0]


def _explain(figure: Figure, quantity: Quantity) -> None:
    """One legend for all panels, below them."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    names = (*quantity.names, quantity.nothing)
    handles: list[Any] = [
        Patch(facecolor=color, label=name)
        for color, name in zip((*CLASS_COLORS, NOTHING_COLOR), names, strict=True)
    ]
    handles += [
        Line2D([], [], linestyle="none", label=name, **look) for name, look in MARKS.values()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
