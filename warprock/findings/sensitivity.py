"""What Sobol' indices came to."""

from __future__ import annotations

from typing import Any

import pandas as pd

from warprock.analysis.sensitivity import Sensitivity
from warprock.findings.digits import number_of, quantity_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.numbers import MISSING, counted, listed, three
from warprock.findings.refinement import refinement_sentences
from warprock.findings.sheets import Heading, Sheet, declared, sheet_of
from warprock.running.provenance import provenance
from warprock.running.run_file import OF_CASE

IDLE = 0.01
"""Share of the variance below which an input is said to change little."""
_MEANINGS = {
    "group": "Labels of the case",
    "input": "Key of the case that is drawn",
    "first_order": "Share of the variance that goes when the input alone is known",
    "total": "Share of the variance that stays when all other inputs are known",
}


def _text(column: str) -> str:
    if column in _MEANINGS:
        return _MEANINGS[column]
    name, percentile = column.rsplit("_p", 1)
    return f"{_MEANINGS[name]}; percentile {int(percentile)} over resampled rows of the design"


def find_sensitivity(found: Sensitivity) -> Finding:
    """What indices came to."""
    facts = provenance(found.run) | {"of": found.of, "groups": found.groups.to_dict("records")}
    columns = {name: ("-", _text(str(name))) for name in found.rows.columns}
    return tell_sensitivity(facts, {"sensitivity": declared(found.rows.copy(), columns)})


def tell_sensitivity(facts: Facts, tables: Tables) -> Finding:
    """What indices came to, of their facts and table."""
    table = tables["sensitivity"]
    groups = [(group, table[table["group"] == group["group"]]) for group in facts["groups"]]
    return Finding(
        kind="Sensitivity",
        facts=facts,
        tables=tables,
        sentences=[
            _headline(table, facts["of"]),
            *(sentence for group in groups for sentence in _sentences(*group, facts["of"])),
            *refinement_sentences(facts),
        ],
        sheets=[
            *(_index_sheet(group["group"], rows, facts["of"]) for group, rows in groups),
            sheet_of("All numbers", table, file="sensitivity.csv", folded=True),
        ],
        rows={"rows": "sensitivity"},
        asked=[("Result", facts["of"])],
        pictures=["sensitivity*.png"],
    )


SENSITIVITY = Kind(
    ("sensitivity",),
    tell_sensitivity,
    "of",
    {
        **OF_CASE,
        "of": str,
        "groups": [
            {
                "group": str,
                "lanes": int,
                "mean": float,
                "standard_deviation": float,
                "overturned": int,
            }
        ],
    },
)


def _headline(table: pd.DataFrame, of: str) -> str:
    """The input that matters most."""
    known, of = table[table["total"].notna()], of.replace("_", " ")
    if known.empty:
        return f"Nothing explains the {of}: it does not vary."
    most = known.sort_values("total", ascending=False, kind="stable").iloc[0]
    where = f" ({most['group']})" if most["group"] else ""
    return (
        f"{most['input']} matters most to the {of}{where}: alone it explains "
        f"{three(100.0 * float(most['first_order']))} % of the variance, with its interactions "
        f"{three(100.0 * float(most['total']))} %."
    )


def _sentences(group: Facts, rows: pd.DataFrame, of: str) -> list[str]:
    """What else is said of a group of lanes."""
    of, name = of.replace("_", " "), f"{group['group']}: " if group["group"] else ""
    fell = f"; {group['overturned']:,} overturned" if group["overturned"] else ""
    found = [
        f"{name}over {counted(group['lanes'], 'lane')} the {of} has a mean of "
        f"{three(group['mean'])} and a standard deviation of "
        f"{three(group['standard_deviation'])}{fell}."
    ]
    idle = [str(each) for each in rows[rows["total"] < IDLE]["input"]]
    if idle:
        share = quantity_of("idle_share", IDLE)
        found.append(f"{name}{listed(idle)} changes less than {share} of its variance.")
    if group.get("censored"):
        lanes = counted(group["censored"], "lane")
        found.append(f"{name}{lanes} that fell or went beyond balance count as 1.")
    return [sentence[0].upper() + sentence[1:] for sentence in found]


def _index_sheet(group: str, table: pd.DataFrame, of: str) -> Sheet:
    """The indices of a group with their bands, the most important input first."""
    rows = []
    for _, row in table.sort_values("total", ascending=False, kind="stable").iterrows():
        rows.append([str(row["input"]), _band(row, "first_order"), _band(row, "total")])
    return Sheet(
        f"Sobol' indices of {of}{f', {group}' if group else ''}",
        [
            Heading("input", "", _MEANINGS["input"]),
            Heading("first order", "", _MEANINGS["first_order"]),
            Heading("total", "", _MEANINGS["total"]),
        ],
        rows,
        "In brackets: 5th and 95th percentile over resampled rows of the design.",
    )


def _band(row: pd.Series[Any], index: str) -> str:
    value, low, high = (float(row[f"{index}{end}"]) for end in ("", "_p05", "_p95"))
    if value != value:
        return MISSING
    return f"{number_of(index, value)} [{number_of(index, low)}, {number_of(index, high)}]"
