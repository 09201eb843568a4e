"""The summary of the atlas of extremes: on the terminal, and as a Markdown file."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.model.response import USABLE
from warprock.running.files import replacing
from warprock.tables.terminal import plain_table, print_end, print_table, print_written, stdout

SUMMARY = "summary.md"


def print_atlas(
    found: Mapping[str, Any], files: Sequence[pathlib.Path] = (), console: Console | None = None
) -> None:
    """Prints what `measure.atlas_summary.summarise` returned.

    Args:
        found: Its return value.
        files: Files that were written.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    headings = ["engine", "precision", "lanes", "no number", "grew", "absurd", "compared"]
    table = plain_table(
        "Atlas of extremes",
        [*headings, "error\n<= 1e-3", "error\n<= 1e-2"],
        ("engine", "precision"),
    )
    for entry in found["engines"]:
        table.add_row(entry["engine"], entry["precision"], *_counts(entry))
    print_table(out, table)
    for line in summary_lines(found):
        out.print(line, highlight=False)
    print_written(files, out)
    absurd = sum(entry["absurd"] for entry in found["engines"])
    print_end(
        f"{absurd} lanes that said their numbers may be used had absurd ones.",
        "warprock trade",
        out,
    )


def summary_lines(found: Mapping[str, Any]) -> list[str]:
    """The summary as lines of Markdown, an engine and precision a section."""
    lines = [found["explained"], ""]
    for entry in found["engines"]:
        lines += [f"## {entry['engine']}, {entry['precision']}", ""]
        lines += [f"- {sentence}" for sentence in entry["sentences"]]
        lines += [f"- Defect: {_defect(row)}" for row in found["defects"] if _same(row, entry)]
        lines.append("")
    return lines


def write_summary(found: Mapping[str, Any], folder: pathlib.Path) -> pathlib.Path:
    """Writes the summary as Markdown, whole or not at all."""
    path = folder / SUMMARY
    text = "\n".join(["# Where each engine may be trusted", "", *summary_lines(found)])
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def _counts(entry: Mapping[str, Any]) -> list[str]:
    passed = tuple(status.name.lower() for status in USABLE)
    refused = sum(count for name, count in entry["status"].items() if name not in passed)
    whole = [entry["lanes"], refused, entry["grew"], entry["absurd"], entry["compared"]]
    shares = [entry[name] for name in ("within_0.001", "within_0.01")]
    texts = ["-" if share != share else f"{share:.1%}" for share in shares]
    return [*map(str, whole), *texts]


def _same(row: Mapping[str, Any], entry: Mapping[str, Any]) -> bool:
    return bool(row["engine"] == entry["engine"] and row["precision"] == entry["precision"])


def _defect(row: Mapping[str, Any]) -> str:
    """One lane in words, with what it takes to run it again."""
    left_out = ("engine", "precision", "of", "usable", "compared", "absurd", "grew", "map")
    parts = [
        f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in row.items()
        if name not in left_out
    ]
    return f"map {row['map']} (one of {row['of']} lanes): " + ", ".join(parts)
