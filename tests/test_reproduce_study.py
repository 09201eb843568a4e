"""The paper's sensitivity study on B0, and its run times beside ours."""

from __future__ import annotations

import io

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from warprock.batch import run_batch
from warprock.report import plots_study, tables_study
from warprock.report.paper import paper_table
from warprock.reproduce_runs import B0, PULSE, PaperRuns
from warprock.reproduce_stack_runs import STACK_SINE
from warprock.reproduce_study import KNOBS, run_study, study_conflict
from warprock.reproduce_times import BATCH, SCENES, SPREAD, run_times, scene_lane, spread_batch

ENGINES = ("impulse", "direct")


@pytest.fixture(scope="module")
def study():
    return run_study(PaperRuns())


@pytest.fixture(scope="module")
def table(study):
    return pd.DataFrame(study.rows).set_index(["source", "knob", "value", "lane"]).sort_index()


@pytest.fixture(scope="module")
def times(tmp_path_factory):
    folder = tmp_path_factory.mktemp("times")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PaperRuns, "timed", _not_timed)
        return run_times("times", PaperRuns(), folder), folder


def _not_timed(_self, _engine, lanes, _motions, _times, **_options):
    """Seconds that tell a lane from a batch, without a run."""
    return {"step_count": np.full(lanes.lane_count, 7)}, 0.5 if lanes.lane_count == 1 else 4.0


def printed(show, *given, width: int = 100) -> str:
    console = Console(file=io.StringIO(), width=width)
    show(console, *given)
    return console.file.getvalue()


def test_the_study_has_every_value_of_table_2_for_both_heights(table):
    """But for the collision shape: a box is exact here."""
    assert table.index.is_unique
    assert set(table.index.get_level_values("lane")) == {0, 1}
    for knob in KNOBS:
        for engine in knob.engines:
            assert len(table.loc[engine, knob.name]) == 2 * len(knob.values)
    assert table["holds"].all()


def test_the_steps_are_those_of_equation_9(table):
    for engine in ENGINES:
        for frames in (10.0, 50.0, 240.0):
            step = table["time_step_s"][engine, "frames_per_second", frames, 0]
            assert step == pytest.approx(1.0 / (201 * frames), rel=1e-12)
        for substeps in (2, 20, 200):
            step = table["time_step_s"][engine, "substeps", substeps, 0]
            assert step == pytest.approx(1.0 / ((substeps + 1) * 240.0), rel=1e-12)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("knob", ["substeps", "frames_per_second"])
def test_the_error_shrinks_with_the_step(engine: str, knob: str, table):
    """First order, but where in a step an impact falls is chance: by a factor of two at most."""
    values = next(k.values for k in KNOBS if k.name == knob)
    for lane in (0, 1):
        rows = table.loc[[(engine, knob, value, lane) for value in values]]
        assert rows["error_5s_ratio"].is_monotonic_decreasing
        rate = (rows["error_5s_ratio"] / rows["time_step_s"]).to_numpy()
        assert rate[-1] < 2.0 * rate[0]


@pytest.mark.parametrize("engine", ENGINES)
def test_coarse_steps_lose_energy_and_stop_the_block_early(engine: str, table, study):
    rest = [table["rest_time_s"][engine, "substeps", value, 0] for value in (2, 20, 200)]
    assert rest == sorted(rest)
    assert rest[0] > 11.0  # as early as the paper's, neither stops
    assert rest[-1] < study.reference["rest_time"][0]


def test_margins_wider_than_a_corner_moves_in_a_step_are_one(study, table):
    """A corner falls at width x angular velocity: by 1e-6 to 1e-5 m in a step at most impacts."""
    width, step = 1.0, table["time_step_s"]["impulse", "collision_margin", 1e-6, 0]
    rotation = study.reference["rotation"][0]
    travel = width * step * np.max(np.abs(np.gradient(rotation, study.reference.times)))
    assert 1e-6 < travel < 1e-5
    wide, middle, narrow = (
        study.responses["impulse", "collision_margin", value] for value in (1e-3, 1e-5, 1e-6)
    )
    np.testing.assert_array_equal(wide["rotation"], middle["rotation"])
    error = table["error_5s_ratio"]["impulse", "collision_margin"]
    assert error[1e-6, 0] < 0.5 * error[1e-3, 0]
    assert np.max(np.abs(narrow["rotation"] - wide["rotation"])) > 1e-4


def test_a_hundred_sweeps_are_as_good_as_a_thousand(study, table):
    """Sweeps converge geometrically: what a hundred leave is far below the error of the step."""
    rotations = {
        n: study.responses["impulse", "iterations", n]["rotation"] for n in (10, 100, 1000)
    }
    error = table["error_run_ratio"]["impulse", "iterations", 1000, 0]
    assert np.max(np.abs(rotations[100] - rotations[1000])) < 1e-6 * error
    assert np.max(np.abs(rotations[10] - rotations[1000])) < error


