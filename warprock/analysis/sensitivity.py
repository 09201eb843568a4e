"""Sobol' indices of a case with a [sample]: which of its inputs explain the variance of a result.

The first-order index of an input is the share of the variance that would go if it alone were known,
the total index the share that would stay if all others were. Both come from Saltelli's design: two
samples A and B of n points, and for each input A with that input's column from B, n (d + 2) lanes
(Saltelli et al. 2010, Variance based sensitivity analysis of model output, *Computer Physics
Communications* 181). A and B are the two halves of one sample of twice the inputs.

What a lane measures ends with its fall: a block that lies on its side has turned by a right angle,
over a slenderness angle that the inputs set. That ratio tells of the inputs and not of the motion.
So where lanes fell the peak rotation is censored at the point of balance: a lane that fell, or went
beyond it, counts as 1. No other result of a fallen lane has such a bound; those are refused.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.case.axes import Axis, crossed_labels
from warprock.case.case import Case
from warprock.case.sampling import Sample
from warprock.errors import NOTHING, InputError, Said, list_allowed
from warprock.model.response import FALLEN, USABLE, Outcome
from warprock.running.case_run import CaseRun, run_case
from warprock.running.lane_table import lane_table
from warprock.running.options import DEFAULT_OPTIONS, RunOptions

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

PEAK, OVERTURNED = "peak_rotation_ratio", "overturned"
BALANCE = 1.0
"""Rotation over the slenderness angle at the point of balance."""
FEWEST = 16
"""Points of a sample, at least: fewer say nothing."""
MOST_LANES = 20_000_000
BAND = (5.0, 95.0)
"""Percentiles that bound the bands of the indices."""


@dataclasses.dataclass(frozen=True)
class SaltelliSample(Sample):
    """The points of A, of B, and of A with one column from B each, behind one another.

    Attributes:
        base: A and B side by side: a sample of twice as many dimensions.
    """

    base: Sample

    def points(self, numbers: npt.NDArray[np.intp]) -> Array:
        """Some points, from 0 to less than 1, shape [point, dimension]; see `Sample.points`."""
        part, row = np.divmod(numbers, self.base.count)
        both = self.base.points(row)
        first, second = both[:, : self.dimensions], both[:, self.dimensions :]
        changed = (part[:, None] == 1) | (part[:, None] == 2 + np.arange(self.dimensions))
        return np.where(changed, second, first)


def saltelli_case(case: Case) -> Case:
    """The case with the lanes of Saltelli's design in place of those of its sample.

    Raises:
        InputError: The case has no sample, one of another number of points than a power of 2 from
            16, or one that makes too many lanes.
    """
    if not case.axes or case.axes[-1].sample is None:
        allowed = "must be given: what its inputs are drawn from"
        raise InputError(case.file, "sample", NOTHING, allowed)
    axis = case.axes[-1]
    sample, inputs = axis.sample, len(axis.columns)
    assert sample is not None
    count, key = sample.count, "sample.lanes"
    if count < FEWEST or count & (count - 1):
        allowed = f"must be a power of 2, at least {FEWEST}, for Sobol' indices"
        raise InputError(case.source_of(key), key, count, allowed)
    length = count * (inputs + 2)
    lanes = case.lane_count // count * length
    if lanes > MOST_LANES:
        allowed = f"must make at most {MOST_LANES:,} lanes, lanes x (inputs + 2)"
        raise InputError(case.source_of(key), key, Said(f"{lanes:,} lanes"), allowed)
    base = dataclasses.replace(sample, dimensions=2 * inputs)
    design = SaltelliSample(sample.sampling, sample.seed, length, inputs, base)
    axes = (*case.axes[:-1], Axis(axis.columns, length, design))
    tables = case.tables.model_copy(update={"check": ()})
    return dataclasses.replace(case, axes=axes, tables=tables)


@dataclasses.dataclass(frozen=True)
class Sensitivity:
    """Sobol' indices of a case.

    Attributes:
        run: The lanes of the design and what became of them.
        of: Column whose variance is explained.
        rows: One row a group and input: `group`, `input`, `first_order`, `total`, and the ends of
            their bands, `first_order_p05` and so on.
        groups: One row a group: `group`, `lanes`, `mean`, `standard_deviation`, `overturned`,
            `censored`, the lanes that count as `BALANCE`.
    """

    run: CaseRun
    of: str
    rows: pd.DataFrame
    groups: pd.DataFrame


def run_sensitivity(
    case: Case,
    engine: str,
    options: RunOptions = DEFAULT_OPTIONS,
    *,
    of: str = PEAK,
    resamples: int = 200,
) -> Sensitivity:
    """Runs the lanes of the design and explains the variance of a result.

    Args:
        case: A case with a [sample].
        engine: Name of the engine.
        options: How the lanes are run.
        of: A column of the lane table that holds a result, or "overturned", 1 where the block did.
        resamples: Samples of rows of the design, for the bands.

    Raises:
        InputError: The case has no sample that can be used, an option is not one of those allowed,
            a lane has no number in that column, or lanes fell and the column is neither `PEAK` nor
            `OVERTURNED`.
    """
    design = saltelli_case(case)
    groups = crossed_labels(case.axes, {len(case.axes) - 1}, case.source_of("sweep"))
    run = run_case(design, engine, options, histories=False)
    inputs = list(design.axes[-1].columns)
    values, censored = _values(run, of)
    counts = {
        "overturned": run.response["outcome"] == Outcome.OVERTURNED,
        "censored": censored,
    }
    return Sensitivity(run, of, *_tables(values, counts, groups, inputs, resamples))


def _tables(
    values: Array,
    counts: Mapping[str, Mask],
    groups: tuple[str, ...],
    inputs: list[str],
    resamples: int,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Rows and groups of a `Sensitivity`, from the results of all lanes and what is counted."""
    split = values.reshape(len(groups), len(inputs) + 2, -1)
    seeds = np.random.SeedSequence(len(values)).spawn(len(groups))
    rows = [
        {"group": group, "input": name, **index}
        for group, mine, seed in zip(groups, split, seeds, strict=True)
        for name, index in zip(inputs, indices(mine, resamples, seed), strict=True)
    ]
    samples = split[:, :2].reshape(len(groups), -1)
    found = {
        "group": list(groups),
        "lanes": split[0].size,
        "mean": samples.mean(axis=1),
        "standard_deviation": samples.std(axis=1),
        **{name: lanes.reshape(len(groups), -1).sum(axis=1) for name, lanes in counts.items()},
    }
    return pd.DataFrame(rows), pd.DataFrame(found)


