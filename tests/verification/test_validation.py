"""Engines held to tests, on responses whose outcomes are known, and the check of kind outcomes."""

from __future__ import annotations

import dataclasses
import json
import pathlib
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from tests.shared.commands import succeed
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.findings.validation import find_validate, validation_facts
from warprock.model.response import INTEGER_FIELDS, LANE_FIELDS, Outcome, Response, Status
from warprock.running.options import RunOptions
from warprock.verification import checks
from warprock.verification.checks import run_checks
from warprock.verification.measured import predict_largest
from warprock.verification.observations import read_tests
from warprock.verification.validation import MEASURES, judge, run_validation, status_rows

SHORT = {"check": [], "run.duration": "1 s"}
SCALES = np.round(np.geomspace(0.2, 2.0, 8), 3).tolist()
FELL, ROCKS = int(Outcome.OVERTURNED), int(Outcome.ROCKING)
OK, SENSITIVE, BROKEN = int(Status.OK), int(Status.SENSITIVE), int(Status.NONFINITE)


def answer(lane_set, outcome, status=OK, peak=0.0) -> Response:
    count = lane_set.lanes.lane_count
    fields = {
        name: np.zeros(count, dtype=np.int64 if name in INTEGER_FIELDS else np.float64)
        for name in LANE_FIELDS
    }
    fields |= {
        "outcome": np.broadcast_to(outcome, count),
        "status": np.broadcast_to(status, count),
        "peak_rotation": np.broadcast_to(peak, count) * lane_set.lanes.slenderness_angle,
    }
    return Response("housner", fields, lane_set.times.times)


def lanes_of(**changes):
    case = load_case("record-ridgecrest", {**SHORT, "sweep": [{"motion.scale": SCALES}], **changes})
    return case, expand_lanes(case)


def seen(*outcomes: int | None, key: str = "lane") -> pd.DataFrame:
    return pd.DataFrame({key: np.arange(len(outcomes)), "observed": outcomes})


def test_single_lanes_are_ranked_by_their_peaks():
    case, lanes = lanes_of()
    tests = read_tests(case, lanes, seen(0, 0, 0, 1, 0, 1, 1, 1))
    peak = np.array([0.1, 0.2, 0.3, 0.9, 0.4, 1.0, 9.0, 9.0])
    outcome = np.where(np.arange(8) < 6, ROCKS, FELL)
    found = judge(answer(lanes, outcome, peak=peak), "housner", lanes, tests, np.arange(8))
    assert found.scores.values["accuracy"] == 6 / 8
    assert found.scores.values["brier"] == 2 / 8
    # The two misses rocked more than all that stood.
    assert found.scores.values["auc"] == 1.0


def test_members_make_a_probability_and_those_without_numbers_do_not_count():
    ensemble = {"members": 4, "spread": {"block.width": "5 %"}}
    case, lanes = lanes_of(ensemble=ensemble, sweep=[{"motion.scale": SCALES[:3]}])
    tests = read_tests(case, lanes, seen(1, 0, 1, key="cell"))
    outcome = np.array([FELL, FELL, FELL, ROCKS, FELL, ROCKS, ROCKS, ROCKS, *[FELL] * 4])
    status = np.array([OK, OK, SENSITIVE, OK, BROKEN, OK, OK, SENSITIVE, *[BROKEN] * 4])
    found = judge(answer(lanes, outcome, status), "housner", lanes, tests, np.arange(3))
    assert found.tests.tolist() == [0, 1]
    assert found.said.probability.tolist() == [0.75, 0.0]
    assert found.said.says.tolist() == [True, False]
    assert found.scores.values["brier"] == pytest.approx(0.0625 / 2, abs=1e-15)
    with pytest.raises(InputError, match="must have numbers in a lane of one test"):
        judge(answer(lanes, outcome, BROKEN), "housner", lanes, tests, np.arange(3))


def test_what_was_measured_is_held_against_members_that_stood():
    ensemble = {"members": 4, "spread": {"contact.friction": "5 %"}}
    case, lanes = lanes_of(ensemble=ensemble, sweep=[{"motion.scale": SCALES[:2]}])
    tests = read_tests(case, lanes, seen(0, 1, key="cell"))
    outcome = np.array([ROCKS, ROCKS, ROCKS, FELL, *[FELL] * 4])
    peak = np.array([0.1, 0.3, 0.7, 9.0, *[9.0] * 4])
    found = judge(answer(lanes, outcome, peak=peak), "housner", lanes, tests, np.arange(2))
    angle = lanes.lanes.slenderness_angle[0]
    ours = predict_largest(found, "peak_rotation", 4)
    assert ours == pytest.approx([0.3 * angle, np.nan], rel=1e-12, nan_ok=True)


def test_what_is_predicted_of_a_stack_is_of_the_block_that_is_named():
    table = pd.DataFrame({"peak_rotation_1_rad": [0.1, 0.4], "peak_rotation_2_rad": [0.3, 0.2]})
    table = table.assign(outcome="rocking", status="ok")
    engine = SimpleNamespace(table=table, tests=np.arange(2))
    for what, peaks in (
        ("peak_rotation", [0.3, 0.4]),
        ("peak_rotation_1", [0.1, 0.4]),
        ("peak_rotation_2", [0.3, 0.2]),
    ):
        assert predict_largest(engine, what, 1).tolist() == peaks


