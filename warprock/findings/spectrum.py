"""What rocking spectra came to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.spectrum import Spectrum
from warprock.findings.asked import group_labels
from warprock.findings.digits import number_of, quantity_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.lanes import lane_sheet
from warprock.findings.numbers import counted, even_selection, listed, three
from warprock.findings.refinement import refinement_sentences
from warprock.findings.sheets import Heading, Sheet, declared
from warprock.model.response import USABLE_NAMES
from warprock.model.undecided import UNDECIDED
from warprock.running.lane_table import PEAK_RATIO, lane_table
from warprock.running.provenance import provenance
from warprock.running.run_file import OF_CASE

PERIODS_SHOWN = 16
"""Periods that stand in the table to read, an even selection."""
FELL, NOTHING = "fell", "-"
PERIOD = {"period_s": ("s", "2 pi / frequency parameter")}
CURVE = "slenderness"
"""Label of the lane table that tells the curves apart."""


def spectrum_facts(found: Spectrum) -> dict[str, Any]:
    """What ran and what came of it, ready for JSON."""
    return provenance(found.run) | {"groups": list(found.groups), "curves": list(found.curves)}


def spectrum_table(found: Spectrum) -> pd.DataFrame:
    """The lane table, with `period_s`, 2 pi / p."""
    table = lane_table(found.run.lane_set, found.run.response)
    return declared(table.assign(period_s=found.period), PERIOD)


def find_spectrum(found: Spectrum) -> Finding:
    """What spectra came to."""
    return tell_spectrum(spectrum_facts(found), {"spectrum": spectrum_table(found)})


def tell_spectrum(facts: Facts, tables: Tables) -> Finding:
    """What spectra came to, of their facts and table."""
    table = tables["spectrum"]
    groups = table.assign(group=group_labels(facts, table, CURVE_KEY)).groupby("group", sort=False)
    return Finding(
        kind="Rocking spectrum",
        facts=facts,
        tables=tables,
        sentences=[*_sentences(facts, table), *refinement_sentences(facts)],
        sheets=[
            *(_curve_sheet(str(group), rows, facts["curves"]) for group, rows in groups),
            lane_sheet(facts, table, besides=(CURVE, "period_s"), file="spectrum.csv", folded=True),
        ],
        rows={"rows": "spectrum"},
        pictures=["spectrum*.png"],
    )


CURVE_KEY = f"label.{CURVE}"
SPECTRUM = Kind(
    ("spectrum",),
    tell_spectrum,
    "curves",
    {**OF_CASE, "curves": [str], "undecided": int, "duration_s": float},
)


def _sentences(facts: Facts, table: pd.DataFrame) -> list[str]:
    """How many blocks fall, the largest of them, and the largest rotation of the others."""
    fell, count = (table["outcome"] == "overturned").to_numpy(), len(table)
    found = [f"None of the {count:,} blocks falls."]
    if fell.any():
        longest = table[fell].groupby(CURVE, sort=False)["period_s"].max()
        found = [
            f"{int(fell.sum()):,} of {count:,} blocks fall; the largest of them has 2 pi / p = "
            f"{three(float(longest.max()))} s."
        ]
        if len(facts["curves"]) > 1:
            texts = [f"{three(float(t))} s at {name}" for name, t in longest.items()]
            stood = [name for name in facts["curves"] if name not in longest.index]
            none = f"; none falls at {listed(stood)}" if stood else ""
            found.append(f"By slenderness angle, the largest that falls: {listed(texts)}{none}.")
    up = table[~fell & table[PEAK_RATIO].notna() & table["status"].isin(USABLE_NAMES)]
    if len(up):
        top = up.iloc[int(up[PEAK_RATIO].argmax())]
        found.append(
            f"Of those that stand the largest rotation is {three(float(top[PEAK_RATIO]))} of the "
            f"slenderness angle, at 2 pi / p = {three(float(top['period_s']))} s and a slenderness "
            f"angle of {top[CURVE]}."
        )
    if facts[UNDECIDED]:
        found.append(
            f"Undecided: {counted(facts[UNDECIDED], 'lane')} in which the block had not fallen by "
            f"the end of the run, {quantity_of('duration_s', facts['duration_s'])}, but still "
            "moved or was still shaken."
        )
    return found


def _curve_sheet(group: str, table: pd.DataFrame, curves: list[str]) -> Sheet:
    """The curves of a group beside one another, at some of the periods."""
    found = dict(list(table.groupby(CURVE, sort=False, observed=True)))
    count = len(table) // len(curves)
    rows = []
    for place in even_selection(range(count), PERIODS_SHOWN):
        lanes = [found[curve].iloc[place] for curve in curves]
        rows.append([number_of("period_s", lanes[0]["period_s"]), *map(_cell, lanes)])
    note = f"{PERIODS_SHOWN} of {count} periods; all are in spectrum.csv."
    return Sheet(
        f"Peak rotation / slenderness angle{f', {group}' if group else ''}",
        [Heading("2 pi / p", "s", PERIOD["period_s"][1]), *map(Heading, curves)],
        rows,
        note if count > PERIODS_SHOWN else "",
    )


def _cell(lane: pd.Series[Any]) -> str:
    usable, ratio = lane["status"] in USABLE_NAMES, float(lane[PEAK_RATIO])
    if usable and lane["outcome"] == "overturned":
        return FELL
    return number_of(PEAK_RATIO, ratio) if usable and not np.isnan(ratio) else NOTHING