def _values(run: CaseRun, of: str) -> tuple[Array, Mask]:
    """The result of every lane, and which of them are censored, shape [lane].

    Raises:
        InputError: There is no such column, a lane without a number in it, or one that fell.
    """
    lane_set, response = run.lane_set, run.response
    bad = ~np.isin(response["status"], USABLE)
    if bad.any():
        got = Said(f"{_lanes(bad)} without a usable number")
        raise InputError(run.case.file, "status", got, "must be none: a design has no gaps")
    none = np.zeros(len(bad), dtype=np.bool_)
    if of == OVERTURNED:
        return np.asarray(response["outcome"] == Outcome.OVERTURNED, dtype=np.float64), none
    table = lane_table(lane_set, response)
    known = [str(name) for name in table.select_dtypes("number").columns]
    known = [name for name in known if name not in {"lane", *map(str, lane_set.inputs.columns)}]
    if of not in known:
        raise InputError(
            "--of", "", of, f"must be {OVERTURNED} or one of {list_allowed(of, known)}"
        )
    values = table[of].to_numpy(dtype=np.float64)
    fell = np.isin(response["outcome"], FALLEN)
    if of == PEAK and fell.any():
        censored = fell | (values >= BALANCE)
        return np.where(censored, BALANCE, values), censored
    if fell.any():
        got = Said(f"{_lanes(fell)} that fell")
        bounded = f"{PEAK}, in which they count as {BALANCE:g}, or " if PEAK in known else ""
        allowed = f"must be none: their numbers end with the fall; ask for {bounded}{OVERTURNED}"
        raise InputError("--of", of, got, allowed)
    if not np.all(np.isfinite(values)):
        got = Said(f"{_lanes(~np.isfinite(values))} without a number")
        raise InputError("--of", of, got, "must be a number in every lane")
    return values, none


def _lanes(which: Mask) -> str:
    """How many lanes, in words."""
    count = int(which.sum())
    return f"{count:,} {'lane' if count == 1 else 'lanes'}"


def indices(
    values: Array, resamples: int, seed: np.random.SeedSequence | int
) -> list[dict[str, float]]:
    """First-order and total indices of every input, with bands over resampled rows of the design.

    Args:
        values: Results of A, of B, and of A with each column from B, shape [input + 2, row]; the
            rows are a power of 2.
        resamples: Samples of rows.
        seed: Their seed.

    Returns:
        For each input `first_order`, `total` and the ends of their bands; NaN where nothing varies.
    """
    rows = values.shape[1]
    rng = np.random.default_rng(seed)
    drawn = [rng.integers(0, rows, rows) for _ in range(resamples)]
    first, total = _indices(values)
    bands = np.array([_indices(values[:, each]) for each in drawn])
    low, high = np.nanpercentile(bands, BAND, axis=0) if np.ptp(values[:2]) > 0.0 else bands[:2]
    return [
        {
            "first_order": float(first[k]),
            "first_order_p05": float(low[0, k]),
            "first_order_p95": float(high[0, k]),
            "total": float(total[k]),
            "total_p05": float(low[1, k]),
            "total_p95": float(high[1, k]),
        }
        for k in range(len(values) - 2)
    ]


def _indices(values: Array) -> tuple[Array, Array]:
    from scipy.stats import sobol_indices

    if np.ptp(values[:2]) == 0.0:
        return (np.full(len(values) - 2, np.nan),) * 2
    # Of a single input SciPy makes numbers that it then cannot index: it is given twice.
    count = len(values) - 2
    changed = np.repeat(values[2:], 2, axis=0) if count == 1 else values[2:]
    parts = {"f_A": values[:1], "f_B": values[1:2], "f_AB": changed[:, None]}
    found = sobol_indices(func=parts, n=values.shape[1])  # type: ignore[arg-type]
    return found.first_order.ravel()[:count], found.total_order.ravel()[:count]
