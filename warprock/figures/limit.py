"""Figures of collapses: mechanisms of limit analysis, and joints that moved in a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.analysis.load_limit import Collapse, LoadLimits, collapse_beside
from warprock.analysis.pushing import Pushes
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLUE, DARK, GREY, PALE, VERMILION
from warprock.figures.scales import logarithmic
from warprock.figures.sheet import headline, legend_below, style, subplots
from warprock.figures.solid_view import SolidView
from warprock.findings.asked import naming_columns
from warprock.findings.limit import COULOMB, LOAD_FACTOR, PUSHED, find_limit
from warprock.findings.numbers import counted, even_selection, three
from warprock.findings.sheets import heading
from warprock.model.response import JointState
from warprock.model.solids import SpatialAssembly
from warprock.running.case_run import CaseRun

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from warprock.findings.finding import Facts

MOST_SHOWN = 4
"""Mechanisms that are drawn, an even selection of the lanes that stand."""
ACROSS = 2
"""Panels in a row."""
PANEL = (4.8, 3.6)
"""Width and height of a panel [inch]."""
STONE = "#F4E8D0"
"""Blocks that can move."""
PAD = 0.12
"""Room above and below panels [inch]."""
MOVED = 0.12
"""Largest displacement of a centre of mass in the drawing, over the size of the assembly."""


def draw_limit(found: LoadLimits, pushes: Pushes | None, title: str) -> list[Drawing]:
    """Draws the mechanisms of a few lanes that stand, or blocks alone where none does.

    Args:
        found: What `run_limits` returned.
        pushes: What slow pushes came to, which have a drawing of their own; None without.
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
        where = "blocks" if found.spatial else "blocks where they stand (outlines) and"
        about = (
            f"{found.case.name}: {where} as the mechanism moves "
            "them, by the same scale in all joints; a mechanism has no size of its own"
        )
        headline(figure, title, about)
    said = "; ".join(_name(found.collapses[places[lane]], lane) for lane in shown)
    mechanism = Drawing("mechanism", figure, title, f"{title}. Mechanisms: {said}.")
    return [mechanism, *draw_pushes(found, pushes)]


def draw_collapse(run: CaseRun) -> list[Drawing]:
    """Draws the joints that moved in the first lane that collapsed, and its limit mechanism.

    Args:
        run: A run.

    Returns:
        The drawing; none where no assembly collapsed, or it has too many blocks.
    """
    beside = collapse_beside(run)
    if beside is None:
        return []
    lane, collapse = beside
    state = run.response["joint_state"][lane, : collapse.assembly.joints.count]
    time = float(run.response["collapse_time"][lane])
    with style():
        across = ACROSS if collapse.stands else 1
        flat = not collapse.assembly.spatial
        figure, panels = subplots(
            1, across, (PANEL[0] * across, PANEL[1]), sharex=flat, sharey=flat
        )
        own, *limits = panels.flat
        _draw_moved(own, collapse, state)
        own.set_title("in the run: joints that moved", fontsize=9.0)
        bound = "at most " if collapse.upper_bound else ""
        said = "by limit analysis it does not carry its own weight"
        about = f"{run.case.name}: the first collapse, blocks as they stood; {said}"
        for limit in limits:
            _draw(limit, collapse)
            said = f"limit analysis: load factor {bound}{three(collapse.load_factor)}"
            limit.set_title(said, fontsize=9.0)
            about = (
                f"{run.case.name}: the first collapse. Left, blocks as they stood; right, the "
                "mechanism under a steady sideways load, not to scale"
            )
        legend_below(figure, *panels.flat, columns=4)
        opened = int(((state & JointState.OPENED) > 0).sum())
        slid = int(((state & JointState.SLID) > 0).sum())
        title = (
            f"Lane {lane} collapsed at {three(time)} s: {counted(opened, 'joint')} opened, "
            f"{slid or 'none'} slid"
        )
        headline(figure, title, about)
    return [Drawing("mechanism", figure, title, f"{title}; {said}.")]


