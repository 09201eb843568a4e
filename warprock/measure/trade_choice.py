"""The cheapest engine and settings within a tolerance, from the shipped trade table, and its test.

Errors in that table are those of its own scenes; a case may be gentler or harsher. So a sample of
the case's lanes runs as in the run that follows, with the step halved once where a lane needs it.
Where a lane misses the tolerance even so, the next setting with half of the error or less is tried.
"""

from __future__ import annotations

import dataclasses
import importlib.resources
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.engines import engine_class
from warprock.errors import InputError
from warprock.measure.trade import CSV, cheapest, settings_text
from warprock.measure.trade_scenes import SAMPLE_INTERVAL, TRADE_SCENES, scene_class
from warprock.model.response import FALLEN, SOUND, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.running.engine_choice import lanes_to_try, outside_model
from warprock.running.options import DEFAULT_OPTIONS, RunOptions
from warprock.running.tolerance import run_to_tolerance
from warprock.settings.engines import SETTINGS, build_settings

Array = npt.NDArray[np.float64]

OPTION = "--cheapest"

SAMPLE = 16
"""Lanes on which a choice is tested, evenly spread over the case."""

HALVINGS = 1
"""How often a test halves the step of a lane, at most. None would choose steps that no lane needs
refined: dearer in all than a setting of which some lanes are. More would pass settings of which
nearly all lanes are."""

TRIALS = 6
"""Settings tested at most; if none of them passes, the case has lanes that no step will tame."""


@dataclasses.dataclass(frozen=True)
class Choice:
    """An engine with its settings, chosen for a tolerance.

    Attributes:
        engine: Its name.
        settings: All of its settings, by name.
        precision: "float64" or "float32".
        why: How it was chosen, in words.
        test: What the sample of lanes said, in words.
        lanes: Lanes of the sample.
        lanes_met: Those of them that met the tolerance.
        largest_error: Largest error in the sample over the slenderness angle.
    """

    engine: str
    settings: Mapping[str, float | int]
    precision: str
    why: str
    test: str
    lanes: int
    lanes_met: int
    largest_error: float

    @property
    def overrides(self) -> tuple[str, ...]:
        """The settings as overrides of a case."""
        return tuple(f"engines.{self.engine}.{k}={v!r}" for k, v in self.settings.items())

    @property
    def advice(self) -> str:
        """What to do where lanes of the sample missed the tolerance; empty where none did."""
        if self.lanes_met == self.lanes:
            return ""
        if engine_class(self.engine).order is None:
            return f"next: {self.engine} has no step to refine; name another engine with -e"
        return (
            "next: the lanes that miss it run again at finer steps, see below; --max-bad 0 ends "
            "with exit code 4 where some still do"
        )


def shipped_trade() -> pd.DataFrame:
    """The shipped table of `warprock trade`."""
    file = importlib.resources.files("warprock.cases") / "trade" / CSV
    with file.open(encoding="utf-8") as stream:
        return pd.read_csv(stream, comment="#")


