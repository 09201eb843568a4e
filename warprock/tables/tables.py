"""Tables on the terminal: what was reproduced, checked and compared."""

from __future__ import annotations

import pathlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.measure import Measurement
from rich.table import Table

Row = Mapping[str, Any]
Input = tuple[float, float]
"""Frequency [Hz] and amplitude [mm]."""
_Column = Callable[[Input, str], str]

MISSING = "-"


def stdout() -> Console:
    """The terminal; where there is none, wide enough for every table here."""
    console = Console()
    return console if console.is_terminal else Console(width=130)


def number(value: object, form: str) -> str:
    """A value in a format, or a dash where there is none."""
    return MISSING if value is None or value != value else format(value, form)


def print_written(files: Iterable[pathlib.Path | str], console: Console | None = None) -> None:
    """Says which files were written.

    Args:
        files: The files.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    for file in files:
        out.print(f"wrote {file}", markup=False, highlight=False, soft_wrap=True)


def plain_table(title: str, headings: Iterable[str], left: Iterable[str] = ()) -> Table:
    """An empty table; the columns in `left` are to the left and may wrap, the others may not."""
    table = Table(
        title=title,
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE_HEAD,
        padding=0,
        pad_edge=False,
    )
    for heading in headings:
        wraps = heading in left
        table.add_column(escape(heading), justify="left" if wraps else "right", no_wrap=not wraps)
    return table


def print_table(out: Console, table: Table) -> None:
    """Prints a table without cutting a word or a number.

    One that needs more room than the terminal has is wider: the terminal breaks its lines.
    """
    options, width = out.options.update(width=1000), out.width
    needed = len(table.columns) + 1
    for column in table.columns:
        sizes = [Measurement.get(out, options, cell) for cell in (column.header, *column.cells)]
        needed += max(size.maximum if column.no_wrap else size.minimum for size in sizes)
    out.width = max(width, needed)
    try:
        out.print(table)
    finally:
        out.width = width
