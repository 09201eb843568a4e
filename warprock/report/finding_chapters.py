"""Chapters of findings: what a command came to, as its folder tells it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from warprock.findings import asked
from warprock.findings.finding import Facts, Finding, Kind
from warprock.findings.lanes import needed
from warprock.findings.run import tell_run
from warprock.findings.sweep import find_sweep, sweep_facts
from warprock.report.content import Chapter
from warprock.report.folder import ResultFolder
from warprock.running.lane_table import LANE_TABLE
from warprock.running.results import CELL_TABLE
from warprock.sweeps.plan import read_plan

Scenes = Mapping[str, Any]


def finding_chapter(
    folder: ResultFolder, finding: Finding, facts: Facts, scenes: Scenes | None
) -> Chapter:
    """The chapter of what a command came to.

    Args:
        folder: Its folder.
        finding: What it came to.
        facts: What `run.json` says of it; of a sweep, what its plan says.
        scenes: Lanes to play; None where there are none.
    """
    # Facts of a comparison have the name of the case at `case`, and the case at `asked`.
    named = (facts[key] for key in ("case", "asked") if isinstance(facts.get(key), dict))
    case: Facts = next(named, {})
    engine = facts.get("engine")
    name = engine.get("name", "") if isinstance(engine, Mapping) else engine
    about = {**facts, "case": case}
    return Chapter(
        kind=f"{finding.kind}, {name}" if name else finding.kind,
        title=finding.title or case["title"],
        found=finding.sentences,
        asked=[*asked.asked(about, finding.tables.get(LANE_TABLE)), *finding.asked],
        background=[case["source"]] if case.get("source") else [],
        scenes=scenes,
        pictures=folder.pictures(*finding.pictures),
        sheets=finding.sheets,
        words=asked.words(facts),
        provenance=asked.provenance_pairs(facts),
        citations=asked.citations(about),
    )


def teller(kind: Kind) -> Callable[[ResultFolder, Scenes | None], Chapter]:
    """What makes the chapter of a kind of findings of a folder."""

    def make(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
        files = {name: name if "." in name else f"{name}.parquet" for name in kind.tables}
        tables = {name: folder.table(file) for name, file in files.items()}
        if kind.key:
            return finding_chapter(folder, kind.tell(folder.facts, tables), folder.facts, scenes)
        # Facts, and lanes to play, are those of the run that it may lie beside.
        of_run = ("versions", "finished", "kernel_sha256")
        versions: Facts = {key: folder.facts[key] for key in of_run if key in folder.facts}
        shown = None if folder.has(LANE_TABLE) else scenes
        return finding_chapter(folder, kind.tell({}, tables), versions, shown)

    return make


def run_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of a run or an ensemble."""
    tables = {LANE_TABLE: folder.table(LANE_TABLE, needed(folder.facts))}
    if folder.has(CELL_TABLE):
        tables[CELL_TABLE] = folder.table(CELL_TABLE)
    return finding_chapter(folder, tell_run(folder.facts, tables), folder.facts, scenes)


def sweep_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of a sweep: its plan, how far it is, and its lanes once they are merged."""
    plan = read_plan(folder.path)
    facts, lanes = sweep_facts(plan, folder.path), None
    if folder.has(LANE_TABLE):
        lanes = folder.table(LANE_TABLE, needed(facts))
    return finding_chapter(folder, find_sweep(plan, folder.path, lanes), facts, scenes)
