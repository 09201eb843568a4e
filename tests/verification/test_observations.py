"""Tables of observed tests, joined with the lanes of a case."""

from __future__ import annotations

import pathlib

import numpy as np
import pandas as pd
import pytest

from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.verification.observations import ObservedTests, read_tests

MEMBERS = 4
RECORDS = ["ridgecrest-2019-ccc-090", "ridgecrest-2019-ccc-360"]
SHORT = {"run.duration": "1 s"}
TWO = [{"motion.record": RECORDS}, {"label.level": ["low", "high"], "motion.scale": [0.5, 1.0]}]
SAMPLE = {
    "lanes": MEMBERS,
    "over": {"block.width": {"distribution": "uniform", "from": "0.16 m", "to": "0.18 m"}},
}
CHANGES = {
    "plain": {"sweep": TWO},
    "ensemble": {
        "sweep": TWO,
        "ensemble": {"members": MEMBERS, "spread": {"block.width": "5 %"}},
    },
    "sample": {"sweep": TWO, "sample": SAMPLE},
}


@pytest.fixture(scope="module")
def cases():
    changed = {"check": [], **SHORT}
    found = {n: load_case("record-ridgecrest", {**changed, **c}) for n, c in CHANGES.items()}
    return {name: (case, expand_lanes(case)) for name, case in found.items()}


@pytest.fixture
def read(cases, tmp_path: pathlib.Path):
    def from_text(text: str, kind: str = "plain", column: str | None = None) -> ObservedTests:
        file = tmp_path / "observed.csv"
        file.write_text(text, encoding="utf-8")
        return read_tests(*cases[kind], file, column)

    return from_text


def test_rows_find_their_lanes_by_any_key_that_fits(read):
    by_record = "record,level,observed\n"
    rows = [f"{RECORDS[1]}.csv,low,fell", f"data/{RECORDS[0]}.csv,high,0"]
    found = read(by_record + "\n".join(rows))
    assert found.lanes.tolist() == [[2], [1]]
    assert found.overturned.tolist() == [True, False]
    assert found.names == (f"low {RECORDS[1]}", f"high {RECORDS[0]}")
    assert found.unobserved == 2
    found = read("lane;outcome\n3;stood\n0;Overturned\n1;\n")
    assert found.lanes.tolist() == [[3], [0]]
    assert found.overturned.tolist() == [False, True]
    assert found.unobserved == 2


@pytest.mark.parametrize("kind", ["ensemble", "sample"])
def test_all_members_of_a_cell_are_one_test(read, kind: str):
    found = read("cell,observed\n2,1\n0,0\n", kind)
    assert found.lanes.tolist() == [[8, 9, 10, 11], [0, 1, 2, 3]]
    found = read(f"level,record,observed\nhigh,{RECORDS[1]},yes\n", kind)
    assert found.lanes.tolist() == [[12, 13, 14, 15]]


def test_a_table_is_as_good_as_a_file(cases, tmp_path: pathlib.Path):
    # A whole number among gaps is written with a point.
    table = pd.DataFrame({"lane": [0, 1, 2], "observed": [1.0, np.nan, 0.0]})
    table.to_parquet(tmp_path / "observed.parquet")
    for observed in (table, tmp_path / "observed.parquet"):
        found = read_tests(*cases["plain"], observed)
        assert found.lanes.tolist() == [[0], [2]]
        assert found.overturned.tolist() == [True, False]


def test_what_was_measured_has_the_unit_of_its_heading(read):
    text = "lane,observed,peak_rotation_deg,peak_slide [mm]\n0,0,90,5\n1,1,,\n2,0,45,\n"
    found = read(text)
    assert found.measured["peak_rotation"] == pytest.approx(
        [np.pi / 2.0, np.nan, np.pi / 4.0], nan_ok=True
    )
    assert found.measured["peak_slide"] == pytest.approx([0.005, np.nan, np.nan], nan_ok=True)
    assert read("lane,observed\n0,0\n").measured == {}


