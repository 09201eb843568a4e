"""The seed paper's printed tables, shipped as data in `cases/paper`."""

from __future__ import annotations

import csv
import importlib.resources
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.case.columns import Columns

if TYPE_CHECKING:
    import pandas as pd

PAPER_TABLES = (
    *("table3", "table4", "table6", "table7"),
    *("table8", "table9", "table10", "table11", "table12"),
    "run-times",
)
PAPER_COLUMNS = ("analytical", "bullet", "vortex", "dem")
"""Columns of the paper's result tables; a row of ours calls them `paper-analytical` and so on."""

GEOMETRIES = ("printed", "low-top")
"""Geometries of the paper's stack that the ensembles run."""
BLOCKS = ("bottom", "top")
"""Blocks of the paper's stack as it names them, the lowest first."""
REFERENCE_DEGREES = 9.85
"""Angle that the paper divides the rotations of its stack by, as printed [deg]."""

INFERRED_NAMES = (
    "test, inferred from Table 7's analytical errors",
    "test, inferred from Table 7's Bullet errors",
)
"""The two routes from Table 7's errors to the maxima of the test, in the order of the code."""
PAPER_NAMES = {"analytical": "analytical", "bullet": "Bullet", "vortex": "Vortex", "dem": "DEM"}
"""Those columns as the reader knows them."""
READING_NAMES = {
    "displacement": "displacement drive",
    "acceleration": "acceleration drive, true size",
    "double-size": "acceleration drive, a block of twice the size: full sizes taken for half sizes",
}
"""Readings of what the paper did, as the reader is told of them."""


def paper_columns(name: str) -> Columns:
    """One table as printed, units in the names of columns; an empty cell of numbers is NaN.

    Args:
        name: One of `PAPER_TABLES`.
    """
    file = importlib.resources.files("warprock.cases") / "paper" / f"{name}.csv"
    lines = [line for line in file.read_text(encoding="utf-8").splitlines() if line[:1] != "#"]
    rows = list(csv.DictReader(lines))
    return Columns({key: _numbers([row[key] for row in rows]) for key in rows[0]})


def paper_table(name: str) -> pd.DataFrame:
    """One table as printed, as a DataFrame; see `paper_columns`."""
    return paper_columns(name).frame


def _numbers(texts: list[str]) -> npt.NDArray[Any] | list[str]:
    """Texts as whole numbers, else as numbers where all are some or empty, else as they are."""
    for kind in (np.int64, np.float64):
        try:
            return np.array([text or "nan" for text in texts]).astype(kind)
        except ValueError:
            continue
    return texts


def as_number(text: object) -> float:
    """What a cell says, NaN where it is a word."""
    try:
        return float(str(text))
    except ValueError:
        return float("nan")
