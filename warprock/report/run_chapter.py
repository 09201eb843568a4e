"""The chapter of a run: what became of its lanes, the lanes to play, its figures and tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warprock.report import asked
from warprock.report.content import Chapter
from warprock.report.folder import ResultFolder
from warprock.report.lanes import lane_sheet, needed
from warprock.report.numbers import sheet_of
from warprock.report.sentences import cell_sentences, run_sentences
from warprock.running.lane_table import LANE_TABLE
from warprock.running.results import CELL_TABLE

FIGURES = ("histories.png", "space.png", "ensemble*.png", "peaks*.png")


def run_chapter(folder: ResultFolder, scenes: Mapping[str, Any] | None) -> Chapter:
    """The chapter of a run or an ensemble.

    Args:
        folder: Its folder, which holds its lane table and `run.json`.
        scenes: Lanes to play; None where there are none.
    """
    facts = folder.facts
    table = folder.table(LANE_TABLE, needed(facts))
    case, found = facts["case"], run_sentences(facts, table)
    kind, sheets = "Run", []
    if folder.has(CELL_TABLE):
        cells = folder.table(CELL_TABLE)
        kind, found = "Ensemble", [*found, *cell_sentences(cells)]
        sheets.append(sheet_of("Cells of the ensemble", cells, file=CELL_TABLE))
    sheets.append(lane_sheet(facts, table, file=LANE_TABLE, folded=bool(sheets)))
    return Chapter(
        kind=f"{kind}, {facts['engine']['name']}",
        title=case["title"],
        found=found,
        asked=asked.asked(facts, table),
        background=[case["source"]] if case.get("source") else [],
        scenes=scenes,
        pictures=folder.pictures(*FIGURES),
        sheets=sheets,
        words=asked.words(facts),
        provenance=asked.provenance_pairs(facts),
        citations=asked.citations(facts),
    )
