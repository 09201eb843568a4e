"""Assemblies as scenes: all blocks of a lane over time, those that move with the base last."""

import numpy as np
import pytest

import warprock as wr
from warprock.errors import InputError
from warprock.running.catalogue import explain_case
from warprock.running.scene_motion import scene_motion

CASE = {
    "assembly": {
        "pattern": "arch",
        "mean_radius": "10 m",
        "thickness": "1.5 m",
        "embrace": "157.5 deg",
        "voussoirs": 7,
        "density": "2400 kg/m^3",
    },
    "contact": {"friction": 1.0},
    "motion": {"waveform": "tilt", "tilt_rate": "4 deg/s"},
    "run": {"duration": "7.5 s"},
}


@pytest.fixture(scope="module")
def run(two_rooms: None):
    return wr.run(wr.Case.from_dict(CASE), progress=False)


def test_a_collapse_is_told_beside_limit_analysis(run):
    """Oppenheim (1992) has 0.37: the arch falls at the tilt whose tangent is the load."""
    text = " ".join(run.finding.sentences)
    assert (
        "By limit analysis a steady sideways load of 0.374 of the weight (a tilt of 20.5 deg)"
        in text
    )
    assert "joints opened between 1 / left abutment, 3 / 4, 5 / 6, 7 / right abutment" in text
    # Its errors are estimated, in parts of its own slenderness angle.
    assert run.table["slenderness_angle_rad"][0] == pytest.approx(0.129, abs=1e-3)
    assert run.table["peak_rotation_error_rad"].notna().all()
    drawn = {each.name: each for each in run.figures()}
    assert "4 joints opened, none slid" in drawn["mechanism"].title
    assert "load factor 0.374" in drawn["mechanism"].alt


def test_a_scene_shows_all_blocks_of_a_collapse(run):
    kind = run.found.lane_set.lanes.assembly.of(0)
    motion = scene_motion(run.found, 0, 0.1)
    assert motion.fixed == 2
    corners = motion.corners()
    assert corners.shape[:2] == (9, len(motion.times))
    order = np.argsort(kind.fixed, kind="stable")
    assert corners[:, 0] == pytest.approx(kind.corners[order], abs=1e-4)
    assert corners[-2:] == pytest.approx(np.repeat(corners[-2:, :1], len(motion.times), axis=1))
    # Four hinges: three stretches of the arch turn, each as one.
    turned = np.sort(np.round(motion.ratio[:7, -1]))
    assert len(np.unique(turned)) == 3
    assert motion.end == pytest.approx(run.table["collapse_time_s"].iloc[0], abs=0.1)


def wall(side: int) -> dict[str, object]:
    """A case of a wall of so many courses of so many blocks."""
    laid = {"pattern": "wall", "block_length": "0.4 m", "block_height": "0.2 m"}
    sizes = {"blocks": side, "courses": side, "density": "2000 kg/m^3"}
    return CASE | {"assembly": laid | sizes}


def test_explain_says_how_large_and_how_long_a_large_run_is():
    """Of 2,296 joints 8 ms a step: one minute for 7,500 of them."""
    said = " ".join(explain_case(wr.Case.from_dict(wall(28)).judged)["scene"]["laid"])
    assert "run by all threads together, in some 9 MB" in said
    assert "some 1 core minutes" in said
    assert "core minutes" not in " ".join(
        explain_case(wr.Case.from_dict(CASE).judged)["scene"]["laid"]
    )


def test_explain_says_how_long_a_run_in_space_is():
    """Of 40 joints 0.4 ms a step: one minute for 140,000 of them."""
    motion = {"waveform": "sine", "control": "acceleration", "amplitude": "0.1 g"}
    motion |= {"frequency": "1 Hz", "cycles": 1}
    long = {"motion": motion, "run": {"duration": "150 s"}}
    space = wall(4) | {"model": "spatial"} | long
    said = " ".join(explain_case(wr.Case.from_dict(space).judged)["scene"]["laid"])
    assert "some 1 core minutes" in said


def test_limit_analysis_declines_what_is_large():
    with pytest.raises(InputError, match="at most 500 for limit analysis; `run` takes more"):
        wr.limit(wr.Case.from_dict(wall(28)), progress=False)


@pytest.fixture(scope="module")
def fallen():
    """A wall of two courses that a table tilts to its front, followed onto the ground."""
    laid = {"pattern": "wall", "block_length": "0.4 m", "block_height": "0.2 m", "blocks": 1}
    tables = {
        "model": "spatial",
        "assembly": laid | {"courses": 2, "density": "2000 kg/m^3", "depth": "0.2 m"},
        "motion": {"waveform": "tilt", "tilt_rate": "20 deg/s", "direction": "90 deg"},
        "run": {"duration": "2 s"},
        "engines": {"assembly": {"after_collapse": "1 s"}},
    }
    return wr.run(wr.Case.from_dict(CASE | tables), progress=False)


def test_a_scene_shows_blocks_in_space_from_where_they_stood_to_the_ground(fallen):
    kind = fallen.found.lane_set.lanes.assembly.of(0)
    motion = scene_motion(fallen.found, 0, 0.05)
    assert motion.spatial
    assert motion.fixed == 1
    order = np.argsort(kind.fixed, kind="stable")
    corners = motion.corners_in_space()
    assert corners[:, 0] == pytest.approx(kind.corners[order], abs=1e-4)
    # Faces look outwards wherever a block is: their normals lead away from its middle.
    for block, faces in enumerate(motion.faces):
        for face in faces:
            a, b, c = (corners[block, -1, corner] for corner in face[:3])
            assert np.cross(b - a, c - b) @ (a - motion.position[block, -1]) > 0.0
    # A wall that falls to its front lies there, a quarter of a turn and more from upright.
    assert motion.ratio[:-1, -1].min() > 60.0
    assert corners[:-1, -1, :, 1].mean() > 0.1
    assert corners[..., 2][:-1].min() > kind.ground - 0.01


def test_a_page_plays_blocks_in_space(fallen):
    (lane,) = fallen.scenes()["lanes"]
    assert lane["spatial"]
    assert lane["assembly"] == 1
    assert [len(block["f"]) for block in lane["blocks"]] == [6] * len(lane["blocks"])
    assert [("q" in block, block.get("fixed", 0)) for block in lane["blocks"]] == [
        *[(True, 0)] * (len(lane["blocks"]) - 1),
        (False, 1),
    ]
    # The base accelerates along y alone, and the plate reaches below what has fallen.
    assert len(set(lane["sway"])) > 1
    assert len(set(lane["acc"])) == 1
    away = max(abs(place) for block in lane["blocks"] for place in block["y"]) * lane["length"]
    assert lane["plate"] >= away


def test_a_fallen_wall_in_space_is_told_beside_limit_analysis(fallen):
    """To the front, where the table sinks: at thickness over height."""
    text = " ".join(fallen.finding.sentences)
    assert "a steady sideways load of 0.500 of the weight (a tilt of 26.6 deg) brings it" in text
