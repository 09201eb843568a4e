"""The chapter of the seed paper on a page: every table and figure beside ours, every conflict."""

from __future__ import annotations

import itertools
import json
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from warprock.paper.print_families import FAMILIES
from warprock.paper.print_tables import by_target, print_target
from warprock.paper.printed import PAPER_NAMES
from warprock.report import asked
from warprock.report.content import Chapter, Heading, Proof, Sheet
from warprock.report.folder import ResultFolder
from warprock.report.numbers import counted, three
from warprock.running.files import replacing
from warprock.running.machine import core_count, cpu_name, kernel_hash, package_versions
from warprock.running.provenance import PACKAGES
from warprock.tables.terminal import Row

FOUND = "reproduce.json"
"""What was reproduced so far in a folder."""

GOOD = 1e-2
"""Error over the slenderness angle up to which an engine is called right."""


def keep(found: Mapping[str, Any], folder: pathlib.Path) -> pathlib.Path:
    """Keeps what was reproduced in a folder, beside other targets of before.

    Args:
        found: What `paper.reproduce.reproduce` returned.
        folder: The folder.
    """
    path = folder / FOUND
    before = ResultFolder(folder).json(FOUND) if path.is_file() else {}
    targets = {row["target"] for row in found["rows"]}
    items = {conflict["item"] for conflict in found["conflicts"]}
    files = [pathlib.Path(file).name for file in found["files"]]
    rows = [row for row in before.get("rows", []) if row["target"] not in targets]
    conflicts = [each for each in before.get("conflicts", []) if each["item"] not in items]
    kept = {
        "rows": [*rows, *found["rows"]],
        "conflicts": sorted([*conflicts, *found["conflicts"]], key=lambda each: each["item"]),
        "files": list(dict.fromkeys([*before.get("files", []), *files])),
        "versions": package_versions(PACKAGES),
        "kernel_sha256": kernel_hash(),
        "machine": {"cpu": cpu_name(), "cores": core_count(), "vector_flags": []},
    }
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(kept, ensure_ascii=False) + "\n", encoding="utf-8")
    return path


def paper_chapter(folder: ResultFolder) -> Chapter:
    """The chapter of what was reproduced in a folder."""
    found = folder.json(FOUND)
    rows, shown = found["rows"], set[str]()
    grouped = by_target(rows)
    order = [*(target for target in _TITLES if target in grouped), *(set(grouped) - set(_TITLES))]
    parts = [_part(folder, target, grouped[target], shown) for target in order]
    verdicts = [_verdict(engine, rows) for engine in _engines(rows)]
    names = [part.kind for part in parts]
    return Chapter(
        kind="The seed paper",
        title="The seed paper, recomputed: its numbers beside ours",
        found=[
            f"{counted(len(parts), 'table or figure', 'tables and figures')} of the paper "
            f"recomputed: {', '.join(names)}.",
            *_lead(rows),
            f"{counted(len(found['conflicts']), 'conflict')} of the paper with itself, each with "
            "its proof below.",
        ],
        asked=[
            ("Paper", asked.BENCHMARK),
            ("Ours", "the shipped cases, each engine at the settings that its case has"),
            ("Readings", "every reading of the input that the paper allows, side by side"),
        ],
        sheets=[_verdict_sheet(verdicts)] if verdicts else [],
        parts=parts,
        proofs_title="Conflicts in the paper",
        proofs=[
            Proof(f"{each['item']}. {each['title']}", each["text"]) for each in found["conflicts"]
        ],
        provenance=asked.provenance_pairs(found),
        citations=asked.citations(found, [asked.BENCHMARK]),
    )


def _part(folder: ResultFolder, target: str, rows: Sequence[Row], shown: set[str]) -> Chapter:
    """One table or figure of the paper."""
    kept = _Kept()
    print_target(kept, target, rows, shown)
    name = target_name(target)
    return Chapter(
        kind=name,
        title=_TITLES.get(target, name),
        pictures=folder.pictures(f"{target}.png", f"{target}-*.png"),
        sheets=kept.sheets,
    )


_TITLES = {
    "table6": "Peaks of the single block under one cycle of sine",
    "table7": "Peaks of the single block under continuous sine",
    "table7-spatial": "The same in space: how far blocks leave the plane",
    "fig4": "Free rocking of B0, and what settings do to it",
    "fig5": "Free rocking of B1 to B3",
    "fig7": "Rotation of the single block under one cycle of sine",
    "fig8": "Peaks over normalised acceleration, one cycle of sine",
    "fig10": "Rotation of the single block under continuous sine",
    "fig11": "Peaks over normalised acceleration, continuous sine",
    "table9": "Top block of the stack under one cycle of sine",
    "table10": "Bottom block of the stack under one cycle of sine",
    "table11": "Top block of the stack under continuous sine",
    "table12": "Bottom block of the stack under continuous sine",
    "collapse": "Collapse of the stack over friction and chamfer",
    "dem": "What the springs of the distinct-element model do",
    "times": "Run times",
}


def target_name(target: str) -> str:
    """A target as a reader knows it: `table6` is `Table 6`."""
    for word, name in (("table", "Table"), ("fig", "Figure")):
        if target.startswith(word):
            return f"{name} {target.removeprefix(word)}".replace("-", " ")
    return target.capitalize()


