"""Lanes run at finer steps until they are within the tolerance, those lanes only, or say so."""

from __future__ import annotations

import dataclasses
import functools
import json
import pathlib

import numpy as np
import pytest
from click.testing import CliRunner, Result

from tests.shared.blocks import Array, make_lanes, sines
from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import load_case
from warprock.cli.main import main
from warprock.engines.bodies import box_bodies
from warprock.errors import InputError
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions
from warprock.model.response import (
    ESTIMATE_FIELDS,
    LANE_FIELDS,
    Outcome,
    Response,
    SampleTimes,
    Status,
    take_lanes,
)
from warprock.running import tolerance
from warprock.running.batch import run_batch
from warprock.running.case_run import run_case, run_lane
from warprock.running.companions import companion_settings, cut_records, halve_step
from warprock.running.options import TOLERANCE, RunOptions
from warprock.running.refinement import MET, MISSED, SENSITIVE, missed_tolerance, refinement_counts
from warprock.running.tolerance import HALVINGS, run_to_tolerance
from warprock.settings.engines import EventSettings, ImpulseSettings

EVENT = EventSettings()
RUN = SampleTimes(5.0)

CABINET = """
title = "A cabinet under six records at ten scales"
source = "made up"
[block]
width = "0.6 m"
height = "2.0 m"
depth = "0.6 m"
density = "500 kg/m^3"
[contact]
friction = 0.4
angular_restitution = 0.876
[motion]
waveform = "record"
record = "ridgecrest-2019-ccc-090"
[run]
duration = "80 s"
sample_interval = "40 ms"
[[sweep]]
motion.record = [
  "ridgecrest-2019-ccc-090",
  "ridgecrest-2019-ccc-360",
  "ridgecrest-2019-clc-090",
  "ridgecrest-2019-clc-360",
  "ridgecrest-2019-tow2-090",
  "ridgecrest-2019-tow2-360",
]
[[sweep]]
motion.scale = { from = 0.5, to = 6, count = 10, spacing = "log" }
"""
SOME = "sweep=[{motion.scale=[0.7, 1.15, 1.5]}]"
"""Lanes under one record: one hardly lifts, one needs a finer step, one a finer one than that."""


RESTITUTION = "contact.angular_restitution=0.876"
"""Housner's, prescribed: such a box runs as a body, whose steps need refinement where it rocks."""


@pytest.fixture
def cabinet(tmp_path: pathlib.Path) -> pathlib.Path:
    file = tmp_path / "case.toml"
    file.write_text(CABINET, encoding="utf-8")
    return file


@functools.cache
def pulses() -> tuple[Lanes, GroundMotions]:
    """One cycle of a sine: strong enough to rock a block, three times; on the brink of a fall."""
    lanes = make_lanes([0.3, 0.3, 0.5, 0.3], [1.0, 1.5, 1.2, 1.0], 0.0, 10.0)
    low = 1.01 * rocking.uplift_acceleration(lanes.width, lanes.height)
    high = 10.0 * low
    frequency = np.array([1.5, 1.0, 1.2, 1.5])
    for _ in range(45):
        middle = 0.5 * (low + high)
        motions = sines(Control.ACCELERATION, middle, frequency, cycles=1.0)
        fell = run_batch("housner", lanes, motions, RUN)["outcome"] == Outcome.OVERTURNED
        low, high = np.where(fell, low, middle), np.where(fell, middle, high)
    amplitude = low * np.array([0.9, 0.95, 0.98, 1.0 + 1e-9])
    # As bodies, whose steps are of second order where they rock: boxes would need no refinement.
    lanes = dataclasses.replace(lanes, body=box_bodies(lanes))
    return lanes, sines(Control.ACCELERATION, amplitude, frequency, cycles=1.0)


def refined(wanted: float) -> Response:
    lanes, motions = pulses()
    return run_to_tolerance("event", lanes, motions, RUN, RunOptions(tolerance=wanted))


def at_step(step: float) -> EventSettings:
    """Settings with which `run_to_tolerance` came to a step."""
    settings: EventSettings = companion_settings(
        EVENT, round(np.log2(EVENT.time_step / step)), pulses()[0]
    )
    assert settings.time_step == step
    return settings


