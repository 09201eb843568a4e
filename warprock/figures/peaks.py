"""Peak rotation over the swept inputs of a case: curves for few values, a map for many."""

from __future__ import annotations

import dataclasses
import itertools
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.figures.drawing import Drawing
from warprock.figures.outcomes import FAR, FARTHEST, RAISED, Peaks, read_peaks
from warprock.figures.palette import DARK, DASHES, SCALE, SERIES, VERMILION
from warprock.figures.scales import logarithmic, three_digits
from warprock.figures.sheet import headline, style, subplots
from warprock.model.response import Outcome
from warprock.running.case_run import CaseRun
from warprock.tables.swept import TICKS, SweptAxis, lanes_at, spread, swept_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

PEAK_LABEL = "peak rotation / slenderness angle [-]"
PANELS = 6
SIDE = 2.5
"""Points between marks of curves at one place of a scale."""
WRITTEN = 24
"""Marks at names up to which each has its number beside it."""
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
        if layout.across is None:
            figure = _draw_one(peaks)
        else:
            size = (9.6, (4.0 if rows == 1 else 2.8 * rows) + 0.6)
            figure, grid = subplots(rows, columns, size, sharex=True, sharey=True)
            for axes in grid.flat[len(places) :]:
                axes.set_visible(False)
            for axes, place in zip(grid.flat, places, strict=False):
                at = {a.number: int(p) for a, p in zip(layout.panels, place, strict=True)}
                names = [a.name(int(p)) for a, p in zip(layout.panels, place, strict=True)]
                axes.set_title(", ".join(names))
                draw = _draw_map if layout.as_map else _draw_curves
                draw(axes, run, peaks, layout, at)
            _label(figure, grid, layout, peaks)
        title, about = peaks.message(block), _about(run, block, peaks, layout, len(places))
        headline(figure, title, about)
    name = "peaks" if block is None else f"peaks-block-{block + 1}"
    return Drawing(name, figure, title, f"{about}. {title}.".replace("\n", ". "))


def _draw_one(peaks: Peaks) -> Figure:
    """The peak of a case of one lane, as a bar beside the slenderness angle."""
    figure, grid = subplots(1, 1, (9.6, 1.2))
    axes = grid[0, 0]
    code, ratio = int(peaks.outcome[0]), float(peaks.ratio[0])
    raised = code in RAISED
    long = peaks.raised_at if raised else ratio if np.isfinite(ratio) else 0.0
    said = peaks.outcomes[code][0] if code in peaks.outcomes else "no usable number"
    axes.barh(0.0, long, height=0.5, color=VERMILION if raised else SERIES[0])
    text = said if raised or code not in peaks.outcomes else f"{three_digits(ratio)}, {said}"
    inside = long > 0.6
    axes.annotate(
        text,
        (long, 0.0),
        xytext=(-5 if inside else 5, 0),
        textcoords="offset points",
        ha="right" if inside else "left",
        va="center",
        color="white" if inside else "black",
    )
    axes.axvline(1.0, color=DARK, linewidth=0.8, linestyle=":")
    axes.set_xlim(0.0, max(1.05, 1.05 * long))
    axes.set_yticks([])
    axes.set_xlabel(PEAK_LABEL)
    return figure


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
    """One curve for each value of the axis beside; a mark for each lane, of one size."""
    across, beside = layout.across, layout.beside
    assert across is not None
    x = across.coordinates
    size = 6.0 if len(x) <= 60 else 4.0 if len(x) <= 300 else 2.0
    count = 1 if beside is None else beside.length
    for index in range(count):
        here = at if beside is None else at | {beside.number: index}
        lanes = lanes_at(run.case, here)
        ratio, outcome = peaks.ratio[lanes], peaks.outcome[lanes]
        color = _series_color(beside, index)
        # Lanes of equal inputs lie side by side.
        place = index / max(count - 1, 1) - 0.5
        beside_names = across.nominal
        aside = _moved(axes, 0.0 if beside_names else SIDE * (index - 0.5 * (count - 1)))
        if not (across.nominal or across.of_seeds):
            standing = np.where(peaks.raised[lanes], np.nan, ratio)
            line = DASHES[index % len(DASHES)]
            axes.plot(x, standing, color=color, linestyle=line, transform=aside)
        for code, (_, marker, filled) in peaks.outcomes.items():
            rows = outcome == code
            up = np.full(int(rows.sum()), peaks.raised_at) if code in RAISED else ratio[rows]
            axes.plot(
                x[rows] + (DODGE * place if beside_names and count > 1 else 0.0),
                up,
                linestyle="none",
                marker=marker,
                markersize=size,
                markeredgewidth=0.9,
                zorder=3.0,
                color=color,
                markerfacecolor=color if filled else "white",
                transform=aside,
            )
            if beside_names and len(x) * count <= WRITTEN:
                _write(axes, x[rows] + (DODGE * place if count > 1 else 0.0), up, code, peaks)


