"""Lanes in groups and by record, and what a table says of the fit of a group."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.analysis.bands import LEAST_RECORDS, Band
from warprock.analysis.lognormal import Fit
from warprock.errors import InputError

RECORD = "record"
"""Column that says which lanes belong to one record."""
MOST_GROUPS = 1000
"""Groups at most; more is a column of numbers that no two lanes share."""


def group_text(group: Mapping[str, object]) -> str:
    """A group of lanes in words; empty where there is only one."""
    return ", ".join(f"{name} {value}" for name, value in group.items())


def lane_groups(
    table: pd.DataFrame, by: Sequence[str]
) -> list[tuple[dict[str, object], npt.NDArray[np.intp]]]:
    """Lanes with the same values of some columns, in the order of the table.

    Lanes without a value, such as the scale of a pulse, share that they have none.

    Args:
        table: One row a lane.
        by: Columns; none makes one group of all lanes.

    Returns:
        For each group its values by column, and the rows of its lanes in the table.

    Raises:
        InputError: There are too many groups.
    """
    if not by:
        return [({}, np.arange(len(table), dtype=np.intp))]
    grouped = table.groupby(list(by), sort=False, observed=True, dropna=False)
    numbers = grouped.ngroup().to_numpy()
    order = np.argsort(numbers, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(numbers[order])) + 1)
    if len(parts) > MOST_GROUPS:
        allowed = f"must make at most {MOST_GROUPS:,} groups, not {len(parts):,}"
        raise InputError("--by", "", ", ".join(by), allowed)
    parts.sort(key=lambda rows: int(rows[0]))
    return [({name: table[name].iloc[int(rows[0])] for name in by}, rows) for rows in parts]


def record_numbers(table: pd.DataFrame) -> npt.NDArray[np.intp]:
    """Number of the record of every lane; without the column each is a record of its own."""
    if RECORD not in table:
        return np.arange(len(table), dtype=np.intp)
    return np.asarray(pd.factorize(table[RECORD])[0], dtype=np.intp)


def fit_columns(fit: Fit, band: Band | None) -> dict[str, object]:
    """Columns of a fit: its verdict and numbers, their band over records, what parts the data.

    `band` says what is to be known of the band: that records are few, or why there is none.
    """
    bands = {
        f"{name}_{end}": value
        for name in ("median", "dispersion")
        for end, value in zip(
            ("p05", "p95"), band.interval(name) if band else (np.nan, np.nan), strict=True
        )
    }
    none = f"none: fewer than {LEAST_RECORDS} records" if fit.dispersion > 0.0 else "none: no fit"
    return {
        "verdict": fit.verdict.value,
        "median": fit.median,
        "dispersion": fit.dispersion,
        **bands,
        "band": none if band is None else band.text,
        "none_up_to": fit.low,
        "all_from": fit.high,
    }
