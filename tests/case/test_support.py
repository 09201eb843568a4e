"""A floor or an isolator between the ground motion and the block, for every engine."""

import dataclasses

import numpy as np
import pytest

import warprock as wr
from tests.shared.case_texts import FREE, PULSE, refusal
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.model.base_path import base_places
from warprock.model.motion import RecordMotions
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings

SUPPORTED = (
    PULSE.replace('"displacement"', '"acceleration"').replace('"8 mm"', '"0.6 g"')
    + """
[support]
frequency = "4 Hz"
damping = 0.05
"""
)


def test_a_support_hands_its_motion_on(write):
    lane_set = expand_lanes(load_case(write(SUPPORTED), ["support.frequency=4 Hz, 0.2 Hz"]))
    motions = lane_set.motions
    assert isinstance(motions, RecordMotions)
    row = lane_set.inputs
    assert row["support_frequency_hz"].tolist() == [4.0, 0.2]
    # A floor near the frequency of the pulse, 3 Hz, makes it stronger; an isolator weaker.
    stronger = row["support_peak_acceleration_m_s2"] / row["peak_acceleration_m_s2"]
    assert stronger[0] > 1.5
    assert stronger[1] < 0.2
    # An isolator far below the frequency of the ground stays where it is: the ground goes from
    # under it. A floor goes with the ground.
    way, ground = (
        row["support_peak_displacement_m"],
        np.ptp(base_places(lane_set.ground, 0, np.linspace(0.0, 2.0, 500))[:, 0]),
    )
    assert 0.8 * ground < way[1] < 1.2 * ground
    assert way[0] < way[1]
    # Peaks and groups of the ground remain those of the ground.
    np.testing.assert_allclose(row["peak_acceleration_m_s2"], 0.6 * 9.81)
    assert np.ptp(base_places(motions, 0, np.linspace(0.0, 2.0, 50))[:, 0]) > 0.0
    # The run does not end before the motion does.
    assert (motions.end <= 5.0 * (1.0 + 1e-9)).all()


def test_engines_follow_a_support_alike(write):
    lane_set = expand_lanes(load_case(write(SUPPORTED), ["block.width=0.3 m"]))
    times = dataclasses.replace(lane_set.times, duration=2.0)
    found = run_batch("housner", lane_set.lanes, lane_set.motions, times)
    other = run_batch(
        "event", lane_set.lanes, lane_set.motions, times, settings=EventSettings(time_step=1e-3)
    )
    assert found["peak_rotation"][0] > 0.0
    # `event` follows a block that rocks to order 5.
    np.testing.assert_allclose(other["peak_rotation"], found["peak_rotation"], rtol=1e-4)


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("support.frequency=0 Hz", "support.frequency: got '0 Hz', must be at least 1e-2 Hz"),
        ("support.damping=1", "support.damping: got 1, must be at least 0 and at most 0.99"),
        ("motion.control=velocity", None),
    ],
)
def test_what_does_not_fit_is_refused_in_one_line(write, override, said):
    if said is not None:
        assert said in str(refusal(write(SUPPORTED), override))
        return
    overrides = [override, "motion.amplitude=0.1 m/s", "motion.cycles=0.75"]
    expand_lanes(load_case(write(SUPPORTED), overrides))
    with pytest.raises(wr.InputError, match="must be 1 where the velocity of the ground steps"):
        expand_lanes(load_case(write(SUPPORTED), [*overrides, "support.height_factor=1.2"]))


def test_a_support_needs_a_motion_along_x(write):
    still = FREE + SUPPORTED[SUPPORTED.index("[support]") :]
    with pytest.raises(wr.InputError, match=r"must be given: \[support\] stands on a ground"):
        expand_lanes(load_case(write(still)))


MOTION = SUPPORTED[SUPPORTED.index("[motion]") : SUPPORTED.index("[support]")]


def test_a_support_is_rigid_upwards(write):
    text = SUPPORTED + MOTION.replace("[motion]", "[motion.z]")
    lane_set = expand_lanes(load_case(write(text)))
    assert lane_set.ground is not None
    times = np.linspace(0.0, 3.0, 200)
    below, above = (base_places(m, 0, times) for m in (lane_set.ground, lane_set.motions))
    assert np.abs(above - below)[:, 0].max() > 1e-2
    # The ground's sine at 100 samples a period: its double integral errs by 1e-3 of it.
    np.testing.assert_allclose(above[:, 2], below[:, 2], atol=2e-3 * np.ptp(below[:, 2]), rtol=0.0)
    assert "support_peak_acceleration_m_s2_z" not in lane_set.inputs
    stops = ["motion.z.control=velocity", "motion.z.amplitude=0.1 m/s", "motion.z.cycles=0.75"]
    with pytest.raises(wr.InputError, match=r"motion\.z\.waveform: .* must end at rest below"):
        expand_lanes(load_case(write(text), stops))


def test_a_support_acts_across_as_along(write):
    text = SUPPORTED + MOTION.replace("[motion]", "[motion.y]")
    times, found = np.linspace(0.0, 3.0, 200), []
    for still in ("motion", "motion.y"):
        lane_set = expand_lanes(load_case(write(text), [f"{still}.amplitude=0 g"]))
        peak = "support_peak_acceleration_m_s2" + ("_y" if still == "motion" else "")
        assert lane_set.inputs[peak][0] > 0.6 * 9.81
        found.append(base_places(lane_set.motions, 0, times))
    across, along = found
    assert np.ptp(along[:, 0]) > 0.01
    np.testing.assert_array_equal(across[:, [1, 0, 2]], along)
