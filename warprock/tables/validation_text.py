"""What a validation says, section by section: on the terminal and as Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console

from warprock.errors import one_line
from warprock.running.cells import wilson_interval
from warprock.tables.terminal import heading_text, plain_table, print_table, say, stdout

Facts = Mapping[str, Any]

SMALL_P = 1e-4
"""Chances below this are said to be below it."""


class Section(NamedTuple):
    """One table of a validation.

    Attributes:
        title: What its rows are.
        headings: Its columns; the first `words` of them hold words.
        rows: Texts of the cells.
        words: Columns of words.
        note: What is to be known of it; empty where there is nothing.
    """

    title: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: int = 1
    note: str = ""


def sections(facts: Facts) -> Iterator[Section]:
    """The tables of a validation, those without rows left out.

    Args:
        facts: What `validation.validation_facts` returned.
    """
    made = (_scores, _confusion, _statuses, _medians, _pairs, _measured, _reliability)
    yield from (section for section in (make(facts) for make in made) if section.rows)


def print_validation(facts: Facts, console: Console | None = None) -> None:
    """Prints a validation; the reliability diagram is left to the figure.

    Args:
        facts: What `validation.validation_facts` returned.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    say(out, _counts(facts))
    for section in sections(facts):
        if section.title == RELIABILITY:
            continue
        left = section.headings[: section.words]
        table = plain_table(section.title, section.headings, left)
        for row in section.rows:
            table.add_row(*row)
        print_table(out, table)
        if section.note:
            say(out, f"  {section.note}")
    for text in _left_out(facts):
        say(out, f"note: {text}")


def markdown_lines(facts: Facts) -> Iterator[str]:
    """The same as Markdown, with what its numbers mean."""
    yield from (f"# {one_line(facts['case']['title'])}: held to tests", "")
    yield from (facts["sentence"], "", _counts(facts), "")
    for section in sections(facts):
        ends = [":--" if at < section.words else "--:" for at in range(len(section.headings))]
        yield from (f"## {section.title}", "")
        for row in (section.headings, ends, *section.rows):
            yield f"| {' | '.join(cell.replace('|', '/') for cell in row)} |"
        yield ""
        if section.note:
            yield from (section.note, "")
    for text in (*_left_out(facts), *facts["validation"]["rules"]):
        yield f"- {text}"


def _counts(facts: Facts) -> str:
    """How many tests there are, and of how many lanes and records."""
    about = facts["validation"]
    text = f"{about['tests']:,} tests, of which {about['overturned']:,} overturned"
    if about["members"] > 1:
        text += f"; {about['members']:,} lanes a test"
    if about["group"]:
        motions = "ground motion" if about["records"] == 1 else "ground motions"
        text += f"; {about['records']:,} {motions} ({about['group']})"
    if about["unobserved"]:
        text += f"; {about['unobserved']:,} tests of the case without an observed outcome"
    return f"{text}."


def _left_out(facts: Facts) -> Iterator[str]:
    """What engines say nothing of."""
    for engine in facts["engines"]:
        lanes = ", ".join(f"{name} {count:,}" for name, count in engine["left_out_lanes"].items())
        if lanes:
            yield (
                f"{engine['name']}: {engine['left_out']:,} tests are left out, for want of a lane "
                f"with numbers (lanes without: {lanes})"
            )


def _scores(facts: Facts) -> Section:
    names = {"accuracy": "accuracy", "balanced_accuracy": "balanced accuracy"}
    names |= {"auc": "AUC", "brier": "Brier score"}
    rows = [
        [row["predictor"], f"{row['tests']:,}", *(_with_band(row, name) for name in names)]
        for row in facts["scores"]
    ]
    notes = []
    if any(row["accuracy_p05"] is not None for row in facts["scores"]):
        notes.append("in brackets: 5th and 95th percentile over ground motions drawn again")
    if facts["validation"]["members"] == 1:
        notes.append("of an engine's single lanes the Brier score is 1 - accuracy")
    headings = ["predictor", "tests", *names.values()]
    return Section("Scores", headings, rows, note="; ".join(notes))


def _confusion(facts: Facts) -> Section:
    names = ("hits", "misses", "false_alarms", "correct_rejections")
    rows = [
        [row["predictor"], *(f"{row[name]:,}" for name in names), _threshold(row)]
        for row in facts["scores"]
    ]
    headings = ["predictor", "fell, said to", "fell, not said to", "stood, said to fall"]
    headings += ["stood, said to", "threshold"]
    return Section("Right and wrong", headings, rows)


