"""Figures of blocks in space."""

from __future__ import annotations

import pathlib

import numpy as np

from warprock.case.load import load_case
from warprock.figures.run import draw_run
from warprock.figures.space import _message
from warprock.running.case_run import run_case

WALL = """
title = "A wall across its plane"
source = "Made up."
model = "spatial"
[assembly]
pattern = "wall"
block_length = "0.4 m"
block_height = "0.2 m"
blocks = 2
courses = 3
density = "2000 kg/m^3"
depth = "0.2 m"
[contact]
friction = 0.7
[motion]
waveform = "tilt"
tilt_rate = "4 deg/s"
direction = "90 deg"
[run]
duration = "0.2 s"
sample_interval = "50 ms"
"""


def test_a_title_has_no_exponents() -> None:
    yaw = np.array([0.0, -123.4])
    said = _message([(yaw, np.array([0.0, 1.46]), yaw)], "")
    assert "up to 1.5 of" in said
    assert said.endswith("120 deg")


def test_an_assembly_has_histories_but_no_axis_that_leaves_a_plane(tmp_path: pathlib.Path) -> None:
    (tmp_path / "case.toml").write_text(WALL, encoding="utf-8")
    run = run_case(load_case(tmp_path), "assembly", histories=False)
    assert [each.name for each in draw_run(run)][:1] == ["histories"]
