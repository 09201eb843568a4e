"""Histories of a rotation as files have them."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

from warprock.errors import InputError
from warprock.recordings.rotation_file import read_rotations


def written(folder: pathlib.Path, text: str) -> pathlib.Path:
    file = folder / "h.csv"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("text", "column", "unit"),
    [
        ("time_s,rotation_deg\n0,1\n0.1,2\n", None, None),
        ("t [ms];x_m;theta [deg]\n0;9;1\n100;9;2\n", None, None),
        ("time theta\n0 1\n0.1 2\n", None, "deg"),
        ("time,a_deg,b_mrad\n0,1,5\n0.1,2,5\n", "a", None),
        ("time,a_deg,b_mrad\n0,1,5\n0.1,2,5\n", "2", None),
    ],
)
def test_a_table_with_an_angle_is_read(tmp_path, text, column, unit):
    found = read_rotations(written(tmp_path, text), column, unit)
    assert found.times == pytest.approx([0.0, 0.1])
    assert found.rotations == pytest.approx(np.radians([1.0, 2.0]))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time,a_deg,b_deg\n0,1,5\n0.1,2,5\n", "rotation: got columns a_deg, b_deg, must be one"),
        ("time,theta\n0,1\n0.1,2\n", "theta: got no unit, must be said"),
        ("x,theta_deg\n0,1\n0.1,2\n", "time: got nothing, must be a column named time"),
        ("time,theta_deg\n0,1\n0,2\n", "time: got 0.0, must grow"),
        ("time,theta_deg\n0,1\n0.1,x\n", "line 3"),
        ("time,theta_deg\n", "must begin a table"),
        ("nothing", "must begin a table"),
        ("", "must begin a table"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_line(tmp_path, text, said):
    with pytest.raises(InputError) as error:
        read_rotations(written(tmp_path, text))
    assert said in str(error.value)


def test_no_file_and_no_text_are_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_rotations(tmp_path / "none.csv")
    (tmp_path / "b.csv").write_bytes(b"time,a_deg\n0,\xff\n")
    with pytest.raises(InputError, match="not UTF-8"):
        read_rotations(tmp_path / "b.csv")