def errors(response: Response) -> Array:
    """|Difference of the peak from Housner's| / slenderness angle, which friction lets hold."""
    lanes, motions = pulses()
    boxes = dataclasses.replace(lanes, body=None)
    truth = run_batch("housner", boxes, motions, RUN)["peak_rotation"]
    return np.abs(response["peak_rotation"] - truth) / lanes.slenderness_angle


def test_lanes_that_need_it_run_at_finer_steps_and_the_others_do_not() -> None:
    lanes, motions = pulses()
    steps = {}
    for wanted in (3e-2, 2e-3):
        found = refined(wanted)
        ratio = found["rotation_error"] / lanes.slenderness_angle
        assert np.all(found["status"][:3] == Status.OK)
        assert np.all(ratio[:3] <= wanted)
        assert np.all(errors(found)[:3] <= ratio[:3])
        steps[wanted] = found["time_step"][:3]
        # Every lane's numbers are those of one run at its step, to the last bit.
        for lane, step in enumerate(steps[wanted]):
            own = run_batch(
                "event",
                lanes.take(np.array([lane])),
                motions.take(np.array([lane])),
                RUN,
                settings=at_step(float(step)),
            )
            for name in set(LANE_FIELDS) - {"step_count", "status"}:
                np.testing.assert_array_equal(own[name][0], found[name][lane], err_msg=name)
    assert np.all(steps[3e-2] == EVENT.time_step)
    assert np.all(steps[2e-3] < EVENT.time_step)
    assert np.all(steps[2e-3] >= EVENT.time_step / 2**HALVINGS)


def test_a_lane_on_the_brink_of_a_fall_is_sensitive_and_says_at_which_step() -> None:
    found = refined(TOLERANCE)
    assert found["status"].tolist() == [Status.OK] * 3 + [Status.SENSITIVE]
    assert found["time_step"][3] < found["time_step"][0] == EVENT.time_step
    lanes, _ = pulses()
    assert found["rotation_error"][3] > TOLERANCE * lanes.slenderness_angle[3]
    assert found["peak_rotation_error"][3] == found["rotation_error"][3]


def test_a_lane_that_converges_but_not_far_enough_keeps_its_status() -> None:
    found = refined(1e-7)
    lanes, motions = pulses()
    lane_set = _lane_set(lanes, motions)
    assert np.all(found["status"][:3] == Status.OK)
    assert missed_tolerance(found, lane_set, 1e-7).all()
    counts = refinement_counts(found, lane_set, EVENT, 1e-7)
    assert (counts[MET], counts[MISSED], counts[SENSITIVE]) == (0, 3, 1)


