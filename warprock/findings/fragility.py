"""What fragility functions came to."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import pandas as pd

from warprock.analysis.exports import component_rows, intensity_of, nrml_text
from warprock.analysis.fragility import RULE, Curve, curve_rows, warnings
from warprock.analysis.risk_functions import PERIOD
from warprock.findings.digits import number_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.fits import FITTED, LIMIT, fit_cells, fit_sentences, fits_headline
from warprock.findings.intensities import measure
from warprock.findings.numbers import counted, listed
from warprock.findings.sheets import Heading, Sheet, heading, sheet_of
from warprock.model.undecided import UNDECIDED

CURVES = "fragility.csv"
COMPONENTS = "fragility-p58.csv"
NRML = "fragility.xml"
GROUPS_SHOWN = 8
"""Groups whose fits are shown one by one; of more, what they come to."""


def find_fragility(
    lanes: pd.DataFrame, curves: Sequence[Curve], source: str, intensity: str
) -> Finding:
    """What fragility functions came to.

    Args:
        lanes: The lane table that they were fitted to.
        curves: The curves.
        source: Name of the table.
        intensity: Column of the intensity measure.
    """
    rows, said = curve_rows(curves), warnings(lanes, curves)
    # A table of an earlier version does not say which of its lanes are undecided.
    undecided = int(lanes[UNDECIDED].sum()) if UNDECIDED in lanes else 0
    period = _period(lanes)
    components = component_rows(curves, intensity, period)
    found = tell_fragility({}, {CURVES: rows, COMPONENTS: components})
    model = nrml_text(curves, intensity, period)
    notes = [f"Note: {text}." for text in said]
    if undecided:
        notes.append(
            f"Undecided: {undecided:,} of {counted(len(lanes), 'lane')} had not fallen when their "
            "run ended, but still moved or were still shaken; they count as standing, with the "
            "peaks so far."
        )
    said_json = {
        "table": source,
        "intensity": intensity,
        "undecided": undecided,
        "rule": RULE,
        "warnings": said,
    }
    return dataclasses.replace(
        found,
        said=said_json,
        sentences=[*found.sentences, *notes],
        texts={NRML: model} if model else {},
    )


def _period(lanes: pd.DataFrame) -> float:
    """Period of the spectral acceleration of all lanes; NaN where they have none, or several."""
    periods = lanes[PERIOD].unique().tolist() if PERIOD in lanes else []
    return float(periods[0]) if len(periods) == 1 else math.nan


def tell_fragility(_facts: Facts, tables: Tables) -> Finding:
    """What fragility functions came to, of their tables; facts beside them are those of a run."""
    rows, names = tables[CURVES], tables[COMPONENTS]
    demand = str(names["Demand-Type"].iloc[0]) if len(names) else "the intensity measure"
    intensity = intensity_of(demand)
    groups = list(map(str, rows.columns[: list(rows.columns).index(LIMIT)]))
    single = rows.drop_duplicates(groups) if groups else rows.head(1)
    many = len(single) > GROUPS_SHOWN
    headline = fits_headline(rows, groups, intensity)
    return Finding(
        kind="Fragility functions",
        title=f"Fragility over {heading(intensity).text}",
        facts={},
        tables=tables,
        sentences=[
            headline,
            *(said for said in fit_sentences(rows, groups, intensity) if said != headline),
            *_not_counted(rows, single, groups),
        ],
        sheets=[
            _group_sheet(rows, intensity, len(single)) if many else
            _fit_sheet(rows, groups, intensity),
            sheet_of(
                "All numbers of the fits",
                rows.dropna(axis="columns", how="all"),
                note="p05 and p95: 5th and 95th percentile over records.",
                file=CURVES,
                folded=True,
            ),
        ],
        asked=[
            ("Intensity measure", intensity),
            ("Limit states", listed([str(name) for name in rows[LIMIT].unique()])),
            ("Function", "lognormal, of greatest likelihood; bands over records"),
        ],
        pictures=["fragility*.png"],
        rows={"curves": CURVES},
        beside=True,
    )  # fmt: skip


FRAGILITY = Kind((CURVES, COMPONENTS), tell_fragility, file=COMPONENTS)


def _not_counted(rows: pd.DataFrame, single: pd.DataFrame, groups: Sequence[str]) -> list[str]:
    """Lanes that are left out, and those in doubt."""
    found, left = [], single[single["left_out"] > 0]
    for _, row in left.head(GROUPS_SHOWN).iterrows():
        where = "".join(f" of {name} {row[name]}" for name in groups)
        found.append(
            f"Left out: {counted(int(row['left_out']), 'lane')}{where} whose numbers cannot be "
            f"used ({row['left_out_as']})."
        )
    if len(left) > GROUPS_SHOWN:
        found.append(f"Lanes are left out in {len(left) - GROUPS_SHOWN:,} more groups, too.")
    doubt = int(rows["in_doubt"].max())
    if doubt:
        found.append(
            f"Up to {counted(doubt, 'lane')} are in doubt: they count by their finest run. Bands "
            "enclose those that follow if all of them reach the limit state, or none."
        )
    return found


def _fit_sheet(rows: pd.DataFrame, groups: Sequence[str], intensity: str) -> Sheet:
    """Every fit, a group and limit state a row."""
    counts = ["lanes", "in_doubt", "records", "reached"]
    cells = [
        [*(str(row[name]) for name in (*groups, LIMIT)), *(f"{row[name]:,}" for name in counts),
         *fit_cells(row)]
        for _, row in rows.iterrows()
    ]  # fmt: skip
    heads = [*map(heading, (*groups, LIMIT, *counts)), median_heading(intensity)]
    note = "In brackets: 5th and 95th percentile over records."
    return Sheet(f"Fragility over {intensity}", [*heads, Heading("dispersion")], cells, note)


def median_heading(intensity: str) -> Heading:
    """The heading of medians, with the unit of the intensity measure."""
    return Heading("median", heading(intensity).unit, measure(intensity).name)


def _group_sheet(rows: pd.DataFrame, intensity: str, groups: int) -> Sheet:
    """What the fits of many groups come to, a limit state a row."""
    cells = []
    for limit, mine in rows.groupby(LIMIT, sort=False):
        medians, verdicts = mine[mine["verdict"] == FITTED]["median"], mine["verdict"].tolist()
        cells.append([
            str(limit),
            f"{len(medians):,}",
            *(number_of("median", value) for value in medians.quantile([0, 0.5, 1])),
            *(f"{verdicts.count(each):,}" for each in ("separated", "none reached", "all reached")),
            f"{mine['in_doubt'].sum():,}",
        ])  # fmt: skip
    heads = ["limit state", "groups fitted", "least median", "middle", "greatest", "separated"]
    heads += ["none reached", "all reached", "lanes in doubt"]
    title = f"Fragility over {intensity}: {groups:,} groups"
    return Sheet(title, [*map(Heading, heads)], cells, f"All {len(rows):,} fits are in {CURVES}.")
