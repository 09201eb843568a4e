"""The table [assembly]: patterns, lanes, columns, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import warprock as wr
from tests.shared.commands import invoke
from warprock.engines import ENGINES

ARCH = {
    "pattern": "arch",
    "mean_radius": "5 m",
    "thickness": "0.8 m",
    "embrace": "160 deg",
    "voussoirs": 9,
    "density": "2000 kg/m^3",
}
WALL = {
    "pattern": "wall",
    "block_length": "0.4 m",
    "block_height": "0.2 m",
    "blocks": 4,
    "courses": 6,
    "density": "2000 kg/m^3",
}


def case(assembly: dict[str, Any], **more: Any) -> wr.Case:
    tables = {"contact": {"friction": 0.6}, "run": {"duration": "1 s"}, **more}
    return wr.Case.from_dict({"assembly": assembly, **tables})


def test_lanes_are_assemblies_and_share_those_that_are_the_same():
    swept = {"assembly.thickness": ["0.7 m", "0.8 m"], "assembly.voussoirs": [9, 11]}
    found = wr.expand_lanes(
        case(ARCH, sweep=[{key: each} for key, each in swept.items()], motion=_motion())
    )
    assemblies = found.lanes.assembly
    assert [kind.joints.count for kind in assemblies.kinds] == [10, 12, 10, 12]
    assert found.inputs["blocks"].tolist() == [9, 11, 9, 11]
    assert found.inputs["thickness_m"].tolist() == [0.7, 0.7, 0.8, 0.8]
    assert found.inputs["embrace_deg"].tolist() == pytest.approx([160.0] * 4)
    weight = 2000.0 * np.radians(160.0) * 5.0 * found.inputs["thickness_m"]
    # Voussoirs have straight sides: less than the sector by 1 - sin(a) / a, a its angle.
    angle = np.radians(160.0) / found.inputs["blocks"]
    assert found.lanes.mass == pytest.approx(weight * np.sin(angle) / angle)
    again = wr.expand_lanes(
        case(ARCH, sweep=[{"motion.amplitude": ["0.1 g", "0.2 g"]}], motion=_motion())
    )
    assert len(again.lanes.assembly.kinds) == 1
    assert found.lanes.take(np.array([3, 1])).assembly.of(0).joints.count == 12


def _motion() -> dict[str, Any]:
    return {
        "waveform": "sine",
        "control": "acceleration",
        "frequency": "1 Hz",
        "amplitude": "0.1 g",
        "cycles": 1,
    }


@pytest.mark.parametrize(
    ("assembly", "more", "said"),
    [
        ({**ARCH, "pattern": "vault"}, {}, "must be the pattern by which the blocks are laid"),
        ({**ARCH, "courses": 3}, {}, "assembly.courses: got 3.0, must be left out: it belongs to"),
        ({**WALL, "voussoirs": 3}, {}, "must be left out: it belongs to pattern arch"),
        ({k: v for k, v in ARCH.items() if k != "embrace"}, {}, "assembly.embrace: got nothing"),
        ({**ARCH, "voussoirs": 2.5}, {}, "must be a whole number (lane 0)"),
        ({**ARCH, "voussoirs": 0}, {}, "assembly.voussoirs: got 0, must be the number"),
        ({**ARCH, "voussoirs": 501}, {}, "assembly.voussoirs: got 501"),
        ({**ARCH, "thickness": "10 m"}, {}, "must be less than twice assembly.mean_radius"),
        ({**WALL, "courses": 300}, {}, "must make at most 500 blocks"),
        ({**WALL, "openings": [["1 m", "0.1 m", "0.2 m", "0.2 m"]]}, {}, "begin and end with"),
        ({**WALL, "openings": [["1 m", "0 m", "0.7 m", "0.2 m"]]}, {}, "must lie in the wall"),
        ({**WALL, "openings": [["1 m", "0 m", "0.7 m"]]}, {}, "must be a list of rectangles"),
        ({**WALL, "openings": [["0 m", "0 m", "1.6 m", "0.2 m"]]}, {}, "rest on something fixed"),
        (ARCH, {"block": {"width": "1 m"}}, "block"),
        (ARCH, {"start": {"rotation": "1 deg"}}, "must be left out: an assembly starts at rest"),
        (ARCH, {"contact": {"friction": 0.5, "angular_restitution": 0.9}}, "impacts are plastic"),
        (ARCH, {"model": "spatial"}, "must be planar, or left out, with [assembly]"),
        (ARCH, {"frame": {"columns": 2, "beam_mass": "1 kg"}}, "is an assembly ([assembly])"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_line(assembly, more, said):
    with pytest.raises(wr.InputError) as error:
        wr.expand_lanes(case(assembly, **more))
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_a_case_has_a_block_or_an_assembly():
    tables = {"contact": {"friction": 0.5}, "run": {"duration": "1 s"}}
    with pytest.raises(wr.InputError, match=r"block: got nothing, must be given, or an \[assembly"):
        wr.Case.from_dict(tables)


@pytest.mark.parametrize("engine", [name for name in ENGINES if name != "assembly"])
def test_other_engines_decline_and_say_which_runs_it(engine: str):
    with pytest.raises(wr.InputError, match=r"has an \[assembly\]; assembly runs it"):
        wr.run(case(WALL), engine, progress=False)


def test_a_run_tells_of_displacements_and_joints():
    run = wr.run(case(WALL), progress=False)
    assert run.engine == "assembly"
    assert {"peak_displacement_m", "opened_joints", "collapse_time_s"} <= set(run.table)
    assert run.table["outcome"].tolist() == ["at_rest"]


def test_limit_is_for_assemblies():
    with pytest.raises(wr.InputError, match="assembly: got nothing, must be given: limit analysis"):
        wr.limit("free-b0")


def test_explain_says_what_touches_what(tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(case({**WALL, "courses": 2}).to_toml(), encoding="utf-8")
    done = invoke("explain", file)
    assert done.exit_code == 0
    assert "a planar assembly of 9 blocks that can move" in done.output
    assert "joints: ground and 1.1; ground and 1.2;" in done.output
    assert "assembly runs them" in done.output
