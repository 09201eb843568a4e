"""The paper's sensitivity study on B0, `thorough`, and its run times beside ours.

The ordinary run has studies of a made-up case in `verification/test_study.py`.
"""

from __future__ import annotations

import io

import numpy as np
import pandas as pd
import pytest

from warprock.figures.drawing import write_drawings
from warprock.model.batch import Batch
from warprock.paper import print_families
from warprock.paper.printed import paper_table
from warprock.paper.runs import B0, PULSE, SENSITIVITY, PaperRuns
from warprock.paper.stack_runs import STACK_SINE
from warprock.paper.study import draw_figures, study_conflict
from warprock.paper.times import BATCH, SCENES, SPREAD, run_times, scene_lane, spread_batch
from warprock.running.batch import run_batch
from warprock.tables import study as tables_study
from warprock.tables.terminal import plain_console

ENGINES = ("impulse", "direct")


@pytest.fixture(scope="module")
def study():
    return PaperRuns().study(SENSITIVITY)


@pytest.fixture(scope="module")
def table(study):
    keys = ["engine", "setting", "value", "lane"]
    return study.table.set_index(keys).sort_index()


@pytest.fixture(scope="module")
def times(tmp_path_factory):
    folder = tmp_path_factory.mktemp("times")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PaperRuns, "timed", _not_timed)
        return run_times("times", PaperRuns(), folder), folder


def _not_timed(_self, _engine, batch, **_options):
    """Seconds that tell a lane from a batch, without a run."""
    count = batch.lanes.lane_count
    return {"step_count": np.full(count, 7)}, 0.5 if count == 1 else 4.0


def printed(show, *given, width: int = 100) -> str:
    console = plain_console(file=io.StringIO(), width=width)
    show(console, *given)
    return console.file.getvalue()


@pytest.mark.thorough
def test_the_study_has_every_value_of_table_2_for_both_heights(table):
    """But for the collision shape: a box is exact here."""
    assert table.index.is_unique
    assert len(table) == 2 * (4 * 3 + 2 * 3)
    assert set(table.index.get_level_values("lane")) == {0, 1}
    assert table["holds"].all()


@pytest.mark.thorough
def test_the_steps_are_those_of_equation_9(table):
    for engine in ENGINES:
        for frames in (10.0, 50.0, 240.0):
            step = table["time_step_s"][engine, "frames_per_second", frames, 0]
            assert step == pytest.approx(1.0 / (201 * frames), rel=1e-12)
        for substeps in (2, 20, 200):
            step = table["time_step_s"][engine, "substeps", substeps, 0]
            assert step == pytest.approx(1.0 / ((substeps + 1) * 240.0), rel=1e-12)


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("setting", ["substeps", "frames_per_second"])
def test_the_error_shrinks_with_the_step(engine: str, setting: str, table):
    """First order, but where in a step an impact falls is chance: by a factor of two at most."""
    for lane in (0, 1):
        rows = table.xs((engine, setting, lane), level=("engine", "setting", "lane"))
        assert rows["error_5s_ratio"].is_monotonic_decreasing
        rate = (rows["error_5s_ratio"] / rows["time_step_s"]).to_numpy()
        assert rate[-1] < 2.0 * rate[0]


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ENGINES)
def test_coarse_steps_lose_energy_and_stop_the_block_early(engine: str, table):
    rows = table.xs((engine, "substeps", 0), level=("engine", "setting", "lane"))
    assert rows["rest_time_s"].is_monotonic_increasing
    assert rows["rest_time_s"].iloc[0] > 11.0  # as early as the paper's, neither stops
    assert (rows["rest_time_error_s"] < 0.0).all()


