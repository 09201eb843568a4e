"""Runs the study of a case: its lanes with every setting that [study] asks for, against Housner.

Three things tell what a setting does: errors against Housner's block, differences from the engine's
run with the case's own settings, and CPU time. Every run has the plain form of its kernel, one lane
a thread, so that times compare whatever the number of lanes.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.case.case import Case
from warprock.case.input_columns import input_meaning
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.study import Study, Variation
from warprock.engines import engine_class, reference_engine
from warprock.engines.launching import Form, Target
from warprock.errors import InputError
from warprock.model.ratios import rotation_ratio
from warprock.model.response import Response, Status, names_of
from warprock.running.batch import run_batch
from warprock.running.case_run import require_options, require_support
from warprock.running.options import DEFAULT_OPTIONS, RunOptions
from warprock.running.provenance import case_facts, surroundings
from warprock.verification.checks import compare_with_housner
from warprock.verification.lane_names import lane_name
from warprock.verification.plain import plain_row

Array = npt.NDArray[np.float64]

STUDY = "study"

COLUMNS: dict[str, tuple[str, str]] = {
    "lane_name": ("-", "The lane in words"),
    "engine": ("-", "Name of the engine"),
    "setting": ("-", "Setting of the engine that the run varies; all others are the case's own"),
    "value": ("-", "Its value, in the unit of the column `unit`"),
    "unit": ("-", "Unit of the setting"),
    "baseline": ("-", "Whether the value is the case's own"),
    "time_step_s": ("s", "Time step that the settings ask for; none for an engine without one"),
    "holds": ("-", "Whether Housner holds in this lane"),
    "why": ("-", "Why he does not"),
    "friction_needed": ("-", "Friction that Housner's block needs; infinite where it is pulled"),
    "outcome": ("-", "What became of the block"),
    "status": ("-", "Whether the numbers may be used"),
    "peak_rotation_ratio": ("-", "Largest rotation / slenderness angle"),
    "peak_error": ("-", "Largest rotation / Housner's - 1"),
    "error_5s_ratio": (
        "-",
        "Largest |rotation - Housner's| / slenderness angle in the first 5 s",
    ),
    "error_run_ratio": ("-", "The same over the run"),
    "baseline_difference_ratio": (
        "-",
        "Largest |rotation - that of the engine's baseline| / slenderness angle over the run",
    ),
    "rest_time_s": ("s", "Time of coming to rest"),
    "rest_time_error_s": ("s", "Rest time - Housner's"),
    "step_count": ("-", "Time steps"),
    "cpu_s": ("s", "CPU time of one lane, kernels built before"),
}
"""Columns of the table of a study beside the lane's inputs: unit and meaning."""

History = tuple[str, str, float]
"""Engine, setting and value."""


