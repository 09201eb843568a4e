"""Which sides of which lanes are led outwards, and which cases are refused."""

from __future__ import annotations

import pytest

import warprock as wr
from tests.shared.commands import succeed

WALL = {
    "block": {"width": "0.6 m", "height": "4.8 m", "depth": "1 m", "density": "2000 kg/m^3"},
    "contact": {"friction": 0.7},
    "run": {"duration": "5 s"},
}
TIE = {"side": "left", "height": "4.5 m", "stiffness": "2 kN/mm", "yield_force": "12 kN"}


def test_a_free_block_has_one_row_and_a_held_one_two():
    assert wr.capacity(WALL).table["side"].tolist() == ["either"]
    assert wr.capacity({**WALL, "tie": [TIE]}).table["side"].tolist() == ["left", "right"]


def test_no_block_is_led_into_its_wall():
    case = {**WALL, "transverse_wall": {"side": "left", "rebound": "plastic"}}
    case["sweep"] = {"transverse_wall": {"side": ["left", "right"]}}
    table = wr.capacity(case).table
    assert table["side"].tolist() == ["right", "left"]
    assert table["lane"].tolist() == [0, 1]


def test_lanes_stay_in_their_order_and_have_what_sets_them_apart():
    swept = {"tie.1.yield_force": ["1 kN", "12 kN"]}
    table = wr.capacity({**WALL, "tie": [TIE]}, overrides=swept).table
    assert table["lane"].tolist() == [0, 0, 1, 1]
    assert table["tie_yield_force_1_N"].tolist() == [1e3, 1e3, 12e3, 12e3]
    right = table[table["side"] == "right"]
    assert right["work_J"].is_monotonic_increasing
    left = table[table["side"] == "left"]["work_J"].tolist()
    assert left[0] == pytest.approx(left[1], rel=1e-12)


def test_many_lanes_are_the_same_as_few(monkeypatch):
    swept = {"block.width": "0.4 m to 0.8 m, 11"}
    whole = wr.capacity({**WALL, "tie": [TIE]}, overrides=swept).table
    monkeypatch.setattr("warprock.analysis.statics.AT_ONCE", 3)
    parts = wr.capacity({**WALL, "tie": [TIE]}, overrides=swept).table
    assert whole.equals(parts)


@pytest.mark.parametrize("name", ["stack-collapse", "space-free", "strip", "arch"])
def test_what_is_no_single_box_in_the_plane_is_refused(name, tmp_path):
    case = name
    if name in ("strip", "arch"):
        case = tmp_path / "case.toml"
        succeed("init", name, case)
    with pytest.raises(wr.InputError, match="must be a single box in the plane") as caught:
        wr.capacity(case)
    assert "\n" not in str(caught.value)
    assert ("warprock limit" in str(caught.value)) == (name == "arch")


def test_a_block_on_ground_that_gives_way_is_refused():
    with pytest.raises(wr.InputError, match="must be left out: statics are those of a block on a"):
        wr.capacity({**WALL, "ground": {"stiffness": "50 MN/m^3"}})


def test_a_block_that_falls_by_itself_says_so():
    pulled = {**TIE, "prestress": "5 kN"}
    found = wr.capacity({**WALL, "tie": [pulled]})
    assert found.finding.sentences[0] == (
        "Nothing has to move: the block falls by itself to the left."
    )
    assert found.facts["capacity"]["velocity_step_least_m_s"] == 0.0


def test_a_block_that_nothing_overturns_says_so(tmp_path):
    held = {**TIE}
    del held["yield_force"]
    case = {**WALL, "tie": [held], "transverse_wall": {"side": "left", "rebound": "plastic"}}
    found = wr.capacity(case)
    assert found.finding.sentences[-1] == (
        "Nothing overturns: the moment holds up to a right angle."
    )
    assert found.save(tmp_path)[-1].name == "report.html"


def test_the_command_prints_what_the_function_says():
    printed = succeed("capacity", "free-b0").stdout
    assert wr.capacity("free-b0").finding.sentences[0] in printed
