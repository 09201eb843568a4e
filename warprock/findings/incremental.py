"""What an incremental dynamic analysis came to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd

from warprock.analysis.capacities import (
    FACTOR,
    Capacities,
    capacity_rows,
    lane_rows,
    run_rows,
    undecided_runs,
)
from warprock.analysis.incremental import Analysis, Verdict
from warprock.case.case import Case
from warprock.case.input_columns import input_meaning
from warprock.findings import asked
from warprock.findings.digits import number_of, value_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.fits import fit_cells, fit_sentences
from warprock.findings.fragility import median_heading
from warprock.findings.intensities import measure
from warprock.findings.numbers import counted, listed
from warprock.findings.sheets import Heading, Sheet, heading, sheet_of
from warprock.model.words import thing_of
from warprock.running.provenance import case_facts, surroundings
from warprock.running.run_file import CASE

_COUNTS = {
    "lanes": "lanes",
    "records": "records",
    "bracketed": "bracketed",
    "never_overturned": "never fell",
    "overturned_at_once": "fell at once",
    "lanes_resurrected": "stood again",
}


def analysis_facts(found: Analysis) -> dict[str, Any]:
    """What ran and what came of it, ready for JSON."""
    content = found.plan.content
    return {
        "plan": found.plan.id,
        "engine": content["engine"],
        "precision": content["precision"],
        "device": content["device"],
        "incremental": content["incremental"],
        "lanes": found.lane_set.lanes.lane_count,
        "estimate": content["estimate"],
        "tolerance": content["tolerance"],
        "runs": len(found.curves),
        "runs_missed_tolerance": int(found.curves["missed_tolerance"].sum()),
        "stages": found.stages,
        "stages_kept": found.kept,
        "undecided_runs": undecided_runs(found),
    }


def find_ida(found: Analysis, case: Case, groups: Sequence[Capacities], intensity: str) -> Finding:
    """What an incremental analysis came to.

    Args:
        found: The analysis.
        case: Its case.
        groups: Capacities of the groups of lanes.
        intensity: The intensity measure.
    """
    facts = analysis_facts(found) | {"sentence": factor_sentence(found, intensity)}
    tables = {
        "capacities": lane_rows(found, intensity),
        "curves": run_rows(found, intensity),
        "fragility": capacity_rows(groups),
    }
    return tell_ida(
        {"case": case_facts(case), **facts, "intensity": intensity, **surroundings(case)},
        tables,
        {"case": case.name, "intensity": intensity, **facts},
    )


def tell_ida(facts: Facts, tables: Tables, said: Facts | None = None) -> Finding:
    """What an incremental analysis came to, of its facts and tables."""
    lanes, rows, intensity = tables["capacities"], tables["fragility"], str(facts["intensity"])
    groups = list(map(str, rows.columns[: list(rows.columns).index("lanes")]))
    ladder = facts["incremental"]
    wanted = [*asked.swept_columns(facts, lanes), "standing_factor", "overturning_factor"]
    wanted += [name for name in map(str, lanes) if name.endswith(intensity)] + ["verdict", "runs"]
    shown = lanes[["lane", *dict.fromkeys(name for name in wanted if name in lanes)]]
    return Finding(
        kind="Incremental dynamic analysis",
        facts=facts,
        tables=tables,
        sentences=[
            facts["sentence"],
            *(fit_sentences(rows, groups, intensity) if len(lanes) > 1 else ()),
            *_sentences(facts, lanes, int(rows["left_out"].sum())),
        ],
        sheets=[
            _group_sheet(rows, groups, intensity),
            sheet_of("Capacities of lanes", shown, file="capacities.csv", folded=len(shown) > 1),
            sheet_of("All numbers of groups", rows.dropna(axis="columns", how="all"), folded=True),
        ],
        rows={"groups": "fragility"},
        said=said,
        asked=[
            ("Intensity measure", intensity),
            (
                "Factors",
                f"{_factors(ladder)}, {ladder['count']} at first, "
                f"brackets to {value_of(ladder, 'accuracy')}",
            ),
        ],
        pictures=["ida*.png"],
    )


INCREMENTAL = Kind(
    ("capacities", "fragility"),
    tell_ida,
    "incremental",
    {
        "case": CASE,
        "incremental": {"lowest": float, "highest": float, "count": int, "accuracy": float},
        **dict.fromkeys(("intensity", "sentence"), str),
        **dict.fromkeys(("runs", "stages", "stages_kept"), int),
        **dict.fromkeys(("runs_missed_tolerance", "undecided_runs"), int),
    },
)


def factor_sentence(found: Analysis, intensity: str) -> str:
    """By how much motions must be scaled, in words: the factor at which lanes first fall."""
    rows, ladder = lane_rows(found, intensity), found.plan.content["incremental"]
    verdicts = rows["verdict"].to_numpy(dtype=object)
    fell = rows[verdicts == Verdict.BRACKETED.value]
    lowest, highest = (number_of(f"{end}_factor", ladder[end]) for end in ("lowest", "highest"))
    if len(rows) == 1:
        row = rows.iloc[0]
        what = f"The {thing_of(found.lane_set.lanes).noun}"
        if row["verdict"] == Verdict.BRACKETED.value:
            at = _intensity(row, "overturning", intensity)
            return (
                f"{what} first falls at {_factor(row, 'overturning')} times its motion{at}; at "
                f"{_factor(row, 'standing')} times it stands."
            )
        if row["verdict"] == Verdict.ABOVE.value:
            top, at = _factor(row, "standing"), _intensity(row, "standing", intensity)
            return f"{what} stands at up to {top} times its motion{at}: a larger --to goes on."
        at = _intensity(row, "overturning", intensity)
        return (
            f"{what} falls at once, at {_factor(row, 'overturning')} times its motion{at}: "
            "a smaller --from finds where it stands."
        )
    count = counted(len(rows), "lane")
    if fell.empty:
        never = int((verdicts == Verdict.ABOVE.value).sum())
        return (
            f"Of {count} {never:,} stand at every factor up to {highest} and the others fall "
            f"already at {lowest} times their motion."
        )
    factors = fell["overturning_factor"]
    weakest, strongest = fell.loc[factors.idxmin()], fell.loc[factors.idxmax()]
    middle = number_of("overturning_factor", float(factors.median()))
    return (
        f"Of {count} {len(fell):,} first fall at {_factor(weakest, 'overturning')} times their "
        f"motion{_intensity(weakest, 'overturning', intensity)} to "
        f"{_factor(strongest, 'overturning')} times"
        f"{_intensity(strongest, 'overturning', intensity)}, half of them at up to {middle} times."
    )


def _factor(row: pd.Series[Any], end: str) -> str:
    """The factor at an end of a lane's bracket."""
    return number_of(f"{end}_factor", float(row[f"{end}_factor"]))


