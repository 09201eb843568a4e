"""What an incremental dynamic analysis comes to: capacities, distributions, fractile curves."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.analysis.bands import Band, Estimate
from warprock.analysis.fragility import INTENSITY
from warprock.analysis.groups import (
    fit_columns,
    group_text,
    lane_groups,
    record_numbers,
)
from warprock.analysis.incremental import Analysis, Verdict
from warprock.analysis.likelihood import Brackets
from warprock.analysis.lognormal import Fit, bands_of, bracket_lanes, fit_lognormal
from warprock.analysis.lognormal import Verdict as FitVerdict
from warprock.case.case import Case
from warprock.case.input_columns import input_meaning
from warprock.case.lanes import expand_lanes
from warprock.errors import InputError, list_allowed
from warprock.model.response import FALLEN_NAMES, USABLE_NAMES, Outcome, Response, Status
from warprock.model.undecided import undecided
from warprock.settings.engines import on_springs

Array = npt.NDArray[np.float64]

FACTOR = "factor"
"""The factor itself as an intensity measure."""
INTENSITIES = (INTENSITY, "normalised_acceleration", "scale", FACTOR)
"""Intensity measures: all of them grow as the factor on the motion does."""

FRACTILES = (0.16, 0.5, 0.84)
LEVELS = 120
"""Intensities at which fractiles are taken."""


@dataclasses.dataclass(frozen=True)
class Capacities:
    """Capacities of one group of lanes.

    Attributes:
        group: Values of the columns that the group shares.
        lanes: Their numbers, shape [lane]; those without any usable run are left out.
        low: Intensity at which each still stood, 0 where there is none, shape [lane].
        high: Intensity at which each had fallen, infinite where it never did, shape [lane].
        verdicts: What is known of each, shape [lane].
        resurrections: Runs of each above its first fall in which it stood, shape [lane].
        records: Records among them.
        fit: The lognormal distribution, or why there is none.
        band: Its band over records; None without a fit or with too few records.
        errors: Errors of the fit alone; None without a fit.
        left_out: Lanes of the group without any usable run.
    """

    group: dict[str, object]
    lanes: npt.NDArray[np.intp]
    low: Array
    high: Array
    verdicts: npt.NDArray[np.object_]
    resurrections: npt.NDArray[np.intp]
    records: int
    fit: Fit
    band: Band | None
    errors: Estimate | None
    left_out: int

    @property
    def group_text(self) -> str:
        """The group in words; empty where there is only one."""
        return group_text(self.group)


def unit_intensity(found: Analysis, intensity: str) -> Array:
    """Intensity of every lane at factor 1, shape [lane].

    Raises:
        InputError: The case has no such intensity measure, or it is not above 0.
    """
    inputs = found.lane_set.inputs
    _require(inputs, intensity, ())
    count = found.lane_set.lanes.lane_count
    if intensity == FACTOR:
        return np.ones(count)
    values = inputs[intensity].to_numpy(dtype=np.float64)
    if not np.all(np.isfinite(values) & (values > 0.0)):
        lane = int(np.argmin(np.isfinite(values) & (values > 0.0)))
        allowed = f"must be above 0 in every lane (lane {lane}): it is the intensity measure"
        raise InputError("--im", intensity, float(values[lane]), allowed)
    return values


def require_columns(case: Case, intensity: str, by: Sequence[str]) -> None:
    """Refuses columns that the lanes of a case do not have, before anything runs.

    Raises:
        InputError: One of them is none, or no intensity measure.
    """
    _require(expand_lanes(case, range(1)).inputs, intensity, by)


def _require(inputs: pd.DataFrame, intensity: str, by: Sequence[str]) -> None:
    known = [name for name in INTENSITIES if name == FACTOR or name in inputs]
    if intensity not in known:
        allowed = f"must grow as the factor on the motion does: {', '.join(known)}"
        raise InputError("--im", "", intensity, allowed)
    for name in by:
        if name not in inputs:
            columns = list_allowed(name, map(str, inputs.columns))
            raise InputError("--by", "", name, f"must be an input of the lanes: {columns}")


def capacities(found: Analysis, *, intensity: str, by: Sequence[str]) -> list[Capacities]:
    """Capacities of every group of lanes, in the order of the lanes.

    Args:
        found: The analysis.
        intensity: One of `INTENSITIES`.
        by: Input columns that make groups.

    Raises:
        InputError: A column that the lanes do not have.
    """
    inputs = found.lane_set.inputs
    _require(inputs, intensity, by)
    unit = unit_intensity(found, intensity)
    known = found.capacities
    ends = [known[f"{end}_factor"].to_numpy() * unit for end in ("standing", "overturning")]
    numbered = known["verdict"].to_numpy(dtype=object) != Verdict.UNKNOWN.value
    made = []
    for group, lanes in lane_groups(inputs, by):
        mine = lanes[numbered[lanes]]
        if not len(mine):
            text = group_text(group) or "all lanes"
            raise InputError("status", "", text, "must have a lane whose numbers can be used")
        low, high = (end[mine] for end in ends)
        brackets = bracket_lanes(low, high, record_numbers(inputs.iloc[mine]))
        fit = fit_capacities(brackets)
        drawn, errors = bands_of(brackets, fit)
        made.append(
            Capacities(
                group=group,
                lanes=mine,
                low=low,
                high=high,
                verdicts=known["verdict"].to_numpy(dtype=object)[mine],
                resurrections=known["resurrections"].to_numpy(dtype=np.intp)[mine],
                records=brackets.record_count,
                fit=fit,
                band=drawn,
                errors=errors,
                left_out=len(lanes) - len(mine),
            )
        )
    return made


def fit_capacities(known: Brackets) -> Fit:
    """The lognormal distribution of greatest likelihood of capacities in brackets.

    A lane says nothing of intensities beyond those that it saw. Where no lane fell, none falls up
    to the weakest of their strongest motions. Where all fell at their weakest motion, all fall from
    the strongest of these on.
    """
    fit = fit_lognormal(known)
    if fit.verdict is FitVerdict.NONE_REACHED:
        return dataclasses.replace(fit, low=float(known.low.min()))
    if fit.verdict is FitVerdict.ALL_REACHED:
        return dataclasses.replace(fit, high=float(known.high.max()))
    return fit


def capacity_rows(groups: Sequence[Capacities]) -> pd.DataFrame:
    """One row a group: how its lanes fell, the lognormal distribution and its band over records."""
    rows = []
    for each in groups:
        counts = {v.value: int((each.verdicts == v.value).sum()) for v in Verdict}
        rows.append(
            {
                **each.group,
                "lanes": len(each.lanes),
                "left_out": each.left_out,
                "records": each.records,
                "bracketed": counts[Verdict.BRACKETED.value],
                "never_overturned": counts[Verdict.ABOVE.value],
                "overturned_at_once": counts[Verdict.BELOW.value],
                "lanes_resurrected": int((each.resurrections > 0).sum()),
                "resurrections": int(each.resurrections.sum()),
                **fit_columns(each.fit, each.band, each.errors),
            }
        )
    return pd.DataFrame(rows)


def lane_rows(found: Analysis, intensity: str) -> pd.DataFrame:
    """One row a lane: its inputs at factor 1, and what is known of its capacity."""
    unit = unit_intensity(found, intensity)
    known = found.capacities.drop(columns="blocked")
    ends = {}
    if intensity != FACTOR:
        for end in ("standing", "overturning"):
            ends[f"{end}_{intensity}"] = known[f"{end}_factor"] * unit
    inputs = found.lane_set.inputs.reset_index(drop=True)
    table = pd.concat([inputs, known.assign(**ends)], axis=1)
    table.insert(0, "lane", np.arange(len(table)))
    table.attrs["columns"] = _meanings(table, set(inputs.columns) | {"lane"}, intensity)
    return table


def undecided_runs(found: Analysis) -> int:
    """Runs whose end left open if the block stands, see `undecided`; they count as standing."""
    curves, lane_set = found.curves, found.lane_set
    lanes = curves["lane"].to_numpy()
    codes = {
        "outcome": [Outcome[word.upper()] for word in curves["outcome"]],
        "status": [Status[word.upper()] for word in curves["status"]],
    }
    response = Response("", {name: np.array(each) for name, each in codes.items()}, np.empty(0))
    blocks, motions = lane_set.lanes.take(lanes), lane_set.motions.take(lanes)
    ends = np.broadcast_to(lane_set.ends, lane_set.lanes.lane_count)[lanes]
    return int(
        undecided(response, blocks, motions, ends, springs=on_springs(response.engine)).sum()
    )


def run_rows(found: Analysis, intensity: str) -> pd.DataFrame:
    """One row a run: the lane, its factor and intensity, and what became of the block."""
    curves = found.curves
    unit = unit_intensity(found, intensity)[curves["lane"].to_numpy()]
    table = curves.assign(**{intensity: curves["factor"] * unit})
    table.attrs["columns"] = _meanings(table, {"lane", intensity} - {FACTOR}, intensity)
    return table


_RESULTS = {
    "factor": "Factor on the motion",
    "stage": "Stage that the run belongs to",
    "outcome": "Where the block is at the end",
    "status": "Whether the numbers may be used",
    "peak_rotation_ratio": "Largest rotation / slenderness angle",
    "missed_tolerance": "Whether the run is not within the tolerance by its estimate",
    "standing_factor": "Largest factor below the first fall at which the block stood; 0 without",
    "overturning_factor": "Factor of the first fall; infinite where there is none",
    "verdict": "What is known of the capacity",
    "resurrections": "Runs above the first fall in which the block stood",
    "runs": "Runs of the lane",
    "unusable": "Runs whose numbers may not be used",
}


def _meanings(table: pd.DataFrame, inputs: set[str], intensity: str) -> dict[str, dict[str, str]]:
    """Unit and meaning of every column."""
    found = {}
    for name in map(str, table.columns):
        unit, text = "-", _RESULTS.get(name, "")
        if name in inputs:
            unit, text = input_meaning(name)
        elif name not in _RESULTS:
            end = name.removesuffix(f"_{intensity}")
            unit, text = input_meaning(intensity)
            text = f"{text}, of {end}_factor"
        found[name] = {"unit": unit, "text": text}
    return found


def run_curves(found: Analysis, unit: Array) -> list[tuple[Array, Array]]:
    """Intensities of every lane's usable runs, weakest first, and its rotation ratio there.

    Args:
        found: The analysis.
        unit: Intensity of every lane at factor 1, shape [lane].

    Returns:
        For each lane two arrays of shape [run]; the ratio is infinite where the block fell.
    """
    curves = found.curves[found.curves["status"].isin(USABLE_NAMES)]
    lane = curves["lane"].to_numpy()
    fell = curves["outcome"].isin(FALLEN_NAMES).to_numpy()
    ratio = np.where(fell, np.inf, curves["peak_rotation_ratio"].to_numpy())
    cuts = np.searchsorted(lane, np.arange(1, len(unit)))
    at = np.split(curves["factor"].to_numpy() * unit[lane], cuts)
    return list(zip(at, np.split(ratio, cuts), strict=True))


def fractile_curves(runs: Sequence[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Fractiles of the largest rotation / slenderness angle of some lanes over the intensity.

    Between two runs in which it stood, a lane's rotation is interpolated over the logarithm of the
    intensity; beside a run in which it fell, it has fallen: infinite. Intensities are those that
    all of the lanes have seen.

    Args:
        runs: What `run_curves` says of the lanes.

    Returns:
        Intensities, shape [level], and `FRACTILES` there, shape [fractile, level].
    """
    some = [each for each in runs if len(each[0]) > 1]
    low = max((float(at[0]) for at, _ in some), default=np.inf)
    high = min((float(at[-1]) for at, _ in some), default=0.0)
    if low >= high:
        return np.empty(0), np.empty((len(FRACTILES), 0))
    levels = np.geomspace(low, high, LEVELS)
    values = np.empty((len(some), len(levels)))
    for row, (at, ratio) in zip(values, some, strict=True):
        after = np.clip(np.searchsorted(at, levels), 1, len(at) - 1)
        part = np.log(levels / at[after - 1]) / np.log(at[after] / at[after - 1])
        fell = np.isinf(ratio[after]) | np.isinf(ratio[after - 1])
        plain = np.where(np.isinf(ratio), 0.0, ratio)
        between = plain[after - 1] + np.clip(part, 0.0, 1.0) * (plain[after] - plain[after - 1])
        row[:] = np.where(fell, np.inf, between)
    return levels, np.quantile(values, FRACTILES, axis=0, method="inverted_cdf")