def _lane_set(lanes: Lanes, motions: GroundMotions) -> LaneSet:
    some = expand_lanes(load_case("free-b0"))
    return dataclasses.replace(some, lanes=lanes, motions=motions, step_factors=None)


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ["event", "impulse"])
def test_a_lane_does_not_depend_on_its_company(
    engine: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    lane_set = expand_lanes(_record_case())
    lanes, motions = lane_set.lanes, lane_set.motions
    times = SampleTimes({"event": 80.0, "impulse": 12.0}[engine])
    whole = run_to_tolerance(engine, lanes, motions, times, RunOptions(workers=2))
    order = np.array([2, 0, 3, 1])
    shuffled = run_to_tolerance(engine, lanes.take(order), motions.take(order), times)
    monkeypatch.setattr(tolerance, "CHUNK_VALUES", 1)
    seen: list[int] = []
    parts = run_to_tolerance(engine, lanes, motions, times, RunOptions(progress=seen.append))
    assert seen == [1, 2, 3, 4]
    for name in whole.fields:
        np.testing.assert_array_equal(whole[name], parts[name], err_msg=name)
        np.testing.assert_array_equal(whole[name][order], shuffled[name], err_msg=name)


def _record_case(scales: str = "[0.7, 1.15, 1.5, 3.0]") -> Case:
    base = load_case("record-ridgecrest", [f"sweep=[{{motion.scale={scales}}}]"])
    more = [
        "block.width=0.6 m",
        "block.height=2.0 m",
        "contact.friction=0.4",
        RESTITUTION,
        "check=[]",
    ]
    return load_case(base.name, [f"sweep=[{{motion.scale={scales}}}]", *more])


@pytest.mark.thorough
def test_a_companion_that_ends_at_rest_is_the_whole_run() -> None:
    case = _record_case()
    lane_set = expand_lanes(case)
    lanes, motions, times = lane_set.lanes, lane_set.motions, lane_set.times
    found = run_to_tolerance("event", lanes, motions, SampleTimes(times.duration))
    finer = np.flatnonzero(found["time_step"] < EVENT.time_step)
    assert len(finer) >= 2
    for lane in finer:
        step = at_step(float(found["time_step"][lane]))
        one = np.array([lane])
        whole = run_batch(
            "event",
            lanes.take(one),
            motions.take(one),
            SampleTimes(times.duration),
            settings=step,
        )
        for name in set(LANE_FIELDS) - {"step_count", "status"}:
            np.testing.assert_array_equal(whole[name][0], found[name][lane], err_msg=name)
        if found["outcome"][lane] == Outcome.AT_REST:
            assert found["step_count"][lane] < 0.6 * whole["step_count"][0]


def test_a_record_that_is_cut_off_is_the_same_until_then() -> None:
    motions = expand_lanes(_record_case("[1.0, 1.0, 2.0]")).motions
    cut = cut_records(motions, np.array([7.003, np.inf, 12.0]))
    times = np.linspace(0.0, 7.0, 1234)
    late = np.linspace(7.02, 90.0, 1000)
    for lane in range(3):
        same = motions.acceleration(times, lane)
        np.testing.assert_array_equal(cut.acceleration(times, lane), same)
    assert not np.any(cut.acceleration(late, 0))
    np.testing.assert_array_equal(cut.acceleration(late, 1), motions.acceleration(late, 1))
    assert not np.any(cut.acceleration(late[late > 12.02], 2))


@pytest.mark.thorough
def test_six_records_at_ten_scales_cost_less_than_three_runs(cabinet: pathlib.Path) -> None:
    run = run_case(load_case(cabinet), "event", histories=False)
    counts = refinement_counts(run.response, run.lane_set, run.settings, run.options.tolerance)
    # Measured: 1.9, with 20 of 60 lanes run again until they meet the tolerance.
    assert counts["total_step_count"] <= 3.0 * counts["first_step_count"]
    assert counts["refined"] >= 15
    # Lanes that never lift take one run.
    still = np.isnan(run.response["uplift_time"])
    assert np.any(still)
    np.testing.assert_array_equal(
        run.response["total_step_count"][still], run.response["first_step_count"][still]
    )
    # Without the refinement a third of the lanes are off, and say nothing.
    met = run.response["status"] == Status.OK
    chosen = np.flatnonzero(met & ~still & (run.response["outcome"] == Outcome.AT_REST))[::6]
    lanes, motions = run.lane_set.lanes.take(chosen), run.lane_set.motions.take(chosen)
    fine = run_batch(
        "event", lanes, motions, SampleTimes(36.0), settings=EventSettings(time_step=2e-4)
    )
    found = take_lanes(run.response, chosen)
    off = np.abs(found["peak_rotation"] - fine["peak_rotation"]) / lanes.slenderness_angle
    assert np.all(off <= TOLERANCE)
    np.testing.assert_array_equal(found["outcome"], fine["outcome"])


def test_the_slide_has_an_estimate_too() -> None:
    # A block too broad to rock slides under a pulse: no closed form is needed beside a fine step.
    lanes = make_lanes(np.full(4, 1.2), 1.0, 0.0, [0.2, 0.3, 0.4, 0.5])
    motions = sines(Control.ACCELERATION, np.full(4, 7.0), [1.0, 1.5, 2.0, 2.5], cycles=1.0)
    times = SampleTimes(2.0)
    fine = run_batch("impulse", lanes, motions, times, settings=halve_step(ImpulseSettings(), 5))
    found = run_to_tolerance("impulse", lanes, motions, times, settings=ImpulseSettings(240.0, 4))
    off = np.abs(found["peak_slide"] - fine["peak_slide"])
    assert np.all(fine["peak_slide"] > 1e-3)
    assert np.all(off > 0.0)
    assert np.all(off <= found["peak_slide_error"])
    assert np.all(found["peak_slide_error"] < 0.05 * fine["peak_slide"])


def test_engines_without_an_order_run_once() -> None:
    lanes, motions = pulses()
    found = run_to_tolerance("housner", lanes, motions, RUN)
    assert not set(ESTIMATE_FIELDS) & set(found.fields)
    with pytest.raises(ValueError, match="tolerance"):
        run_to_tolerance("housner", lanes, motions, RUN, RunOptions(tolerance=0.0))
    with pytest.raises(ValueError, match="halvings"):
        run_to_tolerance("housner", lanes, motions, RUN, halvings=0)
    with pytest.raises(InputError, match="--tolerance"):
        run_case(load_case("free-b0"), "event", RunOptions(tolerance=1.0))


@pytest.mark.thorough
def test_the_history_of_a_refined_lane_is_that_of_its_numbers() -> None:
    run = run_case(_record_case(), "event", histories=False)
    lane = int(np.argmin(run.response["time_step"]))
    assert run.response["time_step"][lane] < run.settings.time_step
    alone = run_lane(run, lane)
    assert alone["peak_rotation"][0] == run.response["peak_rotation"][lane]
    with_histories = run_case(_record_case(), "event", histories=True)
    np.testing.assert_array_equal(with_histories.response["rotation"][lane], alone["rotation"][0])


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.mark.thorough
def test_the_command_says_what_missed_the_tolerance_and_what_to_do(cabinet: pathlib.Path) -> None:
    some = ("-s", SOME, "-s", "run.duration=40 s", "-e", "event")
    shown = invoke("run", cabinet, *some, "--tolerance", 1e-5)
    assert shown.exit_code == 0, shown.output
    assert "-s engines.event.time_step=0.00125" in shown.stdout
    assert "times the steps of one run" in shown.stdout
    assert "--max-bad SHARE ends with exit code 4" in shown.stdout
    for share, code in ((0.1, 4), (1, 0)):
        options = ("--tolerance", 1e-5, "--max-bad", share, "--json")
        result = invoke("run", cabinet, *some, *options)
        assert result.exit_code == code, result.output
    found = json.loads(result.stdout)
    counts = found["refinement"]
    assert found["tolerance"] == 1e-5
    assert counts["met"] + counts["missed"] + counts["sensitive"] == 3
    assert {"time_step_s", "peak_slide_error_m"} <= set(found["rows"][0])
    bare = invoke("run", cabinet, *some, "--no-estimate")
    assert "not estimated" in bare.stdout
    for wrong in (("--tolerance", 1e-3, "--no-estimate"), ("--tolerance", 0), ("--max-bad", 2)):
        refused = invoke("run", cabinet, *some, *wrong)
        assert refused.exit_code == 2
        assert wrong[0] in refused.output


@pytest.mark.thorough
def test_a_sweep_counts_what_a_run_counts_and_its_plan_holds_the_tolerance(
    cabinet: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    some = ("-s", SOME, "-s", "run.duration=40 s", "-e", "event")
    counted = json.loads(invoke("run", cabinet, *some, "--tolerance", 1e-3, "--json").stdout)
    ids = []
    for name, options in (
        ("all", ("--chunk", 2, "--tolerance", 1e-3)),
        ("one", ("--chunk", 1, "--tolerance", 1e-3)),
        ("bare", ("--chunk", 2, "--no-estimate")),
    ):
        planned = invoke("sweep", "plan", cabinet, *some, *options, "-o", tmp_path / name, "--json")
        assert planned.exit_code == 0, planned.output
        ids.append(json.loads(planned.stdout)["plan"])
    assert ids[0] == ids[1] != ids[2]
    for name in ("all", "one"):
        ran = invoke("sweep", "run", tmp_path / name, "--workers", 1, "--json", "--max-bad", 0)
        found = json.loads(ran.stdout)
        assert found["refinement"] == counted["refinement"]
        assert (found["tolerance"], found["unusable"]) == (1e-3, 0)
        assert found["bad"] == found["refinement"]["missed"] + found["refinement"]["sensitive"]
        assert ran.exit_code == (4 if found["bad"] else 0)
        assert invoke("sweep", "merge", tmp_path / name).exit_code == 0
    tables = [(tmp_path / name / "lanes.parquet").read_bytes() for name in ("all", "one")]
    assert tables[0] == tables[1]
