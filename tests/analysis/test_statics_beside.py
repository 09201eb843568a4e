"""Static answers beside what became of the lanes."""

from __future__ import annotations

import numpy as np
import pytest

import warprock as wr

BLOCK = {
    "block": {"width": "0.5 m", "height": "2 m", "depth": "1 m", "density": "2000 kg/m^3"},
    "contact": {"friction": 5.0},
    "run": {"duration": "4 s"},
}


def stepped(step: float) -> dict[str, object]:
    """The block on a base that starts with a velocity, which it keeps for long [m/s]."""
    motion = {"waveform": "sine", "control": "displacement", "frequency": "0.01 Hz", "cycles": 1}
    return {**BLOCK, "motion": {**motion, "amplitude": f"{step!r} m/s"}}


def test_a_step_of_velocity_overturns_where_statics_says():
    whole = float(wr.capacity(BLOCK).table["velocity_step_m_s"].iloc[0])
    swept = {"motion.amplitude": [f"{part * whole!r} m/s" for part in (0.8, 0.99, 1.01, 1.2)]}
    table = wr.capacity(stepped(1.0), dynamics=True, overrides=swept).table
    # In 4 s a base of 0.01 Hz loses 3 % of its velocity, at which the block is pushed back by less
    # than a thousandth of g; the block is over its edge after half of that.
    np.testing.assert_allclose(table["base_velocity_ratio"], [0.8, 0.99, 1.01, 1.2], rtol=1e-4)
    assert table["outcome"].tolist()[::3] == ["rocking", "overturned"]
    assert table["rotation_capacity_ratio"].is_monotonic_increasing
    assert table["rotation_capacity_ratio"].iloc[1] < 1.0


def test_no_block_turns_below_its_multiplier():
    case = {**BLOCK, "motion": {"waveform": "sine", "control": "acceleration", "cycles": 1}}
    case["motion"] |= {"amplitude": "0.3 g", "frequency": "1 Hz"}
    swept = {"motion.amplitude": ["0.24 g", "0.26 g", "0.5 g"]}
    found = wr.capacity(case, dynamics=True, overrides=swept)
    table = found.table
    np.testing.assert_allclose(table["base_multiplier_ratio"], [0.96, 1.04, 2.0], rtol=1e-3)
    turned = table["rotation_capacity_ratio"]
    assert turned.iloc[0] == 0.0
    assert 0.0 < turned.iloc[1] < turned.iloc[2]
    assert found.finding.sentences[0].startswith("In 2 of 3 lanes the base accelerates beyond")


def test_each_side_is_set_against_its_own_statics():
    tie = {"side": "left", "height": "1.9 m", "stiffness": "20 N/mm", "yield_force": "2 kN"}
    table = wr.capacity({**stepped(0.3), "tie": [tie]}, dynamics=True).table
    left, right = table["base_velocity_ratio"]
    assert left > right
    assert table["outcome"].nunique() == 1


@pytest.mark.thorough
def test_two_drawings_come_of_it(tmp_path):
    found = wr.capacity("record-ridgecrest", dynamics=True, overrides={"run.duration": "30 s"})
    found.save(tmp_path)
    assert (tmp_path / "capacity-dynamics.png").is_file()
    assert "outcome" in (tmp_path / "capacity.csv").read_text(encoding="utf-8").splitlines()[0]


def test_a_case_without_a_motion_is_refused():
    with pytest.raises(wr.InputError, match=r"motion: got no table, must be given") as caught:
        wr.capacity(BLOCK, dynamics=True)
    assert "\n" not in str(caught.value)
