"""Lanes in groups and by record, and what a table says of the fit of a group."""

from __future__ import annotations

import io
import pathlib
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.analysis.bands import LEAST_RECORDS, Band, Estimate
from warprock.analysis.lognormal import Fit
from warprock.errors import NOTHING, InputError, Said, list_allowed
from warprock.reading import read_bytes, reason

RECORD = "record"
"""Column that says which lanes belong to one record."""
WEIGHT = "weight"
"""Column of weights of records."""
LABEL_WEIGHT = f"label.{WEIGHT}"
"""The same in a table of a sweep, where it becomes a column of the lane table."""
MOST_WEIGHTS = 2**24
"""Bytes of a file of weights at most."""
Weights = Mapping[str, float] | str
"""Weights by record, or the column of a lane table that has them."""
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


def record_weights(
    table: pd.DataFrame, weights: Weights | None, source: str
) -> npt.NDArray[np.float64] | None:
    """Weights of the records of some lanes, in the order of `record_numbers`, shape [record].

    Args:
        table: The lanes.
        weights: Weights by record, or the column that has them; None where all weigh the same.
        source: What errors name as the source of the table.

    Raises:
        InputError: Lanes without a record, or a record without a weight.
    """
    if weights is None:
        return None
    if RECORD not in table:
        raise InputError(source, RECORD, NOTHING, "must be a column: weights are of records")
    numbers, names = pd.factorize(table[RECORD].astype(str))
    if isinstance(weights, str):
        return _weights_of_column(table, weights, source, numbers)
    found = [weight_of(str(name), weights) for name in names]
    for name, weight in zip(map(str, names), found, strict=True):
        if weight is None:
            known = list_allowed(name, weights)
            raise InputError(source, RECORD, name, f"must have a weight; these have one: {known}")
    return np.array(found, dtype=np.float64)


def _weights_of_column(
    table: pd.DataFrame, column: str, source: str, numbers: npt.NDArray[np.intp]
) -> npt.NDArray[np.float64]:
    """Weights of records, of a column in which all lanes of a record have the same."""
    if column not in table:
        known = list_allowed(column, map(str, table.select_dtypes("number").columns))
        allowed = f"must be a CSV file, or a column of {source}: {known}"
        raise InputError("--weights", "", column, allowed)
    values = pd.to_numeric(table[column], errors="coerce").to_numpy(dtype=np.float64)
    good = np.isfinite(values) & (values > 0.0)
    if not good.all():
        row = int(np.argmin(good))
        got = table[column].tolist()[row]
        raise InputError(source, column, got, f"must be finite and > 0 in every lane (row {row})")
    found = values[np.unique(numbers, return_index=True)[1]]
    same = values == found[numbers]
    if not same.all():
        row = int(np.argmin(same))
        allowed = f"must be the same in all lanes of a record (row {row})"
        raise InputError(source, column, float(values[row]), allowed)
    return np.asarray(found)


def read_weights(path: pathlib.Path) -> dict[str, float]:
    """Weights of records, of a CSV file with a column of records and one of weights.

    Records are names of records, or of their files.

    Raises:
        InputError: It cannot be read, or a weight is not above 0.
    """
    allowed = "must be a CSV file with the columns record and weight"
    try:
        table = pd.read_csv(io.BytesIO(read_bytes(path, MOST_WEIGHTS)), dtype=str)
    except OSError as error:
        raise InputError("--weights", "", str(path), f"{allowed} ({reason(error)})") from None
    except ValueError as error:
        raise InputError("--weights", "", str(path), f"{allowed} ({error})") from None
    table = table.rename(columns={LABEL_WEIGHT: WEIGHT})
    for name in (RECORD, WEIGHT):
        if name not in table:
            raise InputError(str(path), name, NOTHING, allowed)
    found: dict[str, float] = {}
    for row, (text, weight) in enumerate(zip(table[RECORD], table[WEIGHT], strict=True), start=1):
        number = pd.to_numeric(weight, errors="coerce")
        if not (np.isfinite(number) and number > 0.0):
            raise InputError(str(path), WEIGHT, weight, f"must be finite and > 0 (row {row})")
        if str(text) in found:
            raise InputError(str(path), RECORD, text, f"must be there once (row {row})")
        found[str(text)] = float(number)
    if not found:
        raise InputError(str(path), RECORD, Said("0 rows"), "must have at least one record")
    return found


def weight_of(name: str, weights: Mapping[str, float]) -> float | None:
    """The weight of a record, by its name or by that of its file; None where it has none.

    Args:
        name: The record, or the path of its file.
        weights: Weights by the one or the other.
    """
    if name in weights:
        return weights[name]
    stem = pathlib.PurePath(name).stem
    known = [key for key in weights if stem in (key, pathlib.PurePath(key).stem)]
    return weights[known[0]] if len(known) == 1 else None


def fit_columns(fit: Fit, band: Band | None, errors: Estimate | None = None) -> dict[str, object]:
    """Columns of a fit: its verdict and numbers, their band over records, what parts the data.

    `band` says what is to be known of the band: that records are few, or why there is none. With
    the errors of the fit alone it has columns of their band, `_fit_p05` and `_fit_p95`.
    """
    bands = {
        f"{name}_{end}": value
        for name in ("median", "dispersion")
        for end, value in zip(
            ("p05", "p95"), band.interval(name) if band else (np.nan, np.nan), strict=True
        )
    }
    if errors is not None:
        ends = {
            "median": errors.following(lambda median, _: median),
            "dispersion": errors.following(lambda _, dispersion: dispersion),
        }
        for name, (low, high) in ends.items():
            bands |= {f"{name}_fit_p05": low, f"{name}_fit_p95": high}
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