@pytest.fixture(scope="module")
def validation(tmp_path_factory):
    """Fourteen tests under two records, with one outcome that the engine does not say."""
    records = ["ridgecrest-2019-ccc-090", "ridgecrest-2019-ccc-360"]
    scales = [0.4, 0.5, 0.6, 0.75, 1.0, 1.5, 2.0]
    sweep = [{"motion.record": records}, {"motion.scale": scales}]
    case = load_case("record-ridgecrest", {"check": [], "run.duration": "40 s", "sweep": sweep})
    first = run_validation(
        case, ["housner"], seen(*[0, 1] * 7), RunOptions(tolerance=None), group="record"
    )
    fell = first.engines[0].said.says.copy()
    fell[0] = ~fell[0]
    table = seen(*fell.astype(int)).assign(peak_rotation_deg=1.0, event=["a", "b"] * 7)
    file = tmp_path_factory.mktemp("tests") / "observed.csv"
    table.to_csv(file, index=False)
    options = RunOptions(tolerance=None)
    found = run_validation(case, ["housner"], file, options, group="event")
    return case, file, found


def test_a_validation_counts_what_it_should(validation):
    _, file, found = validation
    facts = validation_facts(found)
    (engine, *others) = facts["scores"]
    assert engine["predictor"] == "housner"
    assert engine["accuracy"] == pytest.approx(13 / 14)
    assert [row["predictor"] for row in others] == list(MEASURES.values())
    about = facts["validation"]
    assert (about["tests"], about["records"], about["group"]) == (14, 2, "event")
    assert about["observed"] == str(file)
    assert sum(row["lanes"] for row in status_rows(found)) == 14
    assert {row["source"] for row in facts["medians"]} == {"observed", "housner"}
    assert [pair["second"] for pair in facts["pairs"]] == ["PGA", "PGV"]
    assert facts["measured"][0]["tests"] > 0
    # JSON has no NaN.
    json.dumps(facts, allow_nan=False)


def test_the_text_has_every_number(validation):
    _, _, found = validation
    report = find_validate(found)
    text = report.texts["validation.md"]
    assert report.sentences[0] in text
    for title in ("Scores", "Right by status", "Fragility", "Paired tests", "Reliability"):
        assert f"## {title}" in text
    table = report.tables["validation"]
    assert len(table) == 14
    assert int(table["right"].sum()) == 13
    assert set(table.attrs["columns"]) <= set(table.columns)


@pytest.mark.usefixtures("unrendered")
def test_the_command_writes_a_folder_with_its_page(validation, tmp_path: pathlib.Path):
    case, file, found = validation
    (tmp_path / "case.toml").write_text(case.to_toml(), encoding="utf-8")
    asked = [
        str(tmp_path),
        "--observed",
        str(file),
        "-e",
        "housner",
        "--no-estimate",
        "--group",
        "event",
    ]
    folder = tmp_path / "results"
    done = succeed("validate", *asked, "-o", folder, "--json")
    printed = json.loads(done.stdout)
    assert printed["sentence"] == validation_facts(found)["sentence"]
    names = {pathlib.Path(each).name for each in printed["files"]}
    wanted = {"validation.parquet", "validation.csv", "scores.csv", "validation.md", "run.json"}
    assert names == wanted | {"validation.png", "validation-fragility.png", "report.html"}
    page = (folder / "report.html").read_text(encoding="utf-8")
    for words in (printed["sentence"], "Held to tests", "Paired tests"):
        assert words in page
    shown = succeed("validate", *asked)
    assert "PGV" in shown.stdout
    assert printed["sentence"] in shown.stdout.replace("\n", " ")


def test_engines_are_named_once_and_groups_are_columns(validation):
    case, file, _ = validation
    with pytest.raises(InputError, match="must be named once each"):
        run_validation(case, ["housner", "housner"], file)
    with pytest.raises(InputError, match="--group: got 'quake', must be a column of"):
        run_validation(case, ["housner"], file, group="quake")


def check(tmp_path: pathlib.Path, **keys: object) -> list[checks.CheckRow]:
    seen(0, 0, 0, 0, 1, 1, 1, 0).to_csv(tmp_path / "observed.csv", index=False)
    asked = {"kind": "outcomes", "engine": "housner", "observed": "observed.csv", "because": "x"}
    case, _ = lanes_of(check=[{**asked, **keys}])
    return run_checks(dataclasses.replace(case, folder=tmp_path))


def test_a_case_may_check_outcomes(tmp_path: pathlib.Path, monkeypatch):
    outcome = np.where(np.arange(8) < 4, ROCKS, FELL)
    monkeypatch.setattr(
        checks.CaseResponses, "__getitem__", lambda self, _: answer(self.lane_set, outcome)
    )
    (row,) = check(tmp_path, limit_wrong=0.125)
    assert (row.value, row.ok, row.note) == (0.125, True, "7 of 8 tests predicted correctly")
    wrong, brier = check(tmp_path, limit_wrong=0.1, limit_brier=0.2)
    assert (wrong.ok, brier.ok, brier.value) == (False, True, 0.125)
    with pytest.raises(InputError, match="limit_wrong"):
        check(tmp_path, limit_wrong=1.5)