def test_the_conflict_says_what_the_study_found(study):
    conflict = study_conflict(study)
    assert conflict.item == 12
    assert "Eq. 9" in conflict.text
    assert f"Housner's after {study.reference['rest_time'][0]:.1f} s" in conflict.text
    assert "nan" not in conflict.text


def test_the_study_is_printed_and_drawn(study, tmp_path):
    rows = [row | {"reading": str(row["reading"])} for row in study.rows]
    text = printed(tables_study.print_study, rows, width=80)
    assert "…" not in text
    assert text.count("\n impulse sub-steps ") == text.count("\n direct  sub-steps ") == 1
    # At 5.5 m no setting comes to rest within 20 s, and the column is left out.
    assert text.partition("engine")[0].count(" rest ") == 1
    assert printed(tables_study.print_study, []) == ""
    assert plots_study.draw_study(tmp_path / "study.png", rows).stat().st_size > 10_000


def test_a_timed_run_is_the_run():
    """And takes some time; how much is the machine's affair."""
    runs = PaperRuns()
    lane_set = runs.case(B0).lane_set
    given = (lane_set.lanes, lane_set.motions, lane_set.times)
    response, seconds = runs.timed("event", *given, repeats=2)
    np.testing.assert_array_equal(response["rotation"], run_batch("event", *given)["rotation"])
    assert seconds > 0.0


@pytest.mark.parametrize("scene", SCENES)
def test_the_lane_of_a_scene_is_the_papers(scene):
    case, labels = SCENES[scene]
    lane_set = PaperRuns().case(case).lane_set
    row = paper_table("run-times").set_index(["system", "excitation"]).loc[scene]
    lane = scene_lane(lane_set, labels, row)
    inputs = lane_set.inputs.iloc[lane]
    assert {name: str(inputs[name]) for name in labels} == labels
    assert (inputs["frequency_hz"], inputs["amplitude_mm"]) == pytest.approx(
        (row["frequency_hz"], row["amplitude_mm"])
    )


@pytest.mark.parametrize("case", [PULSE, STACK_SINE])
def test_a_batch_is_its_lane_at_other_amplitudes(case: str):
    lane_set = PaperRuns().case(case).lane_set
    lanes, motions = spread_batch(lane_set, 3, 5)
    assert lanes.lane_count == motions.lane_count == 5
    moments = np.linspace(0.0, 0.1, 11)
    one = lane_set.motions.acceleration(moments, 3)
    for member, factor in enumerate((1 - SPREAD / 2, 1 - SPREAD / 4, 1.0)):
        np.testing.assert_allclose(motions.acceleration(moments, member), factor * one, rtol=1e-12)
        for name in ("velocity_step_start", "velocity_step_stop"):
            ours, theirs = getattr(motions, name)[member], getattr(lane_set.motions, name)[3]
            assert ours == pytest.approx(factor * theirs, rel=1e-12)


def test_run_times_are_those_of_the_paper_and_of_every_engine_that_can(times):
    found, folder = times
    rows = pd.DataFrame(found.rows)
    for scene in SCENES:
        mine = rows[(rows["system"] == scene[0]) & (rows["excitation"] == scene[1])]
        mine = mine.set_index("source")
        theirs = paper_table("run-times").set_index(["system", "excitation"]).loc[scene]
        for name in ("bullet", "vortex", "dem"):
            assert mine["wall_s"][f"paper-{name}"] == theirs[f"{name}_s"]
        assert {"impulse", "event", "direct", "xpbd", "dem"} < set(mine.index)
        assert ("housner" in mine.index) is (scene[0] == "single")
        assert ("two-block" in mine.index) is (scene[0] == "stack")
        assert mine["cpu_s"]["dem"] == 0.5
        assert mine["cpu_s_per_lane"]["dem"] == 4.0 / BATCH
    assert len(pd.read_csv(folder / "times.csv")) == len(rows)
    (conflict,) = found.conflicts
    assert conflict.item == 11
    assert "150 s for the pulse" in conflict.text


def test_run_times_fit_an_80_column_terminal(times):
    text = printed(tables_study.print_times, times[0].rows, width=80)
    assert "…" not in text
    assert "18055" in text
    assert all(engine in text for engine in ("housner", "two-block", "xpbd"))


def test_families_are_printed_side_by_side():
    shared = {"frequency_hz": 5.0, "amplitude_mm": 6.0}
    ours = {"reading": "displacement", "peak_rotation_ratio": 0.11}
    theirs = {"reading": "as printed", "peak_rotation_ratio": 0.1}
    rows = [shared | ours | {"source": name} for name in ("impulse", "direct", "dem")]
    rows += [shared | theirs | {"source": f"paper-{name}"} for name in ("bullet", "vortex", "dem")]
    text = printed(tables_study.print_families, rows, width=80)
    assert text.count("0.1100") == text.count("0.100 ") == text.count("+10.0") == 3
    assert printed(tables_study.print_families, rows[1:]) == ""
