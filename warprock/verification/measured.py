"""Measured largest rotations and slides beside the predicted ones."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.analysis.scores import rank_correlation
from warprock.model.response import FIELDS, USABLE_NAMES
from warprock.verification.validation import Judged, Validation

Array = npt.NDArray[np.float64]

_BLOCK = re.compile(r"_[1-9]$")
"""End of the name of a quantity that belongs to one block of a stack."""
_STOOD = ["at_rest", "rocking"]


def unit_of(what: str) -> str:
    """Unit of a measured quantity, be it of one block of a stack: rad or m."""
    return FIELDS[_BLOCK.sub("", what)].unit


def predict_largest(engine: Judged, what: str, members: int) -> Array:
    """The predicted largest rotation [rad], slide or displacement [m] of each test, [test].

    It is the median over those lanes of the test that stood and have usable numbers; NaN without
    such a lane. Of a stack the largest of all blocks counts, unless the quantity names one.

    Args:
        engine: The engine.
        what: One of `MEASURED`, with the number of a block of a stack or without.
        members: Lanes of a test.
    """
    table = engine.table
    assert table is not None
    block = "" if _BLOCK.search(what) else "(_[1-9])?"
    pattern = re.compile(rf"{what}{block}_{unit_of(what)}")
    columns = [name for name in map(str, table.columns) if pattern.fullmatch(name)]
    values = table[columns].to_numpy(dtype=np.float64).max(axis=1)
    stood = (table["outcome"].isin(_STOOD) & table["status"].isin(USABLE_NAMES)).to_numpy()
    values = np.where(stood, values, np.nan).reshape(-1, members)[engine.tests]
    found = np.full(len(values), np.nan)
    there = np.isfinite(values).any(axis=1)
    found[there] = np.nanmedian(values[there], axis=1)
    return found


def measured_rows(found: Validation) -> Iterator[dict[str, Any]]:
    """How far predictions are from what was measured, of tests that stood in both.

    Yields:
        A row an engine and quantity: `engine`, `what`, `unit`, `tests`, `median_difference`
        (predicted less measured), `median_error` (without its sign) and `rank_correlation`
        (Spearman's).
    """
    members = found.tests.lanes.shape[1]
    for what in measured_quantities(found):
        theirs = np.where(found.tests.overturned, np.nan, found.tests.measured[what])
        for engine in found.engines:
            ours, own = predict_largest(engine, what, members), theirs[engine.tests]
            both = np.isfinite(ours) & np.isfinite(own)
            a, b = ours[both], own[both]
            yield {
                "engine": engine.name,
                "what": what,
                "unit": unit_of(what),
                "tests": len(a),
                "median_difference": float(np.median(a - b)) if len(a) else np.nan,
                "median_error": float(np.median(np.abs(a - b))) if len(a) else np.nan,
                "rank_correlation": rank_correlation(a, b),
            }


def measured_quantities(found: Validation) -> list[str]:
    """Measured quantities, in the order of the table."""
    return [what for what, each in found.tests.measured.items() if np.isfinite(each).any()]