def choose(
    case: Case,
    tolerance: float,
    *,
    engine: str | None = None,
    precision: str | None = None,
    options: RunOptions = DEFAULT_OPTIONS,
    table: pd.DataFrame | None = None,
) -> Choice:
    """The cheapest engine and settings that met a tolerance, tested on a sample of the lanes.

    Args:
        case: The case.
        tolerance: Largest |error of the rotation| / slenderness angle, > 0 and < 1.
        engine: The only engine that may be chosen; any where None.
        precision: The only precision that may be chosen; any where None.
        options: How the tests are run, but for their precision.
        table: Measured rows; those that are shipped where None.

    Raises:
        InputError: The tolerance is out of bounds, or nothing met it on such scenes.
    """
    if not 0.0 < tolerance < 1.0:
        allowed = "must be > 0 and < 1, over the slenderness angle"
        raise InputError("--tolerance", "", tolerance, allowed)
    lane_set = expand_lanes(case)
    name = scene_class(lane_set.lanes, lane_set.motions)
    rows = _usable_rows(shipped_trade() if table is None else table, name, lane_set)
    if engine is not None:
        rows = rows[rows["engine"] == engine]
    if precision is not None:
        rows = rows[rows["precision"] == precision]
    met = cheapest(rows, tolerance)
    if met.empty:
        who = f"{engine or 'any engine'}{f' in {precision}' if precision else ''}"
        raise InputError("--tolerance", "", tolerance, _nothing(rows, name, who))
    judge = _judge_row(rows)
    tried: list[Choice] = []
    failed: dict[str, float] = {}
    for _, row in met.iterrows():
        if len(tried) == TRIALS:
            break
        if row["error_max"] > 0.5 * failed.get(row["engine"], np.inf):
            continue
        failed[row["engine"]] = float(row["error_max"])
        rank = "the next" if tried else "the cheapest"
        found = f"{rank} of {len(met)} settings that met {tolerance:g}"
        tried.append(_test(row, found, judge, lane_set, tolerance, options))
        if tried[-1].lanes_met == tried[-1].lanes:
            return _with_trials(tried, len(tried) - 1)
    most = max(range(len(tried)), key=lambda k: (tried[k].lanes_met, -tried[k].largest_error))
    return _with_trials(tried, most)


def _usable_rows(table: pd.DataFrame, name: str, lane_set: LaneSet) -> pd.DataFrame:
    """Rows of a class of scene whose engines can run the lanes with nothing left out."""
    fit = []
    for engine in table["engine"].unique():
        known = engine in SETTINGS and engine_class(engine).supports(lane_set.scene) is None
        if known and (engine_class(engine).slides or _sticks(lane_set)):
            fit.append(engine)
    return table[(table["scene"] == name) & table["engine"].isin(fit)]


def _sticks(lane_set: LaneSet) -> bool:
    """Whether no single block would slide, as `housner` finds; of stacks the test says so."""
    lanes = lane_set.lanes
    if lanes.stacked:
        return True
    chosen = np.array(lanes_to_try(lanes.lane_count))
    ends = np.full(len(chosen), lane_set.times.duration)
    return not outside_model(lanes.take(chosen), lane_set.motions.take(chosen), ends)


def _nothing(rows: pd.DataFrame, name: str, who: str) -> str:
    """What is said where no row met the tolerance."""
    sound = rows[rows["ok_share"] == 1.0]
    known = f"measured for such a case (class {name})"
    if sound.empty:
        return f"{who}: nothing was {known}"
    best = sound.sort_values(["error_max", "cpu_s_per_simulated_s"]).iloc[0]
    return f"{who}: nothing {known} met it; the best is {best['error_max']:.2g}, {_row_text(best)}"


def _row_text(row: pd.Series[Any]) -> str:
    return f"{row['engine']} with {settings_text(json.loads(row['settings']))}, {row['precision']}"


def _judge_row(rows: pd.DataFrame) -> pd.Series[Any] | None:
    """The most accurate row of an engine with a time step: it judges engines without one."""
    stepping = [e for e in rows["engine"].unique() if engine_class(e).order is not None]
    sound = rows[rows["engine"].isin(stepping) & (rows["ok_share"] == 1.0)]
    ordered = sound.sort_values(["error_max", "cpu_s_per_simulated_s"])
    return None if ordered.empty else ordered.iloc[0]


