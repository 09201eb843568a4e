"""Tables on the terminal for engines beside poses that were observed."""

from __future__ import annotations

import statistics
from collections.abc import Mapping
from typing import Any

from rich.console import Console

from warprock.findings.digits import number_of, quantity_of, short_heading
from warprock.tables.terminal import plain_table, print_end, print_table, stdout

COLUMNS = (
    *("position_error_mm", "rotation_error_deg"),
    *("position_error_at_end_mm", "rotation_error_at_end_deg"),
)
"""Columns of a comparison with observed poses: means and medians of lanes."""


def print_pose_comparison(found: Mapping[str, Any], console: Console | None = None) -> None:
    """Prints a comparison with observed poses: a row an engine.

    Args:
        found: What `verification.checks.compare` returned of a case with observed poses.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    headings = ["engine", *map(short_heading, COLUMNS), "right\nface"]
    lanes = len(found["rows"]) // len(found["engines"])
    title = f"{found['case']}: mean errors of {lanes} observed lanes (medians in brackets)"
    table = plain_table(title, headings, ["engine"])
    best: tuple[float, str] = (float("inf"), "")
    for engine in found["engines"]:
        mine = [row for row in found["rows"] if row["engine"] == engine]
        cells = []
        for name in COLUMNS:
            values = [row[name] for row in mine if row[name] is not None]
            mean = statistics.fmean(values) if len(values) == len(mine) else None
            middle = statistics.median(values) if values else None
            cells.append(f"{number_of(name, mean)} ({number_of(name, middle)})")
            if name == COLUMNS[0] and mean is not None:
                best = min(best, (mean, engine))
        right = sum(bool(row["same_face"]) for row in mine) / len(mine)
        table.add_row(engine, *cells, f"{right:.0%}")
    print_table(out, table)
    out.print("  position, rotation: mean over the observed samples of a lane")
    if best[1]:
        print_end(
            f"{best[1]} is nearest to what was seen, {quantity_of(COLUMNS[0], best[0])} off.",
            f"warprock compare {found['case']} -e {best[1]} --json",
            out,
        )
