"""Estimated errors against the truth: above it, near it, and frank where numbers mean little."""

from __future__ import annotations

import dataclasses
import functools
import json
import pathlib
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from tests.shared.blocks import Array, free_lanes, make_lanes, sines
from tests.shared.marks import first
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.cli.main import main
from warprock.engines import ENGINES, engine_class
from warprock.engines.bodies import box_bodies
from warprock.findings.numbers import three
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, StillBase
from warprock.model.response import (
    ERROR_FIELDS,
    ESTIMATE_FIELDS,
    SOUND,
    Outcome,
    Response,
    SampleTimes,
    Status,
)
from warprock.running import companions, tolerance
from warprock.running.batch import run_batch
from warprock.running.case_run import run_case
from warprock.running.lane_table import lane_table
from warprock.running.options import RunOptions
from warprock.running.provenance import error_summary
from warprock.running.tolerance import run_to_tolerance
from warprock.settings.engines import EventSettings, ImpulseSettings
from warprock.units import GRAVITY

FRICTION = 10.0
"""So high that no block slides, where Housner's solution is the true one."""

Problem = tuple[Lanes, GroundMotions, float]
"""Lanes, their motions and the length of the run [s]."""


def shipped(name: str, duration: float) -> Problem:
    """The lanes of a shipped case, under the friction that Housner's block needs."""
    lane_set = expand_lanes(load_case(name))
    lanes = lane_set.lanes
    high = np.full_like(lanes.friction, FRICTION)
    return dataclasses.replace(lanes, friction=high), lane_set.motions, duration


def pulses() -> Problem:
    """Those of Table 6 that Housner's block can follow.

    In lane 1 the pivot would have to pull the block down at the end velocity step. There it slides
    and parts from Housner at any step, which no estimate of the step's error can tell.
    """
    lanes, motions, duration = shipped("single-sine-pulse", 10.0)
    kept = np.flatnonzero(np.arange(lanes.lane_count) != 1)
    return lanes.take(kept), motions.take(kept), duration


def random_blocks(count: int, rng: np.random.Generator, rotation_ratio: Any = 0.0) -> Lanes:
    """Blocks 0.3 to 4 m high and 0.1 to 0.45 times as wide."""
    height = rng.uniform(0.3, 4.0, count)
    return make_lanes(height * rng.uniform(0.1, 0.45, count), height, rotation_ratio, FRICTION)


def bursts(count: int = 128) -> Problem:
    """One to five cycles of a sine at 1.05 to 4 times the acceleration that lifts the block."""
    rng = np.random.default_rng(1)
    lanes = random_blocks(count, rng)
    amplitude = GRAVITY * np.tan(lanes.slenderness_angle) * rng.uniform(1.05, 4.0, count)
    frequency, cycles = rng.uniform(0.5, 5.0, count), rng.integers(1, 6, count)
    motions = sines(Control.ACCELERATION, amplitude, frequency, cycles=cycles)
    return lanes, motions, 10.0


def shaken(count: int = 64) -> Problem:
    """The shipped record, its peak 1.05 to 4 times the acceleration that lifts the block."""
    rng = np.random.default_rng(2)
    lanes = random_blocks(count, rng)
    motions = shipped("record-ridgecrest", 40.0)[1].take(np.zeros(count, dtype=np.intp))
    peak = np.abs(motions.pool_acceleration).max()
    ratio = rng.uniform(1.05, 4.0, count)
    scale = GRAVITY * np.tan(lanes.slenderness_angle) / peak * ratio
    return lanes, dataclasses.replace(motions, scale=scale), 40.0


def released(count: int = 96) -> Problem:
    """Blocks let go from 0.05 to 0.99 of their slenderness angles."""
    rng = np.random.default_rng(3)
    ratio = rng.uniform(0.05, 0.99, count)
    return random_blocks(count, rng, ratio), StillBase(count), 10.0


PROBLEMS = {
    "free B1 to B3": lambda: (dataclasses.replace(free_lanes(), friction=np.full(9, FRICTION)),
                              StillBase(9), 10.0),
    "free B0": lambda: shipped("free-b0", 20.0),
    "pulses of Table 6": pulses,
    "bursts": bursts,
    "record": shaken,
    "released": released,
}  # fmt: skip
SETTINGS: dict[str, tuple[str, Any]] = {
    "event 1e-2": ("event", EventSettings(time_step=1e-2)),
    "event 5e-3": ("event", EventSettings(time_step=5e-3)),
    "impulse": ("impulse", ImpulseSettings()),
}


