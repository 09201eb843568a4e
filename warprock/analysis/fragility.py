"""Fragility of blocks from the lane table of a run or of a sweep.

The demand is the largest |rotation| / slenderness angle of a lane, or its largest slide, of a stack
the largest of its blocks; a block that overturned has reached every limit state. Rocking is not
monotonic in the intensity: a block may stand at a stronger motion than the one that overturned it,
so lanes are counted at the intensity at which they ran, never from the first exceedance on.

Which lanes count (`RULE`): one whose status says that it has no numbers is left out and counted by
its status. One whose numbers leave open whether it reached a limit state (see
`warprock.analysis.limits`) is in doubt; it counts by what became of it in its finest run. There are
two more fits: in one all lanes in doubt reached the limit, in the other none did. The band of a
curve holds the bands of both. Leaving lanes in doubt out would take away lanes near the limit, and
with them the dispersion; counting half of each would add to it. Where lanes left out and lanes in
doubt are more than a stated share of all there is no fit, for they are not a random part of them.

The fit itself is in `warprock.analysis.lognormal`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.analysis.bands import FEW_RECORDS, LEAST_RECORDS, Band, Estimate
from warprock.analysis.groups import (
    Weights,
    fit_columns,
    group_text,
    lane_groups,
    record_numbers,
    record_weights,
)
from warprock.analysis.lane_tables import require_lane_table
from warprock.analysis.limits import (
    Limit,
    find_reached,
    in_doubt,
    ratio_errors,
    require_slides,
    slide_errors,
)
from warprock.analysis.lognormal import (
    Fit,
    Observations,
    bands_of,
    fit_lognormal,
    observe,
    record_band,
)
from warprock.errors import InputError
from warprock.model.response import USABLE_NAMES
from warprock.settings.engines import EXACT

Array = npt.NDArray[np.float64]

INTENSITY = "peak_acceleration_m_s2"
"""Intensity measure where none is asked for: the peak ground acceleration."""

MOST_DOUBT = 0.2
"""Share of the lanes left out or in doubt above which there is no fit, unless asked for."""

RULE = (
    "a lane without usable numbers is left out; one whose numbers leave a limit state in doubt "
    "counts by its finest run, and bands reach around those in which all such lanes reached it, or "
    "none"
)
"""The rule in a sentence."""


@dataclasses.dataclass(frozen=True)
class Curve:
    """A limit state of one group of lanes.

    Attributes:
        group: Values of the columns that the group shares.
        limit: The limit state.
        seen: The lanes, by record and intensity.
        effective_records: Records of one weight that would tell as much as those seen.
        fit: The fragility function, or why there is none.
        band: Its band over records; None without a fit or with too few records.
        errors: Errors of the fit alone, which know nothing of records; None without a fit.
        in_doubt: Lanes that the limit state is in doubt of.
        extremes: The fits in which all lanes in doubt reached it, and in which none did.
        left_out: Lanes of the group that are left out, by status.
    """

    group: dict[str, object]
    limit: Limit
    seen: Observations
    effective_records: float
    fit: Fit
    band: Band | None
    errors: Estimate | None
    in_doubt: int
    extremes: tuple[Fit, Fit]
    left_out: dict[str, int]

    @property
    def group_text(self) -> str:
        """The group in words; empty where there is only one."""
        return group_text(self.group)


def fragility_curves(
    table: pd.DataFrame,
    *,
    source: str,
    intensity: str = INTENSITY,
    limits: Sequence[Limit],
    by: Sequence[str] = (),
    most_doubt: float = MOST_DOUBT,
    weights: Weights | None = None,
) -> list[Curve]:
    """Fragility functions of every group and limit state.

    Args:
        table: Lane table.
        source: What errors name as its source.
        intensity: Column of the intensity measure.
        limits: Limit states.
        by: Columns that make groups of lanes: each combination of their values is one.
        most_doubt: Share of a group's lanes that may be left out or in doubt.
        weights: Weights by record, or the column that has them; None where all weigh the same.

    Returns:
        The groups in the order of the table, each with its limit states in the order given.

    Raises:
        InputError: A column that the table does not have, an intensity that is not above zero, a
            group without a lane that can be used, or too many that cannot or are in doubt.
    """
    require_lane_table(table, source, intensity, by)
    require_slides(table, source, limits)
    curves = []
    for group, rows in lane_groups(table, by):
        lanes = table.iloc[rows]
        usable = lanes[lanes["status"].isin(USABLE_NAMES)]
        text = group_text(group) or "all lanes"
        if usable.empty:
            raise InputError(source, "status", text, "must have a lane whose numbers can be used")
        weight = record_weights(usable, weights, source)
        for limit in limits:
            curve = _curve(group, lanes, usable, limit, intensity, weight)
            bad = curve.in_doubt + sum(curve.left_out.values())
            if bad > most_doubt * len(lanes):
                raise _too_many(curve, lanes, usable, source, most_doubt, bad)
            curves.append(curve)
    return curves


def _curve(
    group: dict[str, object],
    lanes: pd.DataFrame,
    usable: pd.DataFrame,
    limit: Limit,
    intensity: str,
    weight: Array | None,
) -> Curve:
    """One limit state of a group: its lanes, and those of them that can be used."""
    at = usable[intensity].to_numpy(dtype=np.float64)
    record = record_numbers(usable)
    hit, doubt = find_reached(usable, limit), in_doubt(usable, limit)
    # Of those in doubt as they are, all, or none.
    seen, most, least = (observe(at, each, record) for each in (hit, hit | doubt, hit & ~doubt))
    known = [dataclasses.replace(each.brackets, weight=weight) for each in (seen, most, least)]
    fits = [fit_lognormal(each) for each in known]
    band, errors = bands_of(known[0], fits[0])
    if band is not None and doubt.any():
        others = [
            record_band(each, fit)
            for each, fit in zip(known[1:], fits[1:], strict=True)
            if fit.dispersion > 0.0
        ]
        band = dataclasses.replace(band, others=tuple(others))
    left = lanes["status"][~lanes["status"].isin(USABLE_NAMES)].astype(str).value_counts()
    left_out = {str(name): int(count) for name, count in left.items() if count}
    return Curve(
        group=group,
        limit=limit,
        seen=seen,
        effective_records=known[0].effective_records,
        fit=fits[0],
        band=band,
        errors=errors,
        in_doubt=int(doubt.sum()),
        extremes=(fits[1], fits[2]),
        left_out=left_out,
    )


def _too_many(
    curve: Curve,
    lanes: pd.DataFrame,
    usable: pd.DataFrame,
    source: str,
    most_doubt: float,
    bad: int,
) -> InputError:
    """Why there is no fit: how many lanes, of which statuses, and what to do."""
    why = usable["status"].astype(str)
    if "undecided" in usable:
        why = why.mask(usable["undecided"].astype(bool) & (why == "ok"), "undecided")
    doubted = why[in_doubt(usable, curve.limit)].value_counts()
    counts = {str(name): int(count) for name, count in doubted.items() if count}
    parts = [f"in doubt: {_count_statuses(counts)}"] if counts else []
    parts += [f"left out: {_count_statuses(curve.left_out)}"] if curve.left_out else []
    where = f" of {curve.group_text}" if curve.group else ""
    got = f"{bad} of {len(lanes)} lanes{where} ({'; '.join(parts)})"
    allowed = (
        f"must be at most {100.0 * most_doubt:g} % for limit state {curve.limit.name}: run them "
        "at a smaller step, longer, or with an engine that holds there; --max-doubt 1 takes all"
    )
    return InputError(source, "status", got, allowed)


def _count_statuses(counts: dict[str, int]) -> str:
    """Statuses and how many lanes have them, in words."""
    return ", ".join(f"{name} {count:,}" for name, count in counts.items())


def warnings(table: pd.DataFrame, curves: Sequence[Curve]) -> list[str]:
    """What is to be known of the curves of a table before they are used; may be empty."""
    found = []
    if not np.isfinite(ratio_errors(table)).any():
        found.append(
            "the table has no estimate of errors, so that nobody looked whether its lanes have "
            f"converged ({' and '.join(EXACT)} need none)"
        )
    elif (
        any(c.limit.slide is not None for c in curves)
        and not np.isfinite(slide_errors(table)).any()
    ):
        found.append("the table has no estimate of the error of the slide")
    if any(c.limit.slide is not None and not c.seen.reached.any() for c in curves):
        found.append(f"no lane reached a limit on the slide: {' and '.join(EXACT)} do not slide")
    fewest = min(curve.seen.record_count for curve in curves)
    if fewest < LEAST_RECORDS:
        found.append(
            f"{fewest} record{'s' * (fewest != 1)}: no band over fewer than {LEAST_RECORDS} records"
        )
    elif fewest < FEW_RECORDS:
        found.append(
            f"{fewest} records: from fewer than {FEW_RECORDS} neither a dispersion nor its band "
            "is to be relied upon"
        )
    return found


def curve_rows(curves: Sequence[Curve]) -> pd.DataFrame:
    """One row a curve: its group, what was counted, the fit and its band over records.

    Returns:
        The group's columns, then `limit_state`, `lanes` (that count), `left_out`, their statuses
        `left_out_as`, `in_doubt`, `records`,
        `effective_records` (of weighted ones), `reached`, `verdict`, `median`, `dispersion`, their
        5th and 95th percentiles over records and (`_fit_`) of the fit alone, what is to be said of
        the `band` over records, for data that one intensity
        parts (or that all or none reached) `none_up_to` and `all_from`, and the fits in which all
        lanes in doubt reached the limit state (`_if_reached`) and in which none did (`_if_not`).
    """
    rows = []
    for curve in curves:
        rows.append(
            {
                **curve.group,
                "limit_state": curve.limit.name,
                "lanes": int(curve.seen.count.sum()),
                "left_out": sum(curve.left_out.values()),
                "left_out_as": _count_statuses(curve.left_out),
                "in_doubt": curve.in_doubt,
                "records": curve.seen.record_count,
                "effective_records": curve.effective_records,
                "reached": int(curve.seen.reached.sum()),
                **fit_columns(curve.fit, curve.band, curve.errors),
                **{
                    f"{name}_{end}": getattr(fit, name)
                    for end, fit in zip(("if_reached", "if_not"), curve.extremes, strict=True)
                    for name in ("median", "dispersion")
                },
            }
        )
    return pd.DataFrame(rows)
