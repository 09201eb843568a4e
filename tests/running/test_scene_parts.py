"""What holds a block, as pictures show it: it is where the engine had it."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pytest

from tests.shared.case_texts import pulse_text
from warprock.case.load import load_case
from warprock.figures.moving import frames
from warprock.model.tie_states import TieState, tie_elongations, tie_history
from warprock.report.scenes import scenes_of
from warprock.running.case_run import CaseRun, run_case
from warprock.running.scene_motion import SceneMotion, scene_motion
from warprock.running.scene_parts import Look, Part
from warprock.scenes.solids import solids

INTERVAL = 1e-3

TIES = """
[[tie]]
height = "0.9 m"
side = "left"
stiffness = "0.2 kN/mm"
slack = "1 mm"
yield_force = "300 N"
ultimate_elongation = "12 mm"
[[tie]]
height = "0.6 m"
side = "right"
stiffness = "0.1 kN/mm"
yield_force = "200 N"
acts = "both"
[top_load]
weight = "500 N"
thrust = "-20 N"
point = "stays"
"""
WALL = '[transverse_wall]\nside = "left"\nrebound = "plastic"\n'
FRAME = '[frame]\ncolumns = 9\nbeam_mass = "600 kg"\n'
SUPPORT = '[support]\nfrequency = "1 Hz"\ndamping = 0.1\n'


def held_run(folder: pathlib.Path, text: str, amplitude: str = "0.5 g") -> CaseRun:
    file = folder / "case.toml"
    file.write_text(pulse_text(amplitude=amplitude, duration="2 s") + text)
    return run_case(load_case(file), "housner", histories=False)


def of_look(motion: SceneMotion, look: Look) -> list[Part]:
    return [part for part in motion.parts if part.look is look]


@pytest.fixture(scope="module")
def tied(tmp_path_factory: pytest.TempPathFactory) -> tuple[CaseRun, SceneMotion]:
    run = held_run(tmp_path_factory.mktemp("tied"), TIES + WALL, "0.8 g")
    return run, scene_motion(run, 0, INTERVAL)


def test_ties_do_what_the_engine_had_them_do(tied: tuple[CaseRun, SceneMotion]):
    run, motion = tied
    first, second = of_look(motion, Look.TIE)
    ends = motion.places_of(first)
    # Its end at the block has moved from the far end, which goes with the base.
    stretch = ends[:, 0, 0] - ends[:, 1, 0] - (ends[0, 0, 0] - ends[0, 1, 0])
    hold = run.lane_set.lanes.hold
    assert hold is not None
    assert hold.ties is not None
    turn = 2.0 * np.arctan2(motion.attitude[0, :, 1], motion.attitude[0, :, 3])
    place = (motion.position[0] - motion.base)[:, [0, 2]]
    both = tie_elongations(hold.ties, 0.2, 1.0, np.stack([*place.T, turn]))
    np.testing.assert_allclose(both[0], stretch, rtol=0.0, atol=1e-12)
    # Between samples it moves by its rate times their interval at most.
    near = np.abs(np.diff(both)).max()
    assert both.max() == pytest.approx(run.response["peak_tie_elongation"][0], abs=near)
    assert first.states is not None
    assert second.states is not None
    gone = motion.times[np.argmax(first.states == TieState.BROKEN)]
    assert gone == pytest.approx(run.response["tie_break_time"][0], abs=INTERVAL)
    assert {TieState.SLACK, TieState.YIELDING} <= set(first.states.tolist())
    # The other acts both ways: it is never slack, and yields with 2 mm.
    assert set(second.states.tolist()) == {TieState.TAUT, TieState.YIELDING}


def test_a_break_between_samples_is_of_the_tie_nearest_to_it(tied: tuple[CaseRun, SceneMotion]):
    hold = tied[0].lane_set.lanes.hold
    assert hold is not None
    assert hold.ties is not None
    stretch = np.array([[0.0, 0.0129, 0.0129, 0.0], [0.0, -0.01, -0.01, 0.0]])
    times = np.arange(4.0)
    assert not np.any(tie_history(hold.ties, stretch, times, np.nan).states == TieState.BROKEN)
    states = tie_history(hold.ties, stretch, times, 1.5).states
    np.testing.assert_array_equal(states[0, 2:], TieState.BROKEN)
    assert not np.any(states[1] == TieState.BROKEN)


def test_a_weight_that_stays_keeps_its_place_on_the_base(tied: tuple[CaseRun, SceneMotion]):
    motion = tied[1]
    weight, thrust = of_look(motion, Look.LOAD)
    head = motion.places_of(weight)[:, 1] - motion.base[:, [0, 2]]
    on_top = np.abs(motion.ratio[0]) < 0.4
    np.testing.assert_allclose(head[on_top, 0], 0.0, rtol=0.0, atol=1e-12)
    tail, head = np.moveaxis(motion.places_of(thrust), 1, 0)
    assert np.all(head[:, 0] < tail[:, 0])


def test_the_base_and_the_picture_hold_all_parts(tied: tuple[CaseRun, SceneMotion]):
    motion = tied[1]
    low, high = motion.span
    for part in (*of_look(motion, Look.WALL), *of_look(motion, Look.ANCHOR)):
        assert low < part.points[:, 0].min()
        assert part.points[:, 0].max() < high
    (picture,) = frames(motion, [0])
    white = np.all(picture[70:420] == 255, axis=-1)
    # Nothing reaches the sides of the scene, its ground alone goes that far.
    assert white[:-40, :40].all()
    assert white[:-40, -20:].all()


def test_a_beam_lies_on_the_higher_corners_of_its_columns(tmp_path: pathlib.Path):
    motion = scene_motion(held_run(tmp_path, FRAME), 0, 0.01)
    assert np.abs(motion.ratio).max() > 0.1
    (beam,) = of_look(motion, Look.BEAM)
    columns = of_look(motion, Look.COLUMN)
    assert len(columns) == 5
    under = motion.places_of(beam)[:, 0, 1]
    for corners in (*map(motion.places_of, columns), motion.corners()[0]):
        np.testing.assert_allclose(corners[..., 1].max(axis=1), under, rtol=0.0, atol=1e-12)
    # It goes along with the corner that it lies on, and does not slip on it.
    moved = motion.places_of(beam)[:, 0, 0] - motion.base[:, 0]
    right = motion.corners()[0, :, 2, 0] - motion.base[:, 0]
    left = motion.ratio[0] < 0.0
    np.testing.assert_allclose(np.ptp((moved - right)[left]), 0.0, rtol=0.0, atol=1e-12)


def test_the_ground_below_a_support_moves_by_itself(tmp_path: pathlib.Path):
    run = held_run(tmp_path, SUPPORT)
    motion = scene_motion(run, 0, 0.01)
    assert motion.ground is not None
    # The ground follows one cycle of a sine of acceleration, and keeps the velocity left.
    w, a = 4.0 * np.pi, 0.5 * 9.81
    inside = motion.times <= 0.5
    sine = a / w**2 * (w * motion.times - np.sin(w * motion.times))
    shown = motion.ground[:, 0]
    np.testing.assert_allclose(np.abs(shown[inside]), sine[inside], rtol=0.0, atol=1e-9)
    assert np.abs(shown - motion.base[:, 0]).max() > 0.05
    (below,) = (each for each in solids(motion, 0.1) if each.name == "ground")
    np.testing.assert_array_equal(below.places[:, 0], shown)
    (picture,) = frames(motion, [motion.largest])
    assert picture.shape[2] == 3
    lane = scenes_of(run)["lanes"][0]
    np.testing.assert_allclose(np.array(lane["ground"]["x"]) * lane["length"], shown, atol=1e-4)


def test_a_page_is_told_what_holds_a_block(tied: tuple[CaseRun, SceneMotion]):
    run, motion = tied
    lane = json.loads(json.dumps(scenes_of(run)))["lanes"][0]
    looks = [part["look"] for part in lane["parts"]]
    assert looks == [part.look.value for part in motion.parts]
    (changes,) = [part["states"] for part in lane["parts"] if part["look"] == "tie"][:1]
    assert changes[0][0] == 0
    assert changes[-1][1] == "broken"
    broke = changes[-1][0] * lane["dt"]
    assert broke == pytest.approx(run.response["tie_break_time"][0], abs=lane["dt"])


def test_solids_stand_where_parts_are(tied: tuple[CaseRun, SceneMotion]):
    motion = tied[1]
    found = {each.name: each for each in solids(motion, 0.05)}
    (wall,) = of_look(motion, Look.WALL)
    middle = motion.places_of(wall).mean(axis=1)
    np.testing.assert_allclose(found["wall 1"].places[:, [0, 2]], middle)
    np.testing.assert_allclose(found["wall 1"].sizes[0, [0, 2]], [0.2, 1.0])
    assert found["wall 1"].rigid
    tie = found["tie 1"]
    assert not tie.rigid
    ends = np.stack(tie.ends(400))[:, [0, 2]]
    np.testing.assert_allclose(ends, motion.places_of(of_look(motion, Look.TIE)[0])[400])
