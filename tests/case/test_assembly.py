"""The table [assembly]: patterns, lanes, columns, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import warprock as wr
from tests.shared.commands import invoke
from warprock.engines import ENGINES
from warprock.units import GRAVITY

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

DRY = {
    "pattern": "dry-stone",
    "wall_length": "2 m",
    "wall_height": "1.2 m",
    "stone_length": "0.4 m",
    "stone_height": "0.2 m",
    "variation": 1.0,
    "seed": 1,
    "density": "2000 kg/m^3",
}


CORNER = {**WALL, "pattern": "corner", "return_blocks": 2, "depth": "0.2 m"}


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


def test_single_joints_have_a_friction_of_their_own():
    swept = case({**ARCH, "weak_joints": ["left abutment / 1"]}, sweep=[WEAK])
    found = wr.expand_lanes(swept)
    kinds = found.lanes.assembly.kinds
    assert found.inputs["weak_friction"].tolist() == [0.2, 0.4]
    for kind, friction in zip(kinds, (0.2, 0.4), strict=True):
        own = dict(zip(map(tuple, kind.joints.blocks.tolist()), kind.joints.friction, strict=True))
        assert own.pop((0, kind.names.index("left abutment"))) == friction
        assert set(own.values()) == {0.6}


WEAK = {"assembly.weak_friction": [0.2, 0.4]}


def test_geometry_and_single_joints_are_sampled_and_spread():
    """A sample draws them anew for every lane, an ensemble about those of its case."""
    arch = {**ARCH, "weak_joints": ["left abutment / 1"], "weak_friction": 0.3}
    drawn = {"distribution": "uniform", "from": "0.7 m", "to": "0.9 m"}
    joint = {"distribution": "uniform", "from": 0.2, "to": 0.4}
    sample = {"lanes": 8, "over": {"assembly.thickness": drawn, "assembly.weak_friction": joint}}
    ensemble = {
        "members": 8,
        "spread": {"assembly.thickness": "5 %", "assembly.weak_friction": "20 %"},
    }
    bounds = {"thickness_m": (0.7, 0.9), "weak_friction": (0.2, 0.4)}
    for more in ({"sample": sample}, {"ensemble": ensemble}):
        found = wr.expand_lanes(case(arch, motion=_motion(), **more))
        kinds = found.lanes.assembly
        assert len(kinds.kinds) == 8
        for column, (low, high) in bounds.items():
            values = found.table.columns[column]
            assert len(set(values.tolist())) == 8
            assert low <= values.min() < values.max() <= high
        for lane in range(8):
            joints = kinds.of(lane).joints
            assert joints.friction.min() == found.table.columns["weak_friction"][lane]
            assert joints.lengths == pytest.approx(found.table.columns["thickness_m"][lane])


def test_walls_of_dry_stone_are_drawn_from_their_seed():
    seeds = [{"assembly.seed": {"from": 1, "to": 20, "count": 20}}]
    kinds = wr.expand_lanes(case(DRY, sweep=seeds)).lanes.assembly.kinds
    assert len({kind.count for kind in kinds}) > 3
    for kind in kinds:
        assert kind.area[1:].sum() == pytest.approx(2.0 * 1.2)
    again = wr.expand_lanes(case({**DRY, "seed": 7})).lanes.assembly.of(0)
    assert again.corners.tolist() == kinds[6].corners.tolist()
    alike = wr.expand_lanes(case({**DRY, "variation": 0.0})).lanes.assembly.of(0)
    assert alike.count == 1 + 3 * 5 + 3 * 6


def test_motions_are_measured_by_what_tips_a_block_as_high():
    """So that `map`, `spectrum` and fragility take an assembly as they take a block."""
    found = wr.expand_lanes(case(ARCH, motion=_motion()))
    kind, row = found.lanes.assembly.of(0), found.inputs.iloc[0]
    assert row["slenderness_angle_rad"] == kind.slenderness_angle
    # p of a block: p^2 = 3 g / (4 R), 2 R its diagonal.
    assert row["frequency_parameter_rad_s"] ** 2 == pytest.approx(1.5 * GRAVITY / kind.reach)
    assert row["normalised_acceleration"] == pytest.approx(0.1 / np.tan(kind.slenderness_angle))


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
        ({**ARCH, "pattern": "dome"}, {}, "must be the pattern by which the blocks are laid"),
        ({**ARCH, "courses": 3}, {}, "assembly.courses: got a value, must be left out"),
        ({**WALL, "voussoirs": 3}, {}, "must be left out: it belongs to pattern arch"),
        ({k: v for k, v in ARCH.items() if k != "embrace"}, {}, "assembly.embrace: got nothing"),
        ({**ARCH, "voussoirs": 2.5}, {}, "must be a whole number (lane 0)"),
        ({**ARCH, "voussoirs": 0}, {}, "assembly.voussoirs: got 0, must be at least 1"),
        ({**ARCH, "voussoirs": 20_001}, {}, "assembly.voussoirs: got 20001"),
        ({**ARCH, "thickness": "10 m"}, {}, "must be less than twice assembly.mean_radius"),
        ({**WALL, "courses": 9000}, {}, "must make at most 20,000 blocks"),
        ({**WALL, "openings": [["1 m", "0.1 m", "0.2 m", "0.2 m"]]}, {}, "begin and end with"),
        ({**WALL, "openings": [["1 m", "0 m", "0.7 m", "0.2 m"]]}, {}, "must lie in the wall"),
        ({**WALL, "openings": [["1 m", "0 m", "0.7 m"]]}, {}, "must be a list of rectangles"),
        ({**WALL, "openings": [["0 m", "0 m", "1.6 m", "0.2 m"]]}, {}, "rest on something fixed"),
        ({**ARCH, "weak_friction": 0.3}, {}, "assembly.weak_joints: got nothing, must be a list"),
        ({**ARCH, "weak_joints": ["1 / 2"]}, {}, "assembly.weak_friction: got nothing"),
        ({**ARCH, "weak_joints": ["1 / 3"], "weak_friction": 0.3}, {}, "blocks do not touch"),
        (
            {**ARCH, "weak_joints": ["1 / left abutmnt"], "weak_friction": 0.3},
            {},
            "did you mean left",
        ),
        ({**ARCH, "weak_joints": ["1, 2"], "weak_friction": 0.3}, {}, 'such as ["1.1 / 2.1"]'),
        ({**ARCH, "joint_cohesion": "1 MPa"}, {}, "assembly.joint_tensile_strength: got nothing"),
        ({**ARCH, "joint_tensile_strength": "0 MPa"}, {}, "strength of bonded joints"),
        ({**DRY, "seed": 1.5}, {}, "assembly.seed: got 1.5, must be a whole number"),
        ({**DRY, "stone_length": "9 m"}, {}, "must be at most assembly.wall_length"),
        (
            {**DRY, "stone_length": "1 mm", "stone_height": "10 mm"},
            {},
            "must make at most some 18,000 stones",
        ),
        (ARCH, {"block": {"width": "1 m"}}, "block"),
        (ARCH, {"start": {"rotation": "1 deg"}}, "must be left out: an assembly starts at rest"),
        (ARCH, {"contact": {"friction": 0.5, "angular_restitution": 0.9}}, "impacts are plastic"),
        ({**CORNER, "depth": "0.4 m"}, {}, "must be less than assembly.block_length"),
        ({**CORNER, "returns": 1.5}, {}, "assembly.returns: got 1.5, must be a whole number"),
        (CORNER, {"model": "planar"}, "or left out: assembly.pattern needs it"),
        (
            WALL,
            {
                "model": "planar",
                "motion": {"waveform": "tilt", "tilt_rate": "1 deg/s", "direction": "90 deg"},
            },
            "motion.direction: got a value, must be left out: in the plane the base moves along x",
        ),
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


@pytest.mark.parametrize("engine", [name for name in ENGINES if name not in ("assembly", "dem")])
def test_other_engines_decline_and_say_which_runs_it(engine: str):
    with pytest.raises(wr.InputError, match=r"\[assembly\].*; assembly and dem run it"):
        wr.run(case(WALL), engine, progress=False)


@pytest.mark.usefixtures("two_rooms")
def test_a_run_tells_of_displacements_and_joints():
    push = {"waveform": "push", "amplitude": "0.01 g"}
    run = wr.run(case(ARCH, motion=push), progress=False)
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
    assert "joints: ground / 1.1; ground / 1.2;" in done.output
    assert "assembly runs it" in done.output


@pytest.mark.parametrize(
    ("table", "more", "because"),
    [
        (WALL, {"model": "spatial"}, 'asks for model = "spatial"'),
        (CORNER, {}, "lays its blocks in space (assembly.pattern)"),
        (WALL, {"motion": {"tilt_rate": "1 deg/s", "direction": "90 deg"}}, "motion.direction"),
    ],
)
def test_assemblies_are_in_space_where_the_case_asks_for_it(table, more, because):
    more = {
        key: {"waveform": "tilt", **each} if key == "motion" else each for key, each in more.items()
    }
    found = wr.expand_lanes(case(table, **more))
    assert found.scene.spatial
    assert because in found.scene.spatial_because
    kind = found.lanes.assembly.of(0)
    assert kind.corners.shape[2] == 3
    assert found.lanes.depth[0] == pytest.approx(kind.size[1])
    assert found.lanes.mass[0] == pytest.approx(kind.mass[~kind.fixed].sum())
    assert found.scene.contact_point_count == kind.joints.end_count.sum()


def test_a_table_in_space_tilts_in_its_direction():
    motion = {"waveform": "tilt", "tilt_rate": "1 deg/s", "direction": "30 deg"}
    found = wr.expand_lanes(case(WALL, motion=motion))
    x, y = found.motions.x.scale[0], found.motions.y.scale[0]
    assert [x, y] == pytest.approx([-np.cos(np.pi / 6.0), -0.5])


def test_limit_tells_the_direction_in_space():
    spatial = case({**WALL, "depth": "0.2 m"}, model="spatial")
    found = wr.limit(spatial, direction="90 deg", progress=False)
    assert found.table["load_factor"].tolist() == pytest.approx([0.2 / 1.2])
    assert found.table["towards_deg"].tolist() == pytest.approx([90.0])
    assert "collapses towards 90 degrees" in found.finding.sentences[0]
    with pytest.raises(wr.InputError, match="must be 0 deg or 180 deg: the assembly lies in the"):
        wr.limit(case(WALL), direction="90 deg", progress=False)
    with pytest.raises(wr.InputError, match="must be an angle with a unit"):
        wr.limit(spatial, direction="90", progress=False)