def _draw_moved(axes: Axes, collapse: Collapse, state: npt.NDArray[np.int64]) -> None:
    """An assembly as it stood, and its joints that opened or slid."""
    from matplotlib.collections import PolyCollection

    assembly = collapse.assembly
    if isinstance(assembly, SpatialAssembly):
        _draw_moved_in_space(axes, collapse, assembly, state)
        return
    for blocks, face in ((assembly.fixed, PALE), (~assembly.fixed, STONE)):
        drawn = PolyCollection([*assembly.corners[blocks]], facecolor=face, edgecolor=GREY)
        axes.add_collection(drawn)
    for sort, color, width, label in (
        (JointState.SLID, BLUE, 4.5, "joint that slid"),
        (JointState.OPENED, VERMILION, 2.0, "joint that opened"),
    ):
        for place, line in enumerate(assembly.joints.ends[(state & sort) > 0]):
            named = label if place == 0 else None
            axes.plot(*line.T, color=color, linewidth=width, zorder=3, label=named)
    _frame(axes)


def _draw_moved_in_space(
    axes: Axes,
    collapse: Collapse,
    assembly: SpatialAssembly,
    state: npt.NDArray[np.int64],
) -> None:
    """An assembly in space as it stood, and the outlines of joints that opened or slid."""
    view = _view(collapse)
    colours = np.where(assembly.fixed, PALE, STONE)
    for chosen in (assembly.fixed, ~assembly.fixed):
        own = np.flatnonzero(chosen)
        faces = [assembly.faces[place] for place in own]
        view.draw(axes, assembly.corners[own], faces, colours[own].tolist())
    joints = assembly.joints
    for sort, color, width, label in (
        (JointState.SLID, BLUE, 2.2, "joint that slid"),
        (JointState.OPENED, VERMILION, 1.0, "joint that opened"),
    ):
        for number, place in enumerate(np.flatnonzero((state & sort) > 0)):
            corners = joints.ends[place, : joints.end_count[place]]
            line = view.seen(np.concatenate([corners, corners[:1]]))
            named = label if number == 0 else None
            axes.plot(*line.T, color=color, linewidth=width, zorder=3, label=named)
    view.frame(axes, _in_picture(assembly, assembly.corners))


def _view(collapse: Collapse) -> SolidView:
    """A view from where the mechanism does not fall away."""
    return SolidView(BEHIND if np.sin(collapse.direction) > 0.5 else BEFORE)


def _name(collapse: Collapse, lane: int) -> str:
    if not collapse.stands:
        return f"lane {lane}: does not stand"
    bound = " at most" if collapse.upper_bound else ""
    whither = ""
    if collapse.assembly.spatial:
        whither = f" towards {np.rad2deg(collapse.direction):.4g} deg"
    return f"lane {lane}: load factor{bound} {three(collapse.load_factor)}{whither}"


def _draw(axes: Axes, collapse: Collapse) -> None:
    """One assembly and its mechanism on axes of metres, in space as it is seen from a side."""
    from matplotlib.collections import PolyCollection

    assembly = collapse.assembly
    if isinstance(assembly, SpatialAssembly):
        _draw_in_space(axes, collapse, assembly)
        return
    scale = MOVED * float(assembly.size.max())
    every = np.arange(assembly.count)
    moved = assembly.corners + scale * collapse.moved(every, assembly.corners)
    free = ~assembly.fixed
    fixed = PolyCollection([*assembly.corners[~free]], facecolor=PALE, edgecolor=GREY)
    axes.add_collection(fixed)
    axes.add_collection(PolyCollection([*moved[free]], facecolor=STONE, edgecolor=DARK))
    outline = PolyCollection([*assembly.corners[free]], facecolor="none", edgecolor=GREY)
    outline.set_linewidth(0.6)
    axes.add_collection(outline)
    _mark_joints(axes, collapse, scale)
    _frame(axes)


