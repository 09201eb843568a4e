"""Folders of results: tables as Parquet and CSV, what is needed to judge them, and nothing else.

A folder holds one set of results, that of its `run.json`. What an earlier command left there is
taken away, or the figures of one case would lie beside the numbers of another; a list of what was
written, with hashes, tells it from a user's own files and from those that a user changed.
"""

from __future__ import annotations

import hashlib
import json
import os
import pathlib
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from warprock.arguments import at_the_door
from warprock.model.response import Response
from warprock.reading import read_bytes
from warprock.running.case_run import CaseRun
from warprock.running.cells import cell_table
from warprock.running.files import RESULTS, replacing, replacing_together, require_writable
from warprock.running.lane_table import LANE_TABLE, arrow_table, history_table, lane_table
from warprock.running.provenance import provenance

if TYPE_CHECKING:
    import pandas as pd

PROVENANCE = "run.json"
CELL_TABLE = "cells.csv"
LANE_CSV = "lanes.csv"
MOST_CSV_LANES = 10_000
"""Lanes up to which the lane table is written as CSV as well: some 5 MB."""
HISTORY = "history-lane-{lane}.csv"
WRITTEN = ".warprock.json"
"""List of the results in a folder: SHA-256 by name."""


def list_results(
    folder: pathlib.Path, files: Iterable[pathlib.Path], *, beside: bool = False
) -> list[str]:
    """Lists the results that a command has just written, and removes those of commands before.

    Args:
        folder: Where they are.
        files: The files written.
        beside: Whether they were made from the results in the folder, which stay.

    Returns:
        Names of the files removed: those listed before, not written now, with the bytes that they
        were written with.
    """
    before = _read_list(folder)
    now = {path.name: _digest(path) for path in files if path.parent == folder}
    removed = []
    for name, digest in before.items():
        path = folder / name
        if beside or name in now or path.is_symlink() or not path.is_file():
            continue
        if _digest(path) == digest:
            path.unlink()
            removed.append(name)
    with replacing(folder / WRITTEN) as temporary:
        text = json.dumps(before | now if beside else now, indent=2, ensure_ascii=False)
        temporary.write_text(text + "\n", encoding="utf-8")
    return sorted(removed)


def _read_list(folder: pathlib.Path) -> dict[str, str]:
    """Reads the list of results in a folder; empty where none is there or none can be read."""
    try:
        found = json.loads(read_bytes(folder / WRITTEN))
    except (OSError, ValueError, RecursionError):
        return {}
    if not isinstance(found, dict):
        return {}
    return {
        name: str(digest)
        for name, digest in found.items()
        if pathlib.PurePath(name).name == name and pathlib.PurePath(name).suffix in RESULTS
    }


def _digest(path: pathlib.Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_results(
    folder: pathlib.Path,
    tables: Mapping[str, pd.DataFrame],
    facts: Mapping[str, Any] | None = None,
    texts: Mapping[str, str] | None = None,
) -> list[pathlib.Path]:
    """Writes tables and texts, and `run.json` where there are facts: all of them or none.

    Args:
        folder: Where to; made if it does not exist.
        tables: Name of a file -> its table, whose `attrs["columns"]` may hold the unit and the
            meaning of columns. A name that ends in .parquet or .csv is that file; a name without an
            ending is written twice, NAME.parquet and NAME.csv.
        facts: What ran and what came of it, ready for JSON.
        texts: Name of a file -> what it says.

    Returns:
        The files; `run.json` comes last.

    Raises:
        InputError: The folder cannot be written to.
    """
    from pyarrow.parquet import write_table

    require_writable(folder)
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    with replacing_together() as writing:
        for name, table in tables.items():
            ending = pathlib.PurePath(name).suffix
            for file in (name,) if ending else (f"{name}.parquet", f"{name}.csv"):
                with writing(folder / file) as temporary:
                    if file.endswith(".csv"):
                        table.to_csv(temporary, index=False)
                    else:
                        write_table(arrow_table(table), temporary)
                written.append(folder / file)
        for name, content in (texts or {}).items():
            with writing(folder / name) as temporary:
                temporary.write_text(content, encoding="utf-8")
            written.append(folder / name)
        if facts is not None:
            with writing(folder / PROVENANCE) as temporary:
                text = json.dumps(facts, indent=2, ensure_ascii=False)
                temporary.write_text(text + "\n", encoding="utf-8")
            written.append(folder / PROVENANCE)
    return written


@at_the_door
def write_run(
    run: CaseRun,
    folder: str | os.PathLike[str],
    histories: Mapping[int, Response] | None = None,
    *,
    besides: Mapping[str, Any] | None = None,
) -> list[pathlib.Path]:
    """Writes the lane table, that of cells of an ensemble, histories asked for, and `run.json`.

    The lane table is a Parquet file; of up to `MOST_CSV_LANES` lanes also a CSV file.

    Args:
        run: The run.
        folder: Where to; made if it does not exist.
        histories: One-lane responses with histories, by number of the lane.
        besides: What `run.json` says besides: limit analysis of an assembly that collapsed.

    Returns:
        The files, in the order in which they were written; `run.json` comes last.

    Raises:
        InputError: The folder cannot be written to.

    Example:
        >>> import pathlib, tempfile
        >>> import warprock as wr
        >>> run = wr.run_case(wr.load_case("free-b0"), "housner")
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     [path.name for path in wr.write_run(run, pathlib.Path(folder))]
        ['lanes.parquet', 'lanes.csv', 'run.json']
    """
    facts = provenance(run) | dict(besides or {})
    table = lane_table(run.lane_set, run.response)
    table.attrs["footer"] = {name: facts[name] for name in ("engine", "estimate", "tolerance")}
    tables = {LANE_TABLE: table}
    if len(table) <= MOST_CSV_LANES:
        tables[LANE_CSV] = table
    if run.case.ensemble is not None:
        tables[CELL_TABLE] = cell_table(run.lane_set, run.response)
    for lane, response in (histories or {}).items():
        tables[HISTORY.format(lane=lane)] = history_table(response, 0, run.lane_set, lane)
    return write_results(pathlib.Path(folder), tables, facts)
