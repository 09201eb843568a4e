"""Ensembles run: steps dealt to members, what cells come to, and the commands."""

from __future__ import annotations

import functools
import json
import math
import pathlib
from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest
import scipy.stats

from tests.shared.commands import invoke
from tests.shared.ensembles import STACK, write_pulse
from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import load_case
from warprock.model.response import (
    INTEGER_FIELDS,
    LANE_FIELDS,
    Outcome,
    Response,
    SampleTimes,
    Status,
)
from warprock.running.batch import run_batch
from warprock.running.case_run import run_case, run_lanes
from warprock.running.cells import (
    DIFFERENT,
    QUANTILES,
    SAME,
    cell_table,
    compare_cells,
    percentile_of,
    wilson_interval,
)
from warprock.running.options import RunOptions
from warprock.settings.engines import SETTINGS, has_time_step


@pytest.fixture
def write(tmp_path: pathlib.Path) -> Callable[..., pathlib.Path]:
    """Writes the case of three cells to a folder of its own."""
    return functools.partial(write_pulse, tmp_path)


def answered(lane_set: LaneSet, ratios: np.ndarray, **fields: np.ndarray) -> Response:
    """A response with some peak ratios, all lanes at rest and usable unless fields say else."""
    count = lane_set.lanes.lane_count
    found = {
        name: np.zeros(count, dtype=np.int64 if name in INTEGER_FIELDS else np.float64)
        for name in LANE_FIELDS
    }
    found["peak_rotation"] = ratios * lane_set.lanes.slenderness_angle
    return Response("made up", found | fields, np.empty(0))


def test_a_lane_alone_is_the_same_lane(write):
    case = load_case(write(members=12, more='time_step = "50 %"'))
    whole = run_case(case, "event", RunOptions(tolerance=None))
    again = run_lanes(whole, [17, 3])
    refined = run_case(case, "event", RunOptions(tolerance=1e-4))
    assert len(np.unique(refined.response["time_step"] / whole.lane_set.step_factors)) > 1
    finer = run_lanes(refined, [17, 3])
    for place, lane in enumerate((17, 3)):
        alone = expand_lanes(case, range(lane, lane + 1))
        assert alone.inputs.iloc[0].equals(whole.lane_set.inputs.iloc[lane])
        assert alone.step_factors is not None
        settings = whole.settings.with_step_scaled(float(alone.step_factors[0]))
        single, wrong = (
            run_batch("event", alone.lanes, alone.motions, alone.times, settings=each)
            for each in (settings, whole.settings)
        )
        for name, values in whole.response.fields.items():
            assert values[lane].tobytes() == single[name][0].tobytes(), name
            assert values[lane].tobytes() == again[name][place].tobytes(), name
        same = refined.response["rotation"][lane], finer["rotation"][place]
        assert same[0].tobytes() == same[1].tobytes()
        assert wrong["rotation"][0].tobytes() != single["rotation"][0].tobytes()


@pytest.mark.parametrize("engine", SETTINGS)
def test_a_step_that_can_be_halved_can_be_spread(engine: str):
    settings = SETTINGS[engine]()
    assert has_time_step(settings) == hasattr(settings, "halved")
    if has_time_step(settings):
        half, scaled = settings.halved(), settings.with_step_scaled(0.5)
        assert scaled.time_step == pytest.approx(half.time_step, rel=1e-15)
        longer = settings.with_step_scaled(1.1)
        assert longer.time_step == pytest.approx(1.1 * settings.time_step, rel=1e-15)


def test_a_time_step_means_nothing_to_an_engine_without_one(write):
    case = load_case(write(members=8, more='time_step = "10 %"'))
    stepped = run_case(case, "housner", histories=False)
    lane_set = stepped.lane_set
    assert lane_set.step_factors is not None
    times = SampleTimes(lane_set.times.duration)
    alone = run_batch("housner", lane_set.lanes, lane_set.motions, times)
    np.testing.assert_array_equal(stepped.response["peak_rotation"], alone["peak_rotation"])


def test_quantiles_of_a_narrow_ensemble_are_those_of_a_straight_line(write):
    """Over a narrow spread a smooth response is linear: its quantiles follow from its slope."""
    file = write('motion.amplitude = "0.1 %"', members=1024)
    table = cell_table(*_run(load_case(file)))
    ends = [
        f'sweep=[{{"motion.amplitude"=["{0.25 * part} g", "{0.3 * part} g", "{0.35 * part} g"]}}]'
        for part in (0.999, 1.0, 1.001)
    ]
    tiny = 'ensemble.spread={"motion.amplitude"="1e-9 %"}'
    low, middle, high = (
        cell_table(*_run(load_case(file, [end, tiny, "ensemble.members=2"])))[
            "peak_rotation_ratio_median"
        ]
        for end in ends
    )
    # A member is 1/1024 of the cell; curvature over the spread is a few 1e-3 of the slope.
    for name, share in QUANTILES.items():
        expected = middle + (2.0 * share - 1.0) * 0.5 * (high - low)
        found = table[f"peak_rotation_ratio_{name}"]
        assert (np.abs(found - expected) < 5e-3 * (high - low)).all(), name


