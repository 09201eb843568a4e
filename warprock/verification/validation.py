"""Engines and programs held to what tests showed: who predicts their outcomes, and how well.

A test is a lane, or all members of an ensemble's cell, or of a sample. Its probability of
overturning is the share of its lanes that overturned, among those with numbers; a test is said to
overturn from one half on. A test without a lane that has numbers is left out, and counted. Tests of
the same probability are alike for the AUC; where a test is one lane, tests are ranked by their
peak rotation / slenderness angle, those that overturned last.
"""

from __future__ import annotations

import dataclasses
import itertools
import time
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.analysis.bands import Band
from warprock.analysis.baselines import baseline, observed_function, threshold_of
from warprock.analysis.fragility import Curve, fragility_curves
from warprock.analysis.groups import RECORD
from warprock.analysis.lane_tables import PEAK_RATIO
from warprock.analysis.limits import OVERTURNING, Limit, find_reached
from warprock.analysis.lognormal import Fit, Observations, observe
from warprock.analysis.scores import Paired, Prediction, Scores, compare_pair, score
from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.engines import ENGINES
from warprock.errors import InputError, list_allowed
from warprock.model.response import USABLE_NAMES, Response
from warprock.programs.table import PROGRAMS
from warprock.running.case_run import require_options, run_lane_set
from warprock.running.lane_table import lane_table
from warprock.running.options import DEFAULT_OPTIONS, RunOptions
from warprock.verification.beside import require_programs, require_scene, run_peer
from warprock.verification.observations import ObservedTests, Source, read_tests
from warprock.verification.settings import OPTION, case_asked, plain_name, require_known

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Places = npt.NDArray[np.intp]

MEASURES = {"peak_acceleration_m_s2": "PGA", "peak_velocity_m_s": "PGV"}
"""Intensity measures whose thresholds are the baselines, and what they are called."""
HALF = 0.5
"""Probability from which on a test is said to overturn."""

_FALL = Limit(OVERTURNING)


@dataclasses.dataclass(frozen=True)
class Judged:
    """One predictor and how it did.

    Attributes:
        name: An engine, a program, or an intensity measure.
        tests: Numbers of the tests that it says something of, shape [said].
        said: What it says of them.
        scores: How well.
        table: Lane table of its tests, `record` replaced by what tests share; None of a baseline.
        curves: Its fragility function over each intensity measure; empty of a baseline.
        threshold: Intensity from which on a baseline says that a block overturns; NaN else.
        settings: Settings of an engine or of a program.
        wall_time: Time that its run took [s].
    """

    name: str
    tests: Places
    said: Prediction
    scores: Scores
    table: pd.DataFrame | None = None
    curves: tuple[Curve, ...] = ()
    threshold: float = np.nan
    settings: Any = None
    wall_time: float = 0.0


@dataclasses.dataclass(frozen=True)
class Shaking:
    """What was observed over an intensity measure.

    Attributes:
        column: Column of the measure.
        intensity: Of every test, shape [test].
        seen: The tests, by record and intensity.
        fit: The lognormal function of the tests, or why there is none.
        band: Its band over records; None without one.
    """

    column: str
    intensity: Array
    seen: Observations
    fit: Fit
    band: Band | None


@dataclasses.dataclass(frozen=True)
class Validation:
    """What became of holding a case to tests.

    Attributes:
        case: The case.
        lane_set: Its lanes.
        tests: The tests that were observed.
        group: Column that says which tests share a ground motion; empty where none does.
        records: Number of the ground motion of every test, shape [test].
        engines: The engines and programs, in the order asked for.
        baselines: What intensity measures say alone.
        shakings: What was observed over each intensity measure.
        pairs: Every engine against every other one, and against every baseline.
        options: How the engines were run.
    """

    case: Case
    lane_set: LaneSet
    tests: ObservedTests
    group: str
    records: Places
    engines: tuple[Judged, ...]
    baselines: tuple[Judged, ...]
    shakings: tuple[Shaking, ...]
    pairs: tuple[Paired, ...]
    options: RunOptions


