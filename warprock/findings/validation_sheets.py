"""The tables of a validation, and the same as Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from warprock.errors import one_line
from warprock.findings.digits import number_of, quantity_of, value_of
from warprock.findings.sheets import Heading, Sheet, heading
from warprock.running.cells import wilson_interval

Facts = Mapping[str, Any]

_WORDS = {
    "Right by status": 2,
    "Fragility, observed and predicted": 2,
    "Measured and predicted": 2,
    "Reliability": 2,
}
"""First columns of a table that hold words, where these are not one."""
SMALL_P = 1e-4
"""Chances below this are said to be below it."""


def sections(facts: Facts) -> list[Sheet]:
    """The tables of a validation, those without rows left out.

    Args:
        facts: What `validation.validation_facts` returned.
    """
    made = (_scores, _confusion, _statuses, _medians, _pairs, _measured, _reliability)
    return [section for section in (make(facts) for make in made) if section.rows]


def markdown_lines(facts: Facts) -> Iterator[str]:
    """The tables of a validation as Markdown, with what their numbers mean."""
    yield from (f"# {one_line(facts['case']['title'])}: held to tests", "")
    yield from (facts["sentence"], "", counts_sentence(facts), "")
    for section in sections(facts):
        heads = [each.text for each in section.headings]
        ends = [":--" if at < _WORDS.get(section.title, 1) else "--:" for at in range(len(heads))]
        yield from (f"## {section.title}", "")
        for row in (heads, ends, *section.rows):
            yield f"| {' | '.join(cell.replace('|', '/') for cell in row)} |"
        yield ""
        if section.note:
            yield from (section.note, "")
    for text in (*left_out(facts), *facts["validation"]["rules"]):
        yield f"- {text}"


def counts_sentence(facts: Facts) -> str:
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


def left_out(facts: Facts) -> Iterator[str]:
    """What engines say nothing of."""
    for engine in facts["engines"]:
        lanes = ", ".join(f"{name} {count:,}" for name, count in engine["left_out_lanes"].items())
        if lanes:
            yield (
                f"{engine['name']}: {engine['left_out']:,} tests are left out, for want of a lane "
                f"with numbers (lanes without: {lanes})"
            )


def _sheet(
    title: str,
    headings: Sequence[str],
    rows: Sequence[Sequence[str]],
    note: str = "",
    folded: bool = False,
) -> Sheet:
    return Sheet(title, [Heading(text) for text in headings], rows, note, folded=folded)


def _scores(facts: Facts) -> Sheet:
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
    return _sheet("Scores", headings, rows, "; ".join(notes))


def _confusion(facts: Facts) -> Sheet:
    names = ("hits", "misses", "false_alarms", "correct_rejections")
    rows = [
        [row["predictor"], *(f"{row[name]:,}" for name in names), _threshold(row)]
        for row in facts["scores"]
    ]
    headings = ["predictor", "fell, said to", "fell, not said to", "stood, said to fall"]
    headings += ["stood, said to", "threshold"]
    return _sheet("Right and wrong", headings, rows)


def _threshold(row: Mapping[str, Any]) -> str:
    """The threshold of a baseline; empty of an engine."""
    unit = {"PGA": "m/s^2", "PGV": "m/s"}.get(row["predictor"], "")
    return f"{value_of(row, 'threshold')} {unit}" if row["threshold"] is not None else ""


def _statuses(facts: Facts) -> Sheet:
    # Lanes of one test are alike: of ensembles their number says nothing of how sure the share is.
    alone = facts["validation"]["members"] == 1
    rows = []
    for row in facts["by_status"]:
        share = "no numbers" if row["right"] is None else value_of(row, "right")
        if alone and row["right"] is not None:
            right = np.array([round(row["right"] * row["lanes"])])
            low, high = wilson_interval(right, np.array([row["lanes"]]))
            share += f" [{number_of('right', low[0])}, {number_of('right', high[0])}]"
        rows.append([row["engine"], row["status"], f"{row['lanes']:,}", share])
    note = "share of lanes that became what was observed"
    note += "; in brackets: its 95 % interval (Wilson)" if alone else ""
    return _sheet("Right by status", ["engine", "status", "lanes", "right"], rows, note)


def _medians(facts: Facts) -> Sheet:
    rows = []
    for row in facts["medians"]:
        fitted = row["verdict"] == "fitted"
        ratio = value_of(row, "over_observed")
        cells = [_with_band(row, name) for name in ("median", "dispersion")]
        cells = cells if fitted else [row["verdict"], "-"]
        rows.append([heading(row["intensity"]).label, row["source"], *cells, ratio])
    headings = ["intensity measure", "source", "median", "dispersion", "median / observed"]
    note = "lognormal functions of overturning; in brackets: 5th and 95th percentile over motions"
    return _sheet("Fragility, observed and predicted", headings, rows, note)


def _pairs(facts: Facts) -> Sheet:
    rows = [
        [
            f"{row['first']} / {row['second']}",
            f"{row['tests']:,}",
            f"{row['first_only_right']:,}",
            f"{row['second_only_right']:,}",
            value_of(row, "p_value")
            if row["p_value"] >= SMALL_P
            else f"below {number_of('level', SMALL_P)}",
            _with_band(row, "brier_difference"),
        ]
        for row in facts["pairs"]
    ]
    headings = ["pair", "tests", "first alone right", "second alone right", "p"]
    note = "p: McNemar's exact test; Brier score of the first less that of the second"
    return _sheet("Paired tests", [*headings, "Brier difference"], rows, note)


def _measured(facts: Facts) -> Sheet:
    rows = []
    for row in facts["measured"]:
        names = ("median_difference", "median_error")
        cells = [quantity_of(f"{name}_{row['unit']}", row[name]) for name in names]
        rank_text = value_of(row, "rank_correlation")
        what = row["what"].replace("_", " ")
        rows.append([row["engine"], what, f"{row['tests']:,}", *cells, rank_text])
    headings = ["engine", "measured", "tests", "predicted - measured", "error", "rank correlation"]
    note = "medians over tests that stood, in the prediction too; Spearman's rank correlation"
    return _sheet("Measured and predicted", headings, rows, note)


def _reliability(facts: Facts) -> Sheet:
    rows = [
        [
            row["engine"],
            f"{number_of('probability', row['from'])} to {number_of('probability', row['to'])}",
            f"{row['tests']:,}",
            value_of(row, "predicted"),
            value_of(row, "observed"),
        ]
        for row in facts["reliability"]
    ]
    headings = ["predictor", "probability", "tests", "mean probability", "share that fell"]
    return _sheet("Reliability", headings, rows, folded=True)


def _with_band(row: Mapping[str, Any], name: str) -> str:
    """A number with its band in brackets, where it has one."""
    value, low, high = (row[f"{name}{end}"] for end in ("", "_p05", "_p95"))
    band = f" [{number_of(name, low)}, {number_of(name, high)}]" if low is not None else ""
    return f"{number_of(name, value)}{band}"
