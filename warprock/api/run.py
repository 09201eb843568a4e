"""The command `run` as a function, and what it finds."""

from __future__ import annotations

import dataclasses
import functools
import pathlib
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from warprock.api.case import AnyCase, Case, any_case
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.progress import Shown
from warprock.api.work import HowHeld, working
from warprock.arguments import at_the_door
from warprock.case.input_columns import columns_of
from warprock.case.lanes import require_room_for_lanes
from warprock.case.load import Overrides
from warprock.case.run import Run as RunTable
from warprock.case.validation import refusing, validated
from warprock.errors import InputError, Said
from warprock.findings.finding import Finding
from warprock.findings.run import LIMIT_ANALYSIS, find_run
from warprock.model.response import Response
from warprock.running.case_run import (
    CaseRun,
    require_options,
    require_tolerance,
    run_case,
    run_lane,
)
from warprock.running.devices import start_warp
from warprock.running.engine_choice import EngineChoice
from warprock.running.lane_table import history_table, peak_ratio_columns
from warprock.running.options import TOLERANCE, RunOptions
from warprock.running.provenance import count_words
from warprock.running.results import write_run

if TYPE_CHECKING:
    import pandas as pd

    from warprock.figures.axes import Axes
    from warprock.figures.drawing import Drawing
    from warprock.measure.trade_choice import Choice

SAMPLES = 1000
"""Samples of a history where neither the case nor the caller says how many."""

RESULTS = ("outcome", "impact_count", "peak_slide_m", "status", "rotation_error_rad")
"""Columns of results that a notebook shows behind the peaks."""


