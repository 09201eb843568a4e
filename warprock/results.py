"""Tables of results as Parquet and CSV, with what is needed to judge them in `run.json`."""

from __future__ import annotations

import json
import pathlib
from collections.abc import Mapping
from typing import Any

import pandas as pd
import pyarrow.parquet as pq

from warprock.files import replacing, require_writable
from warprock.store import PROVENANCE, arrow_table


def write_results(
    folder: pathlib.Path, tables: Mapping[str, pd.DataFrame], facts: Mapping[str, Any]
) -> list[pathlib.Path]:
    """Writes every table twice, NAME.parquet and NAME.csv, and `run.json`.

    Args:
        folder: Where to; made if it does not exist.
        tables: Name -> table; `attrs["columns"]` may hold the unit and the meaning of columns.
        facts: What ran and what came of it, ready for JSON.

    Returns:
        The files; `run.json` comes last.

    Raises:
        InputError: The folder cannot be written to.
    """
    require_writable(folder)
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, table in tables.items():
        for ending in ("parquet", "csv"):
            path = folder / f"{name}.{ending}"
            with replacing(path) as temporary:
                if ending == "csv":
                    table.to_csv(temporary, index=False)
                else:
                    pq.write_table(arrow_table(table), temporary)
            written.append(path)
    path = folder / PROVENANCE
    with replacing(path) as temporary:
        text = json.dumps(facts, indent=2, ensure_ascii=False)
        temporary.write_text(text + "\n", encoding="utf-8")
    return [*written, path]
