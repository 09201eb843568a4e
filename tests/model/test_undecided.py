"""Runs that end before their ground motions do, and lanes that they leave undecided."""

from __future__ import annotations

import json
import pathlib
from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest

from tests.shared.blocks import make_lanes, sines
from tests.shared.case_texts import FREE, PULSE
from tests.shared.commands import succeed
from tests.shared.spatial_blocks import along, in_space
from warprock.analysis.overturning import Mode, run_grid
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.model.motion import Control, StillBase
from warprock.model.response import Outcome, SampleTimes
from warprock.model.rocking import frequency_parameter
from warprock.model.undecided import (
    SWUNG,
    cut_short,
    cut_text,
    undecided,
)
from warprock.running.batch import run_batch

Write = Callable[[str], pathlib.Path]

RECORD = (
    FREE.replace('"0.5 m"', '"0.17 m"')
    + """
[motion]
waveform = "record"
record = "ridgecrest-2019-ccc-090"
scale = 1.0
"""
)

MAP = """
[[sweep]]
motion.amplitude = ["20 mm", "60 mm", "300 mm", "900 mm"]
[[sweep]]
motion.frequency = ["1 Hz", "2 Hz"]
"""


def flat(text: str) -> str:
    """A text whose lines are not wrapped."""
    return " ".join(text.split())


def test_a_motion_ends_with_its_last_sample_or_with_its_pulse(write: Write):
    record = expand_lanes(load_case(write(RECORD), ["motion.start='2 s'"])).motions
    # The header of the record says 100 samples a second and 70 s.
    assert record.end[0] == pytest.approx(72.0, abs=1e-9)
    assert record.scaled(np.zeros(1)).end[0] == 0.0
    pulse = sines(Control.DISPLACEMENT, [0.01, 0.02, 0.0], [2.0, 4.0, 1.0], 1.5, start=0.25)
    np.testing.assert_allclose(pulse.end, [1.0, 0.625, 0.0], rtol=1e-14)
    later = sines(Control.DISPLACEMENT, [0.0, 0.01, 0.0], [1.0, 1.0, 1.0], 2.0)
    np.testing.assert_allclose(along(pulse, later).end, [1.0, 2.0, 0.0], rtol=1e-14)
    np.testing.assert_array_equal(StillBase(2).end, [0.0, 0.0])
    np.testing.assert_array_equal(cut_short(pulse, 0.625), [True, False, False])
    assert cut_text(pulse, 1.0) == ""
    assert "1 of 3 lanes (1 s)" in cut_text(pulse, 0.8)


def test_a_rocking_block_is_undecided_until_it_has_swung_back():
    # Slender blocks let go at the point of balance but for a part e fall or swing back after some
    # ln(2 / e) / p: those that still rock after 30 / p do not fall any more.
    part = 1.0 - np.array([1e-2, 1e-4, 1e-6])
    lanes, motions = make_lanes(0.2, 1.0, part), StillBase(3)
    lanes.angular_restitution[:] = 0.999
    end = SWUNG / frequency_parameter(0.2, 1.0)
    for duration, open_end in ((0.99 * end, True), (1.01 * end, False)):
        response = run_batch("housner", lanes, motions, SampleTimes(float(duration)))
        assert np.all(response["outcome"] == Outcome.ROCKING)
        found = undecided(response, lanes, motions, float(duration), springs=False)
        np.testing.assert_array_equal(found, open_end)
        # Rolling on a corner or in a stack nothing bounds how long a fall may wait.
        assert undecided(response, in_space(lanes), motions, float(duration), springs=False).all()
    long = run_batch("housner", lanes, motions, SampleTimes(20.0 * float(end)))
    assert np.all(long["outcome"] != Outcome.OVERTURNED)


