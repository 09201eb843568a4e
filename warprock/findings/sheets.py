"""Tables to read: headings with units, and cells as text, for a terminal and for a page."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from warprock.case.columns import Table
from warprock.findings.numbers import three
from warprock.units import split_unit

if TYPE_CHECKING:
    import pandas as pd

ROWS = 200
"""Rows of a table that a page shows; files hold all of them."""

_NUMBER = re.compile(r"|-|[-+]?[\d,.]+(?:e-?\d+)?[%*]?|-?infinite")
"""A cell that is a number, or has none."""


@dataclasses.dataclass(frozen=True)
class Heading:
    """A column of a table.

    Attributes:
        text: Its name as a reader knows it.
        unit: Its unit; empty where it has none.
        meaning: What it says, in one sentence; empty where the name says all.
    """

    text: str
    unit: str = ""
    meaning: str = ""

    @property
    def label(self) -> str:
        """Its name with the unit in brackets: `peak time [s]`."""
        return f"{self.text} [{self.unit}]" if self.unit else self.text


@dataclasses.dataclass(frozen=True)
class Sheet:
    """A table.

    Attributes:
        title: What its rows are.
        headings: Its columns.
        rows: Texts of the cells, a row each.
        note: What is left out, or what marks mean; empty where there is nothing to say.
        lanes: Number of the lane of every row, where rows are lanes; empty otherwise.
        folded: Whether the reader has to open it.
    """

    title: str
    headings: Sequence[Heading]
    rows: Sequence[Sequence[str]]
    note: str = ""
    lanes: Sequence[int] = ()
    folded: bool = False

    @property
    def texts(self) -> list[bool]:
        """Whether each column holds words, which stand to the left."""
        columns = zip(*self.rows, strict=True) if self.rows else ([""] for _ in self.headings)
        return [not all(_NUMBER.fullmatch(cell) for cell in column) for column in columns]


def heading(name: str, meaning: str = "", unit: str = "") -> Heading:
    """A column as a reader knows it, of its name in a file: `peak_time_s` is `peak time [s]`."""
    stem, known = split_unit(name)
    along = name[-2:] if name[-2:] in ("_y", "_z") else ""
    if along and split_unit(name.removesuffix(along))[1]:
        (stem, known), along = split_unit(name.removesuffix(along)), f" along {along[1]}"
    else:
        along = ""
    unit = (known or unit).replace("^2", "²").replace("^3", "³")
    return Heading(stem.replace("_", " ") + along, "" if unit == "-" else unit, meaning)


def declared(table: pd.DataFrame, columns: Mapping[str, tuple[str, str]]) -> pd.DataFrame:
    """The table itself, whose columns now have these units and meanings, by name."""
    named = {name: {"unit": unit, "text": text} for name, (unit, text) in columns.items()}
    table.attrs["columns"] = table.attrs.get("columns", {}) | named
    return table


def sheet_of(
    title: str,
    table: Table,
    *,
    note: str = "",
    file: str = "",
    folded: bool = False,
) -> Sheet:
    """A table of a page from a table of a file, its first rows where it is long.

    Args:
        title: What its rows are.
        table: The rows; those of lanes have a column `lane`. `attrs["columns"]`, where it is
            there, holds the unit and the meaning of columns.
        note: What marks mean.
        file: Where all rows are.
        folded: Whether the reader has to open it.
    """
    known = table.attrs.get("columns", {})
    columns = [str(name) for name in table]
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
