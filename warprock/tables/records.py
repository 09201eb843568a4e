"""Records on the terminal."""

from __future__ import annotations

import pathlib
import shlex
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.tables.terminal import plain_table, print_end, print_table, stdout
from warprock.units import GRAVITY

_HASH_SHOWN = 12
"""Letters of a hash in a table; `--json` has all."""

MEASURES = (
    ("pga_m_s2", "PGA", "m/s^2"),
    ("pgv_m_s", "PGV", "m/s"),
    ("pgd_m", "PGD", "m"),
    ("pgv_over_pga_s", "PGV / PGA", "s"),
    ("arias_m_s", "Arias intensity", "m/s"),
    ("cav_m_s", "CAV", "m/s"),
    ("d5_95_s", "D5-95", "s"),
    ("final_velocity_m_s", "velocity behind the record", "m/s"),
    ("final_displacement_m", "displacement at its end", "m"),
    ("pga_over_g_tan_alpha", "PGA / (g tan alpha)", ""),
    ("p_pgv_over_g_tan_alpha", "p PGV / (g tan alpha)", ""),
)
"""Key of a measure, its name and its unit."""


def print_records(rows: Sequence[Mapping[str, Any]], console: Console | None = None) -> None:
    """Prints the rows of `recordings.summary.record_rows`.

    Args:
        rows: One a record.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    headings = ["record", "unit", "dt [s]", "length [s]", "PGA [g]", "PGV [m/s]", "SHA-256"]
    table = plain_table("Records", headings, headings[:2])
    for row in rows:
        table.add_row(
            row["name"],
            row["unit"],
            f"{row['interval_s']:g}",
            f"{row['duration_s']:.4g}",
            f"{row['pga_m_s2'] / GRAVITY:.3f}",
            f"{row['pgv_m_s']:.3f}",
            row["sha256"][:_HASH_SHOWN],
        )
    print_table(out, table)
    for licence in dict.fromkeys(row["licence"] for row in rows):
        count = sum(row["licence"] == licence for row in rows)
        out.print(f"  licence of {count}: {licence or 'not stated'}", soft_wrap=True)


def print_imported(
    rows: Sequence[Mapping[str, Any]],
    folder: pathlib.Path,
    table: pathlib.Path | None = None,
    console: Console | None = None,
) -> None:
    """Prints what records were written to a folder.

    Args:
        rows: One a record, as of `recordings.importing.import_files`.
        folder: The folder.
        table: A table for a sweep over them; None where none was written.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    for key, name, unit, size in (
        ("duration_s", "length", "s", 1.0),
        ("interval_s", "time between samples", "s", 1.0),
        ("pga_m_s2", "PGA", "g", GRAVITY),
        ("pgv_m_s", "PGV", "m/s", 1.0),
    ):
        values = [row[key] / size for row in rows]
        least, most = f"{min(values):.3g}", f"{max(values):.3g}"
        out.print(f"  {name}: {least if least == most else f'{least} to {most}'} {unit}")
    swept = "" if table is None else f", and {table} is a table for a sweep over them"
    print_end(
        f"{len(rows)} records were written to {folder}{swept}.",
        f"warprock records info {shlex.quote(rows[0]['file'])}",
        out,
    )


def print_facts(records: Sequence[Mapping[str, Any]], console: Console | None = None) -> None:
    """Prints what `recordings.summary.record_facts` found.

    Args:
        records: One a channel.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    for facts in records:
        direction = f" ({facts['direction']})" if facts["direction"] else ""
        out.print(f"{facts['name']}{direction}", style="bold", soft_wrap=True)
        for key in ("source", "licence", "processing", "sha256", "original_sha256"):
            if key != "original_sha256" or facts[key]:
                out.print(
                    f"  {key}: {facts[key] or 'not stated'}",
                    soft_wrap=True,
                    highlight=False,
                )
        out.print(
            f"  {facts['samples']} samples of {facts['quantity']} every {facts['interval_s']:g} s, "
            f"{facts['duration_s']:g} s",
            highlight=False,
        )
        for key, name, unit in MEASURES:
            if key in facts:
                more = f" ({facts[key] / GRAVITY:.3g} g)" if key == "pga_m_s2" else ""
                out.print(f"  {name}: {facts[key]:.3g} {unit}".rstrip() + more, highlight=False)
        spectrum = ", ".join(f"{t} s: {sa / GRAVITY:.3g} g" for t, sa in facts["sa_m_s2"].items())
        damping = f"{100 * facts['damping']:g} % damping"
        out.print(f"  Sa ({damping}): {spectrum}", soft_wrap=True, highlight=False)
        for warning in facts["warnings"]:
            out.print(f"  note: {warning}", soft_wrap=True, style="yellow")
