"""Incremental dynamic analysis: the factor on its motion at which each lane of a case first falls.

It runs in stages, each of which is one batch of lanes. The first runs all lanes at a ladder of
factors. Rocking is not monotonic: a block may stand at a stronger motion than one that overturned
it, so the first fall on the ladder counts, and runs above it in which the block stood are counted
as resurrections. Each further stage halves, on a logarithmic scale, the bracket between the
strongest motion below the first fall at which the block stood and that fall, until it is narrow
enough. A fall between two factors at which the block stood is not seen. A lane that never falls is
censored at the top of the ladder; fits honour that and the brackets.

A finished stage is a part (see `warprock.running.parts`) that names its plan: an analysis that was
killed goes on behind the last one.

D. Vamvatsikos and C. A. Cornell (2002), Incremental dynamic analysis, *Earthquake Engineering and
Structural Dynamics* 31(3).
"""

from __future__ import annotations

import dataclasses
import enum
import pathlib

import numpy as np
import numpy.typing as npt
import pandas as pd
import pyarrow as pa

from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.errors import InputError, Said
from warprock.model.ratios import peak_ratio
from warprock.model.response import FALLEN_NAMES, USABLE_NAMES, Response, SampleTimes
from warprock.running.case_run import run_lane_set
from warprock.running.files import require_writable
from warprock.running.machine import require_workers
from warprock.running.options import DEFAULT_OPTIONS, Progress, RunOptions
from warprock.running.parts import State, find_part, read_part, write_part
from warprock.running.provenance import count_words
from warprock.running.refinement import missed_tolerance
from warprock.sweeps.plan import PLAN, Plan, make_plan, read_plan, write_plan

Array = npt.NDArray[np.float64]

STAGES = "stages"
"""Folder of the stages in that of an analysis."""

MOST_FACTORS = 1000
MOST_RUNS = 20_000_000
"""Runs of the first stage, at most: its table is held in memory."""


class Verdict(enum.StrEnum):
    """What is known of a lane's capacity."""

    BRACKETED = "bracketed"
    ABOVE = "above"
    BELOW = "below"
    UNKNOWN = "no number"


@dataclasses.dataclass(frozen=True)
class Ladder:
    """Factors on the motion.

    Attributes:
        lowest: The least one, > 0.
        highest: The greatest one.
        count: Factors of the first stage, each the same multiple of the one before.
        accuracy: The greatest factor of a bracket over its least, less 1, when it is narrow enough.
    """

    lowest: float = 0.1
    highest: float = 10.0
    count: int = 21
    accuracy: float = 0.01

    def judge(self) -> None:
        """Refuses numbers out of bounds.

        Raises:
            InputError: One of them is.
        """
        for option, value, good, allowed in (
            ("--from", self.lowest, 1e-6 <= self.lowest <= 1e6, "must be from 1e-6 to 1e6"),
            (
                "--to",
                self.highest,
                self.lowest < self.highest <= 1e6,
                f"must be above --from, {self.lowest:g}, and at most 1e6",
            ),
            ("--count", self.count, 2 <= self.count <= MOST_FACTORS, "must be from 2 to 1000"),
            ("--accuracy", self.accuracy, 1e-9 <= self.accuracy <= 1, "must be from 1e-9 to 1"),
        ):
            if not good:
                raise InputError(option, "", value, allowed)

    @property
    def factors(self) -> Array:
        """Factors of the first stage, weakest first."""
        return np.geomspace(self.lowest, self.highest, self.count)


@dataclasses.dataclass(frozen=True)
class Analysis:
    """An incremental dynamic analysis.

    Attributes:
        plan: What its numbers depend on.
        lane_set: Lanes of the case, at factor 1.
        curves: One row a run, by lane and factor: `lane`, `factor`, `stage`, `outcome`, `status`,
            `peak_rotation_ratio` (of a stack the largest of its blocks), `missed_tolerance`.
        stages: Stages that were needed.
        kept: Stages that were there already.
    """

    plan: Plan
    lane_set: LaneSet
    curves: pd.DataFrame
    stages: int
    kept: int

    @property
    def capacities(self) -> pd.DataFrame:
        """What the runs say of every lane; see `brackets`."""
        return brackets(self.curves, self.lane_set.lanes.lane_count)


def plan_analysis(
    case: Case,
    engine: str,
    ladder: Ladder,
    options: RunOptions = DEFAULT_OPTIONS,
) -> Plan:
    """Plans an analysis, and refuses it if one of its lanes could not be run.

    Args:
        case: The case.
        engine: Name of the engine.
        ladder: Factors on the motion.
        options: How the lanes are run.

    Raises:
        InputError: The ladder is out of bounds, the case has no motion, or `make_plan` refuses it.
    """
    ladder.judge()
    if case.tables.motion is None:
        raise InputError(case.file, "motion", Said("nothing"), "must be given: it is made stronger")
    runs = case.lane_count * ladder.count
    if runs > MOST_RUNS:
        allowed = f"must be at most {MOST_RUNS:,} runs: fewer lanes, or a smaller --count"
        raise InputError(case.file, "sweep", Said(f"{runs:,} runs"), allowed)
    plan = make_plan(case, engine, options.without_progress())
    content = {**plan.content, "incremental": dataclasses.asdict(ladder)}
    return dataclasses.replace(plan, content=content)


