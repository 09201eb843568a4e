"""The trade of speed for accuracy on the terminal."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.tables.terminal import plain_table, print_end, print_table, print_written, stdout


def print_trade(
    levels: Sequence[Mapping[str, Any]],
    scenes: Mapping[str, str],
    files: Sequence[pathlib.Path],
    console: Console | None = None,
) -> None:
    """Prints what each error costs: a table a scene, a row an engine, a column an error level.

    Args:
        levels: What `measure.trade.level_rows` returned.
        scenes: What each scene is.
        files: Files that were written.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    errors = sorted({row["level"] for row in levels}, reverse=True)
    out.print(
        "CPU seconds for a simulated second of one block (packed, one worker) of the cheapest "
        "setting whose largest error was no more than:"
    )
    for scene in dict.fromkeys(row["scene"] for row in levels):
        mine = [row for row in levels if row["scene"] == scene]
        best = {level: _cheapest(mine, level) for level in errors}
        headings = ["engine", *(f"{level:.0e}" for level in errors)]
        table = plain_table(f"\n{scene}: {scenes[scene]}", headings, headings)
        for engine in dict.fromkeys(row["engine"] for row in mine):
            cells = {row["level"]: row for row in mine if row["engine"] == engine}
            table.add_row(
                engine,
                *(_cell(cells.get(level), cells.get(level) is best[level]) for level in errors),
            )
        print_table(out, table)
    out.print("  * the cheapest of all engines; -: no setting tried met it")
    print_written(files, out)
    engines, timed = ({row[name] for row in levels} for name in ("engine", "scene"))
    were = "engine was" if len(engines) == 1 else "engines were"
    print_end(
        f"{len(engines)} {were} timed on {len(timed)} scene{'s' * (len(timed) != 1)}.",
        "warprock run free-b1-b3 --accuracy 1e-3",
        out,
    )


def _cheapest(rows: Sequence[Mapping[str, Any]], level: float) -> Mapping[str, Any] | None:
    found = [row for row in rows if row["level"] == level]
    return min(found, key=lambda row: row["cpu_s_per_simulated_s"], default=None)


def _cell(row: Mapping[str, Any] | None, best: bool) -> str:
    if row is None:
        return "-"
    text = row["settings"].replace(", ", "\n")
    precision = "" if row["precision"] == "float64" else f"\n{row['precision']}"
    return f"{row['cpu_s_per_simulated_s']:.1e}{' *' if best else ''}\n{text}{precision}"
