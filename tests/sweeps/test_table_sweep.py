"""Sweeps whose lanes are the rows of a file, with durations of their own."""

from __future__ import annotations

import pandas as pd
import pytest

import warprock as wr
from tests.shared.sweeps import merged_bytes, planned
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.running.case_run import run_case, run_lane
from warprock.running.lane_table import history_table, lane_table
from warprock.sweeps.lane import run_of_lane
from warprock.sweeps.plan import read_plan, require_same_software

CASE = """
title = "blocks of a table"
source = "made up"
[block]
width = "0.4 m"
depth = "0.4 m"
density = "2000 kg/m^3"
[contact]
friction = 0.8
[start]
rotation_ratio = 0.5
[run]
[sweep]
table = "tests.csv"
"""
ROWS = "height_m,duration_s,label,observed\n" + "".join(
    f"{1.2 + 0.1 * k},{0.5 + 0.25 * (k % 3)},t{k},{k % 2}\n" for k in range(7)
)


@pytest.fixture
def case_file(tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "tests.csv").write_text(ROWS)
    (folder / "case.toml").write_text(CASE)
    return folder / "case.toml"


def test_chunks_of_a_table_give_the_lanes_of_a_run(case_file, tmp_path):
    run = run_case(load_case(case_file), "housner", histories=False)
    expected = lane_table(run.lane_set, run.response)
    found = []
    for chunk in (2, 7):
        folder = tmp_path / f"by{chunk}"
        found.append(merged_bytes(case_file, folder, chunk))
        table = pd.read_parquet(folder / "lanes.parquet")
        for name in ("duration_s", "observed", "peak_rotation_rad", "impact_count", "undecided"):
            assert table[name].tolist() == expected[name].tolist()
        assert table["label"].tolist() == [f"t{k}" for k in range(7)]
    assert found[0] == found[1]


def test_a_plan_holds_its_table_by_its_hash(case_file, tmp_path):
    planned(load_case(case_file), tmp_path / "plan", 3)
    (case_file.parent / "tests.csv").write_text(ROWS.replace("1.3,", "1.35,"))
    with pytest.raises(InputError, match=r"case\.tables\.0\.sha256: got .*, must be"):
        require_same_software(read_plan(tmp_path / "plan"))


def test_a_lane_of_a_sweep_plays_until_its_own_end(case_file, tmp_path):
    plan = planned(load_case(case_file, {"run.sample_interval": "0.1 s"}), tmp_path / "plan", 3)
    run = run_of_lane(plan, 1)
    whole = run_case(load_case(case_file), "housner", histories=False)
    assert run.response["peak_time"][0] == whole.response["peak_time"][1]
    assert run.lane_set.times.duration == 0.75
    history = history_table(run_lane(run, 0), 0, run.lane_set, 0)
    assert history["time_s"].max() == pytest.approx(0.7)


def test_a_table_is_the_same_case_in_python(case_file):
    tables = {**load_case(case_file).raw, "sweep": {"table": "tests.csv"}}
    made = wr.Case.from_dict(tables, folder=case_file.parent)
    of_frame = wr.Case.from_table(
        pd.read_csv(case_file.parent / "tests.csv"),
        **{name: tables[name] for name in ("block", "contact", "start", "run")},
    )
    expected = expand_lanes(load_case(case_file)).inputs
    for case in (made, of_frame):
        pd.testing.assert_frame_equal(case.lanes(), expected, check_dtype=False)
    shorter = made.override({"run.duration": "0.5 s"})
    assert expand_lanes(shorter).durations is None
    assert shorter.lane_count == 7
    assert wr.load_case(case_file).to_toml().endswith('[[sweep]]\ntable = "tests.csv"\n')
