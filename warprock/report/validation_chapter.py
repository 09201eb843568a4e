"""The chapter of engines that were held to tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from warprock.findings.numbers import counted, listed, three
from warprock.findings.sheets import Sheet, heading, sheet_of
from warprock.report.analysis_chapters import chapter_of_case
from warprock.report.content import Chapter
from warprock.report.folder import ResultFolder

Facts = Mapping[str, Any]

SURE = 0.05
"""Chance below which two predictors are said to differ."""


def validation_chapter(folder: ResultFolder, scenes: Mapping[str, Any] | None) -> Chapter:
    """The chapter of engines that were held to tests."""
    facts = folder.facts
    about = facts["validation"]
    tests = f"{counted(about['tests'], 'test')}, of which {about['overturned']:,} overturned"
    lanes = f", {about['members']:,} lanes each" if about["members"] > 1 else ""
    more = [
        ("Tests", f"{tests}{lanes}"),
        ("Observed in", about["observed"]),
        ("Engines", listed([engine["name"] for engine in facts["engines"]])),
    ]
    if about["group"]:
        more.append(("Ground motions", f"{about['records']:,} ({about['group']})"))
    found = [facts["sentence"], *_differences(facts), *_medians(facts)]
    if about["unobserved"]:
        found.append(f"{counted(about['unobserved'], 'test')} of the case had no outcome to see.")
    return chapter_of_case(
        folder,
        "Held to tests",
        found,
        pictures=folder.pictures("validation*.png"),
        sheets=list(_sheets(folder, facts)),
        scenes=scenes,
        more=more,
    )


def _differences(facts: Facts) -> list[str]:
    """Which predictors differ by more than chance explains."""
    texts = []
    for pair in facts["pairs"]:
        first, second = pair["first"], pair["second"]
        better, worse = pair["first_only_right"], pair["second_only_right"]
        if better < worse:
            first, second, better, worse = second, first, worse, better
        if pair["p_value"] < SURE:
            texts.append(
                f"{first} is right in {better:,} tests in which {second} is wrong, {second} in "
                f"{worse:,} in which {first} is: more than chance explains (p = "
                f"{three(pair['p_value'])})."
            )
    return texts or ["No two predictors differ by more than chance explains."]


def _medians(facts: Facts) -> list[str]:
    """How far predicted medians are from those observed."""
    texts = []
    for row in facts["medians"]:
        if row["source"] == "observed" or row["over_observed"] is None:
            continue
        name = heading(row["intensity"])
        off = 100.0 * (row["over_observed"] - 1.0)
        texts.append(
            f"By {row['source']} half of the blocks fall at a {name.text} of "
            f"{three(row['median'])} {name.unit}, {off:+.1f} % from what was observed."
        )
    return texts


def _sheets(folder: ResultFolder, facts: Facts) -> Sequence[Sheet]:
    """Scores, statuses, medians, pairs, and every test."""
    rules = " ".join(facts["validation"]["rules"])
    tests = folder.table("validation.parquet")
    made = [
        ("Scores", "scores", rules, "scores.csv"),
        ("Right by status", "by_status", "", ""),
        ("Fragility, observed and predicted", "medians", "", ""),
        ("Paired tests", "pairs", "", ""),
        ("Measured and predicted", "measured", "", ""),
        ("Reliability", "reliability", "", ""),
    ]
    sheets = [
        sheet_of(title, _whole(facts[key]), note=note, file=file, folded=key == "reliability")
        for title, key, note, file in made
        if facts[key]
    ]
    every = sheet_of("Tests", tests, file="validation.csv", folded=True)
    return [*sheets, every]


def _whole(rows: Sequence[Facts]) -> pd.DataFrame:
    """Rows as a table, without columns that hold nothing."""
    return pd.DataFrame(rows).dropna(axis="columns", how="all")
