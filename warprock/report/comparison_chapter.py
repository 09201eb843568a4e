"""The chapter of engines side by side on one case."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from warprock.findings import asked
from warprock.findings.numbers import counted, listed, three
from warprock.findings.sheets import Heading, Sheet, sheet_of
from warprock.report.content import Chapter
from warprock.report.folder import ResultFolder

Scenes = Mapping[str, Any]

_WANTED = (
    *("lane", "block", "cell", "engine", "engine_a", "engine_b", "outcome", "status"),
    *("peak_rotation_ratio", "error_5s_ratio", "error_run_ratio", "peak_error"),
    *("difference_5s_ratio", "difference_run_ratio", "rest_time_error_s", "peak_slide_mm"),
    *("difference_across_5s_ratio", "difference_yaw_5s_rad", "holds", "why"),
    *("position_error_mm", "rotation_error_deg", "same_face"),
)
"""Columns of lanes that a page shows, of those that a comparison has."""


def comparison_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of a comparison.

    Args:
        folder: Its folder.
        scenes: Lanes to play; None where there are none.
    """
    facts, table = folder.facts, folder.table("comparison.parquet")
    case = facts["asked"]
    wanted = [name for name in _WANTED if name in table]
    if "cell" in table:
        wanted = [str(name) for name in table]
    found = [f"{counted(len(facts['engines']), 'engine')} on the same lanes: "
             f"{listed(facts['engines'])}."]  # fmt: skip
    engines = list(_engines(table))
    found += [sentence for sentence, _ in engines]
    sheets = [_summary([row for _, row in engines])] if engines else []
    lanes = table[wanted]
    sheets.append(sheet_of("Lane by lane", lanes.rename(columns={"lane": "of lane"}),
                           file="comparison.csv", folded=bool(engines)))  # fmt: skip
    if facts.get("costs"):
        sheets.append(sheet_of("What the programs took", pd.DataFrame(facts["costs"])))
    return Chapter(
        kind="Comparison",
        title=case["title"],
        found=found,
        asked=[*asked.asked({"case": case}), ("Engines", ", ".join(facts["engines"]))],
        background=[case["source"]] if case.get("source") else [],
        scenes=scenes,
        pictures=folder.pictures("*.png"),
        sheets=sheets,
        provenance=asked.provenance_pairs(facts),
        citations=asked.citations({**facts, "case": case}),
    )


def _engines(table: pd.DataFrame) -> Iterator[tuple[str, list[str]]]:
    """A sentence and a row of the summary of every engine, where lanes are compared one by one."""
    name = next((n for n in ("error_run_ratio", "difference_run_ratio") if n in table), None)
    if name is None:
        return
    for engine, rows in table.groupby("engine", sort=False):
        kept = rows[rows["holds"].astype(bool)] if "holds" in rows else rows
        reference = str(rows["reference"].iloc[0]) if "reference" in rows else "Housner"
        off = kept[name].to_numpy(dtype=float)
        off = off[np.isfinite(off)]
        if engine == reference or not len(off):
            continue
        counts = f"{counted(len(off), 'row')}, lanes and blocks" if "block" in rows else ""
        counts = counts or f"{counted(len(off), 'lane')} in which Housner holds"
        yield (
            f"{engine} is within {three(float(off.max()))} of the slenderness angle of "
            f"{reference} over the whole run, {three(float(np.median(off)))} in the median of "
            f"{counts}.",
            [str(engine), reference, f"{len(off):,}", *map(three, (np.median(off), off.max()))],
        )


def _summary(rows: list[list[str]]) -> Sheet:
    text = "Largest |rotation - that of the reference| / slenderness angle over the run"
    heads = [Heading("engine"), Heading("held against"), Heading("rows"),
             Heading("median", "", text), Heading("largest", "", text)]  # fmt: skip
    return Sheet("What it comes to", heads, rows)
