"""Tables that tilt, as bases that accelerate."""

import numpy as np
import pytest

import warprock as wr
from tests.shared.blocks import make_lanes
from warprock.model.base_path import base_places
from warprock.model.response import SampleTimes
from warprock.model.tilt import Tilting, steady, tilt_motions
from warprock.running.batch import run_batch
from warprock.units import GRAVITY


def test_the_base_accelerates_at_the_tangent_of_the_tilt_and_stays_where_it_is():
    rate, start, end = np.radians([2.0, -3.0, 2.0]), np.array([0.0, 1.0, 0.0]), np.full(3, 12.0)
    motions = tilt_motions(steady(rate, start), end)
    times = np.array([0.5, 3.21, 11.9])
    for lane in range(3):
        wanted = -GRAVITY * np.tan(rate[lane] * np.maximum(times - start[lane], 0.0))
        # Linear between samples a twentieth of a degree apart.
        assert motions.acceleration(times, lane) == pytest.approx(wanted, abs=1e-5)
        assert not base_places(motions, lane, times).any()
    assert motions.end.tolist() == [12.0] * 3


def test_a_block_lifts_at_its_slenderness_angle():
    """Of any engine; of `housner` at the time at which the table is as steep, to 1e-6 s."""
    lanes = make_lanes([0.5, 0.5], [2.0, 1.0], friction=10.0)
    rate = np.radians([2.0, -2.0])
    motions = tilt_motions(steady(rate, np.zeros(2)), np.full(2, 20.0))
    found = run_batch("housner", lanes, motions, SampleTimes(20.0))
    assert found["uplift_time"] == pytest.approx(lanes.slenderness_angle / np.abs(rate), rel=1e-5)


def test_a_table_pauses_and_stays():
    """2 deg/s, 5 s of pause after every degree, up to 2.5 deg; a second one without pauses."""
    never = np.inf
    tilting = Tilting(
        np.radians([2.0, -2.0]),
        np.array([1.0, 0.0]),
        np.radians([1.0, 75.0]),
        np.array([5.0, 0.0]),
        np.radians([2.5, never]),
    )
    times = np.array([0.9, 1.25, 1.5, 4.0, 6.4, 6.75, 7.0, 12.25, 20.0])
    wanted = [0.0, 0.5, 1.0, 1.0, 1.0, 1.5, 2.0, 2.5, 2.5]
    assert np.degrees(tilting.angle(times[:, None]))[:, 0] == pytest.approx(wanted, abs=1e-9)
    motions = tilt_motions(tilting, np.full(2, 20.0))
    # A pause begins and ends within a sample of a twentieth of a degree.
    felt = np.degrees(np.arctan(-motions.acceleration(times, 0) / GRAVITY))
    assert felt == pytest.approx(wanted, abs=0.05)
    back = motions.acceleration(np.array([12.25]), 1)
    assert back == pytest.approx(GRAVITY * np.tan(np.radians(24.5)), rel=1e-5)


CASE = {
    "block": {"width": "0.5 m", "height": "2 m", "depth": "1 m", "density": "2000 kg/m^3"},
    "contact": {"friction": 0.8},
    "motion": {"waveform": "tilt", "tilt_rate": "1 deg/s"},
    "run": {"duration": "20 s"},
}


@pytest.mark.parametrize(
    ("rate", "message"),
    [("5 deg/s", "got 5 deg/s, must tilt by at most 75 deg"), ("0 deg/s", "must not be 0 deg/s")],
)
def test_what_no_table_does_is_refused(rate: str, message: str):
    tables = {**CASE, "motion": {"waveform": "tilt", "tilt_rate": rate}}
    with pytest.raises(wr.InputError, match=message):
        wr.expand_lanes(wr.Case.from_dict(tables))


def test_a_block_stands_in_a_pause_and_falls_after_it():
    """Its slenderness angle is 14.04 deg: at 14 deg it stands for 10 s, at 15 deg no more."""
    motion = {"waveform": "tilt", "tilt_rate": "7 deg/s", "tilt_step": "14 deg", "pause": "10 s"}
    tables = {**CASE, "motion": motion, "sweep": [{"motion.tilt_to": ["14 deg", "15 deg"]}]}
    run = wr.run(wr.Case.from_dict(tables), progress=False)
    assert run.table["outcome"].tolist() == ["at_rest", "overturned"]
    assert run.table["tilt_to_deg"].tolist() == [14.0, 15.0]
    assert run.table["uplift_time_s"][1] == pytest.approx(12.0, abs=0.01)
    alone = {**tables, "motion": {**motion, "tilt_step": None}}
    del alone["motion"]["tilt_step"]
    with pytest.raises(wr.InputError, match=r"motion\.tilt_step: got nothing, must be the angle"):
        wr.Case.from_dict(alone)


def test_a_case_tilts():
    run = wr.run(wr.Case.from_dict(CASE), progress=False)
    assert run.table["outcome"].tolist() == ["overturned"]
    assert run.table["tilt_rate_deg_s"].tolist() == pytest.approx([1.0])