def _run(case: Case) -> tuple[LaneSet, Response]:
    run = run_case(case, "housner", histories=False)
    return run.lane_set, run.response


def test_cells_of_a_made_up_response(write):
    lane_set = expand_lanes(load_case(write(members=100)))
    ratios = np.random.default_rng(5).gamma(2.0, 0.1, (3, 100))
    outcome = np.full((3, 100), int(Outcome.AT_REST))
    status = np.full((3, 100), int(Status.OK))
    outcome[1, :60] = int(Outcome.OVERTURNED)
    outcome[2, :3] = int(Outcome.SLID_OFF)
    status[2, 2:42] = int(Status.NONFINITE)
    ratios[2, 2:42] = np.nan
    status[0, :5] = int(Status.SENSITIVE)
    response = answered(lane_set, ratios.ravel(), outcome=outcome.ravel(), status=status.ravel())
    table = cell_table(lane_set, response)
    assert list(table["members"]) == [100] * 3
    assert list(table["usable"]) == [1.0, 1.0, 0.6]
    assert list(table["overturned"]) == [0.0, 0.6, 2 / 60]
    ranked = [ratios[0], ratios[1, 60:], np.r_[ratios[2, 42:], np.inf, np.inf]]
    for name, share in QUANTILES.items():
        column = table[f"peak_rotation_ratio_{name}"]
        for cell in (0, 2):
            values = np.sort(ranked[cell])
            if share == 0.95 and cell == 2:
                expected = np.quantile(values[:-2], 57 / 58, method="inverted_cdf")
            else:
                expected = np.quantile(np.minimum(values, 9.0), share, method="inverted_cdf")
            assert column[cell] == pytest.approx(expected, rel=1e-15)
        at = math.ceil(100 * share) - 1
        expected = np.sort(ranked[1])[at] if at < 40 else np.inf
        assert column[1] == pytest.approx(expected, rel=1e-15)
    status[:] = int(Status.EVENT_LIMIT)
    none = cell_table(lane_set, answered(lane_set, ratios.ravel(), status=status.ravel()))
    assert none["peak_rotation_ratio_median"].isna().all()
    assert none["overturned"].isna().all()
    assert (none["overturned_low"] == 0.0).all()
    assert (none["overturned_high"] == 1.0).all()


def test_blocks_of_a_stack_have_columns_of_their_own(tmp_path: pathlib.Path):
    file = tmp_path / "case.toml"
    file.write_text(STACK + 'block.2.offset = "1 mm"\n', encoding="utf-8")
    lane_set = expand_lanes(load_case(file))
    offsets = lane_set.lanes.offset[:, 1]
    # One member in each eighth of -1 mm to 1 mm.
    assert sorted(np.floor(4000.0 * offsets + 4.0)) == list(range(8))
    assert (lane_set.lanes.offset[:, 0] == 0.0).all()
    ratios = np.stack([np.arange(8.0), 10.0 + np.arange(8.0)], axis=1)
    count = lane_set.lanes.lane_count
    response = Response(
        "made up",
        {
            "peak_rotation": ratios * lane_set.lanes.slenderness_angle,
            "outcome": np.r_[np.zeros(count - 1, np.int64), int(Outcome.SLID_OFF)],
            "status": np.zeros(count, np.int64),
        },
        np.empty(0),
    )
    row = cell_table(lane_set, response).iloc[0]
    assert row["peak_rotation_ratio_median_1"] == pytest.approx(3.0)
    assert row["peak_rotation_ratio_median_2"] == pytest.approx(13.0)
    # A lane that fell ranks above all others in both of its blocks.
    assert row["peak_rotation_ratio_q95_1"] == row["peak_rotation_ratio_q95_2"] == np.inf
    assert row["overturned"] == 1 / 8


