"""Capacities of an incremental dynamic analysis: on the terminal, as JSON and as files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd
from rich.console import Console

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
from warprock.model.words import lane_count_text
from warprock.running.provenance import case_facts, surroundings
from warprock.tables.fragility import fit_cells, fit_sentence
from warprock.tables.report import Report
from warprock.tables.terminal import heading_text, plain_table, print_table, stdout
from warprock.units import GRAVITY


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


def factor_sentence(found: Analysis, intensity: str) -> str:
    """By how much motions must be scaled, in words: the factor at which lanes first fall."""
    rows, ladder = lane_rows(found, intensity), found.plan.content["incremental"]
    verdicts = rows["verdict"].to_numpy(dtype=object)
    fell = rows[verdicts == Verdict.BRACKETED.value]
    highest, lowest = ladder["highest"], ladder["lowest"]
    if len(rows) == 1:
        row = rows.iloc[0]
        what = "The stack" if found.lane_set.lanes.stacked else "The block"
        if row["verdict"] == Verdict.BRACKETED.value:
            factor, at = row["overturning_factor"], _intensity(row, "overturning", intensity)
            return (
                f"{what} first falls at {factor:.4g} times its motion{at}; at "
                f"{row['standing_factor']:.4g} times it stands."
            )
        if row["verdict"] == Verdict.ABOVE.value:
            top, at = row["standing_factor"], _intensity(row, "standing", intensity)
            return f"{what} stands at up to {top:.4g} times its motion{at}: a larger --to goes on."
        at = _intensity(row, "overturning", intensity)
        return (
            f"{what} falls at once, at {row['overturning_factor']:.4g} times its motion{at}: "
            "a smaller --from finds where it stands."
        )
    count = lane_count_text(len(rows))
    if fell.empty:
        never = int((verdicts == Verdict.ABOVE.value).sum())
        return (
            f"Of {count} {never:,} stand at every factor up to {highest:g} and the others fall "
            f"already at {lowest:g} times their motion."
        )
    factors = fell["overturning_factor"]
    weakest, strongest = fell.loc[factors.idxmin()], fell.loc[factors.idxmax()]
    return (
        f"Of {count} {len(fell):,} first fall at {factors.min():.4g} times their motion"
        f"{_intensity(weakest, 'overturning', intensity)} to {factors.max():.4g} times"
        f"{_intensity(strongest, 'overturning', intensity)}, half of them at up to "
        f"{factors.median():.4g} times."
    )


def _intensity(row: pd.Series[Any], end: str, intensity: str) -> str:
    """The intensity at an end of a lane's bracket, with its unit; empty of the factor itself."""
    if intensity == FACTOR:
        return ""
    name, _, unit = heading_text(intensity).partition(" [")
    value = float(row[f"{end}_{intensity}"])
    unit = unit.removesuffix("]")
    if unit == "m/s^2":
        return f" ({name} {value:.3g} m/s^2, {value / GRAVITY:.3g} g)"
    return f" ({name} {value:.3g}{f' {unit}' if unit else ''})"


def analysis_report(
    found: Analysis, case: Case, groups: Sequence[Capacities], intensity: str
) -> Report:
    """What an incremental analysis has to show.

    Its files are the capacities of the lanes and of their groups, every run, and what ran.

    Args:
        found: The analysis.
        case: Its case.
        groups: Capacities of the groups of lanes.
        intensity: The intensity measure.
    """
    rows, sentence = capacity_rows(groups), factor_sentence(found, intensity)
    facts = analysis_facts(found) | {"sentence": sentence}
    fitted = fit_sentence(rows, intensity, "overturning") if len(found.capacities) > 1 else ""
    return Report(
        json={
            "case": case.name,
            "intensity": intensity,
            **facts,
            "groups": rows.to_dict("records"),
        },
        tables={
            "capacities": lane_rows(found, intensity),
            "curves": run_rows(found, intensity),
            "fragility": rows,
        },
        facts={"case": case_facts(case), **facts, "intensity": intensity, **surroundings(case)},
        show=lambda: print_analysis(found, rows, intensity),
        came_out=f"{sentence} {fitted}".rstrip(),
    )


def print_analysis(
    found: Analysis,
    rows: pd.DataFrame,
    intensity: str,
    console: Console | None = None,
) -> None:
    """Prints the capacities of every group.

    Args:
        found: The analysis.
        rows: What `analysis.capacities.capacity_rows` returned.
        intensity: The intensity measure.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    groups = [str(name) for name in rows.columns[: list(rows.columns).index("lanes")]]
    counted = ["lanes", "records", "bracketed", "never_overturned", "overturned_at_once"]
    named = ["lanes", "records", "bracketed", "never\nfell", "fell at\nonce", "stood\nagain"]
    headings = [*groups, *named, "median", "dispersion"]
    facts = analysis_facts(found)
    title = f"Capacity to stand over {intensity}, {found.plan.engine}"
    table = plain_table(title, headings, groups)
    for _, row in rows.iterrows():
        table.add_row(
            *(str(row[name]) for name in groups),
            *(f"{row[name]:,}" for name in (*counted, "lanes_resurrected")),
            *fit_cells(row),
        )
    print_table(out, table)
    out.print("  in brackets: 5th and 95th percentile over records")
    out.print(
        "  stood again: lanes that stood at a stronger motion than the first that felled them"
    )
    low, high = (facts["incremental"][name] for name in ("lowest", "highest"))
    accuracy = facts["incremental"]["accuracy"]
    stages = f"{found.stages} {'stage' if found.stages == 1 else 'stages'}"
    out.print(
        f"factors {low:g} to {high:g}, brackets to {accuracy:.3g}; {facts['runs']:,} runs in "
        f"{stages}, {found.kept} of them kept from before",
        highlight=False,
    )
    _print_accuracy(out, facts)
    if facts["undecided_runs"]:
        out.print(
            f"undecided: {facts['undecided_runs']:,} runs in which the block had not fallen by the "
            f"end, {found.lane_set.duration_text}, but still moved or was still shaken; they "
            "count as standing",
            highlight=False,
        )
    left_out = int(rows["left_out"].sum())
    if left_out:
        out.print(f"left out: {lane_count_text(left_out)} whose numbers cannot be used")


def _print_accuracy(out: Console, facts: dict[str, Any]) -> None:
    """How many runs missed the tolerance, and what to do."""
    if facts["tolerance"] is None:
        out.print("errors were not estimated (--no-estimate)")
    elif facts["runs_missed_tolerance"]:
        out.print(
            f"not within {facts['tolerance']:g} of the slenderness angle at the finest step tried: "
            f"{facts['runs_missed_tolerance']:,} runs; close to a fall nearly all are sensitive. "
            "What that does to the capacities is seen with a smaller time step (-s engines. ...)",
            highlight=False,
            soft_wrap=True,
        )