class Run(Found):
    """A case that was run: a lane for each set of inputs, and what became of it.

    Attributes:
        found: The case, its lanes and the engine's response, `CaseRun`.
        choice: The engine, and why it was taken where none was named.
        cheapest: The cheapest engine and settings, and their test; None where not asked for.
        kept: Lanes whose histories are written, too.

    Example:
        >>> import warprock as wr
        >>> run = wr.run("free-b0", progress=False)
        >>> run
        Run(free-b0: housner, 2 lanes: 1 at rest, 1 rocking; 2 ok)
        >>> run.table[["height_m", "peak_rotation_ratio"]].round(3)
           height_m  peak_rotation_ratio
        0       5.0                  0.5
        1       5.5                  0.5
    """

    found: CaseRun

    def __init__(
        self, found: CaseRun, choice: EngineChoice, cheapest: Choice | None = None
    ) -> None:
        report = functools.partial(find_run, found, functools.partial(_show_run, found))
        super().__init__(found.case.name, found, report, functools.partial(_draw_run, found))
        self.choice, self.cheapest = choice, cheapest
        self.kept: tuple[int, ...] = ()

    @property
    def case(self) -> Case:
        """The case."""
        return Case.of(self.found.case)

    @property
    def engine(self) -> str:
        """Name of the engine."""
        return self.found.response.engine

    @property
    def response(self) -> Response:
        """The engine's answer: arrays in SI units and rad, shape [lane, ...]."""
        return self.found.response

    @property
    def cells(self) -> pd.DataFrame:
        """Distributions of an ensemble, one row a cell of the sweep.

        Raises:
            ValueError: The case has no ensemble.
        """
        if self.case.ensemble is None:
            raise ValueError(f"{self.case.name}: has no ensemble, and so no cells")
        from warprock.running.cells import cell_table

        return cell_table(self.found.lane_set, self.response)

    @at_the_door
    def history(self, lane: int = 0, interval: str | None = None) -> pd.DataFrame:
        """What a lane did over time: it runs again, alone, and gives the same numbers.

        Args:
            lane: Number of the lane, from 0.
            interval: Time between samples, such as "10 ms"; that of the case where None, a
                thousandth of the run where the case has none.

        Returns:
            One row a sample; units are in the names of the columns.

        Raises:
            InputError: There is no such lane, or the interval cannot be used.

        Example:
            >>> import warprock as wr
            >>> run = wr.run("free-b0", progress=False)
            >>> history = run.history(0, "1 s")
            >>> len(history), float(history["time_s"].iloc[-1])
            (21, 20.0)
        """
        run, response = self._sampled(lane, interval)
        return history_table(response, 0, run.lane_set, lane)

    @at_the_door
    def plot_history(self, lane: int = 0, *, interval: str | None = None, ax: Any = None) -> Axes:
        """Draws the rotation of a lane over its slenderness angle, over time.

        Args:
            lane: Number of the lane, from 0.
            interval: Time between samples, as in `history`.
            ax: Matplotlib axes to draw on; new ones where None.

        Returns:
            The axes.

        Raises:
            InputError: There is no such lane, or the interval cannot be used.
        """
        from warprock.figures.axes import plot_history, require_axes

        require_axes(ax)
        return plot_history(*self._sampled(lane, interval), lane, ax)

    @at_the_door
    def plot_peaks(self, x: str | None = None, *, ax: Any = None) -> Axes:
        """Draws the largest rotation of every lane over the slenderness angle, over an input.

        Args:
            x: Column of the table; the first input that differs between lanes where None.
            ax: Matplotlib axes to draw on; new ones where None.

        Returns:
            The axes.

        Raises:
            InputError: The table has no such column.
        """
        from warprock.figures.axes import plot_peaks, require_axes

        require_axes(ax)
        return plot_peaks(self.found, self.table, x, ax)

    def _sampled(self, lane: int, interval: str | None) -> tuple[CaseRun, Response]:
        """The run, and a lane of it with its history."""
        with python_names():
            run = _sampling(self.found, interval)
            return run, run_lane(run, lane)

    @functools.cached_property
    def finding(self) -> Finding:
        """What came out, with the cheapest engine and settings where they were asked for."""
        found = self._find()
        if self.cheapest is None:
            return found
        said = {**found.facts, "choice": dataclasses.asdict(self.cheapest)}
        return dataclasses.replace(found, said=said)

    def write(self, folder: pathlib.Path) -> list[pathlib.Path]:
        """Writes the lane table, cells, histories and `run.json`."""
        histories = {lane: run_lane(self.found, lane) for lane in self.kept}
        facts = self.finding.facts
        besides = {LIMIT_ANALYSIS: facts[LIMIT_ANALYSIS]} if LIMIT_ANALYSIS in facts else {}
        return write_run(self.found, folder, histories, besides=besides)

    def scenes(self) -> Mapping[str, Any]:
        """Lanes to play on the page."""
        from warprock.report.scenes import scenes_of

        return scenes_of(self.found)

    def _shown(self) -> pd.DataFrame:
        keys = [key for axis in self.case.axes for key in axis.columns]
        wanted = ["lane", *(name for key in keys for name in sorted(columns_of(key)))]
        wanted += [*peak_ratio_columns(self.found.lane_set), *RESULTS]
        return self.table[[name for name in dict.fromkeys(wanted) if name in self.table]]

    def __repr__(self) -> str:
        words = (
            ", ".join(f"{n:,} {word.replace('_', ' ')}" for word, n in counts.items() if n)
            for counts in (count_words(self.response, name) for name in ("outcome", "status"))
        )
        lanes = self.response.lane_count
        head = f"{self.title}: {self.engine}, {lanes:,} lane{'s' * (lanes != 1)}"
        return f"Run({head}: {'; '.join(words)})"


