"""What the atlas of extremes came to: where each engine may be trusted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from warprock.findings.digits import number_of, quantity_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.numbers import counted
from warprock.findings.plain import plain
from warprock.findings.sheets import Heading, Sheet
from warprock.measure.atlas_summary import BOUNDS, explain_words, summarise
from warprock.model.response import USABLE_NAMES
from warprock.running.run_file import COUNTS, ROWS

TABLE, SUMMARY = "stability.csv", "summary.md"
TITLE = "Where each engine may be trusted"
_WITHIN = {f"within_{number_of('level', bound)}": bound for bound in BOUNDS}


def find_stability(table: pd.DataFrame) -> Finding:
    """What an atlas came to.

    Args:
        table: What `measure.atlas.run_atlas` returned.
    """
    facts = plain({"explained": explain_words(), **summarise(table)})
    return tell_stability(facts, {TABLE: pd.DataFrame(map(_count, facts["engines"]))})


def tell_stability(facts: Facts, tables: Tables) -> Finding:
    """What an atlas came to, of its facts."""
    absurd = sum(entry["absurd"] for entry in facts["engines"])
    has = "has an absurd one" if absurd == 1 else "have absurd ones"
    lines = [
        (
            entry,
            [*entry["sentences"], *(f"Defect: {_defect(row)}" for row in _defects(facts, entry))],
        )
        for entry in facts["engines"]
    ]
    return Finding(
        kind="Stability",
        title=f"{TITLE}: the atlas of extremes",
        facts=facts,
        tables=tables,
        sentences=[
            f"{counted(absurd, 'lane')} whose status lets its number pass {has}.",
            facts["explained"],
        ],
        sheets=[
            _count_sheet(facts),
            Sheet(
                "Every engine in sentences",
                [Heading("engine"), Heading("precision"), Heading("what its lanes say")],
                [[e["engine"], e["precision"], line] for e, texts in lines for line in texts],
            ),
        ],
        pictures=["*.png"],
        texts={SUMMARY: _markdown(facts, lines)},
        then="warprock trade",
    )


STABILITY = Kind(
    (TABLE,),
    tell_stability,
    "defects",
    {
        "explained": str,
        "engines": [
            {
                **dict.fromkeys(("engine", "precision"), str),
                **dict.fromkeys(("lanes", "grew", "absurd", "compared"), int),
                **dict.fromkeys(_WITHIN, (float, None)),
                "status": COUNTS,
                "sentences": [str],
            }
        ],
        "defects": ROWS,
    },
)


def _count(entry: Mapping[str, Any]) -> dict[str, Any]:
    """What became of the lanes of an engine and precision."""
    passed = set(USABLE_NAMES)
    refused = sum(count for name, count in entry["status"].items() if name not in passed)
    counts = {name: entry[name] for name in ("grew", "absurd", "compared", *_WITHIN)}
    named = {name: entry[name] for name in ("engine", "precision", "lanes")}
    return {**named, "no_number": refused, **counts}


def _count_sheet(facts: Facts) -> Sheet:
    """What became of the lanes of every engine and precision, a row each."""
    rows = []
    for entry in facts["engines"]:
        *words, within, nearly = _count(entry).values()
        shares = [quantity_of("compared_share", share) for share in (within, nearly)]
        rows.append([*map(str, words), *shares])
    names = ("engine", "precision", "lanes", "no number", "grew", "absurd", "compared")
    bounds = [f"error <= {number_of('error_bound', bound)}" for bound in BOUNDS]
    heads = [*map(Heading, names), *map(Heading, bounds)]
    return Sheet("Atlas of extremes", heads, rows)


def _markdown(facts: Facts, lines: list[tuple[Mapping[str, Any], list[str]]]) -> str:
    """The summary as Markdown, an engine and precision a section."""
    text = [f"# {TITLE}", "", facts["explained"], ""]
    for entry, sentences in lines:
        text += [f"## {entry['engine']}, {entry['precision']}", ""]
        text += [*(f"- {sentence}" for sentence in sentences), ""]
    return "\n".join(text)


def _defects(facts: Facts, entry: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    names = ("engine", "precision")
    return [row for row in facts["defects"] if all(row[name] == entry[name] for name in names)]


def _defect(row: Mapping[str, Any]) -> str:
    """One lane in words, with what it takes to run it again."""
    left_out = ("engine", "precision", "of", "usable", "compared", "absurd", "grew", "map")
    parts = [
        f"{name} {number_of('input', value)}" if isinstance(value, float) else f"{name} {value}"
        for name, value in row.items()
        if name not in left_out
    ]
    return f"Defect: map {row['map']} (one of {row['of']} lanes): {', '.join(parts)}"
