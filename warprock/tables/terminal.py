"""What every command prints with: JSON, tables, the files that it wrote, and its progress.

Results go to stdout, progress to stderr. There are two kinds of tables: `plain_table` has
chosen columns and headings, `print_rows` prints rows as they are, a column a key.
"""

from __future__ import annotations

import contextlib
import enum
import json
import math
import pathlib
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import rich.progress
from rich import box
from rich.cells import cell_len
from rich.console import Console
from rich.markup import escape
from rich.measure import Measurement
from rich.table import Table

Row = Mapping[str, Any]

WIDTH = 200
"""Columns of rows that are printed into a file or a pipe."""

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


def plain(value: Any) -> Any:
    """The same value from types that JSON has; NaN and infinities become null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, set, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, (enum.Enum, pathlib.PurePath)):
        return str(value)
    return value


def print_json(found: Mapping[str, Any]) -> None:
    """Prints one JSON object on stdout."""
    sys.stdout.write(json.dumps(plain(found), indent=2, allow_nan=False, ensure_ascii=False) + "\n")


@contextlib.contextmanager
def lane_progress(text: str, total: int | None) -> Iterator[Callable[[int], None]]:
    """A progress bar on stderr while the block runs; nothing where stderr is no terminal.

    Args:
        text: What is running.
        total: Number of lanes; None if it is not known.

    Yields:
        A function to call with the number of lanes finished so far.
    """
    console = Console(stderr=True)
    columns = (
        rich.progress.TextColumn("{task.description}"),
        rich.progress.BarColumn(),
        rich.progress.MofNCompleteColumn(),
        rich.progress.TimeElapsedColumn(),
    )
    bar = rich.progress.Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    )
    with bar:
        task = bar.add_task(text, total=total)
        yield lambda done: bar.update(task, completed=done)


def wide_stdout() -> Console:
    """The terminal, without colours of numbers; where there is none, wide enough for most rows."""
    # Without a terminal there is no width to fit into.
    width = None if sys.stdout.isatty() else WIDTH
    return Console(width=width, highlight=False, markup=False)


def print_rows(title: str, rows: Sequence[Mapping[Any, Any]]) -> None:
    """Prints rows as a table whose columns are their keys."""
    out = wide_stdout()
    names = list(dict.fromkeys(str(name) for row in rows for name in row))
    cells = [[cell_text(row.get(name)) for name in names] for row in rows]
    gaps = 2 * (len(names) - 1)
    widths = _column_widths(names, cells, out.width - gaps)
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    for name, width in zip(names, widths, strict=True):
        table.add_column(name, overflow="fold", width=width)
    for row in cells:
        table.add_row(*row)
    out.width = max(out.width, sum(widths) + gaps)
    out.print(table)


def _column_widths(names: Sequence[str], cells: Sequence[Sequence[str]], room: int) -> list[int]:
    """Characters of each column: headings are folded to fit, no word and no number of a cell."""
    columns = list(zip(*cells, strict=True))
    needed = [
        max(cell_len(part) for cell in column for part in ("", *cell.split())) for column in columns
    ]
    wanted = [
        max(cell_len(text) for text in (name, *column))
        for name, column in zip(names, columns, strict=True)
    ]
    found = wanted
    for most in range(max(wanted, default=0), 0, -1):
        found = [max(least, min(full, most)) for least, full in zip(needed, wanted, strict=True)]
        if sum(found) <= room:
            break
    return found


def cell_text(value: Any) -> str:
    """A value as `print_rows` shows it."""
    if value is None:
        return "-"
    if isinstance(value, (float, np.floating)):
        return "-" if math.isnan(value) else f"{value:.6g}"
    return str(value)
