"""What programs that we did not write took for a comparison, on the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from warprock.tables.terminal import number, plain_table, print_table, stdout


def print_costs(found: Mapping[str, Any], console: Console | None = None) -> None:
    """Prints the costs that `verification.checks.compare` found; nothing where no program ran.

    Args:
        found: Its return value.
        console: Where to; the terminal if not given.
    """
    rows = found["costs"]
    if not rows:
        return
    headings = ["program", "steps\n[1/s]", "CPU\n[s]", "CPU s for 1 s\nof one block", "settings"]
    table = plain_table("What the programs' steps took", headings, ("program", "settings"))
    for row in rows:
        knobs = {k: v for k, v in row["settings"].items() if k != "steps_per_second"}
        table.add_row(
            row["engine"],
            number(row["steps_per_s"], ".0f"),
            number(row["cpu_s"], ".3g"),
            number(row["cpu_s_per_simulated_s"], ".3g"),
            ", ".join(f"{name} = {value:g}" for name, value in knobs.items()),
        )
    print_table(console or stdout(), table)
