"""Tables that tilt, as bases that accelerate."""

import numpy as np
import pytest

import warprock as wr
from tests.shared.blocks import make_lanes
from warprock.model.base_path import base_places
from warprock.model.response import SampleTimes
from warprock.model.tilt import tilt_motions
from warprock.running.batch import run_batch
from warprock.units import GRAVITY


def test_the_base_accelerates_at_the_tangent_of_the_tilt_and_stays_where_it_is():
    rate, start, end = np.radians([2.0, -3.0, 2.0]), np.array([0.0, 1.0, 0.0]), np.full(3, 12.0)
    motions = tilt_motions(rate, start, end)
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
    motions = tilt_motions(rate, np.zeros(2), np.full(2, 20.0))
    found = run_batch("housner", lanes, motions, SampleTimes(20.0))
    assert found["uplift_time"] == pytest.approx(lanes.slenderness_angle / np.abs(rate), rel=1e-5)


CASE = {
    "block": {"width": "0.5 m", "height": "2 m", "depth": "1 m", "density": "2000 kg/m^3"},
    "contact": {"friction": 0.8},
    "motion": {"waveform": "tilt", "tilt_rate": "1 deg/s"},
    "run": {"duration": "20 s"},
}


@pytest.mark.parametrize(
    ("rate", "message"),
    [("5 deg/s", "must tilt by at most 75 deg"), ("0 deg/s", "must not be 0 deg/s")],
)
def test_what_no_table_does_is_refused(rate: str, message: str):
    tables = {**CASE, "motion": {"waveform": "tilt", "tilt_rate": rate}}
    with pytest.raises(wr.InputError, match=message):
        wr.expand_lanes(wr.Case.from_dict(tables))


def test_a_case_tilts():
    run = wr.run(wr.Case.from_dict(CASE), progress=False)
    assert run.table["outcome"].tolist() == ["overturned"]
    assert run.table["tilt_rate_deg_s"].tolist() == pytest.approx([1.0])
