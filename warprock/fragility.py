"""Fragility of blocks from the lane table of a run or of a sweep.

The demand is the largest |rotation| / slenderness angle of a lane, of a stack the largest of its
blocks; a block that overturned has reached every limit state. Lanes whose status says that their
numbers cannot be used are left out and counted. Rocking is not monotonic in the intensity: a block
may stand at a stronger motion than the one that overturned it, so lanes are counted at the
intensity at which they ran, never from the first exceedance on.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.errors import InputError
from warprock.fragility_fit import Bootstrap, Fit, Observations, bootstrap, fit_lognormal, observe
from warprock.fragility_groups import (
    LEAST_RECORDS,
    fit_columns,
    group_text,
    lane_groups,
    record_numbers,
)
from warprock.fragility_table import PEAK_RATIO, require_lane_table
from warprock.response import USABLE

Array = npt.NDArray[np.float64]

UPLIFT, OVERTURNING = "uplift", "overturning"
DEFAULT_LIMITS = (UPLIFT, "0.15", "0.35", OVERTURNING)
"""Limit states of a block: it has lifted, its peak rotation / slenderness angle, it has fallen."""

INTENSITY = "peak_acceleration_m_s2"
"""Intensity measure where none is asked for: the peak ground acceleration."""


@dataclasses.dataclass(frozen=True)
class Limit:
    """A limit state.

    Attributes:
        name: As asked for: uplift, overturning, or the ratio.
        ratio: Peak rotation / slenderness angle that reaches it; None for the two others.
    """

    name: str
    ratio: float | None = None

    @property
    def text(self) -> str:
        """The limit state in words."""
        return self.name if self.ratio is None else f"rotation ratio {self.name}"


@dataclasses.dataclass(frozen=True)
class Curve:
    """A limit state of one group of lanes.

    Attributes:
        group: Values of the columns that the group shares.
        limit: The limit state.
        seen: The lanes, by record and intensity.
        fit: The fragility function, or why there is none.
        resampled: Fits of resampled records; None without a fit or with too few records.
        left_out: Lanes of the group whose status keeps them out.
    """

    group: dict[str, object]
    limit: Limit
    seen: Observations
    fit: Fit
    resampled: Bootstrap | None
    left_out: int

    @property
    def group_text(self) -> str:
        """The group in words; empty where there is only one."""
        return group_text(self.group)


def read_limits(texts: Sequence[str]) -> list[Limit]:
    """Limit states as they were asked for.

    Raises:
        InputError: One that is none, or asked for twice.
    """
    limits: list[Limit] = []
    for text in texts:
        name = text.strip().lower()
        limit = Limit(name)
        if name not in (UPLIFT, OVERTURNING):
            try:
                ratio = float(name)
            except ValueError:
                ratio = math.nan
            if not 0.0 < ratio < 100.0:
                allowed = (
                    f"must be {UPLIFT}, {OVERTURNING} or a peak rotation / slenderness angle above "
                    "0 and below 100"
                )
                raise InputError("--limit", "", text, allowed)
            limit = Limit(name, ratio)
        if limit in limits:
            raise InputError("--limit", "", text, "must be asked for once")
        limits.append(limit)
    return limits


def fragility_curves(
    table: pd.DataFrame,
    *,
    source: str,
    intensity: str = INTENSITY,
    limits: Sequence[Limit],
    by: Sequence[str] = (),
    samples: int = 1000,
    seed: int = 1,
) -> list[Curve]:
    """Fragility functions of every group and limit state.

    Args:
        table: Lane table.
        source: What errors name as its source.
        intensity: Column of the intensity measure.
        limits: Limit states.
        by: Columns that make groups of lanes: each combination of their values is one.
        samples: Bootstrap samples over the records.
        seed: Seed of the samples.

    Returns:
        The groups in the order of the table, each with its limit states in the order given.

    Raises:
        InputError: A column that the table does not have, an intensity that is not above zero, or
            a group without a lane that can be used.
    """
    require_lane_table(table, source, intensity, by)
    curves = []
    for group, rows in lane_groups(table, by):
        lanes = table.iloc[rows]
        usable = lanes[lanes["status"].isin([s.name.lower() for s in USABLE])]
        if usable.empty:
            text = group_text(group) or "all lanes"
            raise InputError(source, "status", text, "must have a lane whose numbers can be used")
        for limit in limits:
            seen = observe(
                usable[intensity].to_numpy(dtype=np.float64),
                _reached(usable, limit),
                record_numbers(usable),
            )
            fit = fit_lognormal(seen)
            enough = seen.cluster_count >= LEAST_RECORDS and math.isfinite(fit.median)
            drawn = bootstrap(seen, samples, seed) if enough and fit.dispersion > 0.0 else None
            curves.append(Curve(group, limit, seen, fit, drawn, len(lanes) - len(usable)))
    return curves


def _reached(lanes: pd.DataFrame, limit: Limit) -> npt.NDArray[np.bool_]:
    """Whether every lane reached a limit state, shape [lane]."""
    fell = np.asarray(lanes["outcome"].isin(["overturned", "slid_off"]), dtype=np.bool_)
    if limit.name == OVERTURNING:
        return np.asarray(lanes["outcome"] == "overturned", dtype=np.bool_)
    if limit.ratio is None:
        return np.asarray(np.isfinite(lanes["uplift_time_s"]) | fell, dtype=np.bool_)
    names = [str(name) for name in lanes.columns if PEAK_RATIO.match(str(name))]
    peak = lanes[names].to_numpy(dtype=np.float64).max(axis=1)
    return np.asarray((peak >= limit.ratio) | fell, dtype=np.bool_)


def curve_rows(curves: Sequence[Curve]) -> pd.DataFrame:
    """One row a curve: its group, what was counted, the fit and its band over records.

    Returns:
        The group's columns, then `limit_state`, `lanes`, `left_out`, `records`, `reached`,
        `verdict`, `median`, `dispersion` and their 5th and 95th percentiles, and for data that
        one intensity parts (or that all or none reached) `none_up_to` and `all_from`.
    """
    rows = []
    for curve in curves:
        rows.append(
            {
                **curve.group,
                "limit_state": curve.limit.name,
                "lanes": int(curve.seen.count.sum()),
                "left_out": curve.left_out,
                "records": curve.seen.cluster_count,
                "reached": int(curve.seen.reached.sum()),
                **fit_columns(curve.fit, curve.resampled),
            }
        )
    return pd.DataFrame(rows)


def component_rows(curves: Sequence[Curve], intensity: str) -> pd.DataFrame:
    """One row a group in the layout of component fragility tables after FEMA P-58.

    Limit states that have no lognormal function leave their cells empty and mark the row as
    incomplete. Theta_0 is the median in the unit of the intensity's column, Theta_1 the dispersion.
    """
    rows: dict[str, dict[str, object]] = {}
    for curve in curves:
        name = curve.group_text or "block"
        row = rows.setdefault(
            name, {"ID": name, "Incomplete": 0, "Demand-Type": intensity, "Demand-Offset": 0}
        )
        number = 1 + sum(1 for key in row if key.endswith("-Family"))
        fitted = bool(np.isfinite(curve.fit.median) and curve.fit.dispersion > 0.0)
        row["Incomplete"] = int(bool(row["Incomplete"]) or not fitted)
        row[f"LS{number}-Name"] = curve.limit.text
        row[f"LS{number}-Family"] = "lognormal" if fitted else ""
        row[f"LS{number}-Theta_0"] = curve.fit.median if fitted else np.nan
        row[f"LS{number}-Theta_1"] = curve.fit.dispersion if fitted else np.nan
    return pd.DataFrame(list(rows.values()))
