"""Chapters of what was measured of the engines, and of sweeps: trade, stability, sweep."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warprock.report import asked
from warprock.report.content import Chapter, Proof
from warprock.report.folder import ResultFolder
from warprock.report.lanes import lane_sheet, needed
from warprock.report.numbers import counted, listed, sheet_of, three
from warprock.report.sentences import peak_sentences
from warprock.running.lane_table import LANE_TABLE
from warprock.running.provenance import case_facts
from warprock.sweeps.chunks import sweep_state
from warprock.sweeps.plan import read_plan

Scenes = Mapping[str, Any]

LEVEL = 1e-3
"""Error at which engines are compared in a sentence."""


def trade_chapter(folder: ResultFolder, _scenes: Scenes | None) -> Chapter:
    """The chapter of what accuracy costs."""
    table = folder.table("trade.parquet")
    good = table[(table["ok_share"] == 1.0) & (table["error_max"] <= LEVEL)]
    cheapest = []
    for scene, rows in good.groupby("scene", sort=False):
        best = rows.iloc[int(rows["cpu_s_per_simulated_s"].argmin())]
        seconds = float(best["cpu_s_per_simulated_s"])
        cheapest.append(f"{scene}: {best['engine']}, {three(seconds)} CPU s")
    found = [
        f"{counted(len(table), 'setting')} of {listed(sorted(table['engine'].unique()))} were "
        f"measured on {counted(table['scene'].nunique(), 'scene')}.",
        f"The cheapest that keeps every rotation within {LEVEL:g} of the slenderness angle, per "
        f"simulated second of one block: {'; '.join(cheapest)}."
        if cheapest
        else f"No setting kept every rotation within {LEVEL:g} of the slenderness angle.",
    ]
    return Chapter(
        kind="Trade",
        title="What accuracy costs: every engine over its own settings",
        found=found,
        pictures=folder.pictures("trade*.png"),
        sheets=[sheet_of("Settings", table, table.attrs["columns"], file="trade.csv")],
        citations=asked.citations(folder.facts),
    )


def stability_chapter(folder: ResultFolder, _scenes: Scenes | None) -> Chapter:
    """The chapter of the atlas of extremes, from its summary."""
    text = (folder.path / "summary.md").read_text(encoding="utf-8")
    explained, *sections = text.split("\n## ")
    proofs = []
    for section in sections:
        title, _, body = section.partition("\n")
        lines = [line.removeprefix("- ") for line in body.splitlines() if line.strip()]
        proofs.append(Proof(title, " ".join(lines)))
    lead = [line for line in explained.splitlines() if line and not line.startswith("#")]
    return Chapter(
        kind="Stability",
        title="Where each engine may be trusted: the atlas of extremes",
        found=lead,
        pictures=folder.pictures("*.png"),
        proofs=proofs,
        proofs_title="Every engine in sentences",
        citations=asked.citations(folder.facts),
    )


def sweep_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of a sweep: its plan, how far it is, and its lanes once they are merged."""
    plan = read_plan(folder.path)
    state, content = sweep_state(plan, folder.path), plan.content
    case = case_facts(plan.case)
    counts: dict[str, Any] = {name: state[name] for name in ("outcome", "status") if name in state}
    facts: dict[str, Any] = {
        "case": case,
        "engine": content["engine"],
        "precision": content["precision"],
        "device": content["device"],
        "lanes": plan.lane_count,
        "tolerance": content["tolerance"],
        "estimate": content["estimate"],
        **counts,
    }
    done = f"{state['lanes_done']:,} of {plan.lane_count:,} lanes"
    found = [f"{done} are done, in {state['chunks_done']:,} of {state['chunks']:,} chunks."]
    if state["lanes_done"]:
        found.append(f"Of these {asked.outcome_words(state['outcome'])}.")
    sheets, table = [], None
    if folder.has(LANE_TABLE):
        table = folder.table(LANE_TABLE, needed(facts))
        found += peak_sentences(facts, table)
        sheets.append(lane_sheet(facts, table, file=LANE_TABLE))
        if scenes is None:
            text = "Any lane as a moving picture: warprock animate DIR --lane N."
            found.append(text.replace("DIR", str(folder.path)))
    else:
        found.append(f"Next: warprock sweep run {folder.path}, then warprock sweep merge.")
    return Chapter(
        kind=f"Sweep, {plan.engine}",
        title=case["title"],
        found=found,
        asked=[
            *asked.asked(facts, table),
            ("Chunks", f"{plan.chunk_count:,} of {plan.chunk_lanes:,}"),
        ],
        background=[case["source"]] if case["source"] else [],
        scenes=scenes,
        sheets=sheets,
        words=asked.words(facts),
        provenance=[("Plan", f"SHA-256 {plan.id}"), *asked.provenance_pairs(content)],
        citations=asked.citations({**content, "case": case}),
    )