@dataclasses.dataclass(frozen=True)
class Judged:
    """A response with estimates beside the true errors, shape [lane] each."""

    response: Response
    error: Array
    peak_error: Array
    fell: Array
    truly_fell: Array
    alpha: Array

    @property
    def ok(self) -> Array:
        """Lanes whose estimate holds; some slide as they fall at this friction: AMBIGUOUS."""
        return np.isin(self.response["status"], SOUND)

    @property
    def plain(self) -> Array:
        """Lanes that are `ok` and stand: what the factor of safety is chosen for."""
        return self.ok & ~self.fell

    def coverage(self, name: str) -> float:
        true = {"rotation_error": self.error, "peak_rotation_error": self.peak_error}[name]
        return float(np.mean((true <= self.response[name])[self.plain]))

    @property
    def excess(self) -> float:
        """Median of estimate / true error."""
        return float(np.median((self.response["rotation_error"] / self.error)[self.plain]))


def second_order(engine: str, lanes: Lanes) -> Lanes:
    """Lanes whose errors are of the order that an engine declares: of `event` boxes as bodies.

    As boxes they rock with the fifth order, and their errors are the swings that resting leaves
    out: too small to judge an estimate by.
    """
    return dataclasses.replace(lanes, body=box_bodies(lanes)) if engine == "event" else lanes


@functools.cache
def judged(problem: str, engine: str) -> Judged:
    """Estimates of an engine held against Housner's solution."""
    name, settings = SETTINGS[engine]
    lanes, motions, duration = PROBLEMS[problem]()
    times = SampleTimes(duration, duration / 2.0**13)
    truth = run_batch("housner", lanes, motions, times)
    same = second_order(name, lanes)
    found = run_to_tolerance(name, same, motions, times, settings=settings)
    return Judged(
        response=found,
        error=np.abs(found["rotation"] - truth["rotation"]).max(axis=1),
        peak_error=np.abs(found["peak_rotation"] - truth["peak_rotation"]),
        fell=found["outcome"] == Outcome.OVERTURNED,
        truly_fell=truth["outcome"] == Outcome.OVERTURNED,
        alpha=lanes.slenderness_angle,
    )


RARELY = {
    "event": ("free B1 to B3", "free B0", "released"),
    "impulse": ("bursts", "released", "pulses of Table 6"),
}
"""Problems that only the thorough run judges: bodies on a still base ask `event` for a kernel of
their own, and many lanes `impulse` for many fine steps."""

JUDGED = [
    pytest.param(
        problem,
        engine,
        marks=pytest.mark.thorough
        if engine == "event 1e-2" or problem in RARELY[SETTINGS[engine][0]]
        else (),
    )
    for problem in PROBLEMS
    for engine in SETTINGS
    if (problem, engine) != ("record", "impulse")
]
"""Problems and engines; a second step of `event` is for the thorough run."""


@pytest.mark.parametrize(("problem", "engine"), [p for p in JUDGED if p.values[0] != "record"])
def test_true_errors_lie_below_their_estimates_and_near_them(problem: str, engine: str) -> None:
    found = judged(problem, engine)
    # Measured: 98.9 % of lanes or more, and in the few of a table all. A history's largest error is
    # harder to meet by chance than that of a peak, of which two may lie close to one another.
    assert found.coverage("rotation_error") >= 0.97
    # Of the peaks of `impulse` in bursts 86 of 92.
    assert found.coverage("peak_rotation_error") >= 0.93
    # Of `event` the factor of the table, 1.56, and up to a quarter more: the longer of two steps is
    # long beside a swing. The errors of `impulse` scatter with the times of impacts.
    assert 1.4 <= found.excess <= {"event": 2.0, "impulse": 5.0}[SETTINGS[engine][0]]
    assert np.mean(found.ok) >= 0.94


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ["event 1e-2", "event 5e-3"])
def test_a_record_of_40_s_makes_many_lanes_sensitive_and_the_rest_can_be_trusted(
    engine: str,
) -> None:
    found = judged("record", engine)
    most, least = {"event 5e-3": (0.8, 0.85), "event 1e-2": (0.85, 0.8)}[engine]
    assert 0.3 <= np.mean(~found.ok) <= most
    # Measured: 14 of 15 at 5e-3, 9 of 11 at 1e-2; the others part from Housner's block by more.
    assert found.coverage("rotation_error") >= least
    # Housner's block and this one part ways in dozens of lanes: each of them says so.
    assert np.sum(found.fell != found.truly_fell) >= 5
    assert np.all(found.response["status"][found.fell != found.truly_fell] == Status.SENSITIVE)


