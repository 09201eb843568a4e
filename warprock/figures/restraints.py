"""The figures of what holds a block, over time: its ties, its impacts, and a moment that changes.

Of a run one lane is drawn, again and finely sampled: of those that stay up the one that turns
furthest, so that its ties have the most to do.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.figures.bases import POINTS
from warprock.figures.drawing import Drawing
from warprock.figures.histories import CAP
from warprock.figures.palette import BLUE, DARK, DASHES, FALLEN, GREY, SERIES
from warprock.figures.scales import three_digits
from warprock.figures.sheet import (
    SHORT_ROTATION_LABEL,
    TIME_LABEL,
    headline,
    legend_below,
    style,
    subplots,
)
from warprock.model.base_path import base_places
from warprock.model.hold import Ties
from warprock.model.lanes import Lanes
from warprock.model.ratios import peak_ratio
from warprock.model.response import Outcome, Response
from warprock.model.statics import curve, leaning
from warprock.model.tie_states import TieHistory, TieState, tie_elongations, tie_history
from warprock.running.case_run import CaseRun, run_lane
from warprock.running.companions import usable
from warprock.running.lane_table import first_break, lane_pose
from warprock.running.scene_motion import sampled_by
from warprock.units import GRAVITY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

SAMPLES = 20_000
"""Samples of the lane that is drawn, at least."""
VISIBLE = 0.02
"""Part of the largest rotation that can be seen: where it begins and ends, the figure does."""
DEGREES = 180.0 / np.pi


def told_lane(run: CaseRun) -> int:
    """The lane that turns furthest of those that stay up; where none does, that turns furthest."""
    size = np.nan_to_num(peak_ratio(run.response, run.lane_set.lanes), nan=-1.0)
    up = usable(run.response) & (run.response["outcome"] != Outcome.OVERTURNED)
    return int(np.argmax(np.where(up, size, -1.0) if up.any() else size))


def draw_restraints(run: CaseRun) -> list[Drawing]:
    """Draws what holds the block of one lane, and what moves below its support.

    Args:
        run: A run of single blocks with histories.

    Returns:
        A drawing of ties and of a wall, one of a support; none without either.
    """
    hold = run.lane_set.lanes.hold
    held = hold is not None and (hold.ties is not None or hold.wall is not None)
    if not held and run.lane_set.ground is None:
        return []
    interval = run.case.sample_times.duration / SAMPLES
    fine = dataclasses.replace(run, case=sampled_by(run.case, interval))
    lane = told_lane(run)
    response = run_lane(fine, lane)
    drawings = []
    if held:
        drawings.append(_draw_held(_Told.of(run, lane, response)))
    if run.lane_set.ground is not None:
        drawings.append(_draw_support(run, lane, response))
    return drawings


@dataclasses.dataclass(frozen=True)
class _Told:
    """One lane whose block is held.

    Attributes:
        run: The run.
        lane: Number of the lane.
        lanes: This lane alone.
        response: Its response, finely sampled.
        elongation: Of its ties [m], shape [tie, sample].
        ties: What they do; None without ties.
        arm: Height of the points of its ties above the base [m], shape [tie, sample].
        last: Sample at which its block leaves the figure.
    """

    run: CaseRun
    lane: int
    lanes: Lanes
    response: Response
    elongation: Array
    ties: TieHistory | None
    arm: Array
    last: int

    @classmethod
    def of(cls, run: CaseRun, lane: int, response: Response) -> _Told:
        """One lane of a run, from its response with histories."""
        lanes = run.lane_set.lanes.take(np.array([lane]))
        assert lanes.hold is not None
        ties, times = lanes.hold.ties, response.times
        size = float(lanes.width[0]), float(lanes.height[0])
        pose = lane_pose(response, 0)
        beyond = np.abs(pose[2]) > CAP * lanes.slenderness_angle[0]
        last = int(np.argmax(beyond)) if beyond.any() else len(times) - 1
        if ties is None:
            return cls(run, lane, lanes, response, np.empty((0, 0)), None, np.empty((0, 0)), last)
        elongation = tie_elongations(ties, *size, pose)
        done = tie_history(ties, elongation, times, first_break(response, 0))
        across = 0.5 * size[0] * ties.side[0][:, None]
        above = ties.height[0][:, None] - 0.5 * size[1]
        arm = pose[1] + above * np.cos(pose[2]) - across * np.sin(pose[2])
        return cls(run, lane, lanes, response, elongation, done, arm, last)

    @property
    def rotation(self) -> Array:
        """Towards +x [rad], shape [sample]."""
        return np.asarray(self.response["rotation"].reshape(-1))

    @property
    def window(self) -> tuple[float, float]:
        """When the block turns so that it can be seen [s]."""
        times, size = self.response.times, np.abs(self.rotation[: self.last + 1])
        seen = np.flatnonzero(size > VISIBLE * max(float(size.max()), 1e-300))
        if not len(seen):
            return float(times[0]), float(times[-1])
        first, last = float(times[seen[0]]), float(times[seen[-1]])
        more = 0.05 * (last - first) + float(times[1])
        return max(first - more, 0.0), min(last + more, float(times[-1]))

    @property
    def against_wall(self) -> bool:
        """Whether it stands against a wall all along: it has one, and leans away from it alone."""
        hold = self.lanes.hold
        if hold is None or hold.wall is None:
            return False
        slid = float(self.response["peak_slide"][0]) > 1e-9 * float(self.lanes.height[0])
        return not slid and bool((hold.wall[0] * self.rotation <= 0.0).all())

    @property
    def impacts(self) -> Array:
        """Times at which the block comes back on its base [s], of those that can be seen."""
        size = np.abs(self.rotation[: self.last + 1])
        step = np.abs(np.diff(size))
        inner, near = size[1:-1], np.maximum(step[:-1], step[1:])
        low = (inner <= size[:-2]) & (inner < size[2:]) & (inner <= near)
        ends = 1 + np.flatnonzero(low)
        if not len(ends):
            return np.empty(0)
        peaks = np.maximum.reduceat(size[: ends[-1] + 1], np.concatenate([[0], ends[:-1]]))
        return np.asarray(self.response.times[ends[peaks > VISIBLE * size.max()]])

    def moments(self) -> Array:
        """Moment that turns the block back about the corner it stands on [N m], shape [sample].

        It has the sign of the rotation it resists.
        """
        turn = self.rotation
        found = np.zeros_like(turn)
        free = _without_ties(self.lanes)
        for side in (-1.0, 1.0):
            lean = np.maximum(side * turn, 0.0)[None]
            found = np.where(
                side * turn > 0.0, side * leaning(free, side).moment(lean, lean)[0], found
            )
        if self.ties is not None:
            found -= (self._ties.side[0][:, None] * self.ties.force * self.arm).sum(axis=0)
        return np.asarray(found)

    @property
    def _ties(self) -> Ties:
        assert self.lanes.hold is not None
        assert self.lanes.hold.ties is not None
        return self.lanes.hold.ties

    def sentence(self) -> str:
        """What the ties did; of a wall alone how often the block came back on it."""
        count = int(self.response["impact_count"][0])
        if self.ties is None:
            where = "comes back on its wall" if self.against_wall else "strikes base or wall"
            return f"The block {where} {count} time{'s' * (count != 1)}"
        force = three_digits(float(self.response["peak_tie_force"][0]) / 1e3)
        states = self.ties.states[:, : self.last + 1]
        yield_count = int((states == TieState.YIELDING).any(axis=1).sum())
        broke = first_break(self.response, 0)
        if len(states) == 1:
            text = f"The tie pulls with up to {force} kN" + " and yields" * yield_count
        else:
            text = f"The ties pull with up to {force} kN"
            if yield_count:
                text += f"; {yield_count} of {len(states)} yield{'s' * (yield_count == 1)}"
        if not np.isnan(broke):
            text += f"; {'the first' if len(states) > 1 else 'it'} breaks at {broke:.3g} s"
        return text


def _without_ties(lanes: Lanes) -> Lanes:
    assert lanes.hold is not None
    return dataclasses.replace(lanes, hold=dataclasses.replace(lanes.hold, ties=None))


def _draw_held(told: _Told) -> Drawing:
    """The lane over time to the left, ties and moments over the way to the right."""
    from matplotlib.figure import Figure

    rows = 2 if told.ties is None else 4
    with style():
        figure = Figure(figsize=(9.6, 1.5 * rows + 0.9), layout="constrained")
        halves = figure.add_gridspec(1, 2, width_ratios=(3, 2))
        left, right = halves[0].subgridspec(rows, 1), halves[1].subgridspec(rows // 2, 1)
        times: Any = left.subplots(sharex=True)
        columns: Any = right.subplots(squeeze=False)
        ways = columns[:, 0]
        _draw_base(times[0], told)
        _draw_rotation(times[1], told)
        if told.ties is not None:
            _draw_over_time(times[2], told, told.ties.force / 1e3, "force [kN]")
            _draw_over_time(times[3], told, told.elongation * 1e3, "elongation\n[mm]")
            _draw_cycles(ways[0], told)
        _draw_moment(ways[-1], told)
        times[0].set_xlim(*told.window)
        times[-1].set_xlabel(TIME_LABEL)
        legend_below(figure, times[1], *times[2:3], ways[-1], columns=4)
        title = told.sentence()
        about = f"{told.run.case.name}, {told.run.response.engine}, lane {told.lane}"
        headline(figure, title, f"{about}: the block and what holds it")
    return Drawing("restraints", figure, title, f"{about}. {title}.")


def _draw_base(axes: Axes, told: _Told) -> None:
    motion = told.run.lane_set.motions.components[0]
    times = np.linspace(*told.window, POINTS)
    axes.plot(times, motion.acceleration(times, told.lane) / GRAVITY, color=DARK, linewidth=0.9)
    axes.set_ylabel("base [g]")
    axes.locator_params(axis="y", nbins=3)


def _draw_rotation(axes: Axes, told: _Told) -> None:
    """Rotation, where the block comes back, and the ends at which ties break."""
    shown = slice(0, told.last + 1)
    ratio = told.rotation / told.lanes.slenderness_angle[0]
    axes.plot(told.response.times[shown], ratio[shown], color=BLUE, linewidth=1.1)
    at, name = told.impacts, "impact on the wall" if told.against_wall else "impact"
    look: dict[str, Any] = {"marker": "|", "markersize": 9.0, "color": FALLEN, "linestyle": "none"}
    axes.plot(at, np.zeros(len(at)), label=name, zorder=4.0, **look)
    axes.set_ylabel(SHORT_ROTATION_LABEL)


def _draw_over_time(axes: Axes, told: _Told, values: Array, label: str) -> None:
    """A number of each tie over time, up to where it broke."""
    assert told.ties is not None
    for tie, each in enumerate(values):
        gone = told.ties.states[tie] == TieState.BROKEN
        shown = np.where(gone, np.nan, each)[: told.last + 1]
        name = f"tie {tie + 1}" if len(values) > 1 else "tie"
        look = _look(tie)
        axes.plot(told.response.times[: told.last + 1], shown, label=name, **look)
        if gone.any():
            at = int(np.argmax(gone))
            near = max(at - 1, 0)
            axes.plot(
                told.response.times[at],
                each[near],
                "x",
                color=FALLEN,
                label="it breaks",
                zorder=5.0,
            )
    axes.set_ylabel(label)
    axes.locator_params(axis="y", nbins=4)


def _look(tie: int) -> dict[str, Any]:
    """Colour and line of a tie; the block itself has the first colour."""
    return {
        "color": SERIES[(tie + 1) % len(SERIES)],
        "linestyle": DASHES[tie % len(DASHES)],
        "linewidth": 1.1,
    }


def _draw_cycles(axes: Axes, told: _Told) -> None:
    """Force over elongation: what a tie takes up is the area within."""
    assert told.ties is not None
    for tie, force in enumerate(told.ties.force):
        gone = told.ties.states[tie] == TieState.BROKEN
        force = np.where(gone, np.nan, force)[: told.last + 1] / 1e3
        axes.plot(1e3 * told.elongation[tie, : told.last + 1], force, **_look(tie))
    axes.set(xlabel="elongation [mm]", ylabel="force [kN]", title="Ties")


def _draw_moment(axes: Axes, told: _Told) -> None:
    """Moments over rotation: of the block alone, as it began, as it went, and as it ended."""
    turn, moment = told.rotation[: told.last + 1], told.moments()[: told.last + 1] / 1e3
    hold = told.lanes.hold
    assert hold is not None
    if hold.wall is not None:
        sides: tuple[float, ...] = (-float(hold.wall[0]),)
    else:
        sides = (-1.0, 1.0)
    seen = np.abs(turn) > 0.0
    axes.plot(
        turn * DEGREES,
        np.where(seen, moment, np.nan),
        color=BLUE,
        linewidth=0.9,
        label="moment on its way",
        zorder=2.0,
    )
    curves: list[tuple[Lanes, str, dict[str, Any]]] = [
        (_without_ties(told.lanes), "statics without ties", {"color": GREY, "linestyle": DASHES[2]})
    ]
    if told.ties is not None:
        curves.append((told.lanes, "statics as it began", {"color": DARK, "linestyle": DASHES[1]}))
        worn = dataclasses.replace(hold, ties=told.ties.worn(told._ties))
        after = dataclasses.replace(told.lanes, hold=worn)
        curves.append((after, "statics as it ended", {"color": FALLEN, "linestyle": DASHES[3]}))
    for lanes, name, look in curves:
        label: str | None = name
        for side in sides:
            most = float((side * turn).max())
            if most <= 0.0:
                continue
            found = curve(leaning(lanes, side), most)
            axes.plot(
                side * found.lean * DEGREES,
                side * found.moment / 1e3,
                label=label,
                linewidth=1.4,
                zorder=3.0,
                **look,
            )
            label = None
    axes.axhline(0.0, color=DARK, linewidth=0.6)
    axes.set(xlabel="rotation [deg]", ylabel="moment [kN m]", title="Moment that resists")


def _draw_support(run: CaseRun, lane: int, response: Response) -> Drawing:
    """The floor or the isolator beside the ground: accelerations, and the way between them."""
    ground = run.lane_set.ground
    assert ground is not None
    times = response.times
    below, above = ground.components[0], run.lane_set.motions.components[0]
    pulls = [each.acceleration(times, lane) / GRAVITY for each in (below, above)]
    places = [base_places(each, lane, times)[:, 0] for each in (ground, run.lane_set.motions)]
    way = places[1] - places[0]
    peaks = [float(np.abs(each).max()) for each in pulls]
    title = (
        f"The support moves by up to {three_digits(1e3 * float(np.abs(way).max()))} mm against the "
        f"ground; its peak acceleration is {three_digits(peaks[1] / peaks[0])} times the ground's"
        if peaks[0] > 0.0
        else "The ground stands still"
    )
    with style():
        figure, panels = subplots(3, 1, (9.6, 5.4), sharex=True)
        names = (("ground", DARK, DASHES[1]), ("support", BLUE, DASHES[0]))
        for (name, color, dash), pull, place in zip(names, pulls, places, strict=True):
            look: dict[str, Any] = {"color": color, "linestyle": dash, "linewidth": 1.0}
            panels[0, 0].plot(times, pull, label=name, **look)
            panels[1, 0].plot(times, 1e3 * place, **look)
        panels[2, 0].plot(times, 1e3 * way, color=FALLEN, linewidth=1.0, label="between them")
        panels[0, 0].set_ylabel("acceleration [g]")
        panels[1, 0].set_ylabel("displacement\n[mm]")
        panels[2, 0].set_ylabel("support - ground\n[mm]")
        panels[2, 0].set_xlabel(TIME_LABEL)
        panels[2, 0].set_xlim(0.0, float(times[-1]))
        legend_below(figure, panels[0, 0], panels[2, 0])
        about = (
            f"{run.case.name}, lane {lane}: motion along x of the ground and of the support on it"
        )
        headline(figure, title, about)
    return Drawing("support", figure, title, f"{about}. {title}.")
