"""Tables of checks, and of engines against Housner."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.text import Text

from warprock.findings.digits import cell_of, number_of, short_heading, value_of
from warprock.findings.numbers import MISSING
from warprock.verification.housner import NEEDS, SLIDE_BOUND

if TYPE_CHECKING:
    from warprock.verification.checks import CheckRow

from warprock.tables.terminal import (
    Row,
    number,
    plain_table,
    print_end,
    print_table,
    say,
    stdout,
)

COMPARED_COLUMNS = (
    *("error_5s_ratio", "error_run_ratio", "peak_error", "rest_time_error_s"),
    "peak_slide_mm",
)
"""Columns of numbers of a comparison with Housner."""


HOLDS = "Housner\nholds?"


SLIDES = f"slides by more than {SLIDE_BOUND} of its width"


DIFFERENCE = "  * largest |rotation - Housner's| / slenderness angle"


def reasons(why: str) -> list[str]:
    """Why Housner does not hold, clause by clause, without the numbers of one lane."""
    return [
        SLIDES if clause.startswith("slides") else NEEDS if clause.startswith(NEEDS) else clause
        for clause in why.split("; ")
    ]


class Reasons:
    """Letters for the reasons why Housner does not hold, so that a table stays narrow."""

    def __init__(self) -> None:
        self._letters: dict[str, str] = {}

    def cell(self, row: Row) -> str:
        """`yes`, or `no` with the letters of the reasons."""
        if row["holds"]:
            return "yes"
        clauses = reasons(row["why"])
        for clause in clauses:
            self._letters.setdefault(clause, chr(ord("a") + len(self._letters)))
        return "no: " + ", ".join(self._letters[clause] for clause in clauses)

    def print(self, out: Console) -> None:
        """The reasons behind the letters."""
        out.print(DIFFERENCE, highlight=False)
        for clause, letter in self._letters.items():
            out.print(f"  {letter}: {clause}", highlight=False)
        out.print()


def print_checks(rows: Sequence[CheckRow], console: Console | None = None) -> None:
    """Prints the rows of `verification.checks.run_checks`, and what failed with its reason.

    Args:
        rows: The rows.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    left = ("case", "check", "engine", "lanes", "")
    table = plain_table(
        "Checks", ["case", "check", "engine", "lanes", "outside\nmodel", "value", "limit", ""], left
    )
    for row in rows:
        verdict = Text("ok", "green") if row.ok else Text("FAILED", "bold red")
        table.add_row(
            row.case,
            row.name,
            row.engine,
            row.lanes,
            MISSING if row.outside is None else str(row.outside),
            number(row.value, ".2e"),
            number(row.limit, ".2e"),
            verdict,
        )
    print_table(out, table)
    for row in rows:
        if not row.ok or "left out" in row.note:
            out.print(f"\n{row.case}, {row.engine}, {row.lanes}: {row.note}")
            out.print(f"because: {' '.join(row.because.split())}")
    failed = sum(not row.ok for row in rows)
    out.print()
    what = f"{rows[0].case}" if len({row.case for row in rows}) == 1 else "free-b0"
    print_end(
        f"{len(rows) - failed} passed, {failed} failed.",
        f"warprock compare {what} -e event -e impulse",
        out,
    )


def print_comparison(found: Mapping[str, Any], console: Console | None = None) -> None:
    """Prints what `verification.checks.compare` returned, lane by lane, engines under each other.

    Args:
        found: Its return value.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    table = plain_table(
        f"{found['case']}: engines against Housner",
        [
            *("lane", "engine", short_heading("peak_rotation_ratio"), "outcome"),
            *map(short_heading, (*COMPARED_COLUMNS, "friction_needed")),
            HOLDS,
        ],
        ("lane", "engine", "outcome", HOLDS),
    )
    rows: Sequence[Row] = found["rows"]
    letters = Reasons()
    for lane in dict.fromkeys(row["lane"] for row in rows):
        for index, row in enumerate(row for row in rows if row["lane"] == lane):
            table.add_row(
                lane if index == 0 else "",
                row["engine"],
                value_of(row, "peak_rotation_ratio"),
                row["outcome"],
                *(cell_of(name, row[name]) for name in (*COMPARED_COLUMNS, "friction_needed")),
                letters.cell(row),
            )
    if len(rows) <= ROWS_SHOWN:
        print_table(out, table)
        letters.print(out)
    _print_engines(out, found, count=len(rows))


ROWS_SHOWN = 24
"""Rows of lanes and engines that are printed; of more, what they come to."""


def _print_engines(out: Console, found: Mapping[str, Any], count: int) -> None:
    """What a comparison comes to, an engine a row, and in one sentence."""
    headings = ["engine", "lanes", "diff.*\nmedian", "diff.*\nlargest", "peak error\nlargest"]
    table = plain_table(f"{found['case']}: lanes in which Housner holds", headings, ["engine"])
    for engine in dict.fromkeys(row["engine"] for row in found["rows"]):
        mine = [r for r in found["rows"] if r["engine"] == engine and r["holds"]]
        off = [r["error_run_ratio"] for r in mine if r["error_run_ratio"] is not None]
        peaks = [abs(r["peak_error"]) for r in mine if r["peak_error"] is not None]
        table.add_row(
            engine,
            str(len(mine)),
            number_of("error_run_ratio", statistics.median(off) if off else None),
            number_of("error_run_ratio", max(off, default=None)),
            cell_of("peak_error", max(peaks, default=None)).removeprefix("+"),
        )
    print_table(out, table)
    out.print(DIFFERENCE, highlight=False)
    if count > ROWS_SHOWN:
        say(out, f"  all {count:,} rows, lane by lane: --json, or -o DIR")