def _threshold(row: Mapping[str, Any]) -> str:
    """The threshold of a baseline; empty of an engine."""
    unit = {"PGA": "m/s^2", "PGV": "m/s"}.get(row["predictor"], "")
    return f"{row['threshold']:.3g} {unit}" if row["threshold"] is not None else ""


def _statuses(facts: Facts) -> Section:
    # Lanes of one test are alike: of ensembles their number says nothing of how sure the share is.
    alone = facts["validation"]["members"] == 1
    rows = []
    for row in facts["by_status"]:
        share = "no numbers" if row["right"] is None else f"{row['right']:.3f}"
        if alone and row["right"] is not None:
            right = np.array([round(row["right"] * row["lanes"])])
            low, high = wilson_interval(right, np.array([row["lanes"]]))
            share += f" [{low[0]:.3f}, {high[0]:.3f}]"
        rows.append([row["engine"], row["status"], f"{row['lanes']:,}", share])
    note = "share of lanes that became what was observed"
    note += "; in brackets: its 95 % interval (Wilson)" if alone else ""
    return Section("Right by status", ["engine", "status", "lanes", "right"], rows, 2, note)


def _medians(facts: Facts) -> Section:
    rows = []
    for row in facts["medians"]:
        fitted = row["verdict"] == "fitted"
        ratio = f"{row['over_observed']:.3f}" if row["over_observed"] is not None else "-"
        cells = [_with_band(row, name, ".3g") for name in ("median", "dispersion")]
        cells = cells if fitted else [row["verdict"], "-"]
        rows.append([heading_text(row["intensity"]), row["source"], *cells, ratio])
    headings = ["intensity measure", "source", "median", "dispersion", "median / observed"]
    note = "lognormal functions of overturning; in brackets: 5th and 95th percentile over motions"
    return Section("Fragility, observed and predicted", headings, rows, 2, note)


def _pairs(facts: Facts) -> Section:
    rows = [
        [
            f"{row['first']} / {row['second']}",
            f"{row['tests']:,}",
            f"{row['first_only_right']:,}",
            f"{row['second_only_right']:,}",
            f"{row['p_value']:.2g}" if row["p_value"] >= SMALL_P else f"below {SMALL_P:g}",
            _with_band(row, "brier_difference", "+.3f"),
        ]
        for row in facts["pairs"]
    ]
    headings = ["pair", "tests", "first alone right", "second alone right", "p"]
    note = "p: McNemar's exact test; Brier score of the first less that of the second"
    return Section("Paired tests", [*headings, "Brier difference"], rows, note=note)


def _measured(facts: Facts) -> Section:
    rows = []
    for row in facts["measured"]:
        size, unit = (180.0 / np.pi, "deg") if row["unit"] == "rad" else (1000.0, "mm")
        values = [row[name] for name in ("median_difference", "median_error")]
        cells = ["-" if value is None else f"{size * value:.3g} {unit}" for value in values]
        rank = row["rank_correlation"]
        rank_text = "-" if rank is None else f"{rank:.3f}"
        what = row["what"].replace("_", " ")
        rows.append([row["engine"], what, f"{row['tests']:,}", *cells, rank_text])
    headings = ["engine", "measured", "tests", "predicted - measured", "error", "rank correlation"]
    note = "medians over tests that stood, in the prediction too; Spearman's rank correlation"
    return Section("Measured and predicted", headings, rows, 2, note)


RELIABILITY = "Reliability"


def _reliability(facts: Facts) -> Section:
    rows = [
        [
            row["engine"],
            f"{row['from']:.1f} to {row['to']:.1f}",
            f"{row['tests']:,}",
            f"{row['predicted']:.3f}",
            f"{row['observed']:.3f}",
        ]
        for row in facts["reliability"]
    ]
    headings = ["predictor", "probability", "tests", "mean probability", "share that fell"]
    return Section(RELIABILITY, headings, rows, 2)


def _with_band(row: Mapping[str, Any], name: str, digits: str = ".3f") -> str:
    """A number with its band in brackets, where it has one."""
    value, low, high = (row[f"{name}{end}"] for end in ("", "_p05", "_p95"))
    if value is None:
        return "-"
    band = f" [{low:{digits}}, {high:{digits}}]" if low is not None else ""
    return f"{value:{digits}}{band}"