def _test(
    row: pd.Series[Any],
    found: str,
    judge: pd.Series[Any] | None,
    lane_set: LaneSet,
    tolerance: float,
    options: RunOptions,
) -> Choice:
    """A row as a choice, tested on a sample of the lanes."""
    count = min(SAMPLE, lane_set.lanes.lane_count)
    chosen = np.linspace(0, lane_set.lanes.lane_count - 1, count).round().astype(np.intp)
    if engine_class(row["engine"]).order is not None:
        errors = _estimated_errors(row, lane_set, chosen, tolerance, options)
        how = "by their estimates"
    elif judge is not None:
        errors = _errors_against(row, judge, lane_set, chosen, options)
        how = f"against {_row_text(judge)}, for {row['engine']} has no time step"
    else:
        errors, how = np.zeros(count), "not at all: nothing with a time step can run this case"
    lanes_met = int(np.sum(errors <= tolerance))
    largest = float(errors.max())
    verdict = "verified" if lanes_met == count else "NOT verified"
    test = (
        f"{verdict} on {count} of {lane_set.lanes.lane_count} lanes {how}: {lanes_met} within "
        f"{tolerance:g}, largest error {largest:.2g}"
    )
    why = (
        f"{_row_text(row)}: {found} on scenes of the class {row['scene']} "
        f"({TRADE_SCENES[row['scene']].text}); largest error there "
        f"{row['error_max']:.2g}, {row['cpu_s_per_simulated_s']:.2g} CPU s a simulated second of a "
        f"block, measured {row['measured']}"
    )
    settings = dataclasses.asdict(_settings(row))
    return Choice(row["engine"], settings, row["precision"], why, test, count, lanes_met, largest)


def _settings(row: pd.Series[Any]) -> Any:
    return build_settings(row["engine"], json.loads(row["settings"]), CSV)


def _estimated_errors(
    row: pd.Series[Any],
    lane_set: LaneSet,
    chosen: npt.NDArray[np.intp],
    tolerance: float,
    options: RunOptions,
) -> Array:
    """Estimated error / slenderness angle of some lanes with the settings of a row, shape [chosen].

    Infinite where a lane has no answer, or numbers that depend on the step (`Status.SENSITIVE`).
    """
    lanes = lane_set.lanes.take(chosen)
    response = run_to_tolerance(
        row["engine"],
        lanes,
        lane_set.motions.take(chosen),
        SampleTimes(lane_set.times.duration),
        dataclasses.replace(options, precision=row["precision"], tolerance=tolerance),
        settings=_settings(row),
        halvings=HALVINGS,
    )
    ratio = (response["rotation_error"] / lanes.slenderness_angle).reshape(len(chosen), -1)
    errors = np.nan_to_num(ratio.max(axis=1), nan=np.inf, posinf=np.inf)
    # Two runs that part ways may by chance lie within the tolerance of one another.
    parted = (response["status"] == Status.SENSITIVE) & (errors <= tolerance)
    return np.where(parted, np.inf, errors)


def _errors_against(
    row: pd.Series[Any],
    judge: pd.Series[Any],
    lane_set: LaneSet,
    chosen: npt.NDArray[np.intp],
    options: RunOptions,
) -> Array:
    """|Rotation difference| / slenderness angle of two rows in some lanes, up to a fall in both."""
    lanes, motions = lane_set.lanes.take(chosen), lane_set.motions.take(chosen)
    duration = lane_set.times.duration
    times = SampleTimes(duration, min(SAMPLE_INTERVAL, duration))
    alpha = lanes.slenderness_angle[..., None]
    one, other = (
        run_batch(
            each["engine"],
            lanes,
            motions,
            times,
            settings=_settings(each),
            **dataclasses.replace(options, precision=each["precision"]).of_batch,
        )
        for each in (row, judge)
    )
    sound = np.isin(one["status"], SOUND) & np.isin(other["status"], SOUND)
    # Of a fall in both, what comes after the slenderness angle is not compared.
    fallen = np.isin(one["outcome"], FALLEN) & np.isin(other["outcome"], FALLEN)
    bound = np.where(fallen.reshape(-1, *[1] * (alpha.ndim - 1)), alpha, np.inf)
    ours, theirs = (np.clip(each["rotation"], -bound, bound) for each in (one, other))
    ratio = (np.abs(ours - theirs) / alpha).reshape(len(chosen), -1).max(axis=1)
    return np.where(sound, ratio, np.inf)


def _with_trials(tried: list[Choice], chosen: int) -> Choice:
    """A choice that also says which others were tried and did not pass."""
    choice = tried[chosen]
    failed = [each for k, each in enumerate(tried) if k != chosen]
    if not failed:
        return choice
    names = "; ".join(each.why.partition(":")[0] for each in failed)
    return dataclasses.replace(choice, test=f"{choice.test}; did not pass: {names}")
