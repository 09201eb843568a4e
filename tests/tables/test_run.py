"""What `run` says of a lane in words."""

from __future__ import annotations

import pathlib

import pytest

from warprock.case.load import load_case
from warprock.model.response import Outcome
from warprock.report.sentences import run_sentences
from warprock.running.case_run import run_case
from warprock.running.lane_table import lane_table
from warprock.running.provenance import provenance
from warprock.tables.run import run_sentence

SLIDING = """
title = "a block on ice"
source = "a test"
[block]
width = "{width}"
height = "1 m"
depth = "0.5 m"
density = "2400 kg/m^3"
[contact]
friction = {friction}
[motion]
waveform = "sine"
control = "acceleration"
amplitude = "2 m/s^2"
frequency = "1 Hz"
cycles = 1
[run]
duration = "0.8 s"
"""


@pytest.mark.parametrize(("width", "friction"), [("0.5 m", 0.0), ("0.8 m", 0.001), ("1 m", 0.01)])
def test_a_block_that_slides_and_never_lifts_did_not_rock(
    tmp_path: pathlib.Path, width: str, friction: float
):
    text = SLIDING.format(width=width, friction=friction)
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    run = run_case(load_case(tmp_path), "event", histories=False)
    response = run.response
    assert response["outcome"][0] == Outcome.ROCKING
    assert response["peak_rotation"][0] == 0.0
    assert response["peak_slide"][0] > 0.1
    page = run_sentences(provenance(run), lane_table(run.lane_set, response))
    for said in (run_sentence(run), page[0]):
        assert "still moved" in said
        assert "rocked" not in said