def _factors(ladder: Facts) -> str:
    """The factors between which it was looked."""
    ends = (number_of(f"{end}_factor", ladder[end]) for end in ("lowest", "highest"))
    return " to ".join(ends)


def _intensity(row: pd.Series[Any], end: str, intensity: str) -> str:
    """The intensity at an end of a lane's bracket, with its unit; empty of the factor itself."""
    if intensity == FACTOR:
        return ""
    value, seen = float(row[f"{end}_{intensity}"]), measure(intensity)
    unit = input_meaning(intensity)[0]
    own = "" if unit == seen.unit else f"{number_of(intensity, value)} {unit}, "
    return f" ({heading(intensity).text} {own}{seen.text(value)})"


def _sentences(facts: Facts, lanes: pd.DataFrame, left_out: int) -> list[str]:
    """How the lanes fell, what was run for it, and what limits the numbers."""
    verdicts = lanes["verdict"].astype(str).value_counts()
    counts = [f"{count:,} {str(word).replace('_', ' ')}" for word, count in verdicts.items()]
    ladder, again = facts["incremental"], int((lanes["resurrections"] > 0).sum())
    found = [
        f"Of {counted(len(lanes), 'lane')}: {listed(counts)}; {counted(again, 'lane')} stood again "
        "at a stronger motion than the first that felled them.",
        f"Factors from {_factors(ladder)}, brackets to {value_of(ladder, 'accuracy')}: "
        f"{facts['runs']:,} runs in {counted(facts['stages'], 'stage')}, "
        f"{facts['stages_kept']} of them kept from before.",
    ]
    if facts.get("tolerance") is None:
        found.append("Errors were not estimated: nothing says how far the time step matters.")
    elif facts["runs_missed_tolerance"]:
        found.append(
            f"Not within {value_of(facts, 'tolerance')} of the slenderness angle at the finest "
            f"step tried: {counted(facts['runs_missed_tolerance'], 'run')}; close to a fall nearly "
            "all are sensitive. What that does to the capacities is seen with a smaller time step "
            "(-s engines. ...)."
        )
    if facts["undecided_runs"]:
        found.append(
            f"Undecided: {counted(facts['undecided_runs'], 'run')} in which nothing had fallen by "
            "the end, but blocks still moved or were still shaken; they count as standing."
        )
    if left_out:
        found.append(f"Left out: {counted(left_out, 'lane')} whose numbers cannot be used.")
    return found


def _group_sheet(rows: pd.DataFrame, groups: Sequence[str], intensity: str) -> Sheet:
    """The capacities of every group."""
    cells = [
        [*(str(row[name]) for name in groups), *(f"{row[name]:,}" for name in _COUNTS),
         *fit_cells(row)]
        for _, row in rows.iterrows()
    ]  # fmt: skip
    heads = [*map(heading, groups), *map(Heading, _COUNTS.values())]
    return Sheet(
        f"Capacity to stand over {intensity}",
        [*heads, median_heading(intensity), Heading("dispersion")],
        cells,
        "In brackets: 5th and 95th percentile over records. Stood again: lanes that stood at a "
        "stronger motion than the first that felled them.",
    )
