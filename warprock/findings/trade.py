"""What accuracy costs: error and CPU time of every engine over its own settings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from warprock.findings.digits import number_of, value_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.numbers import MISSING, counted, listed, three
from warprock.findings.sheets import Heading, Sheet, sheet_of
from warprock.measure.trade import CSV, TABLE, cheapest, level_rows
from warprock.measure.trade_scenes import TRADE_SCENES
from warprock.settings.engines import EXACT

LEVEL = 1e-3
_LEVEL_TEXT = number_of("level", LEVEL)
"""Error over the slenderness angle whose cost is told in sentences."""
_COST = "cpu_s_per_simulated_s"
_MARKS = "*: the cheapest of all engines; -: no setting tried met it"


def find_trade(table: pd.DataFrame) -> Finding:
    """What a trade came to.

    Args:
        table: Rows of `measure.trade.run_trade`.
    """
    return tell_trade({}, {TABLE: table})


def tell_trade(_facts: Facts, tables: Tables) -> Finding:
    """What a trade came to, of its table."""
    table = tables[TABLE]
    levels = level_rows(table)
    return Finding(
        kind="Trade",
        title="What accuracy costs: every engine over its own settings",
        facts={},
        tables=tables,
        sentences=[
            _headline(table),
            f"{counted(len(table), 'setting')} of {listed(sorted(table['engine'].unique()))} were "
            f"measured on {counted(table['scene'].nunique(), 'scene')}.",
            _per_scene(table),
        ],
        sheets=[*_level_sheets(levels), sheet_of("Settings", table, file=CSV, folded=True)],
        rows={"rows": TABLE},
        said={"levels": levels},
        pictures=["trade*.png"],
        stays=True,
        then=f"warprock run free-b1-b3 --cheapest --tolerance {_LEVEL_TEXT}",
    )


TRADE = Kind((TABLE,), tell_trade, file=TABLE)


def _headline(table: pd.DataFrame) -> str:
    """What the cheapest engine that can slide costs below the level, on the first scene."""
    scene = str(table["scene"].iloc[0])
    rows = table[(table["scene"] == scene) & ~table["engine"].isin(EXACT)]
    if not len(rows):
        return f"Timed: {listed(sorted(table['engine'].unique()))}, whose blocks do not slide."
    good = cheapest(rows, LEVEL)
    if not len(good):
        return f"No engine whose blocks can slide comes below an error of {_LEVEL_TEXT} ({scene})."
    best = good.iloc[0]
    return (
        f"An error below {_LEVEL_TEXT} costs {three(float(best[_COST]))} CPU seconds a simulated "
        f"second ({scene}, {best['engine']})."
    )


def _per_scene(table: pd.DataFrame) -> str:
    """The cheapest of all engines at the level, scene by scene."""
    found = []
    for scene, rows in table.groupby("scene", sort=False):
        good = cheapest(rows, LEVEL)
        if len(good):
            best = good.iloc[0]
            found.append(f"{scene}: {best['engine']}, {three(float(best[_COST]))} CPU s")
    if not found:
        return f"No setting kept every rotation within {_LEVEL_TEXT} of the slenderness angle."
    return (
        f"The cheapest that keeps every rotation within {_LEVEL_TEXT} of the slenderness angle, "
        f"per simulated second of one block: {'; '.join(found)}."
    )


def _level_sheets(levels: Sequence[Mapping[str, Any]]) -> list[Sheet]:
    """What each error costs: a table a scene, a row an engine, a column an error level."""
    errors = sorted({row["level"] for row in levels}, reverse=True)
    meaning = "CPU seconds of the cheapest setting whose largest error was no more than that"
    texts = (number_of("error_bound", level) for level in errors)
    heads = [Heading("engine"), *(Heading(text, "", meaning) for text in texts)]
    sheets = []
    for scene in dict.fromkeys(row["scene"] for row in levels):
        mine = [row for row in levels if row["scene"] == scene]
        best = {level: min((r[_COST] for r in mine if r["level"] == level), default=None)
                for level in errors}  # fmt: skip
        rows = []
        for engine in dict.fromkeys(row["engine"] for row in mine):
            of = {row["level"]: row for row in mine if row["engine"] == engine}
            rows.append([engine, *(_cell(of.get(level), best[level]) for level in errors)])
        title = f"{scene}: {TRADE_SCENES[scene].text}; CPU s a simulated second by largest error"
        sheets.append(Sheet(title, heads, rows, _MARKS))
    return sheets


def _cell(row: Mapping[str, Any] | None, best: float | None) -> str:
    if row is None:
        return MISSING
    precision = "" if row["precision"] == "float64" else f", {row['precision']}"
    mark = " *" if row[_COST] == best else ""
    return f"{value_of(row, _COST)}{mark} {row['settings']}{precision}"
