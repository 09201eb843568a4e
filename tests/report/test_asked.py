"""What a page says of what was asked."""

from __future__ import annotations

from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.case.round_base import round_base_note
from warprock.report.asked import asked
from warprock.running.provenance import case_facts


def test_a_page_says_what_runs_in_the_place_of_a_cylinder():
    over = ["block.diameter=0.6 m", "block.height=1.1 m"]
    case = load_case("single-sine-pulse", over)
    facts, inputs = {"case": case_facts(case)}, expand_lanes(case).inputs
    assert dict(asked(facts, inputs))["Round base"] == round_base_note(inputs)
    assert "explain" in dict(asked(facts))["Round base"]
    boxes = {"case": case_facts(load_case("single-sine-pulse"))}
    assert "Round base" not in dict(asked(boxes))