@pytest.mark.thorough
def test_margins_wider_than_a_corner_moves_in_a_step_are_one(study, table):
    """A corner falls at width x angular velocity: by 1e-6 to 1e-5 m in a step at most impacts."""
    width, step = 1.0, table["time_step_s"]["impulse", "collision_margin", 1e-6, 0]
    rotation = study.reference * study.lane_set.lanes.slenderness_angle[-1]
    travel = width * step * np.max(np.abs(np.gradient(rotation, study.times)))
    assert 1e-6 < travel < 1e-5
    wide, middle = (study.histories["impulse", "collision_margin", m] for m in (1e-3, 1e-5))
    # An open gap may close within a step, so that its round-off over the step is a velocity, which
    # an impact may leave: after 20 s it is this, of the slenderness angle. Measured: a twentieth.
    drift = np.spacing(width) / step * study.times[-1]
    alpha = study.lane_set.lanes.slenderness_angle[-1]
    np.testing.assert_allclose(wide, middle, rtol=0.0, atol=drift / (width * alpha))
    rows = table.loc["impulse", "collision_margin"]
    for lane in (0, 1):
        errors = rows["error_5s_ratio"].xs(lane, level="lane")
        assert errors[1e-3] == pytest.approx(errors[1e-5], rel=1e-9)
        assert errors[1e-6] < 0.5 * errors[1e-3]


@pytest.mark.thorough
def test_a_hundred_sweeps_are_as_good_as_a_thousand(table):
    """Sweeps converge geometrically: what a hundred leave is round-off of 20 s of rocking."""
    rows = table.loc["impulse", "iterations"]["baseline_difference_ratio"]
    assert rows.loc[100].max() < 1e-9
    assert 1e-9 < rows.loc[10].max() < table.loc["impulse", "iterations"]["error_run_ratio"].max()


@pytest.mark.thorough
def test_a_thousand_sweeps_do_not_cost_a_hundred_times_ten(table):
    """Sweeps end once one changes nothing: some fifteen are enough at nearly every step."""
    cost = table.loc["impulse", "iterations"]["cpu_s"]
    assert cost[1000, 0] < 20.0 * cost[10, 0]


@pytest.mark.thorough
def test_the_conflict_says_what_the_study_found(study):
    conflict = study_conflict(study)
    assert conflict.item == 12
    assert "Eq. 9" in conflict.text
    table = study.table
    rest = (table["rest_time_s"] - table["rest_time_error_s"]).iloc[0]
    assert f"Housner's after {rest:.1f} s" in conflict.text
    assert "nan" not in conflict.text


@pytest.mark.thorough
def test_the_study_is_printed_and_drawn(study, tmp_path):
    rows = [row | {"case": SENSITIVITY} for row in study.rows]
    text = printed(tables_study.print_studies, rows, width=80)
    assert "…" not in text
    assert text.count("\n substeps ") == 2
    # At 5.5 m no setting comes to rest within 20 s, and the column is left out.
    assert text.partition("substeps")[0].count(" rest ") == 1
    assert printed(tables_study.print_studies, []) == ""
    files = write_drawings(draw_figures(study), tmp_path)
    assert [path.name for path in files] == ["fig4-sensitivity.png", "fig4-study.png"]
    assert all(path.stat().st_size > 10_000 for path in files)


def test_a_timed_run_is_the_run():
    """And takes some time; how much is the machine's affair."""
    runs = PaperRuns()
    lane_set = runs.case(B0).lane_set
    batch = Batch(lane_set.lanes, lane_set.motions, lane_set.times)
    response, seconds = runs.timed("event", batch, repeats=2)
    np.testing.assert_array_equal(response["rotation"], run_batch("event", *batch)["rotation"])
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
    lanes, motions, _times = spread_batch(lane_set, 3, 5)
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
    text = printed(print_families.print_times, times[0].rows, width=80)
    assert "…" not in text
    assert "18055" in text
    assert all(engine in text for engine in ("housner", "two-block", "xpbd"))


def test_families_are_printed_side_by_side():
    shared = {"frequency_hz": 5.0, "amplitude_mm": 6.0}
    ours = {"reading": "displacement", "peak_rotation_ratio": 0.11}
    theirs = {"reading": "as printed", "peak_rotation_ratio": 0.1}
    rows = [shared | ours | {"source": name} for name in ("impulse", "direct", "dem")]
    rows += [shared | theirs | {"source": f"paper-{name}"} for name in ("bullet", "vortex", "dem")]
    text = printed(print_families.print_families, rows, width=80)
    assert text.count("0.1100") == text.count("0.100 ") == text.count("+10.0") == 3
    assert printed(print_families.print_families, rows[1:]) == ""
