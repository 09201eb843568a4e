"""Blocks in space beside the paper's table on the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.tables.terminal import number, plain_table, print_table

Row = Mapping[str, Any]


def print_space(out: Console, rows: Sequence[Row]) -> None:
    """The ensembles in space, one row an input and engine, and what the paper prints.

    Args:
        out: Where to.
        rows: Those of `reproduce table7-spatial`.
    """
    ours = [row for row in rows if row["reading"] == "in space"]
    table = plain_table(
        "The single block under 60 s of continuous sine in space, with small imperfections",
        [
            *("input", "engine", "in the\nplane", "in space\nmedian", "95 %"),
            *("wobbling\n[%]", "overturned\n[%]", "after\n[s]", "across\n[deg]", "yaw\n[deg]"),
        ],
    )
    last = None
    for row in sorted(ours, key=lambda row: (row["frequency_hz"], row["amplitude_mm"])):
        name = f"{row['frequency_hz']:g} Hz, {row['amplitude_mm']:g} mm"
        table.add_row(
            "" if name == last else name,
            row["source"],
            *(number(row[f"peak_rotation_ratio{end}"], ".4f") for end in ("_plane", "", "_p95")),
            *(_share(row, kind) for kind in ("wobbling", "overturned")),
            number(row.get("fell_median_s"), ".0f"),
            number(row.get("peak_rotation_across_deg_max"), ".3f"),
            number(row.get("peak_yaw_deg_max"), ".2f"),
        )
        last = name
    print_table(out, table)
    few, many = (pick(row["members"] for row in ours) for pick in (min, max))
    most = next(row for row in reversed(ours) if row["members"] == many)
    said = f"{many} members an input"
    if few < many:
        said += f" at {most['frequency_hz']:g} Hz, {most['amplitude_mm']:g} mm, {few} at the others"
    out.print(
        f"  {said}.\n"
        "  Peaks: rotation in the plane of rocking / slenderness angle.\n"
        "  Wobbling: standing, with a rotation across the plane above a twentieth of the\n"
        "  slenderness angle there. After: median time. Across, yaw: largest of those that stand.\n"
        "  In brackets: 95 % interval of the share.",
        highlight=False,
    )
    printed = [row for row in rows if row["reading"] == "as printed"]
    paper = plain_table(
        "The paper's Table 7: error against the test, without its sign [%]",
        ["input", *(row["source"].removeprefix("paper-") for row in printed[:4])],
        ("input",),
    )
    for at in range(0, len(printed), 4):
        first = printed[at]
        paper.add_row(
            f"{first['frequency_hz']:g} Hz, {first['amplitude_mm']:g} mm",
            *(row["why"] or number(row["abs_error_pct"], ".0f") for row in printed[at : at + 4]),
        )
    out.print(paper)
    out.print()


def _share(row: Row, kind: str) -> str:
    low, high = row[f"{kind}_low"], row[f"{kind}_high"]
    return f"{100.0 * row[kind]:.1f} ({100.0 * low:.0f} to {100.0 * high:.0f})"
