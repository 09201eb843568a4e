"""What a run leaves in a folder: the lane table, its metadata, its provenance, histories."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import pathlib

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from tests.shared.shipped import RUNNABLE_CASES
from warprock.case.input_columns import input_meaning
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.model.response import FIELDS, LANE_FIELDS, Outcome, Response, Status
from warprock.running import machine, provenance
from warprock.running.case_run import CaseRun, run_case, run_lane
from warprock.running.lane_table import lane_table
from warprock.running.results import write_run

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def run() -> CaseRun:
    """Nine lanes of free rocking."""
    return run_case(load_case("free-b1-b3"), "housner", histories=False)


@pytest.fixture(scope="module")
def folder(run: CaseRun, tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    folder = tmp_path_factory.mktemp("run") / "new" / "folder"
    write_run(run, folder, {4: run_lane(run, 4)})
    return folder


def test_a_run_leaves_its_files_and_no_others(folder: pathlib.Path):
    assert sorted(path.name for path in folder.iterdir()) == [
        "history-lane-4.csv",
        "lanes.csv",
        "lanes.parquet",
        "run.json",
    ]


def test_the_table_reads_back_as_it_was(run: CaseRun, folder: pathlib.Path):
    table = lane_table(run.lane_set, run.response)
    pd.testing.assert_frame_equal(pd.read_parquet(folder / "lanes.parquet"), table)


def test_the_table_holds_every_field_of_every_lane(run: CaseRun):
    table = lane_table(run.lane_set, run.response)
    assert list(table["lane"]) == list(range(9))
    for name in LANE_FIELDS:
        field, values = FIELDS[name], run.response[name]
        if field.enum is None:
            np.testing.assert_array_equal(table[field.column], values)
    ratio = run.response["peak_rotation"] / np.arctan(
        run.lane_set.inputs["width_m"] / run.lane_set.inputs["height_m"]
    )
    # Two ways to write one quotient: a few units in the last place.
    np.testing.assert_allclose(table["peak_rotation_ratio"], ratio, rtol=1e-15)


def test_units_are_in_the_metadata_and_in_the_names(folder: pathlib.Path):
    schema = pq.read_schema(folder / "lanes.parquet")
    suffix = {"rad": "_rad", "s": "_s", "m": "_m", "J": "_J", "kg/m^3": "_kg_m3"}
    for field in schema:
        unit, text = field.metadata[b"unit"].decode(), field.metadata[b"text"].decode()
        assert text
        if unit in suffix:
            assert field.name.endswith(suffix[unit]), field.name
    assert schema.field("peak_rotation_rad").metadata[b"unit"] == b"rad"
    assert schema.field("block").metadata[b"text"] == b"Label of the case"


@pytest.mark.parametrize("name", RUNNABLE_CASES)
def test_no_input_goes_without_a_meaning(name: str):
    lane_set = expand_lanes(load_case(name))
    label = input_meaning("a label")
    nameless = {name for name in lane_set.inputs.columns if input_meaning(name) == label}
    assert nameless == set(lane_set.labels)


def test_codes_are_words(run: CaseRun):
    codes = {
        "outcome": np.array([Outcome.OVERTURNED, Outcome.AT_REST, Outcome.ROCKING] * 3),
        "status": np.array([Status.OK, Status.NONFINITE, Status.EVENT_LIMIT] * 3),
    }
    response = dataclasses.replace(run.response, fields={**run.response.fields, **codes})
    table = lane_table(run.lane_set, response)
    assert list(table["outcome"][:3]) == ["overturned", "at_rest", "rocking"]
    assert list(table["status"][:3]) == ["ok", "nonfinite", "event_limit"]
    counts = {"at_rest": 3, "rocking": 3, "overturned": 3, "slid_off": 0}
    assert provenance.count_words(response, "outcome") == counts


def test_provenance_says_what_ran(run: CaseRun, folder: pathlib.Path):
    found = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    assert found["case"]["name"] == "free-b1-b3"
    assert found["case"]["resolved"] == json.loads(json.dumps(run.case.raw))
    assert found["engine"]["name"] == "housner"
    assert found["engine"]["settings"] == dataclasses.asdict(run.settings)
    assert (found["precision"], found["device"], found["lanes"]) == ("float64", "cpu", 9)
    assert sum(found["status"].values()) == sum(found["outcome"].values()) == 9
    assert all(found["versions"].values())
    assert set(found["versions"]) == {"python", "warprock", *provenance.PACKAGES}
    assert found["wall_time_s"] > 0.0
    assert found["records"] == []


def test_provenance_names_the_records_with_their_hashes():
    rows = provenance.record_rows(load_case("record-ridgecrest"))
    assert len(rows) == 1
    file = next(ROOT.glob(f"cases/*/{rows[0]['name']}.csv"))
    assert rows[0]["sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
    assert rows[0]["licence"]
    assert rows[0]["source"]


def test_the_kernel_hash_follows_the_kernel_sources(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(machine.importlib.resources, "files", lambda _: tmp_path)
    hashes = set()
    for name, text in (
        ("a.py", "x = 1"),
        ("a.py", "x = 2"),
        ("b.py", "x = 1"),
        ("folder/a.py", "x = 1"),
        ("c.txt", ""),
    ):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
        hashes.add(machine.kernel_hash.__wrapped__())
    assert len(hashes) == 4  # the last file is no kernel


def test_a_history_is_that_of_the_lane_in_its_batch(run: CaseRun, folder: pathlib.Path):
    case = load_case("free-b1-b3")
    together = run_case(case, "housner", histories=True).response
    # Text holds every digit of a double, so the lane alone is the lane in the batch, bit by bit;
    # pandas reads all of them from 3.1 on.
    alone = np.genfromtxt(folder / "history-lane-4.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(alone["time_s"], together.times)
    np.testing.assert_array_equal(alone["rotation_rad"], together["rotation"][4])


def test_a_run_keeps_no_histories_unless_asked(run: CaseRun):
    assert "rotation" not in run.response.fields


def test_histories_need_a_sample_interval(tmp_path: pathlib.Path):
    text = (ROOT / "cases/free-b0/case.toml").read_text()
    file = tmp_path / "case.toml"
    file.write_text(text.replace('sample_interval = "10 ms"', ""), encoding="utf-8")
    with pytest.raises(InputError, match=r"run\.sample_interval"):
        run_case(load_case(str(file)), "housner", histories=True)


def test_a_lane_that_is_not_there_is_refused(run: CaseRun):
    with pytest.raises(InputError, match="from 0 to 8"):
        run_lane(run, 9)


def test_words_do_not_hide_an_unknown_code(run: CaseRun):
    wrong = {**run.response.fields, "status": np.full(9, 77)}
    response = Response(engine="housner", fields=wrong, times=run.response.times)
    with pytest.raises(ValueError, match="codes"):
        lane_table(run.lane_set, response)


def test_the_summary_of_errors_is_of_lanes_that_are_ok():
    fields = {
        "status": np.array([Status.OK, Status.SENSITIVE, Status.OK, Status.NONFINITE]),
        "rotation_error": np.array([1e-3, 5.0, 3e-3, np.nan]),
    }
    found = provenance.error_summary(Response(engine="event", fields=fields, times=np.empty(0)))
    assert found == {"median": 2e-3, "largest": 3e-3}
