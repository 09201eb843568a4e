"""Sweeps from files: one row a lane, and what a bad one is told."""

import re

import pandas as pd
import pytest

from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError

CASE = """
title = "blocks of a table"
source = "made up"
[block]
width = "0.4 m"
depth = "0.4 m"
density = "2000 kg/m^3"
height = "2 m"
[contact]
friction = 0.8
[start]
rotation = "1 deg"
[run]
duration = "2 s"
[sweep]
table = "tests.csv"
"""

RECORD = "ridgecrest-2019-ccc-090"
MOTION = '[motion]\nwaveform = "record"\n[run]'


@pytest.fixture
def case_of(tmp_path):
    def write(table, case=CASE):
        (tmp_path / "case.toml").write_text(case)
        if isinstance(table, str):
            (tmp_path / "tests.csv").write_text(table, encoding="utf-8")
        else:
            table.to_parquet(tmp_path / "tests.csv")
        return tmp_path

    return write


def test_a_row_is_a_lane_with_units_in_the_header_or_in_the_cell(case_of):
    rows = "height_mm,block.depth [cm],width,friction,label,observed\n"
    rows += "1800,40,30 cm,0.5,A,1\n1900, 50 ,0.4 m,0.6,B,0\n"
    found = expand_lanes(load_case(case_of(rows)))
    assert found.lanes.height.tolist() == [1.8, 1.9]
    assert found.lanes.depth.tolist() == [0.4, 0.5]
    assert found.lanes.width.tolist() == [0.3, 0.4]
    assert found.lanes.friction.tolist() == [0.5, 0.6]
    assert found.inputs["label"].tolist() == ["A", "B"]
    assert found.inputs["observed"].tolist() == [1.0, 0.0]


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_table_may_be_parted_otherwise_and_begin_with_a_mark(case_of, separator):
    rows = "\ufeffheight_m,observed\r\n1.8,stands\r\n1.9,fell\r\n".replace(",", separator)
    found = expand_lanes(load_case(case_of(rows)))
    assert found.lanes.height.tolist() == [1.8, 1.9]
    assert found.inputs["observed"].tolist() == ["stands", "fell"]


def test_a_parquet_file_is_the_same_table(case_of):
    table = pd.DataFrame({"file": [RECORD] * 2, "scale": [0.5, 0.25], "observed": [1, 0]})
    case = CASE.replace("[run]", MOTION)
    found = expand_lanes(load_case(case_of(table, case)))
    assert found.inputs["scale"].tolist() == [0.5, 0.25]
    assert found.inputs["observed"].tolist() == [1.0, 0.0]


def test_a_table_is_crossed_with_other_sweeps(case_of):
    case = CASE.replace("[sweep]", '[[sweep]]\n"contact.friction" = [0.5, 0.6]\n[[sweep]]')
    found = expand_lanes(load_case(case_of("height_m\n1.8\n1.9\n2.0\n", case)))
    assert found.shape == (2, 3)
    assert found.lanes.height.tolist() == [1.8, 1.9, 2.0] * 2


def test_an_override_takes_the_place_of_one_column(case_of):
    folder = case_of("height_m,width_m\n1.8,0.3\n1.9,0.4\n")
    found = expand_lanes(load_case(folder, ["block.height=2.2 m"]))
    assert found.lanes.height.tolist() == [2.2, 2.2]
    assert found.lanes.width.tolist() == [0.3, 0.4]


def test_columns_are_left_out_by_name_or_key(case_of):
    case = CASE + 'leave_out = ["remarks", "block.width"]\n'
    found = expand_lanes(load_case(case_of("height_m,remarks,width_m\n1.8,windy,0.3\n", case)))
    assert (found.lanes.height.tolist(), found.lanes.width.tolist()) == ([1.8], [0.4])


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("height_m\n1.8\n-3\n", "height_m, row 2: got '-3 m', must be at least 1 mm and"),
        ("height_m\n1.8\nhigh\n", "height_m, row 2: got 'high', must be a length with a unit"),
        ("block.height\n1.8\n", "block.height, row 1: got 1.8, must be a length with a unit"),
        ("height_m,width_m\n1.8,0.4\n1.9\n", "width_m: got nothing, must be given in every row"),
        ("height_m,width_m\n1.8,0.4\n1.9,\n", "width_m: got nothing, must be given in every ro"),
        ("height_m\n1.8\n1.9,4\n", "line 3: got 2 cells, must have 1, as the header"),
        ("heigth_m\n1.8\n", "heigth_m: got the column, must be a key"),
        ("height_m,height_m\n1.8,1.9\n", "height_m: got 'block.height', must be there once"),
        ("height_m,\n1.8,1.9\n", "column 2: got no name, must have a name in the header"),
        ("height_m\n", "got 0 rows, must have at least one row"),
        ("", "got nothing, must have a header and rows"),
        ("rotation_start_deg\n1\n80\n", "start.rotation, row 2: got 80 deg, must be less than"),
    ],
)
def test_a_bad_row_names_file_row_column_and_value(case_of, rows, said):
    folder = case_of(rows)
    with pytest.raises(InputError, match=re.escape(said)) as caught:
        expand_lanes(load_case(folder))
    assert str(caught.value).startswith(str(folder / "tests.csv"))


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('table = "none.csv"', "none.csv: table: got 'none.csv', must be a file to read (no such"),
        ("table = 3", "case.toml: sweep[0].table: got 3, must be the path of a CSV or Parquet"),
        ('table = "tests.csv"\nleave = []', "sweep[0].leave: got [], unknown key (allowed: table"),
        ('table = "tests.csv"\nleave_out = 1', "sweep[0].leave_out: got 1, must be a list"),
    ],
)
def test_an_entry_that_cannot_be_used_names_its_key(case_of, line, said):
    folder = case_of("height_m\n1.8\n", CASE.replace('table = "tests.csv"', line))
    with pytest.raises(InputError, match=re.escape(said)):
        load_case(folder)
