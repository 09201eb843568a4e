"""Rotation histories of a run, each with the acceleration of its base."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.case.case import Case
from warprock.figures.bases import Bases
from warprock.figures.drawing import Drawing
from warprock.figures.outcomes import read_peaks
from warprock.figures.palette import BLACK, BLUE, DARK, DASHES, GREEN, ORANGE, PURPLE, VERMILION
from warprock.figures.scales import three_digits
from warprock.figures.sheet import (
    SHORT_ROTATION_LABEL,
    TIME_LABEL,
    headline,
    legend_below,
    style,
    subplots,
)
from warprock.model.ratios import peak_ratio, rotation_ratio
from warprock.model.response import FIELDS, USABLE, Outcome, Response, Status
from warprock.running.case_run import CaseRun
from warprock.tables.swept import lanes_at, spread, swept_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]
Window = tuple[float, float]

PANELS, OVERLAYS = 12, 4
TITLE_LETTERS = 116
"""Letters that fit side by side above all panels of a row."""
UNFOLDED = 4
"""Panels above one another; more are folded into two columns."""
CAP = 1.2
"""Rotation ratio at which a history leaves its panel: a fallen block would squash the others."""

MANY_CROSSINGS, TOO_MANY_CROSSINGS = 40, 150
"""Zero crossings beyond which a history needs an enlarged part, or is drawn as an outline."""
ENLARGED_CROSSINGS, ENLARGED_PART = 10, 6.0
"""Most zero crossings, and most of the run as its part, on either side of the largest rotation."""
LEAST, OWN_SCALE = 1e-3, 3.0
"""Smallest rotation ratio that fills a panel, and how many times those of panels may differ before
each has a scale of its own."""
VISIBLE = 0.02
"""Part of the largest rotation below which a crossing cannot be seen."""
OUTLINE_CROSSINGS, OUTLINE_POINTS = 6, 100
"""Crossings at least, and points at most, that one point of an outline stands for or is one of."""

OVERLAY_COLORS = (BLUE, ORANGE, GREEN, BLACK, VERMILION, PURPLE)


def overlay_style(number: int) -> dict[str, Any]:
    """Look of one of the curves of a panel."""
    return {"color": OVERLAY_COLORS[number], "linestyle": DASHES[number]}


@dataclasses.dataclass(frozen=True)
class ShownLanes:
    """The lanes whose histories are drawn.

    Attributes:
        lanes: Their numbers, shape [panel, overlay]; [panel, 1] for stacks.
        panels: Name of every panel, empty where there is only one.
        overlays: Name of every curve of a panel, empty where there is only one; the curves of a
            stack are its blocks.
    """

    lanes: Indices
    panels: tuple[str, ...]
    overlays: tuple[str, ...]


def choose_lanes(case: Case) -> ShownLanes:
    """Lanes to draw: a few values of a text over each other, the other inputs in panels.

    Where there are more inputs than panels, those drawn are evenly spaced along each axis.
    """
    axes = swept_axes(case)
    stacked = case.tables.stacked
    texts = [axis for axis in axes if axis.texts and axis.length <= OVERLAYS]
    over = texts[0] if texts and not stacked else None
    rest = [axis for axis in axes if axis is not over]
    lanes, panels = [], []
    for positions in itertools.product(*spread([axis.length for axis in rest], PANELS)):
        at = {axis.number: int(p) for axis, p in zip(rest, positions, strict=True)}
        lanes.append(lanes_at(case, at))
        panels.append(", ".join(a.name(int(p)) for a, p in zip(rest, positions, strict=True)))
    overlays = [over.name(p) for p in range(over.length)] if over else [""]
    if stacked:
        overlays = _block_names(case.tables.block_count)
    return ShownLanes(np.stack(lanes), tuple(panels), tuple(overlays))


def _block_names(count: int) -> list[str]:
    ends = {1: " (bottom)", count: " (top)"} if count > 1 else {}
    return [f"block {number}{ends.get(number, '')}" for number in range(1, count + 1)]


def _by_curve(response: Response) -> Response:
    """The histories of stacks with each block as a lane of its own, in the order of the curves."""
    if response["rotation"].ndim == 2:
        return response
    blocks = response["rotation"].shape[1]
    fields = {
        name: values.reshape(-1, *values.shape[2:])
        if FIELDS[name].per_block
        else np.repeat(values, blocks)
        for name, values in response.fields.items()
    }
    return dataclasses.replace(response, fields=fields)


def draw_histories(run: CaseRun, shown: ShownLanes, response: Response) -> Drawing:
    """Rotation histories, each below the acceleration of its base.

    Lanes that share their motion have it above all panels, once.

    Args:
        run: The run.
        shown: Which lanes, and their names.
        response: Their histories, in the order of `shown.lanes`, read along its rows.
    """
    lanes = run.lane_set.lanes.take(shown.lanes.ravel())
    response = _by_curve(response)
    if lanes.stacked:
        ratios = response["rotation"] / lanes.slenderness_angle.reshape(-1, 1)
    else:
        ratios = rotation_ratio(response["rotation"], lanes)
    ratios = ratios.reshape(len(shown.lanes), len(shown.overlays), -1)
    curves = _Curves(response, ratios, run.case.sample_times.duration)
    bases = Bases.of(run, shown.lanes)
    windows = curves.windows
    folds = 2 if len(windows) == 1 and len(shown.lanes) > UNFOLDED else 1
    heights = bases.heights(-(-len(shown.lanes) // folds))
    with style():
        size = (9.6, sum(heights) + 0.9)
        columns = folds * len(windows)
        figure, grid = subplots(len(heights), columns, size, sharex="col", height_ratios=heights)
        strips, panels = bases.split(grid, len(windows))
        for unused in panels[len(shown.lanes) :].flat:
            unused.set_visible(False)
        for index, pair in enumerate(panels[: len(shown.lanes)]):
            for axes, window in zip(pair, windows, strict=True):
                _draw_panel(axes, curves, shown, index, window)
            pair[0].set_ylabel(SHORT_ROTATION_LABEL)
        for index, pair in enumerate(strips):
            for axes, window in zip(pair, windows, strict=True):
                bases.draw(axes, index, window)
        for index, pair in enumerate(_heads(strips, panels, len(shown.lanes), bases)):
            letters = TITLE_LETTERS // (columns if index == 0 else folds)
            notes = bases.start(index)
            pair[0].set_title(_in_lines(_panel_title(run, shown, index, notes), letters))
            for axes, (first, end) in zip(pair[1:], windows[1:], strict=True):
                axes.set_title(f"enlarged: {first:g} s to {end:g} s" if index == 0 else "")
        for column in grid.T:
            last = [axes for axes in column if axes.get_visible()][-1]
            last.set_xlabel(TIME_LABEL)
            last.tick_params(labelbottom=True)
        _add_legend(figure, panels[0, 0], shown, curves)
        title, about = read_peaks(run).message(), _about(run, shown, curves)
        headline(figure, title, about)
    return Drawing("histories", figure, title, f"{about}. {title}.".replace("\n", ". "))


def _heads(strips: Any, panels: Any, count: int, bases: Bases) -> Any:
    """The uppermost axes of every lane shown, which bear its title."""
    return panels[:count] if bases.shared or not len(strips) else strips


@dataclasses.dataclass(frozen=True)
class _Curves:
    """Histories to draw.

    Attributes:
        response: The histories as they came, shape [panel x overlay, sample].
        ratios: Rotation / slenderness angle, shape [panel, overlay, sample].
        duration: Length of the run [s].
    """

    response: Response
    ratios: Array
    duration: float

    @functools.cached_property
    def crossings(self) -> int:
        """Most zero crossings of a curve, those too small to be seen left out."""
        sizes = np.abs(np.nan_to_num(self.ratios))
        floor = VISIBLE * min(float(sizes.max()), 1.0)
        return max(
            int(np.sum(np.diff(np.signbit(ratio[size > floor]))))
            for ratio, size in zip(
                self.ratios.reshape(-1, sizes.shape[-1]),
                sizes.reshape(-1, sizes.shape[-1]),
                strict=True,
            )
        )

    @property
    def outlined(self) -> bool:
        """Whether the curves over the whole run would be mere areas."""
        return self.crossings > TOO_MANY_CROSSINGS

    @property
    def outline_points(self) -> int:
        """Points of an outline."""
        return min(OUTLINE_POINTS, self.crossings // OUTLINE_CROSSINGS)

    @functools.cached_property
    def windows(self) -> list[Window]:
        """The whole run, and where it is dense, the part around the largest rotation [s]."""
        windows = [(0.0, self.duration)]
        if self.crossings > MANY_CROSSINGS:
            stands = self.response["outcome"] != Outcome.OVERTURNED
            sizes = np.abs(np.nan_to_num(self.ratios)).max(axis=2).ravel()
            largest = int(np.argmax(np.where(stands, sizes, 0.0)))
            ratio = self.ratios.reshape(len(sizes), -1)[largest]
            at = self.response.times[1:][np.diff(np.signbit(ratio))]
            centre = float(self.response["peak_time"][largest])
            near = int(np.searchsorted(at, centre))
            ends = np.concatenate([[0.0], at, [self.duration]])
            most = self.duration / ENLARGED_PART
            first = max(ends[max(near - ENLARGED_CROSSINGS, 0)], centre - most, 0.0)
            last = min(ends[min(near + ENLARGED_CROSSINGS, len(ends) - 1)], centre + most)
            grain = 1.0 if last - first > 5.0 else 0.1
            first = np.floor(first / grain) * grain
            windows.append((float(first), float(min(np.ceil(last / grain) * grain, self.duration))))
        return windows

    @functools.cached_property
    def largest(self) -> Array:
        """Largest rotation ratio that is drawn, at most `CAP`, shape [panel]."""
        sizes = np.nanmax(np.abs(self.ratios), axis=(1, 2), initial=0.0)
        return np.asarray(np.clip(sizes, LEAST, CAP))

    @property
    def scaled(self) -> bool:
        """Whether every panel has a scale of its own, so that small rotations can be seen."""
        return bool(self.largest.max() > OWN_SCALE * self.largest.min())

    def limits(self, panel: int) -> Window:
        """Limits of the rotation ratio of a panel."""
        limit = 1.1 * float(self.largest[panel] if self.scaled else self.largest.max())
        # Of assemblies it is the largest rotation of any block, to either side.
        return (-limit if np.any(self.ratios < 0.0) else -0.05 * limit), limit


def _about(run: CaseRun, shown: ShownLanes, curves: _Curves) -> str:
    count, total = shown.lanes.size, run.case.lane_count
    which = "" if count == total else f"\n{count} of {total} lanes, evenly spaced along each input"
    scales = "; each panel has its own scale" if curves.scaled else ""
    return f"{run.case.name}, {run.response.engine}: rotation over time{scales}{which}"


def _panel_title(run: CaseRun, shown: ShownLanes, index: int, base: str) -> str:
    lanes = shown.lanes[index]
    numbers = f"lane{'s' * (len(lanes) > 1)} {', '.join(str(lane) for lane in lanes)}"
    statuses = {int(lane): Status(int(run.response["status"][lane])) for lane in lanes}
    said = [
        f"{lane}: {status.name.lower().replace('_', ' ')}"
        + ("" if status in USABLE else ", numbers not usable")
        for lane, status in statuses.items()
        if status is not Status.OK
    ]
    notes = f" ({'; '.join(filter(None, [*_peaks_of(run, lanes), *said, base]))})"
    name = shown.panels[index]
    return f"{name}{' - ' if name else ''}{numbers}{notes}"


def _peaks_of(run: CaseRun, lanes: Indices) -> list[str]:
    """Peaks of lanes over slenderness angles, or that they fell; nothing of what has no number."""
    ratios = peak_ratio(run.response, run.lane_set.lanes)
    found = []
    for lane in lanes:
        if run.response["outcome"][lane] == Outcome.OVERTURNED:
            found.append("overturned")
        else:
            found += [three_digits(ratio) for ratio in np.atleast_1d(ratios[lane])]
    return (
        [f"peak{'s' * (len(found) > 1)} {' / '.join(found)}"] if found != ["overturned"] else found
    )


def _in_lines(title: str, letters: int) -> str:
    """A title in lines that break behind commas only, so that a number keeps its unit."""
    space = "\N{NO-BREAK SPACE}"
    lines = textwrap.fill(title.replace(" ", space).replace(f",{space}", ", "), letters)
    return lines.replace(space, " ")


def _draw_panel(axes: Axes, curves: _Curves, shown: ShownLanes, index: int, window: Window) -> None:
    """Curves of one panel, the larger ones below, and where a block falls."""
    whole = window == curves.windows[0]
    for overlay, ratio in enumerate(curves.ratios[index]):
        outside = np.abs(ratio) > CAP
        inside = np.where(outside, np.nan, ratio)
        size = float(np.sqrt(np.mean(np.nan_to_num(inside) ** 2)))
        look = overlay_style(overlay) | {"zorder": 3.0 - size / (2.0 * CAP)}
        times, values = curves.response.times, inside
        if whole and curves.outlined:
            times, values = _outline(times, inside, curves.outline_points)
        label = shown.overlays[overlay] or "_"
        axes.plot(times, values, label=label, linewidth=1.1, **look)
        row = index * len(curves.ratios[index]) + overlay
        if curves.response["outcome"][row] == Outcome.OVERTURNED and outside.any():
            at = int(np.argmax(outside))
            up = ratio[at] > 0.0
            axes.plot(
                curves.response.times[at],
                CAP if up else -CAP,
                marker="^" if up else "v",
                color=look["color"],
                markersize=7.0,
                zorder=5.0,
            )
    axes.set_xlim(*window)
    axes.set_ylim(*curves.limits(index))
    within = (curves.response.times >= window[0]) & (curves.response.times <= window[1])
    if np.all(np.abs(curves.ratios[index][:, within]) > CAP):
        axes.text(0.5, 0.5, "overturned before", transform=axes.transAxes, ha="center", va="center")


def _outline(times: Array, ratio: Array, points: int) -> tuple[Array, Array]:
    """The largest and, after a gap, the smallest values within equal parts of the run."""
    starts = np.linspace(0, len(times), points, endpoint=False).astype(np.intp)
    middle = 0.5 * (times[starts] + times[np.append(starts[1:], len(times)) - 1])
    gap = np.array([np.nan])
    upper, lower = np.fmax.reduceat(ratio, starts), np.fmin.reduceat(ratio, starts)
    return np.concatenate([middle, gap, middle]), np.concatenate([upper, gap, lower])


def _add_legend(figure: Figure, axes: Axes, shown: ShownLanes, curves: _Curves) -> None:
    """A legend where there is something to tell apart or to explain."""
    notes: list[tuple[dict[str, Any], str]] = []
    if curves.outlined:
        part = curves.duration / curves.outline_points
        notes.append(({}, f"whole run, left: largest and smallest in every {part:.2g} s"))
    if any(line.get_marker() in ("^", "v") for a in figure.axes for line in a.lines):
        notes.append(({"marker": "^", "color": DARK}, f"overturned: goes beyond {CAP:g}"))
    for look, note in notes:
        axes.plot([], [], linestyle="none", label=note, **look)
    if notes or shown.overlays[0]:
        legend_below(figure, axes, columns=3)