@dataclasses.dataclass(frozen=True)
class StudyRun:
    """A study that has been run.

    Attributes:
        case: The case.
        engines: Engines that were run, in the order of the study.
        lane_set: Its lanes, motions and inputs.
        table: One row a lane, engine, setting and value: `lane`, the inputs and `COLUMNS`; equal
            settings were run once.
        times: Sample times [s], shape [sample].
        reference: Housner's rotation / slenderness angle in the last lane, shape [sample].
        histories: The same of every run.
        options: How it was run.
        wall_time: Time that all runs took [s], kernel builds included.
    """

    case: Case
    engines: tuple[str, ...]
    lane_set: LaneSet
    table: pd.DataFrame
    times: Array
    reference: Array
    histories: dict[History, Array]
    options: RunOptions
    wall_time: float

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The rows of the table as JSON can hold them."""
        return [plain_row(row) for row in self.table.to_dict("records")]


def chosen_engines(case: Case, engine: str | None) -> tuple[str, ...]:
    """Engines that a study runs: all of its own, or the one asked for.

    Raises:
        InputError: The one asked for is none of them, or cannot do the scene.
    """
    engines = _study(case).engines
    if engine is not None and engine not in engines:
        allowed = f"must be an engine of the study ({', '.join(engines)})"
        raise InputError("--engine", "", engine, allowed)
    return engines if engine is None else (engine,)


def run_count(case: Case, engine: str | None = None) -> int:
    """Runs of a study, equal settings counted once; see `chosen_engines`."""
    return sum(_study(case).plan(name)["runs"] for name in chosen_engines(case, engine))


def run_study(
    case: Case,
    engine: str | None = None,
    options: RunOptions = DEFAULT_OPTIONS,
    *,
    finished: Callable[[int], None] | None = None,
) -> StudyRun:
    """Runs a study.

    Args:
        case: A case with a study.
        engine: The only engine to run; None runs all of the study.
        options: How it is run, every lane once at each step; the reference is float64 on the CPU.
        finished: Called after each run with its number of lanes.

    Raises:
        InputError: An option is not one of those allowed, or an engine cannot do the scene.
        ValueError: The case has no study.
    """
    engines = chosen_engines(case, engine)
    lane_set = expand_lanes(case)
    require_support(case, lane_set, reference_engine())
    for name in engines:
        require_options(name, options)
        require_support(case, lane_set, name)
    started = time.perf_counter()
    given = (lane_set.lanes, lane_set.motions, lane_set.times)
    reference = run_batch(reference_engine(), *given, workers=options.workers)
    tables, histories = [], {}
    for name in engines:
        baseline = _study(case).baseline[name]
        timed = _Timed(name, lane_set, options, finished)
        own, _ = timed(baseline)
        for variation in _study(case).variations(name):
            response, seconds = timed(variation.settings)
            tables.append(_table(lane_set, variation, response, reference, own, seconds))
            key = (name, variation.setting, variation.value)
            histories[key] = _ratio(lane_set, response)[-1]
    return StudyRun(
        case=case,
        engines=engines,
        lane_set=lane_set,
        table=_join_rows(tables),
        times=reference.times,
        reference=_ratio(lane_set, reference)[-1],
        histories=histories,
        options=options.without_progress(),
        wall_time=time.perf_counter() - started,
    )


def study_provenance(run: StudyRun) -> dict[str, Any]:
    """Everything that is needed to run a study again and to judge it, ready for JSON."""
    study = _study(run.case)
    runs = [
        {
            "engine": variation.engine,
            "setting": variation.setting,
            "value": variation.value,
            "settings": dataclasses.asdict(variation.settings),
        }
        for engine in run.engines
        for variation in study.variations(engine)
    ]
    return {
        "case": case_facts(run.case),
        "study": [study.plan(engine) for engine in run.engines],
        "runs": runs,
        "precision": run.options.precision,
        "device": run.options.device,
        "workers": run.options.workers,
        **surroundings(run.case),
        "lanes": run.lane_set.lanes.lane_count,
        "duration_s": run.lane_set.times.duration,
        "wall_time_s": run.wall_time,
    }


def _study(case: Case) -> Study:
    if case.study is None:
        raise ValueError(f"case: {case.name} has no [study]")
    return case.study


class _Timed:
    """Runs the lanes of a study with one engine, each settings once, and times them."""

    def __init__(
        self,
        engine: str,
        lane_set: LaneSet,
        options: RunOptions,
        finished: Callable[[int], None] | None,
    ) -> None:
        self._engine, self._lane_set = engine, lane_set
        self._options, self._finished = options.without_progress(), finished
        self._found: dict[Any, tuple[Response, float]] = {}

    def __call__(self, settings: Any) -> tuple[Response, float]:
        """The response, and the CPU time of one lane [s]."""
        if settings in self._found:
            return self._found[settings]
        lanes, motions = self._lane_set.lanes, self._lane_set.motions
        target = Target(self._options.precision, self._options.device, Form.PLAIN)
        engine_class(self._engine)(settings, target).warm_up(lanes, motions)
        begin = time.process_time()
        response = run_batch(
            self._engine,
            lanes,
            motions,
            self._lane_set.times,
            settings=settings,
            **{**self._options.of_batch, "form": target.form},
        )
        seconds = time.process_time() - begin
        self._found[settings] = response, seconds / lanes.lane_count
        if self._finished is not None:
            self._finished(lanes.lane_count)
        return self._found[settings]


def _ratio(lane_set: LaneSet, response: Response) -> Array:
    """Rotation / slenderness angle, shape [lane, sample]."""
    return rotation_ratio(response["rotation"], lane_set.lanes)


def _join_rows(tables: list[pd.DataFrame]) -> pd.DataFrame:
    """The rows of all runs, with the unit and the meaning of every column."""
    table = pd.concat(tables, ignore_index=True)
    names = map(str, table.columns)
    meanings = {name: COLUMNS.get(name) or input_meaning(name) for name in names}
    table.attrs["columns"] = {
        name: {"unit": unit, "text": text} for name, (unit, text) in meanings.items()
    }
    return table


def _table(
    lane_set: LaneSet,
    variation: Variation,
    response: Response,
    reference: Response,
    own: Response,
    seconds: float,
) -> pd.DataFrame:
    """Rows of one run, one a lane."""
    count = lane_set.lanes.lane_count
    found = compare_with_housner(lane_set, response, reference)
    difference = np.abs(_ratio(lane_set, response) - _ratio(lane_set, own))
    found = found.assign(
        lane=np.arange(count),
        lane_name=[lane_name(lane_set, lane) for lane in range(count)],
        setting=variation.setting,
        value=float(variation.value),
        unit=variation.unit,
        baseline=variation.baseline,
        time_step_s=float(getattr(variation.settings, "time_step", np.nan)),
        status=names_of(Status, response["status"]),
        baseline_difference_ratio=difference.max(axis=1),
        rest_time_s=response["rest_time"],
        step_count=response["step_count"],
        cpu_s=seconds,
    )
    return found[["lane", *lane_set.inputs.columns, *COLUMNS]]