@pytest.mark.thorough
@pytest.mark.parametrize(("problem", "engine"), JUDGED)
def test_no_lane_that_is_ok_has_a_wrong_outcome(problem: str, engine: str) -> None:
    found = judged(problem, engine)
    np.testing.assert_array_equal(found.fell[found.ok], found.truly_fell[found.ok])


@pytest.mark.thorough
@pytest.mark.parametrize("problem", ["free B1 to B3", "free B0", "bursts", "record"])
def test_boxes_that_rock_with_fifth_order_err_by_less_than_their_estimates(problem: str) -> None:
    lanes, motions, duration = PROBLEMS[problem]()
    times = SampleTimes(duration, duration / 2.0**13)
    truth = run_batch("housner", lanes, motions, times)
    # Measured medians of the error: 7e-7, the swings below which a block rests; 6e-4 in bursts.
    for step, most in ((1.25e-3, 2e-6), (1.25e-2, 2e-3)):
        settings = EventSettings(time_step=step)
        found = run_to_tolerance("event", lanes, motions, times, settings=settings)
        stands = np.isin(found["status"], SOUND) & (found["outcome"] != Outcome.OVERTURNED)
        error = np.abs(found["rotation"] - truth["rotation"]).max(axis=1)
        # All of 9 and 2 lanes and of 128 bursts; of 45 under a record one is not.
        assert np.mean((error <= found["rotation_error"])[stands]) >= 0.97
        # What stands stands in truth, within the swings below which a block rests.
        assert not np.any((truth["outcome"] == Outcome.OVERTURNED)[stands])
        assert np.median((error / lanes.slenderness_angle)[stands]) <= most


def critical_pulses() -> tuple[Lanes, Array, Array]:
    """Ten blocks, frequencies [Hz], and amplitudes [m/s^2] between standing and overturning."""
    frequency = np.repeat([0.8, 1.0, 1.5, 2.0, 3.0], 2)
    lanes = make_lanes(np.tile([0.2, 0.4], 5), 1.0, 0.0, FRICTION)
    low = 1.01 * rocking.uplift_acceleration(lanes.width, lanes.height)
    high = 30.0 * low
    for _ in range(45):
        middle = 0.5 * (low + high)
        motions = sines(Control.ACCELERATION, middle, frequency, cycles=1.0)
        fell = run_batch("housner", lanes, motions, SampleTimes(6.0))["outcome"] == (
            Outcome.OVERTURNED
        )
        low, high = np.where(fell, low, middle), np.where(fell, middle, high)
    return lanes, frequency, low


@pytest.mark.parametrize(
    ("engine", "distances", "most"),
    [
        pytest.param("event 1e-2", [0.01], 0.0, marks=pytest.mark.thorough),
        ("event 5e-3", [0.01], 0.0),
        # Of the first order it errs by a twentieth of the slenderness angle there and more: some of
        # its lanes have errors that happen not to halve with the step.
        pytest.param("impulse", np.linspace(0.01, 0.05, 9), 0.1, marks=pytest.mark.thorough),
    ],
)
def test_lanes_at_the_brink_of_overturning_are_sensitive_and_lanes_off_it_are_not(
    engine: str, distances: list[float], most: float
) -> None:
    name, settings = SETTINGS[engine]
    lanes, frequency, amplitude = critical_pulses()

    def status(factor: float) -> Array:
        motions = sines(Control.ACCELERATION, factor * amplitude, frequency, cycles=1.0)
        same = second_order(name, lanes)
        found = run_to_tolerance(name, same, motions, SampleTimes(6.0), settings=settings)
        return np.asarray(found["status"])

    for side in (-1.0, 1.0):
        assert np.all(status(1.0 + side * 1e-6) == Status.SENSITIVE)
        # At this friction a block that slides, as it falls at the latest, is AMBIGUOUS.
        sound = np.isin([status(1.0 + side * distance) for distance in distances], SOUND)
        assert np.mean(~sound) <= most