@at_the_door
def run(
    case: AnyCase,
    engine: str | None = None,
    *,
    overrides: Overrides = (),
    tolerance: float | None = TOLERANCE,
    cheapest: bool = False,
    precision: str | None = None,
    device: str = "cpu",
    workers: int | None = None,
    progress: Shown = True,
) -> Run:
    """Runs every lane of a case with one engine.

    Without a tolerance, None, every lane runs once, and nothing says how far off it is. Without a
    precision lanes run in float64, or in what `cheapest` picks.

    Args:
        case: A `Case`, the tables of one, the name of a shipped one, or the path of a case file.
        engine: Engine; without, housner for one block that it can follow, else event.
        overrides: Values by dotted key, of settings too: `{"engines.event.time_step": 1e-3}`.
        tolerance: Largest error of a rotation over the slenderness angle [-], 0.01 without: lanes
            that miss it by their estimate run again at half the step, and again.
        cheapest: Picks the cheapest engine, settings and precision that met the tolerance in
            `warprock trade`, of the engine and in the precision that are named, and tests them on
            a sample of the lanes. No settings beside it.
        precision: float64 or float32.
        device: Warp device, such as cpu or cuda:0.
        workers: Worker threads; the cores at hand without. No number depends on it.
        progress: Whether to show how far it is, or a function that is called with the number of
            lanes finished so far.

    Raises:
        InputError: Something cannot be used, said before anything runs.

    Example:
        >>> import warprock as wr
        >>> run = wr.run("free-b0", overrides={"start.rotation_ratio": 0.9}, progress=False)
        >>> run.table["peak_rotation_ratio"].round(6).tolist()
        [0.9, 0.9]
    """
    chosen: Choice | None = None
    if cheapest:
        case, chosen = _choose(case, engine, tolerance, overrides, precision, workers)
        engine, overrides, precision = chosen.engine, (), chosen.precision
    how: HowHeld = {"overrides": overrides, "tolerance": tolerance, "device": device}
    how |= {"precision": precision or "float64", "workers": workers, "progress": progress}
    with working(case, engine, **how) as work:
        if work.case.study is not None:
            allowed = "must not be given: warprock.study runs a case with all settings of a study"
            raise InputError(work.case.file, "study", Said("a table"), allowed)
        found = run_case(work.case, work.engine, work.options, histories=False)
        return Run(found, work.choice, chosen)


def _choose(
    case: AnyCase,
    engine: str | None,
    tolerance: float | None,
    overrides: Overrides,
    precision: str | None,
    workers: int | None,
) -> tuple[Case, Choice]:
    """The case with the cheapest settings within a tolerance, and the choice.

    Raises:
        InputError: No tolerance, or settings were given as well, or nothing met the tolerance.
    """
    # The oracle behind the trade table wants SciPy, which no other run does.
    from warprock.measure.trade_choice import OPTION, choose

    with python_names():
        require_options(engine, RunOptions(precision or "float64", workers=workers))
        if tolerance is None:
            raise InputError("tolerance", "", Said("None"), "must be given with cheapest")
        require_tolerance(tolerance)
        found = any_case(case, overrides)
        for key in sorted(found.overridden):
            if key.startswith("engines."):
                allowed = f"chooses the settings itself, without {key}"
                raise InputError(OPTION, "", True, allowed)
        require_room_for_lanes(found.judged)
        start_warp()
        options = RunOptions(workers=workers)
        chosen = choose(found, tolerance, engine=engine, precision=precision, options=options)
        return found.override(chosen.overrides), chosen


def _show_run(found: CaseRun) -> None:
    """Prints a run as the command does."""
    if found.case.ensemble is None:
        from warprock.tables.run import print_run

        print_run(found)
    else:
        from warprock.tables.cells import print_cells

        print_cells(found)


def _draw_run(found: CaseRun, _title: str) -> Sequence[Drawing]:
    """The figures of a run, which have titles of their own."""
    from warprock.figures.run import draw_run

    return draw_run(found)


def _sampling(run: CaseRun, interval: str | None) -> CaseRun:
    """The run of a case that says how to sample histories.

    Raises:
        InputError: The interval cannot be used.
    """
    times = run.case.tables.run
    if interval is None and times.sample_interval is not None:
        return run
    asked = {
        "duration": f"{times.duration!r} s",
        "sample_interval": interval or f"{times.duration / SAMPLES!r} s",
    }
    with refusing(lambda _: "interval"):
        sampled = validated(RunTable, asked)
    tables = run.case.tables.model_copy(update={"run": sampled})
    return dataclasses.replace(run, case=dataclasses.replace(run.case, tables=tables))