def run_validation(
    case: Case,
    engines: Sequence[str],
    observed: Source = None,
    options: RunOptions = DEFAULT_OPTIONS,
    *,
    column: str | None = None,
    group: str | None = None,
) -> Validation:
    """Runs a case with engines, and holds what becomes of its lanes to what tests showed.

    Args:
        case: The case.
        engines: Names of engines and of programs, each with settings of its own or without.
        observed: The tests, see `warprock.verification.observations`; None takes the label
            `observed` of the case.
        options: How its lanes are run.
        column: Column of the outcome in the file.
        group: Column of the file or of the lane table that says which tests share a ground motion;
            None takes the record.

    Raises:
        InputError: Something cannot be used, said before anything runs.
        ChildProcessError: A program that runs in a process of its own failed.
    """
    _require_engines(engines, options)
    lane_set = expand_lanes(case)
    for engine in engines:
        require_scene(case_asked(case, engine), lane_set, plain_name(engine))
    tests = read_tests(case, lane_set, observed, column)
    name, records = _groups(lane_set, tests, group)
    shakings = tuple(_shakings(lane_set, tests, records))
    judged, before = [], 0
    for engine in engines:
        started = time.perf_counter()
        response, settings = _answer(case, lane_set, engine, options.counting_from(before))
        found = judge(response, engine, lane_set, tests, records, shakings)
        seconds = time.perf_counter() - started
        judged.append(dataclasses.replace(found, settings=settings, wall_time=seconds))
        before += lane_set.lanes.lane_count
    baselines = tuple(_baselines(shakings, tests, records))
    pairs = [(a, b) for a, b in itertools.combinations(judged, 2)]
    pairs += [(a, b) for a in judged for b in baselines]
    return Validation(
        case=case,
        lane_set=lane_set,
        tests=tests,
        group=name,
        records=records,
        engines=tuple(judged),
        baselines=baselines,
        shakings=shakings,
        pairs=tuple(_pair(a, b, tests, records) for a, b in pairs),
        options=options.without_progress(),
    )


def _require_engines(engines: Sequence[str], options: RunOptions) -> None:
    """Refuses engines that nobody knows, that are not there, or that are named twice."""
    require_known(engines, [*ENGINES, *PROGRAMS])
    require_programs(map(plain_name, engines))
    if len(set(engines)) < len(engines):
        raise InputError(OPTION, "", ", ".join(engines), "must be named once each")
    for engine in engines:
        if plain_name(engine) in ENGINES:
            require_options(plain_name(engine), options)


def _answer(
    case: Case, lane_set: LaneSet, engine: str, options: RunOptions
) -> tuple[Response, Any]:
    """The response of an engine or of a program, and its settings."""
    asked, name = case_asked(case, engine), plain_name(engine)
    if name in PROGRAMS:
        answer = run_peer(asked, lane_set, name, options.progress)
        return answer.response, asked.peer_settings(name)
    times = dataclasses.replace(lane_set.longest, interval=None)
    settings = asked.engine_settings(name)
    return run_lane_set(name, lane_set, times, options, settings=settings), settings


def judge(
    response: Response,
    name: str,
    lane_set: LaneSet,
    tests: ObservedTests,
    records: Places,
    shakings: Sequence[Shaking] = (),
) -> Judged:
    """How well a response predicts tests.

    Args:
        response: The answer for all lanes.
        name: Who gave it.
        lane_set: The lanes.
        tests: The tests.
        records: Number of the ground motion of every test, shape [test].
        shakings: Intensity measures to fit fragility functions over.

    Raises:
        InputError: No test has a lane with numbers.
    """
    count, members = tests.lanes.shape
    table = lane_table(lane_set, response).iloc[tests.lanes.ravel()].reset_index(drop=True)
    table[RECORD] = np.repeat(records, members)
    usable = table["status"].isin(USABLE_NAMES).to_numpy().reshape(count, members)
    fell = find_reached(table, _FALL).reshape(count, members) & usable
    said = np.flatnonzero(usable.any(axis=1))
    if not len(said):
        allowed = "must have numbers in a lane of one test at least: see warprock run"
        raise InputError(OPTION, "", name, allowed)
    probability = fell[said].sum(axis=1) / usable[said].sum(axis=1)
    rank = probability
    if members == 1:
        ratios = table[[c for c in map(str, table.columns) if PEAK_RATIO.match(c)]]
        rank = np.where(fell[:, 0], np.inf, ratios.to_numpy().max(axis=1))[said]
        rank = np.unique(rank, return_inverse=True)[1].astype(np.float64)
    prediction = Prediction(name, probability, probability >= HALF, rank)
    curves = [
        curve
        for shaking in shakings
        for curve in fragility_curves(
            table, source=name, intensity=shaking.column, limits=[_FALL], most_doubt=1.0
        )
    ]
    scores = score(prediction, tests.overturned[said], records[said])
    return Judged(name, said, prediction, scores, table, tuple(curves))


