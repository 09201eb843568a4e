"""What programs that we did not write took for a comparison, on the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from warprock.findings.digits import number_of, short_heading, value_of
from warprock.tables.terminal import plain_table, print_table, stdout

COLUMNS = ("steps_per_s", "cpu_s", "cpu_s_per_simulated_s")
"""Columns of numbers of what programs took."""


def print_costs(found: Mapping[str, Any], console: Console | None = None) -> None:
    """Prints the costs that `verification.checks.compare` found; nothing where no program ran.

    Args:
        found: Its return value.
        console: Where to; the terminal if not given.
    """
    rows = found["costs"]
    if not rows:
        return
    headings = ["program", *map(short_heading, COLUMNS), "settings"]
    table = plain_table("What the programs' steps took", headings, ("program", "settings"))
    for row in rows:
        knobs = {k: v for k, v in row["settings"].items() if k != "steps_per_second"}
        table.add_row(
            row["engine"],
            *(value_of(row, name) for name in COLUMNS),
            ", ".join(f"{name} = {number_of('value', value)}" for name, value in knobs.items()),
        )
    print_table(console or stdout(), table)