def _moved(axes: Axes, points: float) -> Any:
    """The coordinates of a panel, moved across by some points."""
    from matplotlib.transforms import ScaledTranslation

    figure: Any = axes.get_figure()
    return axes.transData + ScaledTranslation(points / 72.0, 0.0, figure.dpi_scale_trans)


def _write(axes: Axes, across: Array, up: Array, code: int, peaks: Peaks) -> None:
    """Writes peaks beside their marks; of what fell the scale says enough."""
    for x, y in zip(across, up, strict=True):
        if code not in RAISED and np.isfinite(y):
            inside = y > 0.9 * peaks.top
            axes.annotate(
                three_digits(y),
                (x, y),
                xytext=(0, -5 if inside else 5),
                textcoords="offset points",
                ha="center",
                va="top" if inside else "bottom",
                fontsize=8.5,
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
    axes.pcolormesh(x, y, standing, cmap=SCALE, vmin=0.0, vmax=min(peaks.largest_standing, 1.0))
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


def _ends(axis: SweptAxis) -> tuple[float, float]:
    """Limits of a scale that leave room for marks beside one another."""
    values = np.log(axis.coordinates) if axis.logarithmic else axis.coordinates
    room = 0.6 if axis.nominal else 0.05 * float(np.ptp(values))
    low, high = float(values.min()) - room, float(values.max()) + room
    return (np.exp(low), np.exp(high)) if axis.logarithmic else (low, high)


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
        if layout.across is not None:
            _scale(axes.xaxis, layout.across, TICK_TEXT // grid.shape[1])
        if layout.as_map and layout.beside is not None:
            _scale(axes.yaxis, layout.beside, None)
        else:
            peaks.scale(axes)
            if layout.across is not None:
                axes.set_xlim(_ends(layout.across))
    if layout.across is not None:
        for axes in shown[-grid.shape[1] :]:
            axes.set_xlabel(layout.across.title)
            axes.tick_params(labelbottom=True)
    if layout.as_map and layout.beside is not None:
        figure.supylabel(layout.beside.title, fontsize=9.0)
        extend = "max" if peaks.largest_standing > 1.0 else "neither"
        figure.colorbar(shown[0].collections[1], ax=shown, label=PEAK_LABEL, extend=extend)
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


def _scale(ticked: Any, axis: SweptAxis, room: int | None) -> None:
    """Ticks with the names of a nominal axis; else a scale, with plain numbers.

    Args:
        ticked: Axis of matplotlib.
        axis: What lies along it.
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
        logarithmic(ticked)


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
    for code, (name, marker, filled) in peaks.outcomes.items():
        if np.any(peaks.outcome == code):
            face = DARK if filled else "none"
            if code in RAISED:
                name = f"{name} (drawn at the top)"
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
            Line2D([], [], ls="none", marker="o", ms=3.0, mfc="w", mec="k", label="still moving")
        )
    return handles
