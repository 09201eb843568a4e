"""Figures of ties, walls and supports over time."""

from __future__ import annotations

import dataclasses
import pathlib

import numpy as np
import pytest

from warprock.case.load import load_case
from warprock.engines.held import inertia_of
from warprock.figures.restraints import SAMPLES, _Told, draw_restraints, told_lane
from warprock.model.hold import Ties
from warprock.model.tie_states import TieState
from warprock.running.case_run import CaseRun, run_case, run_lane
from warprock.running.lane_table import history_table
from warprock.running.scene_motion import sampled_by

PIER = """
title = "A pier between two ties"
source = "Made for a test."
block = {width = "0.5 m", height = "2.5 m", depth = "0.5 m", density = "2000 kg/m^3"}
contact.friction = 1.0
run = {duration = "4 s", sample_interval = "10 ms"}
# Of no size: kernels of pulses are those that other tests compile.
motion.waveform = "sine"
motion.control = "acceleration"
motion.amplitude = "1e-9 g"
motion.frequency = "1 Hz"
motion.cycles = 1

[[tie]]
height = "2.4 m"
side = "left"
stiffness = "50 N/mm"
prestress = "0.2 kN"
yield_force = "1 kN"

[[tie]]
height = "1.5 m"
side = "right"
stiffness = "20 N/mm"
slack = "10 mm"
ultimate_elongation = "30 mm"

[[sweep]]
start.rotation_ratio = [0.3, 0.5, -0.2]
"""
ISOLATED = """
title = "A statue on an isolator"
source = "Made for a test."
block = {width = "0.5 m", height = "2 m", depth = "0.5 m", density = "2000 kg/m^3"}
contact.friction = 1.0
support = {frequency = "0.5 Hz", damping = 0.1}
motion.waveform = "sine"
motion.control = "acceleration"
motion.amplitude = "0.3 g"
motion.frequency = "2 Hz"
motion.cycles = 1
run = {duration = "5 s", sample_interval = "20 ms"}
"""


def ran(folder: pathlib.Path, text: str) -> CaseRun:
    (folder / "case.toml").write_text(text, encoding="utf-8")
    return run_case(load_case(str(folder)), "housner")


@pytest.fixture(scope="module")
def pier(tmp_path_factory: pytest.TempPathFactory) -> CaseRun:
    return ran(tmp_path_factory.mktemp("pier"), PIER)


@pytest.fixture(scope="module")
def told(pier: CaseRun) -> _Told:
    interval = pier.case.sample_times.duration / SAMPLES
    fine = dataclasses.replace(pier, case=sampled_by(pier.case, interval))
    return _Told.of(pier, 1, run_lane(fine, 1))


def test_the_lane_that_is_told_turns_furthest(pier: CaseRun):
    assert told_lane(pier) == int(np.argmax(pier.response["peak_rotation"]))


def test_the_moment_is_what_turns_the_block(told: _Told):
    """On a still base inertia times angular acceleration is minus the moment that resists."""
    step = told.response.times[1]
    turn = told.rotation
    bend = (turn[2:] - 2.0 * turn[1:-1] + turn[:-2]) / step**2
    moment = told.moments()[1:-1]
    inertia = float(inertia_of(told.lanes)[0])
    # Away from impacts and from corners of ties, where a difference of three samples says nothing.
    even = np.abs(np.diff(told.moments(), 2)) < 1e-3 * np.abs(moment).max()
    away = (np.abs(turn[1:-1]) > 1e-3) & even
    assert away.mean() > 0.8
    np.testing.assert_allclose(inertia * bend[away], -moment[away], atol=2e-3 * moment.max())


def test_impacts_are_where_the_engine_counts_them(told: _Told):
    assert 3 <= len(told.impacts) <= told.response["impact_count"][0]
    near = np.searchsorted(told.response.times, told.impacts)
    step = np.abs(np.diff(told.rotation)).max()
    assert np.abs(told.rotation[near]).max() <= step


def test_ties_as_they_end_have_the_force_of_their_end(told: _Told):
    hold = told.lanes.hold
    assert hold is not None
    assert hold.ties is not None
    assert told.ties is not None
    assert told.ties.states[1, -1] == TieState.BROKEN
    worn = told.ties.worn(hold.ties)
    assert isinstance(worn, Ties)
    assert worn.count == 1
    assert worn.free_length[0, 0] > hold.ties.free_length[0, 0] + 0.01
    again = worn.stiffness[0, 0] * (told.elongation[0, -1] - worn.free_length[0, 0])
    assert max(again, 0.0) == pytest.approx(told.ties.force[0, -1], abs=1e-6)


def test_histories_tell_force_and_elongation_of_ties(pier: CaseRun):
    table = history_table(run_lane(pier, 1), 0, pier.lane_set, 1)
    # A tie that yields is at its yield force wherever a sample comes.
    assert table["tie_force_1_N"].max() == pytest.approx(1000.0, rel=1e-12)
    assert table["tie_force_1_N"].iloc[0] == pytest.approx(1000.0, rel=1e-12)
    broken = table["time_s"] >= pier.response["tie_break_time"][1]
    assert (table["tie_force_2_N"][broken] == 0.0).all()
    assert table["tie_elongation_2_m"].max() > 0.0
    assert table.attrs["columns"]["tie_force_1_N"]["unit"] == "N"


def test_a_figure_of_ties_says_what_they_did(pier: CaseRun):
    (drawing,) = draw_restraints(pier)
    assert drawing.title.startswith("The ties pull with up to 1 kN; 1 of 2 yields; the first break")
    labels = [axes.get_ylabel().replace("\n", " ") for axes in drawing.figure.axes]
    assert {"force [kN]", "elongation [mm]", "moment [kN m]"} <= set(labels)


def test_a_support_is_drawn_and_told_beside_the_ground(tmp_path: pathlib.Path):
    run = ran(tmp_path, ISOLATED)
    (drawing,) = draw_restraints(run)
    table = history_table(run_lane(run, 0), 0, run.lane_set, 0)
    way = (table["base_x_m"] - table["ground_x_m"]).abs().max()
    told = float(drawing.title.split("up to ")[1].split(" mm")[0])
    assert told == pytest.approx(1e3 * way, rel=1e-2)
    assert table["ground_acceleration_m_s2"].abs().max() == pytest.approx(0.3 * 9.80665, rel=1e-2)
