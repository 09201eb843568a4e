"""Capacities of an incremental dynamic analysis: on the terminal, as JSON and as files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd
from rich.console import Console

from warprock.analysis.capacities import (
    Capacities,
    capacity_rows,
    lane_rows,
    run_rows,
    undecided_runs,
)
from warprock.analysis.incremental import Analysis
from warprock.case.case import Case
from warprock.model.words import lane_count_text
from warprock.run.provenance import case_facts, surroundings
from warprock.tables.fragility import fit_cells, fit_sentence
from warprock.tables.report import Report
from warprock.tables.terminal import plain_table, print_table, stdout


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
    rows, facts = capacity_rows(groups), analysis_facts(found)
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
        came_out=fit_sentence(rows, intensity, "overturning"),
        then="warprock map overturning-map -o results/map",
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
    out.print(
        f"factors {low:g} to {high:g}, brackets to {accuracy:.3g}; {facts['runs']:,} runs in "
        f"{found.stages} stages, {found.kept} of them kept from before",
        highlight=False,
    )
    _print_accuracy(out, facts)
    if facts["undecided_runs"]:
        out.print(
            f"undecided: {facts['undecided_runs']:,} runs in which the block had not fallen by the "
            f"end, {found.lane_set.duration_text}, but still rocked or was still shaken; they "
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
