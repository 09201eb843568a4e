"""What a page says of what was asked."""

from __future__ import annotations

from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.case.round_base import round_base_note
from warprock.findings.asked import asked, units_given
from warprock.findings.lanes import lane_name
from warprock.running.provenance import case_facts


def test_lanes_are_named_in_the_unit_in_which_the_case_gives_them():
    over = [
        'motion.frequency="1 Hz"',
        'motion.amplitude={ from = "0.2 g", to = "0.8 g", count = 2 }',
    ]
    case = load_case("overturning-map", over)
    facts, inputs = {"case": case_facts(case)}, expand_lanes(case).inputs
    (column,) = set(units_given(facts["case"]))
    assert column == "amplitude_m_s2"
    table = inputs.assign(lane=range(len(inputs)))
    assert lane_name(facts, table, 1) == "lane 1 (half sine, amplitude 0.800 g)"
    plain = {
        "case": case_facts(
            load_case("overturning-map", [over[0], 'motion.amplitude=["2 m/s^2", "3 m/s2"]'])
        )
    }
    assert units_given(plain["case"]) == {}


def test_an_axis_whose_only_key_is_overridden_is_no_sweep():
    assert "Sweep" in dict(asked({"case": case_facts(load_case("free-b0"))}))
    alone = {"case": case_facts(load_case("free-b0", ["block.height=5 m"]))}
    assert "Sweep" not in dict(asked(alone))


def test_a_page_says_what_runs_in_the_place_of_a_cylinder():
    over = ["block.diameter=0.6 m", "block.height=1.1 m"]
    case = load_case("single-sine-pulse", over)
    facts, inputs = {"case": case_facts(case)}, expand_lanes(case).inputs
    assert dict(asked(facts, inputs))["Round base"] == round_base_note(inputs)
    assert "explain" in dict(asked(facts))["Round base"]
    boxes = {"case": case_facts(load_case("single-sine-pulse"))}
    assert "Round base" not in dict(asked(boxes))
