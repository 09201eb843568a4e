"""Lanes of a folder as scenes in motion."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pytest

from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.model.response import Outcome
from warprock.running.case_run import run_case, run_lane
from warprock.running.lane_table import history_table
from warprock.running.results import write_run
from warprock.running.scene_motion import SceneMotion, run_of_folder, scene_motion


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """A pulse under which a block slides and rocks: two of the six inputs."""
    where = tmp_path_factory.mktemp("run")
    change = ["contact.friction=0.3", "run.duration=1 s"]
    write_run(run_case(load_case("single-sine-pulse", change), "event", histories=False), where)
    return where


@pytest.fixture(scope="module")
def motion(folder: pathlib.Path) -> SceneMotion:
    return scene_motion(run_of_folder(folder), 4, 0.01)


def test_a_lane_of_a_folder_is_the_lane_of_the_run(folder: pathlib.Path, motion: SceneMotion):
    change = ["contact.friction=0.3", "run.duration=1 s"]
    run = run_case(load_case("single-sine-pulse", change), "event", histories=False)
    table = history_table(run_lane(run, 4), 0, run.lane_set, 4)
    np.testing.assert_array_equal(motion.times, table["time_s"])
    np.testing.assert_array_equal(motion.position[0, :, 0], table["x_m"])
    np.testing.assert_array_equal(motion.position[0, :, 2], table["z_m"])
    np.testing.assert_array_equal(motion.base[:, 0], table["base_x_m"])
    np.testing.assert_array_equal(motion.acceleration[:, 0], table["base_acceleration_m_s2"])
    # One cycle of 5 Hz and 5 mm: the base is where its sine says, the block where it slid to.
    inside = motion.times <= 0.2
    sine = 5e-3 * np.sin(2.0 * np.pi * 5.0 * motion.times[inside])
    np.testing.assert_allclose(motion.base[inside, 0], sine, rtol=0.0, atol=1e-12)
    # In the frame of the base it turns about its corner, which slides.
    turn, off = table["rotation_rad"], table["x_m"] - table["base_x_m"]
    lean = np.sign(turn) * 0.085 * (1.0 - np.cos(turn)) + 0.5 * np.sin(turn)
    np.testing.assert_allclose(off, table["slide_m"] + lean, rtol=0.0, atol=1e-9)
    assert np.max(np.abs(table["slide_m"])) > 1e-4


def test_a_history_tells_units_and_meanings(folder: pathlib.Path):
    run = run_of_folder(folder)
    table = history_table(run_lane(run, 0), 0, run.lane_set, 0)
    names = ["time_s", "rotation_rad", "slide_m", "x_m", "z_m", "base_x_m"]
    assert list(table) == [*names, "base_acceleration_m_s2"]
    assert set(table.attrs["columns"]) == set(table)
    assert (
        table.attrs["columns"]["x_m"]["text"] == "Centre of the block along x, seen from the ground"
    )


def test_corners_stand_on_the_base(motion: SceneMotion):
    corners = motion.corners()
    assert corners.shape == (1, len(motion.times), 4, 2)
    np.testing.assert_allclose(corners[..., 1].min(axis=-1), 0.0, rtol=0.0, atol=1e-9)
    sides = np.linalg.norm(np.diff(corners, axis=2), axis=-1)
    np.testing.assert_allclose(sides[0], [[0.17, 1.0, 0.17]] * len(motion.times), rtol=1e-12)
    ends = motion.corners_in_space()
    np.testing.assert_allclose(ends[..., 2].min(axis=-1), 0.0, rtol=0.0, atol=1e-9)
    assert np.ptp(ends[..., 1]) == pytest.approx(0.502)


def test_a_folder_without_a_run_is_refused(folder: pathlib.Path, tmp_path: pathlib.Path):
    with pytest.raises(InputError, match="warprock run -o DIR"):
        run_of_folder(tmp_path)
    (tmp_path / "run.json").write_text(json.dumps({"case": {}}))
    with pytest.raises(InputError, match=r"case\.name: got nothing"):
        run_of_folder(tmp_path)
    with pytest.raises(InputError, match="must be a lane from 0 to 17"):
        scene_motion(run_of_folder(folder), 18, 0.01)


def test_a_stack_that_falls_says_when_its_model_ends(tmp_path: pathlib.Path):
    # The amplitudes are not those that the case's check has answers for.
    change = ["motion.amplitude=6 mm, 60 mm", "run.duration=2 s"]
    run = run_case(load_case("stack-sine-pulse", change), "event")
    write_run(run, tmp_path)
    lane = int(np.flatnonzero(run.response["outcome"] == Outcome.OVERTURNED)[0])
    stood = int(np.flatnonzero(run.response["outcome"] == Outcome.AT_REST)[0])
    fell = scene_motion(run_of_folder(tmp_path), lane, 0.01)
    assert fell.end is not None
    assert 0.0 < fell.end < 2.0
    after, places = fell.times >= fell.end, fell.position - fell.base
    # Beside its base nothing moves from then on, and something did until then.
    assert np.all(places[:, after] == places[:, -1:])
    last = int(np.argmax(after)) - 1
    assert np.any(places[:, last] != places[:, -1])
    assert scene_motion(run_of_folder(tmp_path), stood, 0.01).end is None
