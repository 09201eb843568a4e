"""Chapters of findings: what a command came to, as its folder tells it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from warprock.findings import asked
from warprock.findings.finding import Finding, Kind
from warprock.findings.fragility import FRAGILITY
from warprock.findings.lanes import needed
from warprock.findings.run import tell_run
from warprock.findings.sheets import heading
from warprock.report.content import Chapter
from warprock.report.folder import ResultFolder
from warprock.running.lane_table import LANE_TABLE
from warprock.running.results import CELL_TABLE

Scenes = Mapping[str, Any]


def finding_chapter(folder: ResultFolder, finding: Finding, scenes: Scenes | None) -> Chapter:
    """The chapter of what a command came to.

    Args:
        folder: Its folder.
        finding: What it came to.
        scenes: Lanes to play; None where there are none.
    """
    facts = folder.facts
    if not isinstance(facts.get("case"), Mapping):
        facts = {**facts, "case": facts["asked"]}
    case, engine = facts["case"], facts.get("engine")
    name = engine.get("name", "") if isinstance(engine, Mapping) else engine
    return Chapter(
        kind=f"{finding.kind}, {name}" if name else finding.kind,
        title=case["title"],
        found=finding.sentences,
        asked=[*asked.asked(facts, finding.tables.get(LANE_TABLE)), *finding.asked],
        background=[case["source"]] if case.get("source") else [],
        scenes=scenes,
        pictures=folder.pictures(*finding.pictures),
        sheets=finding.sheets,
        words=asked.words(facts),
        provenance=asked.provenance_pairs(facts),
        citations=asked.citations(facts),
    )


def teller(kind: Kind) -> Callable[[ResultFolder, Scenes | None], Chapter]:
    """What makes the chapter of a kind of findings of a folder."""

    def make(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
        files = {name: name if "." in name else f"{name}.parquet" for name in kind.tables}
        tables = {name: folder.table(file) for name, file in files.items()}
        return finding_chapter(folder, kind.tell(folder.facts, tables), scenes)

    return make


def run_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of a run or an ensemble."""
    tables = {LANE_TABLE: folder.table(LANE_TABLE, needed(folder.facts))}
    if folder.has(CELL_TABLE):
        tables[CELL_TABLE] = folder.table(CELL_TABLE)
    return finding_chapter(folder, tell_run(folder.facts, tables), scenes)


def fragility_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of fragility functions, which may lie beside the run that they are of."""
    finding = FRAGILITY.tell({}, {name: folder.table(name) for name in FRAGILITY.tables})
    intensity = dict(finding.asked)["Intensity measure"]
    return Chapter(
        kind=finding.kind,
        title=f"Fragility over {heading(intensity).text}",
        found=finding.sentences,
        asked=finding.asked,
        pictures=folder.pictures(*finding.pictures),
        # Beside a run the player is that of the run.
        scenes=None if folder.has(LANE_TABLE) else scenes,
        sheets=finding.sheets,
        citations=asked.citations(folder.facts),
    )
