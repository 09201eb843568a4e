"""Records on the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.findings.digits import number_of, quantity_of, value_of
from warprock.tables.terminal import plain_table, print_table, stdout
from warprock.units import GRAVITY

_HASH_SHOWN = 12
"""Letters of a hash in a table; `--json` has all."""

MEASURES = (
    ("pga_m_s2", "PGA"),
    ("pgv_m_s", "PGV"),
    ("pgd_m", "PGD"),
    ("pgv_over_pga_s", "PGV / PGA"),
    ("arias_m_s", "Arias intensity"),
    ("cav_m_s", "CAV"),
    ("d5_95_s", "D5-95"),
    ("final_velocity_m_s", "velocity behind the record"),
    ("final_displacement_m", "displacement at its end"),
    ("pga_over_g_tan_alpha", "PGA / (g tan alpha)"),
    ("p_pgv_over_g_tan_alpha", "p PGV / (g tan alpha)"),
)
"""Key of a measure and its name."""


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
            value_of(row, "interval_s"),
            value_of(row, "duration_s"),
            number_of("pga_g", row["pga_m_s2"] / GRAVITY),
            value_of(row, "pgv_m_s"),
            row["sha256"][:_HASH_SHOWN],
        )
    print_table(out, table)
    for licence in dict.fromkeys(row["licence"] for row in rows):
        count = sum(row["licence"] == licence for row in rows)
        out.print(f"  licence of {count}: {licence or 'not stated'}", soft_wrap=True)


def print_imported(rows: Sequence[Mapping[str, Any]], console: Console | None = None) -> None:
    """Prints from what to what the measures of records go that were written.

    Args:
        rows: One a record, as of `recordings.importing.import_files`.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    for key, column, name, unit, size in (
        ("duration_s", "duration_s", "length", "s", 1.0),
        ("interval_s", "interval_s", "time between samples", "s", 1.0),
        ("pga_m_s2", "pga_g", "PGA", "g", GRAVITY),
        ("pgv_m_s", "pgv_m_s", "PGV", "m/s", 1.0),
    ):
        values = [row[key] / size for row in rows]
        ends = dict.fromkeys(number_of(column, end) for end in (min(values), max(values)))
        out.print(f"  {name}: {' to '.join(ends)} {unit}")


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
            f"  {facts['samples']} samples of {facts['quantity']} every "
            f"{quantity_of('interval_s', facts['interval_s'])}, "
            f"{quantity_of('duration_s', facts['duration_s'])}",
            highlight=False,
        )
        for key, name in MEASURES:
            if key in facts:
                more = (
                    f" ({number_of('pga_g', facts[key] / GRAVITY)} g)" if key == "pga_m_s2" else ""
                )
                out.print(f"  {name}: {quantity_of(key, facts[key])}{more}", highlight=False)
        spectrum = ", ".join(
            f"{t} s: {number_of('sa_g', sa / GRAVITY)} g" for t, sa in facts["sa_m_s2"].items()
        )
        damping = f"{quantity_of('damping', facts['damping'])} damping"
        out.print(f"  Sa ({damping}): {spectrum}", soft_wrap=True, highlight=False)
        for warning in facts["warnings"]:
            out.print(f"  note: {warning}", soft_wrap=True, style="yellow")