def test_a_block_at_rest_stays_where_the_rest_of_its_record_cannot_lift_it(write: Write):
    scales = ", ".join(f"{scale:g}" for scale in np.geomspace(0.05, 2.0, 24))
    swept = RECORD + f"[[sweep]]\nmotion.scale = [{scales}]\n"
    short = expand_lanes(
        load_case(write(swept.replace("scale = 1.0\n", "")), ["run.duration='12 s'"])
    )
    lanes, motions = short.lanes, short.motions
    found = run_batch("housner", lanes, motions, SampleTimes(12.0))
    at_rest = found["outcome"] == Outcome.AT_REST
    open_end = undecided(found, lanes, motions, 12.0, springs=False)
    lifts = motions.later_acceleration(12.0) >= 9.81 * lanes.width / lanes.height
    np.testing.assert_array_equal(open_end[at_rest], lifts[at_rest])
    # Both kinds are there, and the whole record leaves those that are decided where they stood.
    assert (at_rest & open_end).any()
    assert (at_rest & ~open_end).any()
    whole = run_batch("housner", lanes, motions, SampleTimes(75.0))
    decided = at_rest & ~open_end
    np.testing.assert_array_equal(whole["outcome"][decided], Outcome.AT_REST)
    same = whole["peak_rotation"][decided] == found["peak_rotation"][decided]
    assert same.all()
    # Springs let a block lift below that, and a later step may throw it.
    assert undecided(found, lanes, motions, 12.0, springs=True)[at_rest].all()
    motions.velocity_step_stop[:] = 0.1
    assert undecided(found, lanes, motions, 12.0, springs=False)[at_rest].all()


def test_a_run_that_cuts_its_motion_says_so(write: Write, tmp_path: pathlib.Path, unrendered: None):
    file, short = write(RECORD), "run.duration=3 s"
    said = "the run ends at 3 s, before the ground motion of 1 of 1 lane (70 s)"
    run = succeed("run", file, "-e", "housner", "-s", short, "--no-estimate", "-o", tmp_path / "o")
    assert said in flat(run.output)
    assert said in flat(succeed("explain", file, "-s", short).output)
    table = pd.read_parquet(tmp_path / "o" / "lanes.parquet")
    assert table["undecided"].tolist() == [True]
    facts = json.loads((tmp_path / "o" / "run.json").read_text(encoding="utf-8"))
    assert (facts["undecided"], facts["motion_cut_short"]) == (1, 1)
    fits = succeed("fragility", tmp_path / "o", "--limit", "overturning", "--max-doubt", 1)
    assert "Undecided: 1 of 1 lane" in flat(fits.output)
    whole = succeed("run", file, "-e", "housner", "-s", "run.duration=75 s", "--json")
    found = json.loads(whole.output)
    assert (found["undecided"], found["motion_cut_short"]) == (0, 0)
    ladder = ("--from", "0.1", "--to", "0.2", "--count", "2")
    capacities = succeed("ida", file, "-e", "housner", "-s", short, *ladder)
    assert "Undecided: 2 runs" in flat(capacities.output)


def test_a_map_has_no_safe_lanes_before_its_pulses_are_over(write: Write):
    file = write(PULSE.replace('"8 mm"', '"8 mm" # swept') + MAP)
    modes = {}
    for duration in ("1 ms", "0.4 s", "20 s"):
        found = run_grid(load_case(file, [f"run.duration={duration}"]), "housner")
        modes[duration] = found.lane_mode
    assert np.all(modes["1 ms"] == Mode.UNDECIDED)
    assert np.all(modes["0.4 s"] != Mode.SAFE)
    assert set(modes["20 s"]) >= {Mode.SAFE, Mode.WITH_IMPACT}
    assert not np.any(modes["20 s"] == Mode.UNDECIDED)
    said = succeed("map", file, "-e", "housner", "-s", "run.duration=1 ms").output
    assert "8 pulses of the grid 8 are undecided" in flat(said)
    assert "safe" not in said.partition("grid of")[2].partition("next:")[0]
