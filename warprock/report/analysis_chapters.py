"""Chapters of the analyses of a case: overturning maps, spectra, Sobol' indices, studies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pandas as pd

from warprock.findings import asked
from warprock.findings.finding import Finding, Kind
from warprock.findings.fragility import FRAGILITY
from warprock.findings.lanes import needed
from warprock.findings.run import tell_run
from warprock.findings.sheets import Sheet, heading
from warprock.report.content import Chapter, Picture
from warprock.report.folder import ResultFolder
from warprock.running.lane_table import LANE_TABLE
from warprock.running.results import CELL_TABLE

Scenes = Mapping[str, Any]


def chapter_of_case(
    folder: ResultFolder,
    kind: str,
    found: Sequence[str],
    *,
    pictures: Sequence[Picture],
    sheets: Sequence[Sheet],
    scenes: Scenes | None = None,
    more: Sequence[tuple[str, str]] = (),
    lanes: pd.DataFrame | None = None,
) -> Chapter:
    """A chapter of what one case, run by one engine, gave.

    Args:
        folder: Its folder, which holds `run.json`.
        kind: What it is.
        found: What came out.
        pictures: Its figures.
        sheets: Its tables.
        scenes: Lanes to play; None where there are none.
        more: What was asked besides.
        lanes: Its lane table, where what was asked is told of it.
    """
    facts = folder.facts
    case, engine = facts["case"], facts.get("engine")
    name = engine.get("name", "") if isinstance(engine, Mapping) else engine
    return Chapter(
        kind=f"{kind}, {name}" if name else kind,
        title=case["title"],
        found=found,
        asked=[*asked.asked(facts, lanes), *more],
        background=[case["source"]] if case.get("source") else [],
        scenes=scenes,
        pictures=pictures,
        sheets=sheets,
        words=asked.words(facts),
        provenance=asked.provenance_pairs(facts),
        citations=asked.citations(facts),
    )


def finding_chapter(folder: ResultFolder, finding: Finding, scenes: Scenes | None) -> Chapter:
    """The chapter of what an analysis came to."""
    return chapter_of_case(
        folder,
        finding.kind,
        finding.sentences,
        pictures=folder.pictures(*finding.pictures),
        sheets=finding.sheets,
        scenes=scenes,
        more=finding.asked,
        lanes=finding.tables.get(LANE_TABLE),
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
