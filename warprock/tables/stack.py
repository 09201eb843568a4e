"""Tables on the terminal for stacks of blocks, assemblies and blocks in space."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.findings.digits import number_of, short_heading, value_of
from warprock.tables.terminal import plain_table, print_table, say, stdout

LANES_SHOWN = 24
"""Lanes that are printed one by one; of more, what they come to."""

COLUMNS = ("peak_rotation_ratio", "difference_5s_ratio", "difference_run_ratio", "peak_slide_mm")
"""Columns of numbers of a comparison of stacks."""
SPATIAL_COLUMNS = (
    *("difference_across_5s_ratio", "difference_yaw_5s_rad", "peak_tilt_ratio"),
    "peak_yaw_rad",
)
"""Those that a comparison in space has besides."""


def print_stack_comparison(found: Mapping[str, Any], console: Console | None = None) -> None:
    """Prints a comparison of stacks or in space: a row a lane, block and engine.

    Args:
        found: What `verification.checks.compare` returned.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    rows: Sequence[Mapping[str, Any]] = found["rows"]
    reference = rows[0]["reference"]
    named = ("lane", "block", "engine", "outcome", "status")
    columns = COLUMNS + (SPATIAL_COLUMNS if found["spatial"] else ())
    headings = [*named, *map(short_heading, columns)]
    table = plain_table(f"{found['case']}: engines against {reference}", headings, named)
    places = dict.fromkeys((row["lane"], row["block"]) for row in rows)
    last_lane = None
    for lane, block in places:
        mine = [row for row in rows if (row["lane"], row["block"]) == (lane, block)]
        for index, row in enumerate(mine):
            table.add_row(
                "" if lane == last_lane else lane,
                str(block) if index == 0 else "",
                row["engine"],
                row["outcome"],
                row["status"],
                *(value_of(row, name) for name in columns),
            )
            last_lane = lane
    lanes = len({row["lane_number"] for row in rows})
    if lanes <= LANES_SHOWN:
        print_table(out, table)
    _print_engines(found, out)
    out.print(f"  * largest |rotation - that of {reference}| / the block's slenderness angle")
    if found["spatial"]:
        out.print("  ** the same of the turn about the vertical over the first 5 s")
        _print_largest(found, out)
    if lanes > LANES_SHOWN:
        say(out, f"  all {len(rows):,} rows, lane by lane: --json, or -o DIR")


def _print_engines(found: Mapping[str, Any], out: Console) -> None:
    """What a comparison comes to, an engine and block a row."""
    headings = ["engine", "block", "lanes", "diff.*\nmedian", "diff.*\nlargest", "other\noutcome"]
    reference, rows = found["engines"][0], found["rows"]
    blocks = list(dict.fromkeys(row["block"] for row in rows))
    table = plain_table(f"{found['case']}: all lanes against {reference}", headings, ["engine"])
    outcomes = {r["lane_number"]: r["outcome"] for r in rows if r["engine"] == reference}
    for engine in found["engines"]:
        for block in blocks:
            mine = [row for row in rows if (row["engine"], row["block"]) == (engine, block)]
            off = [r["difference_run_ratio"] for r in mine if r["difference_run_ratio"] is not None]
            other = sum(row["outcome"] != outcomes[row["lane_number"]] for row in mine)
            table.add_row(
                engine if block == blocks[0] else "",
                str(block),
                str(len(mine)),
                number_of("difference_run_ratio", statistics.median(off) if off else None),
                number_of("difference_run_ratio", max(off, default=None)),
                str(other),
            )
    print_table(out, table)


def _print_largest(found: Mapping[str, Any], out: Console) -> None:
    """Prints what a comparison in space comes to: the largest differences of each engine."""
    names = ("difference_5s_ratio", "difference_across_5s_ratio", "difference_yaw_5s_rad")
    headings = ["engine", "rotation*", "across*", "yaw** [deg]"]
    table = plain_table("largest over all lanes, first 5 s", headings, ["engine"])
    for engine in found["engines"]:
        mine = [row for row in found["rows"] if row["engine"] == engine]
        known = {n: [row[n] for row in mine if row[n] is not None] for n in names}
        table.add_row(engine, *(number_of(n, max(known[n], default=None)) for n in names))
    print_table(out, table)


ASSEMBLY_COLUMNS = ("fell_at_s", "moved_mm", "difference_deg")
"""Columns of numbers of a comparison of assemblies."""


def print_assembly_comparison(found: Mapping[str, Any], console: Console | None = None) -> None:
    """Prints a comparison of assemblies: a row a lane and engine.

    Args:
        found: What `verification.checks.compare` returned.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    rows: Sequence[Mapping[str, Any]] = found["rows"]
    reference = rows[0]["reference"]
    named = ("lane", "engine", "outcome", "status")
    headings = [*named, *map(short_heading, ASSEMBLY_COLUMNS)]
    table = plain_table(f"{found['case']}: engines against {reference}", headings, named)
    shown = list(dict.fromkeys(row["lane_number"] for row in rows))[:LANES_SHOWN]
    for lane in shown:
        for index, row in enumerate(row for row in rows if row["lane_number"] == lane):
            table.add_row(
                row["lane"] if index == 0 else "",
                row["engine"],
                row["outcome"],
                row["status"],
                *(value_of(row, name) for name in ASSEMBLY_COLUMNS),
            )
    print_table(out, table)
    say(
        out,
        f"* of the largest rotation of any block so far, from that in {reference}; the most over "
        "the run",
    )
    count = len({row["lane_number"] for row in rows})
    if count > len(shown):
        say(out, f"{count - len(shown)} more lanes are in the table of the results (-o FOLDER)")
