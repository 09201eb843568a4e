"""The results of an ensemble: distributions of the responses in each cell, and comparison of two.

Near overturning the result depends on the smallest change of the input, and for a stack it does
nearly everywhere. The answer for a cell is then the distribution over its members, not one of them.

A lane that overturned, or whose blocks slid off one another, has no meaningful largest rotation: it
ranks above every lane that stayed up, as +infinity, in all of its blocks. A quantile among such
lanes is +infinity, which is printed as "overturned". Lanes without usable numbers are left out, and
counted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.case.lanes import LaneSet
from warprock.model.ratios import peak_ratio
from warprock.model.response import FALLEN, USABLE, Response
from warprock.running.lane_table import PEAK_RATIO

if TYPE_CHECKING:
    import pandas as pd

Array = npt.NDArray[np.float64]

QUANTILES: dict[str, float] = {
    "q05": 0.05,
    "q25": 0.25,
    "median": 0.5,
    "q75": 0.75,
    "q95": 0.95,
}
"""Name of a quantile in a column -> the share of lanes at or below it."""

SAME, DIFFERENT = "same at 5 %", "different at 5 %"
"""Results of a comparison of two distributions."""

DIGITS = 4
"""Digits behind the point to which rotation ratios are compared."""

_LEVEL = 0.05
_FEW = 200
"""Number of members below which the exact p value is computed."""
_NORMAL_95 = 1.959963984540054
"""Quantile 0.975 of the standard normal distribution."""


def cell_table(lane_set: LaneSet, response: Response) -> pd.DataFrame:
    """Distributions of an ensemble, one row a cell.

    Args:
        lane_set: All lanes of a case with an ensemble.
        response: The engine's answer for the same lanes.

    Returns:
        `cell`, its labels and the inputs in which cells differ, without their spread; `members`;
        `usable`, the share of members whose numbers may be used; of these, `overturned`, the share
        that overturned or slid off, with its 95 % interval (Wilson 1927), `overturned_low` and
        `overturned_high`; then the quantiles of the largest rotation / slenderness angle,
        `peak_rotation_ratio_q05`, `_q25`, `_median`, `_q75` and `_q95`, in stacks of every block,
        its number last: `peak_rotation_ratio_median_2`. A quantile is the least value that at
        least its share of the members do not exceed; +infinity is "overturned", NaN that no member
        may be used.

    Raises:
        ValueError: The lanes are no whole ensemble.
    """
    table = _cell_inputs(lane_set)
    usable = _in_cells(lane_set, np.isin(response["status"], USABLE))
    fallen = _in_cells(lane_set, np.isin(response["outcome"], FALLEN)) & usable
    count, overturned = usable.sum(axis=1), fallen.sum(axis=1)
    low, high = wilson_interval(overturned, count)
    columns: dict[str, Any] = {
        "members": lane_set.members,
        "usable": count / lane_set.members,
        "overturned": _share(overturned, count),
        "overturned_low": low,
        "overturned_high": high,
    }
    for suffix, peaks in _peak_ratios(lane_set, response).items():
        # NaN sorts last, so that the usable members come first.
        ordered = np.sort(peaks, axis=1)
        for name, share in QUANTILES.items():
            columns[f"{PEAK_RATIO}_{name}{suffix}"] = _order_statistic(ordered, count, share)
    return table.assign(**columns)


def percentile_of(values: Array, outcomes: npt.NDArray[np.integer[Any]], printed: float) -> float:
    """Where a number falls in the distribution of a cell.

    Args:
        values: Values of the members, shape [member]; NaN is left out.
        outcomes: Codes of `Outcome`, same shape; members that overturned or slid off rank above
            every number.
        printed: The number; +infinity is "overturned".

    Returns:
        Its mid-rank, 0 to 1: the share of members below it and half of the share equal to it; NaN
        without a member.
    """
    ranked = np.where(np.isin(outcomes, FALLEN), np.inf, np.asarray(values, dtype=np.float64))
    ranked = ranked[~(np.isnan(values) | np.isnan(ranked))]
    if not len(ranked):
        return float("nan")
    below, equal = np.count_nonzero(ranked < printed), np.count_nonzero(ranked == printed)
    return float((below + 0.5 * equal) / len(ranked))


def compare_cells(lane_set: LaneSet, a: Response, b: Response) -> pd.DataFrame:
    """Whether two engines give the same distribution of peak rotations, one row a cell.

    The two-sample Kolmogorov-Smirnov test on ratios rounded to `DIGITS` digits, so that a block
    which hardly lifts does not count as different; overturned lanes tie at +infinity. The test
    takes members for independent draws. Members of a Sobol' or Latin hypercube sample scatter less,
    and so do members that both engines share. So where a scene is not chaotic the p value is too
    large.

    Args:
        lane_set: All lanes of a case with an ensemble.
        a: Response of one engine for these lanes.
        b: Response of the other.

    Returns:
        `cell`, its labels and inputs as in `cell_table`; `usable_a` and `usable_b`, shares of the
        members, and `overturned_a` and `overturned_b`, shares of the usable ones; then of every
        block, its number last in stacks, `median_a`, `median_b`, `statistic` (largest difference
        of the two cumulative distributions), `p_value` and `meaning`: `SAME` or `DIFFERENT`. NaN,
        and an empty meaning, where an engine has no usable member.

    Raises:
        ValueError: The lanes are no whole ensemble.
    """
    from scipy.stats import ks_2samp

    table = _cell_inputs(lane_set)
    tables = {"a": cell_table(lane_set, a), "b": cell_table(lane_set, b)}
    columns: dict[str, Any] = {
        f"{column}_{n}": t[column] for column in ("usable", "overturned") for n, t in tables.items()
    }
    of_b = _peak_ratios(lane_set, b)
    for suffix, peaks in _peak_ratios(lane_set, a).items():
        for name, cells in tables.items():
            columns[f"median_{name}{suffix}"] = cells[f"{PEAK_RATIO}_median{suffix}"]
        statistic, p_value = np.full((2, len(table)), np.nan)
        for cell, (mine, other) in enumerate(zip(peaks, of_b[suffix], strict=True)):
            mine, other = mine[~np.isnan(mine)], other[~np.isnan(other)]
            if len(mine) and len(other):
                found = ks_2samp(
                    mine.round(DIGITS),
                    other.round(DIGITS),
                    method="auto" if max(len(mine), len(other)) < _FEW else "asymp",
                )
                statistic[cell], p_value[cell] = found.statistic, found.pvalue
        columns[f"statistic{suffix}"] = statistic
        columns[f"p_value{suffix}"] = p_value
        meaning = np.where(p_value >= _LEVEL, SAME, DIFFERENT)
        columns[f"meaning{suffix}"] = np.where(np.isnan(p_value), "", meaning)
    return table.assign(**columns)


def wilson_interval(
    count: npt.NDArray[np.integer[Any]], total: npt.NDArray[np.integer[Any]]
) -> tuple[Array, Array]:
    """95 % interval of a share (Wilson 1927), which holds where a share is 0 or 1, too.

    Args:
        count: Members that have something.
        total: All members, same shape.

    Returns:
        Its ends; 0 and 1 where there is no member.
    """
    z2 = _NORMAL_95**2
    centre = (count + 0.5 * z2) / (total + z2)
    spread = count * (total - count) / np.maximum(total, 1) + 0.25 * z2
    half = _NORMAL_95 * np.sqrt(spread) / (total + z2)
    low = np.where(count == 0, 0.0, centre - half)
    high = np.where(count == total, 1.0, centre + half)
    return np.asarray(low), np.asarray(high)


def _cell_inputs(lane_set: LaneSet) -> pd.DataFrame:
    """Number, labels and inputs of every cell, those inputs alone in which cells differ."""
    if lane_set.cells is None:
        raise ValueError("lanes: must be all lanes of a case with an ensemble")
    cells = lane_set.cells
    shown = [c for c in cells if c in lane_set.labels or cells[c].nunique(dropna=False) > 1]
    table = cells[shown].reset_index(drop=True)
    table.insert(0, "cell", np.arange(len(table)))
    return table


def _in_cells(lane_set: LaneSet, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values of lanes as [cell, member]."""
    return values.reshape(-1, lane_set.members)


