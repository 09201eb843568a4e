"""Peak rotation over the swept inputs of a case: curves for few values, a map for many."""

from __future__ import annotations

import dataclasses
import itertools
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.figures.drawing import Drawing
from warprock.figures.outcomes import FAR, FARTHEST, OUTCOMES, RAISED, Peaks, read_peaks
from warprock.figures.palette import DARK, DASHES, SCALE, SERIES, VERMILION
from warprock.figures.sheet import headline, style, subplots
from warprock.model.response import Outcome
from warprock.run.case_run import CaseRun
from warprock.tables.swept import TICKS, SweptAxis, lanes_at, spread, swept_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

PEAK_LABEL = "peak rotation / slenderness angle [-]"
PANELS = 6
DODGE = 0.4
"""Width over which the lanes of one name spread, the next name being 1 away."""
LEGEND_TEXT, LEGEND_MARK = 140, 8
"""Letters that fit side by side in the legend, and how many its mark and its gap take."""
TICK_TEXT, TICK_NAME = 100, 24
"""Letters that fit side by side below a figure, and the most that a name below it has."""

UNUSABLE_COLOR = "#BBBBBB"
OVERTURNED_FILL: dict[str, Any] = {"facecolor": "white", "edgecolor": VERMILION, "hatch": "////"}
"""Hatched, as no colour is unlike all those of the scale for every reader."""
DOTTED_CELLS = 2500
"""Cells of a map in which dots can still be told apart."""


@dataclasses.dataclass(frozen=True)
class _Layout:
    """What the swept axes become.

    Attributes:
        across: Along the abscissa; None for a case of one lane.
        beside: Colours of the curves, or the ordinate of a map; None without.
        panels: One panel for each of their values.
        as_map: Whether there are more curves than can be told apart.
    """

    across: SweptAxis | None
    beside: SweptAxis | None
    panels: list[SweptAxis]
    as_map: bool


