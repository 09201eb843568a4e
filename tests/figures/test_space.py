"""Figures of blocks in space."""

from __future__ import annotations

import pathlib

import numpy as np

from warprock import limit
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


def test_a_wide_slab_leaves_the_wall_on_it_large(tmp_path: pathlib.Path) -> None:
    def outline(name: str, left: float, bottom: float, right: float, top: float) -> str:
        corners = [(left, bottom), (right, bottom), (right, top), (left, top)]
        return "\n".join([f"o {name}", *(f"v {x} {z} 0" for x, z in corners), "f -4 -3 -2 -1\n"])

    drawing = outline("ground", -50.0, -1.0, 50.0, 0.0) + outline("wall", 0.0, 0.0, 1.0, 2.0)
    (tmp_path / "wall.obj").write_text(drawing, encoding="utf-8")
    fields = 'pattern = "file"\nfile = "wall.obj"\nfile_unit = "1 m"\nfixed = ["ground"]\n'
    lines = [line for line in WALL.splitlines() if not line.startswith(("block", "courses"))]
    case = "\n".join(lines).replace('pattern = "wall"\n', fields)
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    (figure,) = [each.figure for each in limit(tmp_path, progress=False).figures()]
    low, high = figure.axes[0].get_xlim()
    # The wall is 2 m high, and what is fixed is seen for 0.15 of that beside it.
    assert high - low < 4.0
