"""What engines came to that were held to tests."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.bands import LEAST_RECORDS
from warprock.analysis.groups import fit_columns
from warprock.analysis.scores import SCORES, reliability
from warprock.findings.digits import quantity_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.numbers import listed, three
from warprock.findings.plain import plain
from warprock.findings.sheets import heading, sheet_of
from warprock.findings.validation_sheets import counts_sentence, left_out, markdown_lines, sections
from warprock.model.response import USABLE_NAMES
from warprock.running.provenance import case_facts, duration_facts, surroundings
from warprock.running.run_file import CASE, COUNTS, with_band
from warprock.verification.measured import (
    measured_quantities,
    measured_rows,
    predict_largest,
    unit_of,
)
from warprock.verification.settings import plain_name
from warprock.verification.validation import Judged, Validation, status_rows

MARKDOWN = "validation.md"
TABLE, SCORE_TABLE = "validation", "scores.csv"
RULES = (
    "A test is said to overturn where at least half of its lanes with numbers did.",
    "A baseline says it from a threshold on; threshold and lognormal function of each test are "
    "those of the other records.",
    "Bands: 5th to 95th percentile over records drawn again; p: McNemar's exact test.",
)
"""What numbers of a validation mean, in sentences."""
SURE = 0.05
"""Chance below which two predictors are said to differ."""


def find_validate(found: Validation) -> Finding:
    """What a validation came to; its files are every test, the scores, and a text."""
    facts = validation_facts(found)
    tables = {TABLE: test_table(found), SCORE_TABLE: pd.DataFrame(facts["scores"])}
    return dataclasses.replace(
        tell_validate(facts, tables),
        texts={MARKDOWN: "\n".join(markdown_lines(facts)) + "\n"},
        then=f"warprock run {_typed(found)} -e {plain_name(found.engines[0].name)} -o results/run",
    )


def tell_validate(facts: Facts, tables: Tables) -> Finding:
    """What a validation came to, of its facts and tables."""
    about = facts["validation"]
    notes = [f"Note: {text}." for text in left_out(facts)]
    return Finding(
        kind="Held to tests",
        facts=facts,
        tables=tables,
        sentences=[
            facts["sentence"],
            counts_sentence(facts),
            *_differences(facts),
            *_medians(facts),
            *notes,
        ],
        sheets=[
            *sections(facts),
            sheet_of(
                "Tests",
                tables[TABLE],
                note=" ".join(about["rules"]),
                file=f"{TABLE}.csv",
                folded=True,
            ),
        ],
        asked=[
            ("Observed in", about["observed"]),
            ("Engines", listed([engine["name"] for engine in facts["engines"]])),
        ],
        pictures=["validation*.png"],
    )


VALIDATION = Kind(
    (TABLE,),
    tell_validate,
    "validation",
    {
        "case": CASE,
        "validation": {
            "tests": int,
            "overturned": int,
            "members": int,
            "observed": str,
            "group?": (str, None),
            "records?": (int, None),
            "unobserved": int,
            "rules": [str],
        },
        "engines": [{"name": str, "left_out": int, "left_out_lanes": COUNTS}],
        "sentence": str,
        "pairs": [
            {
                "first": str,
                "second": str,
                "first_only_right": int,
                "second_only_right": int,
                "p_value": float,
                "tests": int,
                **with_band("brier_difference"),
            }
        ],
        "medians": [
            {
                "source": str,
                "over_observed": (float, None),
                "intensity": str,
                "verdict": str,
                **with_band("median", "dispersion"),
            }
        ],
        "scores": [
            {
                "predictor": str,
                "threshold": (float, None),
                **dict.fromkeys(("tests", "hits", "misses", "false_alarms"), int),
                "correct_rejections": int,
                **with_band("accuracy", "balanced_accuracy", "auc", "brier"),
            }
        ],
        "by_status": [{"engine": str, "status": str, "lanes": int, "right": (float, None)}],
        "measured": [
            {
                **dict.fromkeys(("engine", "what", "unit"), str),
                "tests": int,
                **dict.fromkeys(("median_difference", "median_error"), (float, None)),
                "rank_correlation": (float, None),
            }
        ],
        "reliability": [
            {
                "engine": str,
                "tests": int,
                **dict.fromkeys(("from", "to", "predicted", "observed"), float),
            }
        ],
    },
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
        off = quantity_of("median_change", row["over_observed"] - 1.0)
        texts.append(
            f"By {row['source']} half of the blocks fall at a {name.text} of "
            f"{three(row['median'])} {name.unit}, {off} from what was observed."
        )
    return texts


def _typed(found: Validation) -> str:
    """The case as a command takes it."""
    case = found.case
    return shlex.quote(case.name if case.folder is None else str(case.folder))


def validation_facts(found: Validation) -> dict[str, Any]:
    """What ran and what came of it, ready for JSON: what there is no number of is None."""
    tests, members = found.tests.lanes.shape
    facts = {
        "case": case_facts(found.case),
        "validation": {
            "observed": found.tests.source,
            "tests": tests,
            "overturned": int(found.tests.overturned.sum()),
            "unobserved": found.tests.unobserved,
            "members": members,
            "records": len(np.unique(found.records)),
            "group": found.group,
            "rules": list(RULES),
        },
        "engines": [_engine_facts(found, engine) for engine in found.engines],
        "precision": found.options.precision,
        "device": found.options.device,
        "workers": found.options.workers,
        "tolerance": found.options.tolerance,
        **surroundings(found.case),
        "lanes": found.lane_set.lanes.lane_count,
        **duration_facts(found.lane_set),
        "scores": [_score_row(each) for each in (*found.engines, *found.baselines)],
        "by_status": status_rows(found),
        "reliability": [
            {"engine": each.name, **row}
            for each in (*found.engines, *found.baselines)
            for row in reliability(each.said.probability, found.tests.overturned[each.tests])
        ],
        "medians": list(_median_rows(found)),
        "pairs": [_pair_row(pair) for pair in found.pairs],
        "measured": list(measured_rows(found)),
    }
    bare: dict[str, Any] = plain(facts)
    return {**bare, "sentence": _sentence(bare)}


def _engine_facts(found: Validation, engine: Judged) -> dict[str, Any]:
    """An engine: its settings, and the lanes that gave no number."""
    assert engine.table is not None
    status = engine.table["status"].astype(str).value_counts()
    usable = set(USABLE_NAMES)
    return {
        "name": engine.name,
        "settings": dataclasses.asdict(engine.settings),
        "left_out": len(found.tests.names) - len(engine.tests),
        "left_out_lanes": {k: int(n) for k, n in status.items() if k not in usable},
        "wall_time_s": engine.wall_time,
    }


def _score_row(each: Judged) -> dict[str, Any]:
    """The scores of a predictor with their bands, and its confusion matrix."""
    row: dict[str, Any] = {"predictor": each.name, "tests": each.scores.tests}
    for name in SCORES:
        row[name] = each.scores.values[name]
        row[f"{name}_p05"], row[f"{name}_p95"] = each.scores.bands[name]
    for name in ("hits", "misses", "false_alarms", "correct_rejections"):
        row[name] = getattr(each.scores, name)
    return row | {"threshold": each.threshold}


def _median_rows(found: Validation) -> Iterator[dict[str, Any]]:
    """Fragility functions, observed and predicted: one row an intensity measure and source."""
    for number, shaking in enumerate(found.shakings):
        enough = shaking.seen.record_count >= LEAST_RECORDS
        own = fit_columns(shaking.fit, shaking.band if enough else None)
        yield {"intensity": shaking.column, "source": "observed", **own, "over_observed": 1.0}
        for engine in found.engines:
            fit, band = engine.curves[number].fit, engine.curves[number].band
            both = fit.dispersion > 0.0 and shaking.fit.dispersion > 0.0
            ratio = fit.median / shaking.fit.median if both else np.nan
            row = {"intensity": shaking.column, "source": engine.name, **fit_columns(fit, band)}
            yield row | {"over_observed": ratio}


def _pair_row(pair: Any) -> dict[str, Any]:
    low, high = pair.brier_band
    return {
        "first": pair.names[0],
        "second": pair.names[1],
        "tests": pair.tests,
        "first_only_right": pair.first_only,
        "second_only_right": pair.second_only,
        "p_value": pair.p_value,
        "brier_difference": pair.brier_difference,
        "brier_difference_p05": low,
        "brier_difference_p95": high,
    }


def test_table(found: Validation) -> pd.DataFrame:
    """One row a test and engine: what was observed, what was predicted, and how strong it was."""
    parts = []
    for engine in found.engines:
        tests = engine.tests
        lanes = found.tests.lanes[tests]
        part = {
            "test": np.array(found.tests.names, dtype=object)[tests],
            "engine": engine.name,
            "lane": lanes[:, 0],
            "lanes": lanes.shape[1],
            "motion": found.records[tests],
            "observed": found.tests.overturned[tests],
            "probability": engine.said.probability,
            "predicted": engine.said.says,
            "right": engine.said.says == found.tests.overturned[tests],
        }
        part |= {each.column: each.intensity[tests] for each in found.shakings}
        for what in measured_quantities(found):
            end = f"{what}_{unit_of(what)}"
            part[f"observed_{end}"] = found.tests.measured[what][tests]
            part[f"predicted_{end}"] = predict_largest(engine, what, lanes.shape[1])
        parts.append(pd.DataFrame(part))
    table = pd.concat(parts, ignore_index=True)
    texts = {
        "test": "What the test is called",
        "engine": "Engine or program, with its settings",
        "lane": "First lane of the test",
        "lanes": "Lanes of the test",
        "motion": "Number of the ground motion, which tests may share",
        "observed": "Whether the block overturned in the test",
        "probability": "Share of the lanes with numbers that overturned",
        "predicted": "Whether at least half of them did",
        "right": "Whether the prediction is what was observed",
    }
    table.attrs["columns"] = {
        name: {"unit": "-", "text": text} for name, text in texts.items() if name in table
    }
    return table


def _right(row: Mapping[str, Any]) -> int:
    """Tests whose outcome was predicted correctly."""
    return int(row["hits"] + row["correct_rejections"])


def _sentence(facts: Mapping[str, Any]) -> str:
    """Who is right most often, in one sentence."""
    names = {row["name"] for row in facts["engines"]}
    engines = [row for row in facts["scores"] if row["predictor"] in names]
    best = max(engines, key=_right)
    text = (
        f"{best['predictor']} predicts the outcome of {_right(best):,} of {best['tests']:,} tests "
        f"correctly ({quantity_of('right_share', best['accuracy'])})"
    )
    left = facts["validation"]["tests"] - best["tests"]
    if left:
        text += f" and nothing of the other {left:,}"
    others = [row for row in facts["scores"] if row["predictor"] not in names]
    if not others:
        return f"{text}."
    base = max(others, key=lambda row: row["accuracy"])
    share = quantity_of("right_share", base["accuracy"])
    return f"{text}; a threshold on {base['predictor']} alone {share}."
