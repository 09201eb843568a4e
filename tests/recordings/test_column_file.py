"""Tables with named columns: what is read of them, and what is said where something is missing."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

from warprock.errors import InputError
from warprock.recordings import load_channels, load_record
from warprock.recordings.column_file import Reading
from warprock.recordings.loading import read_channels
from warprock.units import GRAVITY

ROWS = "0.00,0.0\n0.01,0.1\n0.02,-0.2\n0.03,0.0\n"


@pytest.mark.parametrize(
    ("text", "peak", "interval"),
    [
        (f"time,acceleration_g\n{ROWS}", 0.2 * GRAVITY, 0.01),
        (f"Time (s),Acc [m/s^2]\n{ROWS}", 0.2, 0.01),
        (f"t [ms],acc_cm_s2\n{ROWS}", 2e-3, 1e-5),
        (f'"time","a g"\n{ROWS}', 0.2 * GRAVITY, 0.01),
        ("# time acc_gal\n0 0\n0.5 3\n1 -1\n", 0.03, 0.5),
        ("# source: a test\ntime;a_m_s2\n0,0;0,5\n0,1;-1,5\n", 1.5, 0.1),
        ("time\tv_cm_s\tsite\n0\t0\t1\n1\t2\t1\n2\t0\t1\n", 0.02, 1.0),
    ],
)
def test_a_header_says_what_the_columns_are(text: str, peak: float, interval: float):
    ((channel,),) = read_channels("quake.csv", text.encode())
    assert np.max(np.abs(channel.samples)) == pytest.approx(peak, rel=1e-12)
    assert channel.interval == interval


def test_what_the_header_leaves_out_is_said_by_its_reader(tmp_path: pathlib.Path):
    file = tmp_path / "quake.csv"
    file.write_text(f"time,acceleration\n{ROWS}")
    with pytest.raises(InputError, match=r"--column acceleration --unit g -o record\.csv"):
        load_record(str(file))
    record = load_record(str(file), asked=Reading(unit="g"))
    assert record.peak_acceleration == pytest.approx(0.2 * GRAVITY, rel=1e-12)
    assert load_record(str(file), asked=Reading("2", "gal")).peak_acceleration == 2e-3
    slower = load_record(str(file), asked=Reading(unit="g", interval="20 ms"))
    assert slower.interval == 0.02


def test_columns_are_channels(tmp_path: pathlib.Path):
    file = tmp_path / "two.csv"
    file.write_text("time,x_g,y_g,remark\n0,0,1,7\n1,2,3,7\n")
    assert [record.direction for record in load_channels(str(file))] == ["x_g", "y_g"]
    assert load_record(f"{file}#y_g").samples[1] == pytest.approx(3 * GRAVITY)
    assert load_record(str(file), asked=Reading(column="x")).samples[1] == pytest.approx(
        2 * GRAVITY
    )
    with pytest.raises(InputError, match=r"must be followed by # and a channel: 1 \(x_g\)"):
        load_record(str(file))


@pytest.mark.parametrize(
    ("text", "asked", "words"),
    [
        (f"time,acc\n{ROWS}", Reading("speed", "g"), "--column: .* must be a column of .*: acc$"),
        (f"time,acc\n{ROWS}", Reading(unit="kg"), "--unit: .* must be a unit of a motion: g"),
        ("acc_g,b\n1,2\n3,4\n", Reading(), "must be a column named time"),
        ("time,a_g\n0,1\n1,2\n5,3\n", Reading(), "must be evenly spaced, here 2.5 s apart"),
        ("time,a_g\n0,1\n0,2\n", Reading(), "must be evenly spaced"),
        ("time,a_g\n0,1\n1,2,3\n", Reading(), "line 3: got 3 fields, must have 2 fields"),
        ("time,a_g\n0,1\n1,nan\n", Reading(), "line 3: got 'nan', must be finite numbers"),
        ("time,a_g\n0,1\n", Reading(), "must be at least 2 samples"),
        ("a_g\n1\n2\n", Reading(interval="fast"), "--interval: got 'fast', must be a time"),
        ("a_g\n1\n2\n", Reading(interval="0 s"), "--interval: .* must be a time above 0 s"),
        ("# unit: g\n# interval: 1 s\n1\n2\n", Reading(unit="g"), "--unit: .* must be left out"),
    ],
)
def test_what_cannot_be_read_is_one_line(text: str, asked: Reading, words: str):
    with pytest.raises(InputError, match=words):
        read_channels("quake.csv", text.encode(), [asked])