def _lead(rows: Sequence[Row]) -> list[str]:
    """The engine that keeps closest to Housner, and the one farthest from him."""
    errors = {name: max(found) for name in _engines(rows) if (found := _errors(name, rows))}
    if not errors:
        return []
    best, worst = min(errors, key=errors.__getitem__), max(errors, key=errors.__getitem__)
    text = (
        f"Where Housner's solution holds, {best} differs from it by at most "
        f"{three(errors[best])} of the slenderness angle over the first 5 s"
    )
    return [f"{text}, {worst} by at most {three(errors[worst])}." if worst != best else f"{text}."]


def _engines(rows: Sequence[Row]) -> list[str]:
    found = dict.fromkeys(str(row["source"]) for row in rows)
    return [name for name in found if not name.startswith(("paper-", "inferred"))]


def _errors(engine: str, rows: Sequence[Row]) -> list[float]:
    """Errors against Housner in the first 5 s, a lane each in which he holds."""
    return [
        row["error_5s_ratio"]
        for row in rows
        if row["source"] == engine
        and engine != "housner"
        and row.get("holds")
        and row.get("setting") is None
        and row.get("error_5s_ratio") is not None
    ]


def _verdict(engine: str, rows: Sequence[Row]) -> tuple[str, ...]:
    """One engine: what it was held against, how far off it was, and what follows."""
    mine = [row for row in rows if row["source"] == engine]
    found = _errors(engine, rows)
    error, median = (max(found), float(np.median(found))) if found else (None, None)
    off = _from_paper(engine, rows)
    family = {ours: PAPER_NAMES[name] for name, ours in FAMILIES}.get(engine, "")
    if engine == "housner":
        family, text = PAPER_NAMES["analytical"], "the reference of single blocks that do not slide"
    elif engine == "oracle":
        text = "holds housner to account: another solution of the same equations"
    elif engine == "two-block":
        text = "the reference of pairs of blocks that do not slide"
    elif error is None:
        text = "no reference here says how far off it is"
    elif error <= GOOD:
        text = f"right within {GOOD:g} of the slenderness angle"
    elif median is not None and median <= GOOD:
        text = f"within {GOOD:g} of the slenderness angle in most lanes, not in all"
    else:
        text = f"beyond {GOOD:g} of the slenderness angle: another model, or too long a step"
    if engine == "dem":
        text = "answers another question: the springs of the paper's Table 5, not rigid contact"
    beside = "-" if off is None else f"{off:+.1f} %"
    return engine, f"{len(mine):,}", three(median), three(error), family or "-", beside, text


def _from_paper(engine: str, rows: Sequence[Row]) -> float | None:
    """Mean difference of Table 6's peaks from the paper's program of its family [%]."""
    column = {ours: name for name, ours in FAMILIES}.get(engine)
    peaks = {
        (row["source"], row["frequency_hz"], row["amplitude_mm"]): row["peak_rotation_ratio"]
        for row in rows
        if row["target"] == "table6" and row["reading"] in ("displacement", "as printed")
    }
    pairs = [
        (peak, peaks[f"paper-{column}", *key[1:]])
        for key, peak in peaks.items()
        if key[0] == engine and (f"paper-{column}", *key[1:]) in peaks
    ]
    if not pairs:
        return None
    return 100.0 * float(np.mean([ours / theirs - 1.0 for ours, theirs in pairs]))


def _verdict_sheet(rows: Sequence[tuple[str, ...]]) -> Sheet:
    return Sheet(
        "Verdict by engine",
        [
            Heading("engine"),
            Heading("rows", "", "Numbers of it on this page"),
            Heading("median error", "", "Median over lanes of the error, as in the next column"),
            Heading(
                "largest error",
                "",
                "Largest |rotation - Housner's| / slenderness angle in the first "
                "5 s, over the lanes in which Housner holds",
            ),
            Heading("program of its family", "", "Program of the paper that works alike"),
            Heading(
                "from it",
                "",
                "Mean difference of the peaks of Table 6 from that program's, displacement reading",
            ),
            Heading("verdict"),
        ],
        rows,
    )


class _Kept(Console):
    """A console that keeps tables as sheets of a page, and lines as notes below them."""

    def __init__(self) -> None:
        super().__init__(width=130)
        self.sheets: list[Sheet] = []

    def print(self, *objects: Any, **_options: Any) -> None:
        """Keeps what would be printed."""
        for each in objects:
            if isinstance(each, Table):
                self.sheets.append(_sheet(each))
            elif str(each).strip() and self.sheets:
                last = self.sheets[-1]
                note = f"{last.note} {str(each).strip().rstrip('.')}.".strip()
                self.sheets[-1] = Sheet(last.title, last.headings, last.rows, note)


def _sheet(table: Table) -> Sheet:
    """A table of the terminal as one of a page: cells that repeat those above are written out."""
    columns = [[_plain(cell) for cell in column.cells] for column in table.columns]
    rows = [list(row) for row in zip(*columns, strict=True)]
    for above, row in itertools.pairwise(rows):
        row[0] = row[0] or above[0]
    heads = [Heading(" ".join(_plain(column.header).split())) for column in table.columns]
    return Sheet(" ".join(_plain(table.title or "").split()), heads, rows)


def _plain(text: Any) -> str:
    return str(text).strip()