def _groups(lane_set: LaneSet, tests: ObservedTests, group: str | None) -> tuple[str, Places]:
    """The column that says which tests share a ground motion, and its number for every test."""
    first = lane_set.inputs.iloc[tests.lanes[:, 0]]
    name = group or (RECORD if RECORD in first else "")
    if not name:
        return "", np.arange(len(tests.names), dtype=np.intp)
    if name not in tests.table and name not in first:
        known = [*map(str, tests.table.columns), *map(str, first.columns)]
        allowed = (
            f"must be a column of {tests.source} or of the lane table: {list_allowed(name, known)}"
        )
        raise InputError("--group", "", name, allowed)
    values = tests.table[name] if group and name in tests.table else first[name]
    return name, np.asarray(pd.factorize(values)[0], dtype=np.intp)


def _shakings(lane_set: LaneSet, tests: ObservedTests, records: Places) -> Iterator[Shaking]:
    """What was observed over the intensity measures that the lanes have and that vary."""
    for column in MEASURES:
        if column not in lane_set.inputs:
            continue
        lanes = lane_set.inputs[column].to_numpy(dtype=np.float64)[tests.lanes]
        intensity = np.median(lanes, axis=1)
        if not np.all(lanes > 0.0) or not np.ptp(intensity) > 0.0:
            continue
        fit, band = observed_function(intensity, tests.overturned, records)
        seen = observe(intensity, tests.overturned, records)
        yield Shaking(column, intensity, seen, fit, band)


def _baselines(
    shakings: Sequence[Shaking], tests: ObservedTests, records: Places
) -> Iterator[Judged]:
    """What each intensity measure says alone."""
    for each in shakings:
        name = MEASURES[each.column]
        fitted = (each.fit, each.band)
        said = baseline(name, each.intensity, tests.overturned, records, fitted)
        if said is None:
            continue
        everything = np.arange(len(records), dtype=np.intp)
        scores = score(said, tests.overturned, records)
        threshold = threshold_of(each.intensity, tests.overturned)
        yield Judged(name, everything, said, scores, threshold=threshold)


def _pair(a: Judged, b: Judged, tests: ObservedTests, records: Places) -> Paired:
    """Two predictors on the tests that both say something of."""
    both = np.intersect1d(a.tests, b.tests)
    said = [each.said.take(np.searchsorted(each.tests, both)) for each in (a, b)]
    return compare_pair(said[0], said[1], tests.overturned[both], records[both])


def status_rows(found: Validation) -> list[dict[str, Any]]:
    """How often lanes of each status agree with their test: `engine`, `status`, `lanes`, `right`.

    `right` is the share of the lanes that became what was observed; NaN of those without numbers.
    """
    rows = []
    for engine in found.engines:
        assert engine.table is not None
        observed = np.repeat(found.tests.overturned, found.tests.lanes.shape[1])
        right = find_reached(engine.table, _FALL) == observed
        for status in engine.table["status"].cat.categories:
            mine = (engine.table["status"] == status).to_numpy()
            if mine.any():
                share = float(right[mine].mean()) if status in USABLE_NAMES else np.nan
                row = {"engine": engine.name, "status": status, "lanes": int(mine.sum())}
                rows.append(row | {"right": share})
    return rows