def draw_peaks(run: CaseRun, block: int | None = None) -> Drawing:
    """Peak rotation of every lane over the swept inputs.

    Args:
        run: The run.
        block: Which block of stacks, the lowest is 0; None for single blocks.
    """
    layout = _lay_out(swept_axes(run.case))
    peaks = read_peaks(run, block)
    chosen = spread([axis.length for axis in layout.panels], PANELS)
    places = list(itertools.product(*chosen))
    columns = min(len(places), 3 if layout.as_map else 2)
    rows = -(-len(places) // columns)
    with style():
        size = (9.6, (4.4 if rows == 1 else 3.0 * rows) + 0.8)
        figure, grid = subplots(rows, columns, size, sharex=True, sharey=True)
        for axes in grid.flat[len(places) :]:
            axes.set_visible(False)
        for axes, place in zip(grid.flat, places, strict=False):
            at = {a.number: int(p) for a, p in zip(layout.panels, place, strict=True)}
            names = [a.name(int(p)) for a, p in zip(layout.panels, place, strict=True)]
            axes.set_title(", ".join(names))
            if layout.as_map:
                _draw_map(axes, run, peaks, layout, at)
            else:
                _draw_curves(axes, run, peaks, layout, at)
        _label(figure, grid, layout, peaks)
        title, about = peaks.message(block), _about(run, block, peaks, layout, len(places))
        headline(figure, title, about)
    name = "peaks" if block is None else f"peaks-block-{block + 1}"
    return Drawing(name, figure, title, f"{about}. {title}.".replace("\n", ". "))


def _lay_out(axes: list[SweptAxis]) -> _Layout:
    """The longest scale lies across, or without one the longest axis."""
    if not axes:
        return _Layout(None, None, [], as_map=False)
    across = max(axes, key=lambda axis: (not axis.nominal, axis.length))
    rest = [axis for axis in axes if axis is not across]
    many = [axis for axis in rest if axis.length > len(SERIES)]
    beside = max(many, key=lambda axis: axis.length, default=None)
    if beside is None and rest:
        beside = next((axis for axis in rest if axis.texts), rest[0])
    panels = [axis for axis in rest if axis is not beside]
    return _Layout(across, beside, panels, as_map=bool(many))


def _about(run: CaseRun, block: int | None, peaks: Peaks, layout: _Layout, panels: int) -> str:
    notes = []
    total = int(np.prod([axis.length for axis in layout.panels]))
    if panels < total:
        notes.append(f"{panels} of {total} panels, evenly spaced along each input")
    unusable = int(np.sum(peaks.outcome < 0))
    if unusable:
        notes.append(f"lanes without a usable number: {unusable} of {len(peaks.ratio)}")
    below = "".join(f"\n{note}" for note in notes)
    over = "" if layout.across is None else " over the swept inputs"
    of = "" if block is None else f" of block {block + 1}"
    return f"{run.case.name}, {run.response.engine}: peak rotation{of}{over}{below}"


def _draw_curves(
    axes: Axes, run: CaseRun, peaks: Peaks, layout: _Layout, at: dict[int, int]
) -> None:
    """One curve for each value of the axis beside; a mark for each lane."""
    across, beside = layout.across, layout.beside
    x = np.zeros(1) if across is None else across.coordinates
    size = 9.0 if len(x) <= 60 else 4.0 if len(x) <= 300 else 2.0
    count = 1 if beside is None else beside.length
    for index in range(count):
        here = at if beside is None else at | {beside.number: index}
        lanes = lanes_at(run.case, here)
        ratio, outcome = peaks.ratio[lanes], peaks.outcome[lanes]
        color = _series_color(beside, index)
        # Lanes of equal peaks lie side by side between names, and in one another on a scale.
        place = index / max(count - 1, 1)
        beside_names = across is not None and across.nominal and count > 1
        aside = DODGE * (place - 0.5) if beside_names else 0.0
        if across is not None and not across.nominal:
            axes.plot(
                x,
                np.where(peaks.raised[lanes], np.nan, ratio),
                color=color,
                linestyle=DASHES[index % len(DASHES)],
                linewidth=1.2,
            )
        for code, (_, marker, filled) in OUTCOMES.items():
            rows = outcome == code
            raised = code in RAISED
            axes.plot(
                x[rows] + aside,
                np.full(int(rows.sum()), peaks.raised_at) if raised else ratio[rows],
                linestyle="none",
                marker=marker,
                markersize=size * (1.0 if beside_names else 1.0 - 0.6 * place),
                zorder=3.0 + place,
                color=color,
                markerfacecolor=color if filled else "none",
            )


def _series_color(beside: SweptAxis | None, index: int) -> Any:
    if beside is None or beside.nominal:
        return SERIES[index]
    import matplotlib

    return matplotlib.colormaps["viridis"](0.9 * index / max(beside.length - 1, 1))


def _draw_map(axes: Axes, run: CaseRun, peaks: Peaks, layout: _Layout, at: dict[int, int]) -> None:
    """Peaks of lanes that stand as colours; fallen and unusable lanes in colours of their own."""
    from matplotlib.colors import ListedColormap

    across, beside = layout.across, layout.beside
    assert across is not None
    assert beside is not None
    lanes = lanes_at(run.case, at)
    # Of the two axes left, the one that the case names first is the slower.
    if beside.number < across.number:
        lanes = lanes.reshape(beside.length, across.length)
    else:
        lanes = lanes.reshape(across.length, beside.length).T
    ratio, outcome = peaks.ratio[lanes], peaks.outcome[lanes]
    x, y = _edges(across), _edges(beside)
    axes.patch.set(**OVERTURNED_FILL, linewidth=0.0)
    unusable = np.ma.masked_where(outcome >= 0, np.ones(outcome.shape))
    standing = np.ma.masked_where((outcome < 0) | peaks.raised[lanes], ratio)
    axes.pcolormesh(x, y, unusable, cmap=ListedColormap([UNUSABLE_COLOR]))
    axes.pcolormesh(x, y, standing, cmap=SCALE, vmin=0.0, vmax=peaks.largest_standing)
    rocking = outcome == Outcome.ROCKING
    if rocking.any() and rocking.size <= DOTTED_CELLS:
        rows, columns = np.nonzero(rocking)
        axes.plot(
            across.coordinates[columns],
            beside.coordinates[rows],
            linestyle="none",
            marker="o",
            markersize=3.0,
            color="white",
            markeredgecolor="black",
            markeredgewidth=0.5,
        )
    axes.grid(visible=False)


def _edges(axis: SweptAxis) -> Array:
    """Edges of the cells around the values of an axis, shape [axis + 1]."""
    values = np.log(axis.coordinates) if axis.logarithmic else axis.coordinates
    middle = 0.5 * (values[1:] + values[:-1])
    ends = (2.0 * values[0] - middle[0], 2.0 * values[-1] - middle[-1])
    edges = np.concatenate([ends[:1], middle, ends[1:]])
    return np.exp(edges) if axis.logarithmic else edges


def _label(figure: Figure, grid: Any, layout: _Layout, peaks: Peaks) -> None:
    """Labels, scales, ticks, and one legend below."""
    shown = [axes for axes in grid.flat if axes.get_visible()]
    for axes in shown:
        if layout.across is None:
            axes.set_xticks([0.0], ["the one lane of the case"])
        else:
            _scale(axes.xaxis, layout.across, axes.set_xscale, TICK_TEXT // grid.shape[1])
        if layout.as_map and layout.beside is not None:
            _scale(axes.yaxis, layout.beside, axes.set_yscale, None)
        else:
            axes.set_ylim(-0.02 * peaks.top, peaks.top)
            if peaks.raised.any():
                axes.axhline(1.0, color=DARK, linewidth=0.8, linestyle=":")
    if layout.across is not None:
        for axes in shown[-grid.shape[1] :]:
            axes.set_xlabel(layout.across.title)
            axes.tick_params(labelbottom=True)
    if layout.as_map and layout.beside is not None:
        figure.supylabel(layout.beside.title, fontsize=9.0)
        figure.colorbar(shown[0].collections[1], ax=shown, label=PEAK_LABEL)
    else:
        figure.supylabel(PEAK_LABEL, fontsize=9.0)
    handles = _map_handles(peaks) if layout.as_map else _curve_handles(layout, peaks)
    if handles:
        longest = max(len(handle.get_label()) for handle in handles)
        figure.legend(
            handles=handles,
            loc="outside lower center",
            ncols=max(1, min(4, LEGEND_TEXT // (longest + LEGEND_MARK))),
            frameon=False,
            handlelength=2.8,
        )


def _scale(ticked: Any, axis: SweptAxis, set_scale: Any, room: int | None) -> None:
    """Ticks with the names of a nominal axis; else a scale, with plain numbers.

    Args:
        ticked: Axis of matplotlib.
        axis: What lies along it.
        set_scale: Sets its scale.
        room: Letters that fit side by side, beyond which names are slanted; None for no limit.
    """
    if axis.nominal:
        at = spread([axis.length], TICKS)[0]
        names = [axis.name(int(p), bare=True) for p in at]
        words = [[word[-TICK_NAME:] for word in name.split(", ")] for name in names]
        longest = max(len(word) for each in words for word in each)
        slanted = room is not None and (longest + 1) * len(at) > room
        style = {"rotation": 25.0, "ha": "right", "rotation_mode": "anchor"} if slanted else {}
        ticked.set_ticks(at, [(", " if slanted else "\n").join(each) for each in words], **style)
    elif axis.logarithmic:
        from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

        set_scale("log")
        wide = np.ptp(np.log10(axis.coordinates)) > 3.0
        ticked.set_major_locator(LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 5.0)))
        ticked.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        ticked.set_minor_locator(NullLocator())


def _curve_handles(layout: _Layout, peaks: Peaks) -> list[Any]:
    from matplotlib.lines import Line2D

    handles = []
    if layout.beside is not None:
        plain = layout.across is None or layout.across.nominal
        handles = [
            Line2D(
                [],
                [],
                color=_series_color(layout.beside, index),
                linestyle="none" if plain else DASHES[index % len(DASHES)],
                marker="s" if plain else None,
                label=layout.beside.name(index),
            )
            for index in range(layout.beside.length)
        ]
    for code, (name, marker, filled) in OUTCOMES.items():
        if np.any(peaks.outcome == code):
            face = DARK if filled else "none"
            if code in RAISED:
                name = f"{name} (drawn at {peaks.raised_at:g})"
            handles.append(
                Line2D([], [], color=DARK, ls="none", marker=marker, mfc=face, label=name)
            )
    return handles


def _map_handles(peaks: Peaks) -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = []
    if peaks.raised.any():
        far = f", or beyond {FARTHEST:g} when the run ends" if np.any(peaks.outcome == FAR) else ""
        handles.append(Patch(**OVERTURNED_FILL, label=f"overturned{far}"))
    if np.any(peaks.outcome < 0):
        handles.append(Patch(color=UNUSABLE_COLOR, label="no usable number"))
    if np.any(peaks.outcome == Outcome.ROCKING) and len(peaks.outcome) <= DOTTED_CELLS:
        handles.append(
            Line2D([], [], ls="none", marker="o", ms=3.0, mfc="w", mec="k", label="still rocking")
        )
    return handles
