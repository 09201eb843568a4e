"""Tables on the terminal for engines beside poses that were observed."""

from __future__ import annotations

import statistics
from collections.abc import Mapping
from typing import Any

from rich.console import Console

from warprock.tables.terminal import number, plain_table, print_end, print_table, stdout

COLUMNS = (
    ("position_error_mm", "position\n[mm]"),
    ("rotation_error_deg", "rotation\n[deg]"),
    ("position_error_at_end_mm", "position at\nthe end [mm]"),
    ("rotation_error_at_end_deg", "rotation at\nthe end [deg]"),
)
"""Column of a comparison with observed poses and its heading; means and medians of lanes."""


def print_pose_comparison(found: Mapping[str, Any], console: Console | None = None) -> None:
    """Prints a comparison with observed poses: a row an engine.

    Args:
        found: What `verification.checks.compare` returned of a case with observed poses.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    headings = ["engine", *(heading for _, heading in COLUMNS), "right\nface"]
    lanes = len(found["rows"]) // len(found["engines"])
    title = f"{found['case']}: mean errors of {lanes} observed lanes (medians in brackets)"
    table = plain_table(title, headings, ["engine"])
    best: tuple[float, str] = (float("inf"), "")
    for engine in found["engines"]:
        mine = [row for row in found["rows"] if row["engine"] == engine]
        cells = []
        for name, _ in COLUMNS:
            values = [row[name] for row in mine if row[name] is not None]
            mean = statistics.fmean(values) if len(values) == len(mine) else None
            middle = statistics.median(values) if values else None
            cells.append(f"{number(mean, '.1f')} ({number(middle, '.1f')})")
            if name == COLUMNS[0][0] and mean is not None:
                best = min(best, (mean, engine))
        right = sum(bool(row["same_face"]) for row in mine) / len(mine)
        table.add_row(engine, *cells, f"{right:.0%}")
    print_table(out, table)
    out.print("  position, rotation: mean over the observed samples of a lane")
    if best[1]:
        print_end(
            f"{best[1]} is nearest to what was seen, {best[0]:.1f} mm off.",
            f"warprock compare {found['case']} -e {best[1]} --json",
            out,
        )