def test_a_coarse_step_is_told_from_chaos() -> None:
    lanes, motions, duration = PROBLEMS["pulses of Table 6"]()
    lanes, settings = second_order("event", lanes), EventSettings(time_step=8e-2)
    times, options = SampleTimes(duration), RunOptions(tolerance=1e-6)
    found = [
        run_to_tolerance("event", lanes, motions, times, options, settings=settings, halvings=count)
        for count in (1, 2)
    ]
    ratio = [each["rotation_error"] / lanes.slenderness_angle for each in found]
    # The first halving is too coarse to tell; the second shows that the runs approach one another.
    large = ratio[0] > tolerance.SENSITIVE_ABOVE
    assert np.mean(large) >= 0.8
    assert np.all(found[0]["status"][large] == Status.SENSITIVE)
    assert np.max(ratio[1]) > 2.0 * tolerance.SENSITIVE_ABOVE
    assert np.mean(found[1]["status"] == Status.OK) >= 0.8


@pytest.mark.thorough
def test_where_one_run_falls_the_estimate_covers_the_fall() -> None:
    found = judged("record", "event 5e-3")
    apart = found.fell != found.truly_fell
    errors = found.response["rotation_error"]
    assert np.all(np.isfinite(errors))
    peak = np.where(found.fell, np.pi / 2, found.response["peak_rotation"])
    # Of these lanes the companions disagree in most: such an estimate reaches from the smaller
    # peak to the ground, or further.
    both = apart & (errors >= 0.5 * np.pi - peak)
    assert np.sum(both) >= 0.5 * np.sum(apart)


def test_the_companion_steps_finer_where_something_else_cuts_the_step() -> None:
    # The record has a sample every 10 ms and the small blocks follow 0.25 / p = 30 ms: halves of
    # these steps of 0.1 s would be cut as the steps themselves are.
    lanes, motions, _ = shaken(32)
    settings = EventSettings(time_step=0.1)
    found = run_to_tolerance("event", lanes, motions, SampleTimes(20.0), settings=settings)
    fine = run_to_tolerance(
        "event", lanes, motions, SampleTimes(20.0), settings=EventSettings(time_step=1e-2)
    )
    # Steps of 0.1 s and of 0.01 s are cut to the same, but for where they begin after an impact.
    coarse, same = (np.median(each["rotation_error"]) for each in (found, fine))
    assert 0.2 <= coarse / same <= 5.0
    lanes, motions, duration = released(32)
    times = SampleTimes(duration, duration / 2.0**13)
    truth = run_batch("housner", lanes, motions, times)["rotation"]
    found = run_to_tolerance("event", lanes, motions, times, settings=settings)
    error = np.abs(found["rotation"] - truth).max(axis=1)
    assert np.mean(error <= found["rotation_error"]) >= 0.95


@pytest.mark.parametrize("engine", first(1, ["event", "impulse"]))
def test_a_bad_lane_harms_no_neighbour(engine: str, unjudged: None) -> None:
    lanes, motions, _ = bursts(40)
    times = SampleTimes(2.0)
    good = run_to_tolerance(engine, lanes, motions, times)
    height = lanes.height.copy()
    height[5] = np.nan
    found = run_to_tolerance(engine, dataclasses.replace(lanes, height=height), motions, times)
    assert found["status"][5] == Status.NONFINITE
    others = np.arange(40) != 5
    for name in ERROR_FIELDS:
        assert np.isnan(found[name][5])
        np.testing.assert_array_equal(found[name][others], good[name][others])