def run_analysis(
    case: Case,
    plan: Plan,
    ladder: Ladder,
    folder: pathlib.Path | None = None,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Analysis:
    """Runs the stages that are not there yet.

    Args:
        case: The case.
        plan: Its plan.
        ladder: The ladder that the plan was made with.
        folder: Where stages are kept; None keeps none.
        workers: Worker threads; None uses the cores at hand.
        progress: Called with the runs finished so far.

    Raises:
        InputError: The folder holds another plan or stages of one.
        OSError: A stage could not be written; those before it are kept.
    """
    require_workers(workers)
    options = plan.options(workers, progress)
    if folder is not None:
        _claim(plan, folder)
    lane_set = expand_lanes(case)
    count = lane_set.lanes.lane_count
    lanes = np.repeat(np.arange(count, dtype=np.intp), ladder.count)
    factors = np.tile(ladder.factors, count)
    curves, stage, kept = pd.DataFrame(), 0, 0
    while len(lanes):
        done = len(curves)
        found = None if folder is None else _read_stage(plan, folder, stage, lanes, factors)
        kept += found is not None
        if found is None:
            found = _run_stage(plan, case, lane_set, lanes, factors, options.counting_from(done))
            if folder is not None:
                _write_stage(plan, folder, stage, found)
        curves = pd.concat([curves, found.assign(stage=stage)], ignore_index=True)
        lanes, factors = _next_stage(brackets(curves, count), ladder)
        stage += 1
    curves = curves.sort_values(["lane", "factor"], ignore_index=True)
    return Analysis(plan, lane_set, curves, stage, kept)


def at_factors(lane_set: LaneSet, lanes: npt.NDArray[np.intp], factors: Array) -> LaneSet:
    """Some lanes, each with its motion a factor stronger; their inputs are those at factor 1."""
    chosen = lane_set.take(lanes)
    return dataclasses.replace(chosen, motions=chosen.motions.scaled(factors))


def alone_at(lane_set: LaneSet, lane: int, factor: float) -> LaneSet:
    """One lane with its motion a factor stronger."""
    return at_factors(lane_set.alone(lane), np.array([0]), np.array([factor]))


def telling(found: Analysis) -> list[tuple[int, float, str]]:
    """Runs at either side of the first fall, of the weakest, the median and the strongest lane.

    Args:
        found: The analysis.

    Returns:
        Lane, factor on its motion, and what this run is.
    """
    known = found.capacities
    bracketed = np.flatnonzero(known["verdict"] == Verdict.BRACKETED.value)
    ranked = bracketed[np.argsort(known["overturning_factor"].to_numpy()[bracketed], kind="stable")]
    if not len(ranked):
        return []
    places = {0: "falls first", len(ranked) - 1: "falls last", len(ranked) // 2: "is the median"}
    runs = []
    for place in sorted(places):
        lane = int(ranked[place])
        for column, what in (
            ("standing_factor", "the strongest motion below its fall"),
            ("overturning_factor", "the weakest motion that fells it"),
        ):
            why = f"{what}; of the lanes that fall this one {places[place]}"
            runs.append((lane, float(known[column].iloc[lane]), why))
    return runs


def _run_stage(
    plan: Plan,
    case: Case,
    lane_set: LaneSet,
    lanes: npt.NDArray[np.intp],
    factors: Array,
    options: RunOptions,
) -> pd.DataFrame:
    """One batch: some lanes, each at a factor."""
    chosen = at_factors(lane_set, lanes, factors)
    response = run_lane_set(
        plan.engine,
        chosen,
        SampleTimes(lane_set.longest.duration),
        options,
        settings=case.engine_settings(plan.engine),
    )
    ratio = peak_ratio(response, chosen.lanes)
    return pd.DataFrame(
        {
            "lane": lanes,
            "factor": factors,
            "outcome": _words(response, "outcome"),
            "status": _words(response, "status"),
            "peak_rotation_ratio": ratio.reshape(len(lanes), -1).max(axis=1),
            "missed_tolerance": missed_tolerance(response, chosen, plan.tolerance),
        }
    )


def _words(response: Response, name: str) -> npt.NDArray[np.object_]:
    words = np.array(list(count_words(response, name)), dtype=object)
    return np.asarray(words[response[name]])


def brackets(curves: pd.DataFrame, lane_count: int) -> pd.DataFrame:
    """What some runs say of the capacity of every lane.

    Args:
        curves: One row a run; see `Analysis`.
        lane_count: Number of lanes.

    Returns:
        One row a lane: `standing_factor`, the largest below the first fall at which the block stood
        (0 without), `overturning_factor`, that of the first fall (infinite without), `verdict`,
        `resurrections`, runs above the first fall in which it stood, `runs`, `unusable`, those
        whose numbers may not be used, and `blocked`, whether one of these, not on the ladder, lies
        between the two factors.
    """
    usable = curves["status"].isin(USABLE_NAMES).to_numpy()
    fell = curves["outcome"].isin(FALLEN_NAMES).to_numpy() & usable
    stood = usable & ~fell
    lane, factor = curves["lane"].to_numpy(), curves["factor"].to_numpy()
    high = np.full(lane_count, np.inf)
    np.minimum.at(high, lane[fell], factor[fell])
    below = stood & (factor < high[lane])
    low = np.zeros(lane_count)
    np.maximum.at(low, lane[below], factor[below])
    again = stood & (factor > high[lane])
    any_number = np.bincount(lane, weights=usable, minlength=lane_count) > 0
    verdict = np.select(
        [~any_number, np.isinf(high), low == 0.0],
        [Verdict.UNKNOWN.value, Verdict.ABOVE.value, Verdict.BELOW.value],
        Verdict.BRACKETED.value,
    )
    between = ~usable & (factor > low[lane]) & (factor < high[lane])
    return pd.DataFrame(
        {
            "standing_factor": low,
            "overturning_factor": high,
            "verdict": verdict,
            "resurrections": np.bincount(lane[again], minlength=lane_count),
            "runs": np.bincount(lane, minlength=lane_count),
            "unusable": np.bincount(lane[~usable], minlength=lane_count),
            "blocked": np.bincount(
                lane[between & (curves["stage"].to_numpy() > 0)], minlength=lane_count
            )
            > 0,
        }
    )


def _next_stage(known: pd.DataFrame, ladder: Ladder) -> tuple[npt.NDArray[np.intp], Array]:
    """Lanes whose brackets are too wide, and the middle of each.

    A bracket in which a run has no usable number stays as it is.
    """
    low, high = (known[name].to_numpy() for name in ("standing_factor", "overturning_factor"))
    bracketed = (known["verdict"] == Verdict.BRACKETED.value).to_numpy()
    wide = bracketed & (high > low * (1.0 + ladder.accuracy)) & ~known["blocked"].to_numpy()
    lanes = np.flatnonzero(wide)
    return lanes, np.sqrt(low[lanes] * high[lanes])


def _claim(plan: Plan, folder: pathlib.Path) -> None:
    """Writes the plan to its folder, or finds it there.

    Raises:
        InputError: The folder holds another plan, or cannot be written to.
    """
    require_writable(folder)
    if (folder / PLAN).exists():
        there = read_plan(folder)
        if there.id != plan.id:
            names = [n for n in plan.content if plan.content[n] != there.content.get(n)]
            allowed = f"must be another folder: it holds a plan with another {', '.join(names)}"
            raise InputError("--output", "", str(folder), allowed)
        return
    write_plan(plan, folder)


def _stage_path(folder: pathlib.Path, stage: int) -> pathlib.Path:
    return folder / STAGES / f"stage-{stage:03d}.parquet"


def _write_stage(plan: Plan, folder: pathlib.Path, stage: int, runs: pd.DataFrame) -> None:
    table = pa.Table.from_pandas(runs, preserve_index=False)
    write_part(_stage_path(folder, stage), table, {"plan": plan.id, "stage": stage})


def _read_stage(
    plan: Plan,
    folder: pathlib.Path,
    stage: int,
    lanes: npt.NDArray[np.intp],
    factors: Array,
) -> pd.DataFrame | None:
    """A stage that has been run; None where there is none, or one that was cut off.

    Raises:
        InputError: The file is of another plan or stage.
    """
    path = _stage_path(folder, stage)
    part = find_part(path, {"plan": plan.id, "stage": stage})
    if part.state in (State.MISSING, State.BROKEN):
        return None
    try:
        runs: pd.DataFrame = read_part(path).to_pandas()
    except OSError:
        return None
    if part.state is State.FOREIGN or not (
        {"lane", "factor", "outcome", "status", "peak_rotation_ratio"} <= set(runs)
        and np.array_equal(runs["lane"], lanes)
        and np.array_equal(runs["factor"], factors)
    ):
        got = Said(f"stage {part.footer.get('stage')} of {str(part.footer.get('plan'))[:12]}")
        allowed = f"must be stage {stage} of the plan {plan.id[:12]}: delete it, or use another -o"
        raise InputError(str(path), "", got, allowed)
    return runs
