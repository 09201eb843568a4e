"""Records of ground motion: shipped ones, and what a file holds."""

from __future__ import annotations

import functools
import pathlib
import shlex
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from warprock.case.columns import Columns
from warprock.findings.digits import number_of, quantity_of
from warprock.findings.finding import Finding
from warprock.units import GRAVITY

Rows = Sequence[Mapping[str, Any]]


def find_records(rows: Rows, show: Callable[..., None]) -> Finding:
    """Shipped records, one row each.

    Args:
        rows: What `recordings.summary.record_rows` found.
        show: Prints them.
    """
    most = max(rows, key=lambda row: float(row["pga_m_s2"]))
    peak = number_of("pga_g", most["pga_m_s2"] / GRAVITY)
    return Finding(
        kind="Records",
        facts={},
        tables={"records": Columns.of(rows)},
        sentences=[f"{len(rows)} records; the strongest is {most['name']}, {peak} g."],
        said={"records": rows},
        show=functools.partial(show, rows),
    )


def find_imported(
    rows: Rows, folder: pathlib.Path, table: pathlib.Path | None, show: Callable[..., None]
) -> Finding:
    """Records that were written to a folder, one row each.

    Args:
        rows: What `recordings.importing.import_files` found.
        folder: The folder.
        table: A table for a sweep over them; None where none was written.
        show: Prints them.
    """
    swept = "" if table is None else f", and {table} is a table for a sweep over them"
    files = [*(row["file"] for row in rows), *([] if table is None else [str(table)])]
    return Finding(
        kind="Records",
        facts={},
        tables={"records": Columns.of(rows)},
        sentences=[f"{len(rows)} records were written to {folder}{swept}."],
        said={"records": rows, "files": files},
        then=f"warprock records info {shlex.quote(rows[0]['file'])}",
        show=functools.partial(show, rows),
    )


def find_record(channels: Rows, show: Callable[..., None]) -> Finding:
    """What a record holds, or each channel of a file.

    Args:
        channels: What `recordings.summary.record_facts` found.
        show: Prints them.
    """
    first = channels[0]
    peak = number_of("pga_g", first["pga_m_s2"] / GRAVITY)
    length = quantity_of("record_length_s", first["duration_s"])
    spectrum = [
        {"name": each["name"], "period_s": float(period), "sa_m_s2": value}
        for each in channels
        for period, value in each["sa_m_s2"].items()
    ]
    own = [
        {name: value for name, value in each.items() if name not in ("sa_m_s2", "warnings")}
        for each in channels
    ]
    return Finding(
        kind="Record",
        facts={},
        tables={"records": Columns.of(own), "spectrum": Columns.of(spectrum)},
        sentences=[f"The record reaches {peak} g in {length}."],
        said={"records": channels},
        title=first["name"],
        show=functools.partial(show, channels),
    )