def test_a_failed_companion_leaves_no_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    lanes, motions, _ = bursts(40)

    def run_part(engine: str, lanes: Lanes, *rest: Any, settings: Any, **options: Any) -> Response:
        found = run_batch(engine, lanes, *rest, settings=settings, **options)
        if settings.time_step != EventSettings().time_step:
            status = np.where(lanes.width == blocks.width[7], Status.EVENT_LIMIT, found["status"])
            return dataclasses.replace(found, fields={**found.fields, "status": status})
        return found

    blocks = lanes
    monkeypatch.setattr(companions, "run_batch", run_part)
    found = run_to_tolerance("event", lanes, motions, SampleTimes(2.0))
    assert found["status"][7] == Status.SENSITIVE
    assert found["rotation_error"][7] == found["peak_rotation_error"][7] == np.inf
    assert np.all(np.isfinite(np.delete(found["rotation_error"], 7)))


@pytest.mark.thorough
def test_blocks_of_a_stack_have_estimates_of_their_own() -> None:
    lane_set = expand_lanes(load_case("stack-sine-pulse"))
    first = np.arange(4)
    lanes, motions = lane_set.lanes.take(first), lane_set.motions.take(first)
    found = run_to_tolerance("impulse", lanes, motions, SampleTimes(2.0))
    assert found["rotation_error"].shape == found["peak_rotation_error"].shape == (4, 2)
    assert found["status"].shape == (4,)
    assert np.all(found["rotation_error"] > 0.0)


@pytest.mark.parametrize("settings", [EventSettings(), ImpulseSettings(), ImpulseSettings(60.0, 0)])
def test_halved_settings_halve_the_step_exactly(settings: Any) -> None:
    half = settings.halved()
    assert half.time_step == 0.5 * settings.time_step
    same = {f.name for f in dataclasses.fields(settings)} - {"time_step", "substeps"}
    assert all(getattr(half, name) == getattr(settings, name) for name in same)


FREE = load_case("free-b1-b3", ["run.duration=2 s"])
FREE_ENGINES = [
    name for name in ENGINES if not engine_class(name).supports(expand_lanes(FREE).scene)
]


@pytest.mark.parametrize(
    "engine",
    [
        # Nothing else asks for their kernels of a base that stands still.
        pytest.param(e, marks=pytest.mark.thorough if e in ("direct", "xpbd") else ())
        for e in FREE_ENGINES
    ],
)
def test_engines_answer_no_estimates_and_the_run_adds_them_where_there_is_an_order(
    engine: str,
) -> None:
    bare = run_case(FREE, engine, RunOptions(tolerance=None), histories=False)
    assert not set(ESTIMATE_FIELDS) & set(bare.response.fields)
    run = run_case(FREE, engine, histories=False)
    table = lane_table(run.lane_set, run.response)
    columns = {
        *("rotation_error_rad", "peak_rotation_error_rad"),
        *("peak_slide_error_m", "uplift_time_error_s"),
    }
    if engine_class(engine).order is None:
        assert not columns & set(table)
        assert error_summary(run.response) is None
    else:
        assert columns <= set(table)
        summary = error_summary(run.response)
        assert summary is not None
        # Those of sensitive lanes are no bounds.
        assert summary["largest"] == table["rotation_error_rad"][table["status"] == "ok"].max()
        units = {name: table.attrs["columns"][name]["unit"] for name in columns}
        assert units == {name: name.rpartition("_")[2] for name in columns}


def test_run_shows_the_estimates_and_leaves_them_out_on_request(tmp_path: pathlib.Path) -> None:
    def invoke(*arguments: str) -> str:
        result = CliRunner().invoke(main, ["run", "free-b1-b3", "-e", "event", *arguments])
        assert result.exit_code == 0, result.output
        return result.stdout

    found = json.loads(invoke("--json"))
    errors = [row["rotation_error_rad"] for row in found["rows"]]
    assert found["rotation_error_rad"]["median"] == pytest.approx(np.median(errors))
    assert f"largest {three(np.rad2deg(max(errors)))} deg" in invoke()
    bare = json.loads(invoke("--json", "--no-estimate"))
    assert bare["rotation_error_rad"] is None
    assert not {"rotation_error_rad", "peak_rotation_error_rad"} & set(bare["rows"][0])
    explained = CliRunner().invoke(main, ["explain", "free-b1-b3"]).stdout
    assert any(engine_class(name).order is not None for name in FREE_ENGINES)
    assert explained.count("--no-estimate") == 1