def _draw_in_space(axes: Axes, collapse: Collapse, assembly: SpatialAssembly) -> None:
    """An assembly in space as its mechanism moves it, seen from where it does not fall away."""
    view = _view(collapse)
    scale = MOVED * float(assembly.size.max())
    every = np.arange(assembly.count)
    moved = assembly.corners + scale * collapse.moved(every, assembly.corners)
    still = np.abs(collapse.velocity).max(axis=1) <= STILL
    colours = np.where(assembly.fixed, PALE, np.where(still, UNMOVED, STONE))
    for chosen in (assembly.fixed, ~assembly.fixed):
        own = np.flatnonzero(chosen)
        faces = [assembly.faces[place] for place in own]
        view.draw(axes, moved[own], faces, colours[own].tolist())
    _mark_joints_in_space(axes, collapse, assembly, view, scale)
    every_corner = np.concatenate([assembly.corners, moved])
    view.frame(axes, _in_picture(assembly, every_corner))


def _in_picture(
    assembly: SpatialAssembly, corners: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Corners that a picture has to show: a wide slab below a wall is seen in part."""
    loose = assembly.corners[~assembly.fixed].reshape(-1, 3)
    beside = BESIDE * float(np.ptp(loose, axis=0).max())
    free = np.resize(~assembly.fixed, len(corners))
    least, most = loose.min(axis=0) - beside, loose.max(axis=0) + beside
    return np.where(free[:, None, None], corners, np.clip(corners, least, most))


BEFORE, BEHIND = np.deg2rad(-55.0), np.deg2rad(125.0)
"""Where the reader of a picture of an assembly in space stands; see `SolidView`."""
BESIDE = 0.15
"""How far what is fixed is shown beside the other blocks of a picture in space, over their size."""
STILL = 1e-6
"""Velocity of a block below which it stays in a mechanism, over the largest."""
UNMOVED = "#E3E6EA"
"""Blocks that can move and stay in a mechanism."""
CLOSED = 1e-6
"""Opening of an end below which it is part of a hinge, over the largest of its joint."""


def _mark_joints_in_space(
    axes: Axes, collapse: Collapse, assembly: SpatialAssembly, view: SolidView, scale: float
) -> None:
    """Hinges as lines where joints that open stay closed, and outlines of joints that slide."""
    joints = assembly.joints
    ends = joints.ends + scale * collapse.moved(joints.blocks[:, 1], joints.ends)
    opens, slides = collapse.opens, collapse.slides
    marks: dict[str, list[npt.NDArray[np.float64]]] = {"hinge": [], "sliding joint": []}
    for place in np.flatnonzero(opens | slides):
        count = int(joints.end_count[place])
        corners, parting = ends[place, :count], collapse.parting[place, :count]
        if slides[place]:
            marks["sliding joint"].append(np.concatenate([corners, corners[:1]]))
        elif (closed := parting <= CLOSED * parting.max()).any():
            marks["hinge"].append(corners[closed])
    for (label, lines), colour, width in zip(
        marks.items(), (VERMILION, BLUE), (2.5, 1.2), strict=True
    ):
        for number, line in enumerate(lines):
            named = label if number == 0 else None
            style_of = "-" if len(line) > 1 else "o"
            axes.plot(
                *view.seen(line).T,
                style_of,
                color=colour,
                linewidth=width,
                markersize=4.0,
                zorder=3,
                label=named,
            )


def _frame(axes: Axes) -> None:
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.margins(0.04)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("z [m]")
    # Panels of one scale fill their room, and leave too little below their labels otherwise.
    layout = axes.figure.get_layout_engine()
    if isinstance(layout, ConstrainedLayoutEngine):
        layout.set(h_pad=PAD)


def _mark_joints(axes: Axes, collapse: Collapse, scale: float) -> None:
    """Hinges as dots where joints that open stay closed, sliding joints as lines."""
    joints = collapse.assembly.joints
    second = joints.blocks[:, 1]
    ends = joints.ends + scale * collapse.moved(second, joints.ends)
    opens, slides = collapse.opens, collapse.slides
    closed = np.argmin(collapse.parting, axis=1)
    hinges = ends[np.arange(joints.count), closed][opens]
    if len(hinges):
        axes.plot(*hinges.T, "o", color=VERMILION, markersize=5.0, zorder=3, label="hinge")
    for place, line in enumerate(ends[slides]):
        label = "sliding joint" if place == 0 else None
        axes.plot(*line.T, color=BLUE, linewidth=2.5, zorder=3, label=label)


def draw_pushes(found: LoadLimits, pushes: Pushes | None) -> list[Drawing]:
    """Draws slow pushes beside limit analysis.

    Of one assembly it is how far each load moved it; of several the load of each over what sets
    them apart.

    Returns:
        The drawing; none where nothing was pushed, or no load was found.
    """
    if pushes is None or not np.isfinite(pushes.factor).any():
        return []
    one = len(found.collapses) == 1
    finding = find_limit(found, pushes)
    title = next(text for text in finding.sentences if text.startswith("Pushed")).removesuffix(".")
    about = f"{found.case.name}: the load is the same part of the weight of every block"
    with style():
        figure, panels = subplots(1, 1, (7.0, 3.8))
        axes = panels[0, 0]
        if one:
            _draw_tries(axes, found.collapses[0], pushes)
        else:
            _draw_loads(axes, finding.facts, finding.frames["limits"])
        legend_below(figure, axes, columns=3)
        headline(figure, title, about)
    return [Drawing("push", figure, title, f"{title}.")]


LIMIT_LABEL = "limit analysis"
LEAST_SHOWN = 1e-3
"""Displacement as which less is drawn, too [mm]."""


def _draw_tries(axes: Axes, collapse: Collapse, pushes: Pushes) -> None:
    """The largest displacement under each load that was tried, and the loads of limit analysis."""
    tried, most = pushes.tried, collapse.load_factor
    for fell, color, mark, label in (
        (False, BLUE, "o", "stands"),
        (True, VERMILION, "x", "collapses"),
    ):
        mine = tried.fell == fell
        moved = np.maximum(1e3 * tried.moved[mine], LEAST_SHOWN)
        axes.plot(
            tried.factor[mine], moved, mark, color=color, markersize=5.0, zorder=3, label=label
        )
    least = float(np.fmin(collapse.coulomb_load, most))
    if least < most:
        axes.axvspan(least, most, color=PALE, linewidth=0.0, label=LIMIT_LABEL)
    else:
        axes.axvline(most, color=GREY, linewidth=1.2, label=LIMIT_LABEL)
    logarithmic(axes.yaxis)
    axes.set_xlim(left=0.0)
    axes.set_xlabel(LOAD_LABEL)
    axes.set_ylabel("largest displacement [mm]")


LOAD_LABEL = "sideways load / self-weight [-]"


def _draw_loads(axes: Axes, facts: Facts, table: pd.DataFrame) -> None:
    """Loads of limit analysis and of pushes over the input that is swept, or over lanes."""
    names = [name for name in naming_columns(facts, table) if table[name].dtype.kind in "if"]
    across = names[0] if len(names) == 1 else "lane"
    at, most = table[across].to_numpy(dtype=float), table[LOAD_FACTOR].to_numpy(dtype=float)
    least = np.fmin(table[COULOMB].to_numpy(dtype=float), most)
    axes.vlines(at, least, most, color=GREY, linewidth=4.0, alpha=0.6)
    slide = least < most
    upper = f"{LIMIT_LABEL}, upper end" if slide.any() else LIMIT_LABEL
    axes.plot(at, most, "_", color=GREY, markersize=14.0, label=upper)
    if slide.any():
        lower = f"{LIMIT_LABEL}, lower end"
        axes.plot(at[slide], least[slide], "_", color=DARK, markersize=9.0, label=lower)
    axes.plot(at, table[PUSHED], "o", color=VERMILION, markersize=4.5, zorder=3, label="slow push")
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel(heading(across).label)
    axes.set_ylabel(LOAD_LABEL)
