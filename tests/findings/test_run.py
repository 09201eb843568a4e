"""What is said of a run in words."""

from __future__ import annotations

import pathlib

import pandas as pd
import pytest

from tests.shared.case_texts import pulse_text
from warprock.case.load import load_case
from warprock.findings.refinement import refinement_sentences
from warprock.findings.run import peak_sentences, run_sentences, tie_sentences
from warprock.model.response import Outcome
from warprock.running.case_run import run_case
from warprock.running.lane_table import lane_table
from warprock.running.provenance import provenance


@pytest.mark.parametrize(("width", "friction"), [("0.5 m", 0.0), ("0.8 m", 0.001), ("1 m", 0.01)])
def test_a_block_that_slides_and_never_lifts_did_not_rock(
    tmp_path: pathlib.Path, width: str, friction: float
):
    text = pulse_text(
        width=width, friction=friction, amplitude="2 m/s^2", frequency="1 Hz", duration="0.8 s"
    )
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    run = run_case(load_case(tmp_path), "event", histories=False)
    response = run.response
    assert response["outcome"][0] == Outcome.ROCKING
    assert response["peak_rotation"][0] == 0.0
    assert response["peak_slide"][0] > 0.1
    said = run_sentences(provenance(run), lane_table(run.lane_set, response))[0]
    assert "still moved" in said
    assert "rocked" not in said


def test_of_thrown_blocks_the_page_says_how_far_they_went() -> None:
    """They lie on any side, so that a peak rotation beyond the slenderness angle is no fall."""
    table = pd.DataFrame(
        {
            "lane": [0, 1],
            "outcome": ["at_rest", "at_rest"],
            "status": ["ok", "ok"],
            "peak_rotation_ratio": [4.5, 2.1],
            "peak_slide_m": [0.25, 0.75],
            "rest_time_s": [0.5, 1.25],
            "attitude_w_start": [1.0, 0.0],
        }
    )
    facts = {"case": {"resolved": {}}}
    (said,) = peak_sentences(facts, table)
    assert said.startswith("The farthest goes 0.750 m along the base, lane 1")
    assert said.endswith("lies still after 1.25 s.")
    (alone,) = peak_sentences(facts, table.iloc[:1])
    assert alone == "It goes 0.250 m along the base and lies still after 0.500 s."
    standing = table.drop(columns="attitude_w_start").assign(peak_rotation_ratio=[0.5, 0.25])
    assert "stayed up" in peak_sentences(facts, standing)[0]


def test_the_largest_force_of_a_tie_is_that_of_a_usable_lane() -> None:
    table = pd.DataFrame(
        {
            "lane": [0, 1, 2],
            "status": ["ok", "ok", "broken"],
            "peak_tie_force_N": [4e3, 1.25e4, 9e9],
            "broken_ties": [0, 2, 1],
            "tie_break_time_s": [float("nan"), 3.5, 1.0],
        }
    )
    facts = {"case": {"resolved": {}}}
    (said,) = tie_sentences(facts, table)
    assert said == "The largest force of a tie is 12.5 kN, in lane 1; in 1 lane a tie broke."
    (alone,) = tie_sentences(facts, table.iloc[1:2])
    assert alone == "The largest force of a tie is 12.5 kN; a tie broke at 3.50 s."
    (none,) = tie_sentences(facts, table.iloc[:1])
    assert none == "The largest force of a tie is 4 kN; none broke."
    assert tie_sentences(facts, table.iloc[2:]) == []
    assert tie_sentences(facts, table.drop(columns="peak_tie_force_N")) == []


def test_lanes_that_no_step_settles_leave_the_distributions_that_the_case_asks_for() -> None:
    counts = {"met": 0, "missed": 0, "sensitive": 1, "refined": 1}
    facts = {
        "engine": {"name": "event", "settings": {"time_step": 5e-3}},
        "tolerance": 0.01,
        "lanes": 1,
        "status": {"sensitive": 1},
        "refinement": {**counts, "first_step_count": 1, "total_step_count": 4},
    }
    for resolved, advice in (
        ({}, "an [ensemble] in the case, and its distributions instead of single lanes."),
        ({"ensemble": {"members": 8}}, "the distributions of the cells instead of single lanes."),
    ):
        said = refinement_sentences({**facts, "case": {"resolved": resolved}})[-1]
        assert said.endswith(f"where that does not help, {advice}")