def _peak_ratios(lane_set: LaneSet, response: Response) -> dict[str, Array]:
    """Largest rotations / slenderness angle by the suffix of their block, shape [cell, member].

    +infinity where a lane overturned or slid off, NaN where its numbers may not be used.
    """
    ratios = peak_ratio(response, lane_set.lanes)
    fallen = np.isin(response["outcome"], FALLEN)
    usable = np.isin(response["status"], USABLE)
    stacked = lane_set.lanes.stacked
    of_blocks = {f"_{k + 1}": ratios[:, k] for k in range(ratios.shape[1])} if stacked else {}
    return {
        suffix: _in_cells(lane_set, np.where(usable, np.where(fallen, np.inf, values), np.nan))
        for suffix, values in (of_blocks or {"": ratios}).items()
    }


def _share(count: npt.NDArray[Any], total: npt.NDArray[Any]) -> Array:
    return np.where(total > 0, count / np.maximum(total, 1), np.nan)


def _order_statistic(ordered: Array, count: npt.NDArray[Any], share: float) -> Array:
    """The least of the first `count` sorted values that `share` of them do not exceed, a row."""
    at = np.maximum(np.ceil(share * count - 1e-9).astype(np.intp), 1) - 1
    return np.where(count > 0, ordered[np.arange(len(ordered)), at], np.nan)
