"""What a study of settings came to."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import pandas as pd

from warprock.findings.digits import number_of, value_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.numbers import three
from warprock.findings.sheets import sheet_of
from warprock.running.run_file import CASE
from warprock.verification.study import STUDY, StudyRun, study_provenance

_WANTED = (
    *("engine", "setting", "value", "unit", "baseline", "lane_name", "time_step_s"),
    *("error_5s_ratio", "error_run_ratio", "baseline_difference_ratio"),
    *("peak_rotation_ratio", "rest_time_error_s", "cpu_s", "status", "why"),
)
"""Columns of the table to read."""
_ERROR = "error_run_ratio"


def find_study(found: StudyRun, show: Callable[[], None]) -> Finding:
    """What a study came to.

    Args:
        found: The study.
        show: Prints its tables on the terminal.
    """
    told = tell_study(study_provenance(found), {STUDY: found.table})
    return dataclasses.replace(told, said={**told.facts, "rows": found.rows}, show=show)


def tell_study(facts: Facts, tables: Tables) -> Finding:
    """What a study came to, of its facts and table."""
    table = tables[STUDY]
    shown = table[[name for name in _WANTED if name in table]]
    return Finding(
        kind="Study",
        facts=facts,
        tables=tables,
        sentences=[study_headline(table), *_engine_sentences(table), _cost_sentence(table)],
        sheets=[sheet_of("Runs", shown, file=f"{STUDY}.csv")],
        asked=[
            (
                f"Settings of {plan['engine']}" if "engine" in plan else "Settings",
                f"{_settings(plan)}, one varied at a time",
            )
            for plan in facts["study"]
        ],
        pictures=["study*.png", "histories*.png"],
    )


STUDIES = Kind(
    (STUDY,),
    tell_study,
    "study",
    {
        "case": CASE,
        "study": [{"engine?": str, "vary": [{"setting": str, "baseline": float}]}],
    },
)


def _settings(plan: Facts) -> str:
    """The settings that a study varies, with their values in the case."""
    each = (f"{row['setting']} {number_of('value', row['baseline'])}" for row in plan["vary"])
    return ", ".join(each)


def study_headline(table: pd.DataFrame) -> str:
    """The setting that changes the error of the first 5 s most, where Housner holds.

    Args:
        table: Rows of a study.
    """
    held = table[table["holds"].astype(bool)]
    largest = held.groupby(["engine", "setting", "value"], sort=False)["error_5s_ratio"].max()
    known = largest[(largest > 0.0) & (largest < math.inf)]
    spans = known.groupby(level=["engine", "setting"], sort=False).agg(lambda e: e.max() / e.min())
    if spans.empty or not spans.max() > 1.0:
        return "No setting changes the error."
    most = int(spans.argmax())
    engine, setting = (spans.index.get_level_values(level)[most] for level in (0, 1))
    return (
        f"{setting} changes the error of the first 5 s most: that of {engine} by a factor of "
        f"{number_of('error_span', float(spans.max()))}."
    )


def _engine_sentences(table: pd.DataFrame) -> list[str]:
    """How far every engine is from Housner, at its own settings and at the worst."""
    found = []
    for engine, rows in table.groupby("engine", sort=False):
        error = rows[_ERROR]
        own, worst = rows[rows["baseline"]], rows.iloc[int(error.argmax())]
        unit = "" if worst["unit"] == "-" else f" {worst['unit']}"
        found.append(
            f"{engine} at the case's own settings differs from Housner by at most "
            f"{three(float(own[_ERROR].max()))} of the slenderness angle; the largest error of "
            f"all, {three(float(error.max()))}, is that of {worst['setting']} "
            f"{three(float(worst['value']))}{unit}."
        )
    return found


def _cost_sentence(table: pd.DataFrame) -> str:
    """The dearest run and the cheapest."""
    cost = table["cpu_s"]
    dear, cheap = (table.iloc[int(at)] for at in (cost.argmax(), cost.argmin()))
    return (
        f"The dearest run, {dear['setting']} {value_of(dear, 'value')} of {dear['engine']}, took "
        f"{three(float(dear['cpu_s'] / cheap['cpu_s']))} times the CPU time of the cheapest, "
        f"{cheap['setting']} {value_of(cheap, 'value')} of {cheap['engine']}."
    )
