"""What every command prints with: JSON, tables, the files that it wrote, and its progress.

Results go to stdout, progress to stderr. There are two kinds of tables: `plain_table` has
chosen columns and headings, `print_rows` prints rows as they are, a column a key.
"""

from __future__ import annotations

import contextlib
import json
import math
import pathlib
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.cells import cell_len
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from warprock.findings.numbers import MISSING, three
from warprock.findings.plain import plain
from warprock.findings.sheets import heading

if TYPE_CHECKING:
    import rich.progress

Row = Mapping[str, Any]

WIDTH = 200
"""Columns of rows that are printed into a file or a pipe."""


def plain_console(**more: Any) -> Console:
    """A terminal that prints text as it is: brackets and colons of a name are no markup of Rich.

    Args:
        more: What else Rich is to know of it.
    """
    return Console(markup=False, emoji=False, **more)


def stdout() -> Console:
    """The terminal; where there is none, wide enough for every table here."""
    console = plain_console()
    return console if console.is_terminal else plain_console(width=130)


def number(value: object, form: str) -> str:
    """A value in a format, or a dash where there is none."""
    return MISSING if value is None or value != value else format(value, form)


def print_end(came_out: str, command: str, console: Console | None = None) -> None:
    """Says at the end of a command what came out, in one sentence, and what to try next.

    Args:
        came_out: The sentence.
        command: The command, as it is typed; empty where nothing follows.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    say(out, came_out)
    if command:
        out.print(f"next: {command}", highlight=False, soft_wrap=True)


def say(out: Console, text: str, style: str | None = None) -> None:
    """Prints a sentence, which a terminal breaks between words and a pipe not at all."""
    out.print(text, style=style, highlight=False, soft_wrap=not out.is_terminal)


def print_written(files: Iterable[pathlib.Path | str], console: Console | None = None) -> None:
    """Says which files were written.

    Args:
        files: The files.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    for file in files:
        out.print(f"wrote {file}", highlight=False, soft_wrap=True)


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
    for name in headings:
        wraps = name in left
        table.add_column(name, justify="left" if wraps else "right", no_wrap=not wraps)
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


def print_json(found: Mapping[str, Any]) -> None:
    """Prints one JSON object on stdout."""
    sys.stdout.write(json.dumps(plain(found), indent=2, allow_nan=False, ensure_ascii=False) + "\n")


def progress_text(form: str = "{task.description}") -> rich.progress.TextColumn:
    """A column of a progress bar that shows a text as it is.

    Args:
        form: What of the task it shows.
    """
    import rich.progress

    return rich.progress.TextColumn(form, markup=False)


@contextlib.contextmanager
def lane_progress(text: str, total: int | None) -> Iterator[Callable[[int], None]]:
    """A progress bar on stderr while the block runs; nothing where stderr is no terminal.

    Args:
        text: What is running.
        total: Number of lanes; None if it is not known.

    Yields:
        A function to call with the number of lanes finished so far.
    """
    console = plain_console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    import rich.progress

    columns = (
        progress_text(),
        rich.progress.BarColumn(),
        rich.progress.MofNCompleteColumn(),
        rich.progress.TimeElapsedColumn(),
    )
    with rich.progress.Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(text, total=total)
        yield lambda done: bar.update(task, completed=done)


def wide_stdout() -> Console:
    """The terminal, without colours of numbers; where there is none, wide enough for most rows."""
    # Without a terminal there is no width to fit into.
    width = None if sys.stdout.isatty() else WIDTH
    return plain_console(width=width, highlight=False)


def print_rows(title: str, rows: Sequence[Mapping[Any, Any]]) -> None:
    """Prints rows as a table whose columns are their keys, numbers to three digits.

    Headings break between words; a table that is wider than the terminal is printed in parts, each
    with the first column.
    """
    out = wide_stdout()
    names = list(dict.fromkeys(str(name) for row in rows for name in row))
    cells = {name: [_row_text(row.get(name)) for row in rows] for name in names}
    for number, part in enumerate(_parts(names, cells, out.width)):
        table = Table(box=None, pad_edge=False)
        if number == 0:
            table.title, table.title_justify = title, "left"
        shown = {name: cells[name] for name in part}
        widths = _column_widths(part, shown, out.width - _gaps(part))
        for name, width in zip(part, widths, strict=True):
            table.add_column(Text(heading(name).label), width=width)
        for row in zip(*shown.values(), strict=True):
            table.add_row(*map(Text, row))
        before, out.width = out.width, max(out.width, sum(widths) + _gaps(part))
        out.print(table)
        out.width = before


def _gaps(names: Sequence[str]) -> int:
    return 2 * (len(names) - 1)


def _parts(
    names: Sequence[str], cells: Mapping[str, Sequence[str]], room: int
) -> Iterator[list[str]]:
    """The columns of each part of a table: as many as the terminal has room for."""
    part: list[str] = []
    for name in names:
        longer = [*part, name]
        if len(part) > 1 and sum(_least_widths(longer, cells)) + _gaps(longer) > room:
            yield part
            part = [names[0], name]
        else:
            part = longer
    yield part


def _least_widths(names: Sequence[str], cells: Mapping[str, Sequence[str]]) -> list[int]:
    """Characters that the longest word of each column takes, its heading included."""
    return [
        max(cell_len(word) for text in (heading(name).label, *cells[name]) for word in _words(text))
        for name in names
    ]


def _words(text: str) -> list[str]:
    return text.split() or [""]


def _column_widths(
    names: Sequence[str], cells: Mapping[str, Sequence[str]], room: int
) -> list[int]:
    """Characters of each column, the widest folded first, no word cut."""
    needed = _least_widths(names, cells)
    wanted = [max(cell_len(text) for text in (heading(n).label, *cells[n])) for n in names]
    found = wanted
    for most in range(max(wanted, default=0), 0, -1):
        found = [max(least, min(full, most)) for least, full in zip(needed, wanted, strict=True)]
        if sum(found) <= room:
            break
    return found


def _row_text(value: Any) -> str:
    """A value as `print_rows` shows it."""
    if isinstance(value, (float, np.floating)):
        return three(value)
    if isinstance(value, int) and not isinstance(value, bool):
        return f"{value:,}"
    return cell_text(value)


def cell_text(value: Any) -> str:
    """A value as it was given: an input, a setting."""
    if value is None:
        return "-"
    if isinstance(value, (float, np.floating)):
        return "-" if math.isnan(value) else f"{value:.6g}"
    return str(value)