@pytest.mark.parametrize(
    ("count", "total", "low", "high"),
    [
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_wilson_intervals_of_newcombe(count: int, total: int, low: float, high: float):
    """R. G. Newcombe (1998), Statistics in Medicine 17, 857-872, Table I, method 3; four digits."""
    found = wilson_interval(np.array([count]), np.array([total]))
    assert [end[0] for end in found] == pytest.approx([low, high], abs=5e-5)
    mirrored = wilson_interval(np.array([total - count]), np.array([total]))
    assert [end[0] for end in mirrored] == pytest.approx([1.0 - high, 1.0 - low], abs=5e-5)


def test_a_printed_number_has_a_percentile():
    values = np.array([0.1, 0.2, 0.2, 0.4, 1.5, np.nan])
    outcomes = np.array([0, 0, 0, 1, int(Outcome.OVERTURNED), 0])
    assert percentile_of(values, outcomes, 0.05) == 0.0
    assert percentile_of(values, outcomes, 0.2) == pytest.approx(0.4)
    assert percentile_of(values, outcomes, 0.3) == pytest.approx(0.6)
    assert percentile_of(values, outcomes, 2.0) == pytest.approx(0.8)
    assert percentile_of(values, outcomes, np.inf) == pytest.approx(0.9)
    assert math.isnan(percentile_of(values[5:], outcomes[5:], 0.3))


def test_a_shifted_distribution_is_found_and_an_equal_one_is_not(write):
    lane_set = expand_lanes(load_case(write(members=500)))
    draw = np.random.default_rng(8)
    ratios = draw.normal(0.5, 0.1, (3, 500))
    a = answered(lane_set, ratios.ravel())
    same = compare_cells(lane_set, a, a)
    assert (same["statistic"] == 0.0).all()
    assert (same["meaning"] == SAME).all()
    others = draw.normal(0.5, 0.1, (3, 500))
    others[1] += 0.03
    outcome = np.zeros((3, 500), np.int64)
    outcome[2, :100] = int(Outcome.OVERTURNED)
    found = compare_cells(lane_set, a, answered(lane_set, others.ravel(), outcome=outcome.ravel()))
    assert list(found["meaning"]) == [SAME, DIFFERENT, DIFFERENT]
    others[2, :100] = 100.0
    for cell in range(3):
        expected = scipy.stats.ks_2samp(ratios[cell].round(4), others[cell].round(4))
        assert found["statistic"][cell] == pytest.approx(expected.statistic, rel=1e-12)
    # 0.2 of one sample are above all of the other.
    assert found["statistic"][2] >= 0.2
    assert list(found["overturned_b"]) == [0.0, 0.0, 0.2]


def test_lanes_that_may_not_be_used_are_left_out_of_a_comparison(write):
    lane_set = expand_lanes(load_case(write(members=100)))
    ratios = np.random.default_rng(4).normal(0.5, 0.1, (3, 100))
    a = answered(lane_set, ratios.ravel())
    status = np.zeros((3, 100), np.int64)
    status[0, :50] = status[1] = int(Status.EVENT_LIMIT)
    others = np.where(status == 0, ratios, 100.0)
    found = compare_cells(lane_set, a, answered(lane_set, others.ravel(), status=status.ravel()))
    assert list(found["usable_a"]) == [1.0, 1.0, 1.0]
    assert list(found["usable_b"]) == [0.5, 0.0, 1.0]
    expected = scipy.stats.ks_2samp(ratios[0].round(4), ratios[0, 50:].round(4)).statistic
    assert found["statistic"][0] == pytest.approx(expected, rel=1e-12)
    assert math.isnan(found["statistic"][1])
    assert list(found["meaning"]) == [SAME, "", SAME]


ENSEMBLE = ("-s", "ensemble.members=40", "-s", 'ensemble.spread.contact.friction="5 %"')


@pytest.mark.usefixtures("unrendered")
def test_a_run_prints_and_writes_cells(tmp_path: pathlib.Path):
    options = (*ENSEMBLE, "-s", 'ensemble.time_step="10 %"', "-e", "housner")
    done = invoke("run", "single-sine-pulse", *options, "-o", tmp_path)
    assert done.exit_code == 0, done.output
    assert "18 cells of 40 members" in done.stdout
    assert "housner has none" in done.stdout
    names = {"lanes.parquet", "lanes.csv", "cells.csv", "run.json", "ensemble.png", "report.html"}
    assert {path.name for path in tmp_path.iterdir()} == names | {".warprock.json"}
    cells, lanes = pd.read_csv(tmp_path / "cells.csv"), pd.read_parquet(tmp_path / "lanes.parquet")
    assert (len(cells), len(lanes)) == (18, 720)
    # Housner's block does not slide, so its friction changes nothing: the table of the case's own
    # check, whose tolerance is half of its last digit.
    own = [0.1864, 0.1366, 0.1858, 0.0903, 0.1079, 0.1228]
    for name in ("q05", "median", "q95"):
        assert cells[f"peak_rotation_ratio_{name}"][:6].to_numpy() == pytest.approx(own, abs=5e-5)
    assert (tmp_path / "ensemble.png").read_bytes().startswith(b"\x89PNG")
    assert list(lanes["member"][:41]) == [*range(40), 0]


def test_a_run_prints_cells_as_json():
    done = invoke("run", "single-sine-pulse", *ENSEMBLE, "--json")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert (found["lanes"], len(found["rows"])) == (720, 18)
    assert found["rows"][0]["reading"] == "displacement"


def test_engines_are_compared_by_distribution():
    case = ("compare", "single-sine-pulse", *ENSEMBLE, "-e", "housner")
    found = json.loads(invoke(*case, "-e", "housner", "--json").stdout)
    assert len(found["rows"]) == 18
    assert {row["meaning"] for row in found["rows"]} == {SAME}
    printed = invoke(*case, "-e", "event")
    assert printed.exit_code == 0, printed.output
    assert "p value" in printed.stdout
    alone = invoke(*case)
    assert alone.exit_code == 2
    assert "must be given twice" in alone.stderr
