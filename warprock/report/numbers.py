"""Numbers as a reader wants them: three digits, with a unit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd

from warprock.report.content import Heading, Sheet

MISSING = "-"
ROWS = 200
"""Rows of a table that a page shows; files hold all of them."""


def three(value: Any) -> str:
    """A number with three digits; counts and words as they are, a dash where there is nothing.

    >>> three(0.12345), three(123456), three(1299790.0), three(3.2e-7), three(float("nan"))
    ('0.123', '123,456', '1.30e6', '3.20e-7', '-')
    """
    if value is None or value is pd.NA or value is pd.NaT:
        return MISSING
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (int, np.integer)):
        return f"{value:,}"
    return _three(float(value)) if isinstance(value, (float, np.floating)) else str(value)


def _three(value: float) -> str:
    if math.isnan(value):
        return MISSING
    if math.isinf(value):
        return "infinite" if value > 0 else "-infinite"
    size = abs(value)
    if value == round(value) and size < 1e4:
        return f"{value:.0f}"
    if 1e-3 <= size < 9.995e4:
        digits = max(0, 2 - math.floor(math.log10(size) + 1e-9))
        return f"{value:,.{digits}f}"
    mantissa, exponent = f"{value:.2e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def counted(count: int, thing: str, plural: str = "") -> str:
    """A count and what is counted.

    >>> counted(1, "lane"), counted(2000, "lane")
    ('1 lane', '2,000 lanes')
    """
    return f"{count:,} {thing if count == 1 else plural or thing + 's'}"


def listed(texts: list[str]) -> str:
    """Texts in one sentence.

    >>> listed(["a"]), listed(["a", "b", "c"])
    ('a', 'a, b and c')
    """
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"


_UNITS = {
    "_rad": "rad",
    "_rad_s": "rad/s",
    "_m_s2": "m/s²",
    "_m_s": "m/s",
    "_kg_m3": "kg/m³",
    "_deg": "deg",
    "_hz": "Hz",
    "_mm": "mm",
    "_m": "m",
    "_s": "s",
    "_j": "J",
    "_J": "J",
    "_pct": "%",
}
"""Endings of column names that are units."""


def heading(name: str, meaning: str = "", unit: str = "") -> Heading:
    """A column as a reader knows it, of its name in a file: `peak_time_s` is `peak time [s]`."""
    for axis in "yz":
        if name.endswith(f"_{axis}") and name.removesuffix(f"_{axis}").endswith(tuple(_UNITS)):
            along = heading(name.removesuffix(f"_{axis}"), meaning)
            return Heading(f"{along.text} along {axis}", along.unit, meaning)
    for ending in sorted(_UNITS, key=len, reverse=True):
        if name.endswith(ending) and len(name) > len(ending):
            return Heading(name.removesuffix(ending).replace("_", " "), _UNITS[ending], meaning)
    known = unit.replace("^2", "²").replace("^3", "³")
    return Heading(name.replace("_", " "), "" if known == "-" else known, meaning)


def sheet_of(
    title: str,
    table: pd.DataFrame,
    meanings: dict[str, dict[str, str]] | None = None,
    *,
    note: str = "",
    file: str = "",
    folded: bool = False,
) -> Sheet:
    """A table of a page from a table of a file, its first rows where it is long.

    Args:
        title: What its rows are.
        table: The rows; those of lanes have a column `lane`.
        meanings: Unit and text of columns, by name.
        note: What marks mean.
        file: Where all rows are.
        folded: Whether the reader has to open it.
    """
    known = meanings or {}
    columns = [str(name) for name in table.columns]
    headings = [
        heading(name, known.get(name, {}).get("text", ""), known.get(name, {}).get("unit", ""))
        for name in columns
    ]
    shown = table.head(ROWS)
    values = [shown[name].tolist() for name in columns]
    rows = [[three(value) for value in row] for row in zip(*values, strict=True)]
    if len(shown) < len(table):
        where = f"; all are in {file}" if file else ""
        note = f"{note} The first {len(shown):,} of {len(table):,} rows{where}.".strip()
    lanes = [int(lane) for lane in shown["lane"]] if "lane" in columns else []
    return Sheet(title, headings, rows, note, lanes, folded)