def test_what_was_measured_may_be_of_one_block_of_a_stack():
    case = load_case("stack-sine-pulse", {"check": []})
    lanes = expand_lanes(case)
    headings = {"peak_rotation_2_deg": 90.0, "peak_slide_1 [mm]": 5.0, "peak_rotation_mrad": 3.0}
    table = pd.DataFrame({"lane": [0], "observed": [0], **headings})
    found = read_tests(case, lanes, table).measured
    assert {name: float(values[0]) for name, values in found.items()} == pytest.approx(
        {"peak_rotation_2": np.pi / 2.0, "peak_slide_1": 5e-3, "peak_rotation": 3e-3}
    )
    for heading, words in (
        ("peak_rotation_3_deg", "got block 3, must be from 1, the lowest block, to 2"),
        ("peak_displacement_mm", "must be peak_rotation or peak_slide"),
        ("peak_rotation_2_rad", "must be there once"),
    ):
        with pytest.raises(InputError, match=words):
            read_tests(case, lanes, table.assign(**{heading: 1.0}))


def test_the_labels_of_a_case_may_say_the_outcomes():
    axis = {"label.observed": ["fell", "stood", "-"], "motion.scale": [0.5, 0.7, 0.9]}
    axis |= {"label.observed_later": ["0", "0", "1"], "label.test": ["a", "b", "c"]}
    case = load_case("record-ridgecrest", {"check": [], "sweep": [axis], **SHORT})
    lanes = expand_lanes(case)
    found = read_tests(case, lanes, None)
    assert (found.names, found.overturned.tolist(), found.unobserved) == (
        (f"a {RECORDS[0]}", f"b {RECORDS[0]}"),
        [True, False],
        1,
    )
    for column in ("later", "observed_later", "observed.later"):
        assert read_tests(case, lanes, None, column).overturned.tolist() == [False, False, True]
    with pytest.raises(InputError, match="--column: got 'test2', must be a label"):
        read_tests(case, lanes, None, "test2")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("record,observed\nx,1\n", "record: got 'x', must fit a lane of the case (row 1)"),
        (f"record,observed\n{RECORDS[0]},1\n", "must fit one test, not 2: a column level or lane"),
        ("lane,observed\n1,1\n0,1\n1,0\n", "must be there once, and is in row 1 too (row 3)"),
        ("lane,observed\n9,1\n", "lane: got '9', must fit a lane"),
        ("lane,observed\n1,maybe\n", "observed: got 'maybe', must be 1, true, yes"),
        ("lane,observed\n1,\n", "must say of a test whether it fell"),
        ("level2,observed\nlow,1\n", "must be a column: level or record or lane says which test"),
        ("lane,obsrved\n1,1\n", "did you mean obsrved?"),
        ("lane,observed\n", "at least one row"),
        ("lane,lane,observed\n1,1,1\n", "the column again"),
        ("lane,observed,peak_slide_2_mm\n1,1,3\n", "the case has no stack"),
        ("lane,observed,peak_rotation\n1,1,3\n", "must have the unit behind it: peak_rotation"),
        ("lane,observed,peak_slide_kg\n1,1,3\n", "must have the unit behind it: peak_slide"),
        ("lane,observed,peak_slide_mm\n1,1,-3\n", "must be a number from 0 up, or nothing (row 1)"),
        ("lane,observed\n1,1,2,3\n2,1\n", "4 cells, must have 2, as the header"),
    ],
)
def test_what_cannot_be_joined_is_refused_in_one_line(read, text: str, words: str):
    with pytest.raises(InputError) as refused:
        read(text)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_files_and_columns_that_are_not_there_are_refused(cases, read, tmp_path: pathlib.Path):
    with pytest.raises(InputError, match="no such file"):
        read_tests(*cases["plain"], tmp_path / "none.csv")
    with pytest.raises(
        InputError, match=r"--column: got 'fel', must be a column of .*: lane, fell"
    ):
        read("lane,fell\n1,1\n", column="fel")
    with pytest.raises(InputError, match=r"label.observed: got nothing"):
        read_tests(*cases["plain"], None)
