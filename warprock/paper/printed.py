"""The seed paper's printed tables, shipped as data in `cases/paper`."""

from __future__ import annotations

import importlib.resources

import pandas as pd

PAPER_TABLES = (
    *("table3", "table4", "table6", "table7"),
    *("table8", "table9", "table10", "table11", "table12"),
    "run-times",
)
PAPER_COLUMNS = ("analytical", "bullet", "vortex", "dem")
"""Columns of the paper's result tables; a row of ours calls them `paper-analytical` and so on."""

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


def paper_table(name: str) -> pd.DataFrame:
    """One table as printed, units in the column names; an empty cell is NaN.

    Args:
        name: One of `PAPER_TABLES`.
    """
    file = importlib.resources.files("warprock.cases") / "paper" / f"{name}.csv"
    with file.open(encoding="utf-8") as stream:
        return pd.read_csv(stream, comment="#")
