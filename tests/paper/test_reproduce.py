"""The reproduction of the paper's tables and figures, end to end and with given responses."""

from __future__ import annotations

import json
import threading
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.figures.drawing import Drawing
from warprock.model.batch import Batch
from warprock.model.response import (
    FIELDS,
    INTEGER_FIELDS,
    LANE_FIELDS,
    MODEL_FIELDS,
    SPATIAL_FIELDS,
    Response,
)
from warprock.paper import reproduce as module
from warprock.paper import runs as paper_runs
from warprock.paper import stack as reproduce_stack
from warprock.paper.conflicts import slip_deceleration
from warprock.paper.printed import PAPER_COLUMNS, paper_table
from warprock.paper.reproduce import CASES_OF, GROUPS, SENSITIVITY, reproduce
from warprock.paper.runs import MEMBERS
from warprock.paper.space import space_ensembles
from warprock.verification import study
from warprock.verification.checks import CaseResponses

pytestmark = pytest.mark.usefixtures("nothing_rendered")

KEYS = {"target", "frequency_hz", "amplitude_mm", "reading", "source", "peak_rotation_ratio"}
DISPLACEMENT_PEAKS = (0.1864, 0.1366, 0.1858, 0.0903, 0.1079, 0.1228)
"""Housner's equation with the velocity step as an impulse, integrated independently."""


@pytest.fixture(scope="module")
def table6(tmp_path_factory):
    folder = tmp_path_factory.mktemp("table6")
    return reproduce("table6", folder), folder


@pytest.fixture(scope="module")
def table7(tmp_path_factory):
    folder = tmp_path_factory.mktemp("table7")
    return reproduce("table7", folder), folder


def rows_of(found, **chosen) -> list[dict]:
    return [row for row in found["rows"] if all(row[key] == value for key, value in chosen.items())]


def peaks_of(found, source: str, reading: str) -> np.ndarray:
    return np.array(
        [r["peak_rotation_ratio"] for r in rows_of(found, source=source, reading=reading)]
    )


def test_table_6_prints_the_digits_of_the_displacement_reading(table6):
    found, _ = table6
    for source in ("housner", "oracle"):
        peaks = peaks_of(found, source, "displacement")
        np.testing.assert_allclose(peaks, DISPLACEMENT_PEAKS, atol=0.5e-4)


def test_table_6_holds_housner_to_the_oracle_in_every_reading(table6):
    """Both solve one equation; 1e-6 is what the project asks of the peaks."""
    found, _ = table6
    for reading in ("displacement", "acceleration", "double-size"):
        ours, oracle = (peaks_of(found, source, reading) for source in ("housner", "oracle"))
        assert len(ours) == 6
        np.testing.assert_allclose(ours, oracle, rtol=1e-6)


def test_table_6_keeps_the_paper_as_printed(table6):
    found, _ = table6
    printed = paper_table("table6")
    for name in PAPER_COLUMNS:
        assert list(peaks_of(found, f"paper-{name}", "as printed")) == list(printed[name])


def test_table_6_says_where_housner_does_not_hold(table6):
    found, _ = table6
    for row in rows_of(found, source="impulse"):
        assert row["holds"] is (row["reading"] != "displacement")
        # The velocity step at the start needs 2.19, that at the end more, or pulls at the block.
        told = "needs more friction" in row["why"] or "have to pull" in row["why"]
        assert told is (row["reading"] == "displacement")


def test_impulse_slips_as_far_as_a_slipping_corner_does(table6):
    """The velocity step v slips over v^2 / (2 deceleration); a time step adds at most v dt."""
    found, _ = table6
    slowing = slip_deceleration(0.17, 1.0, 1.0)
    for row in rows_of(found, source="impulse", reading="displacement"):
        step = 2e-3 * np.pi * row["frequency_hz"] * row["amplitude_mm"]
        slide = 1e-3 * row["peak_slide_mm"]
        assert slide == pytest.approx(step**2 / (2.0 * slowing), abs=step / (21 * 240.0))


def test_dem_with_the_springs_of_table_5_is_the_column_of_the_papers_dem(table6):
    """Nothing is fitted; 3 % for a plane model of a program in space; rounding is 0.6 %."""
    found, _ = table6
    ours = peaks_of(found, "dem", "displacement")
    np.testing.assert_allclose(ours, paper_table("table6")["dem"], rtol=0.03)


def test_direct_is_the_column_of_vortex(table6):
    """Half of the last printed digit is 0.3 to 0.6 %; its stiffness and damping are not printed."""
    found, _ = table6
    ours = peaks_of(found, "direct", "displacement")
    np.testing.assert_allclose(ours, paper_table("table6")["vortex"], rtol=0.01)


def test_table_6_is_one_json_object_of_rows_with_the_agreed_keys(table6):
    found, _ = table6
    json.dumps(found, allow_nan=False)
    assert len(found["rows"]) == 6 * 18 + 4 * 6
    assert all(row.keys() >= KEYS for row in found["rows"])
    assert {conflict["item"] for conflict in found["conflicts"]} == {1, 2, 3, 7, 8}


def test_table_6_is_written_as_csv(table6):
    found, folder = table6
    assert found["files"] == [str(folder / "table6.csv")]
    written = pd.read_csv(folder / "table6.csv")
    assert len(written) == len(found["rows"])
    assert list(written["source"]) == [row["source"] for row in found["rows"]]


@pytest.mark.thorough
def test_table_7_keeps_the_printed_errors_apart_from_peaks(table7):
    found, _ = table7
    printed = paper_table("table7")
    for name in PAPER_COLUMNS:
        rows = rows_of(found, source=f"paper-{name}")
        assert all(row["peak_rotation_ratio"] is None for row in rows)
        theirs = pd.to_numeric(printed[name], errors="coerce").tolist()
        ours = [np.nan if row["abs_error_pct"] is None else row["abs_error_pct"] for row in rows]
        np.testing.assert_array_equal(ours, theirs)
    fell = rows_of(found, source="paper-dem")[-1]
    assert (fell["abs_error_pct"], "collapsed" in fell["why"]) == (None, True)


@pytest.mark.thorough
def test_the_two_routes_to_the_test_of_table_7_agree(table7):
    """Within 4.5 %: the printed errors are rounded to 1 %, 0.5/0.57 of a point at most a route."""
    found, _ = table7
    routes = [peaks_of(found, "inferred-experiment", r) for r in ("double-size", "displacement")]
    assert [len(route) for route in routes] == [6, 6]
    assert np.max(np.abs(routes[0] / routes[1] - 1.0)) < 0.045


@pytest.mark.thorough
def test_nothing_inferred_is_called_measured(table7):
    found, _ = table7
    assert not any("measured" in row["source"] for row in found["rows"])
    inferred = rows_of(found, source="inferred-experiment")
    assert all("not measured" in row["why"] for row in inferred)


@pytest.mark.thorough
def test_table_7_is_one_json_object(table7):
    found, _ = table7
    json.dumps(found, allow_nan=False)
    assert {conflict["item"] for conflict in found["conflicts"]} == {1, 4, 7, 11}


def _answer(responses: CaseResponses, engine: str) -> Response:
    """A decaying swing, of every block of a stack; `impulse` is 1 % larger."""
    lanes, times = responses.lane_set.lanes, responses.lane_set.times.times
    size = 0.2 * lanes.slenderness_angle * (1.01 if engine == "impulse" else 1.0)
    fields = {
        name: np.zeros(
            size.shape if FIELDS[name].per_block else lanes.lane_count,
            np.int64 if name in INTEGER_FIELDS else np.float64,
        )
        for name in (*LANE_FIELDS, *MODEL_FIELDS, *(SPATIAL_FIELDS if lanes.spatial else ()))
    }
    history = size[..., None] * np.cos(6.0 * times) * np.exp(-0.3 * times)
    return Response(engine, fields | {"peak_rotation": size, "rotation": history}, times)


@pytest.fixture
def answered(monkeypatch):
    """Runs no engine and no oracle."""

    def timed(self, engine, batch, **_more):
        lane_set = SimpleNamespace(lanes=batch.lanes, times=batch.times)
        return _answer(SimpleNamespace(lane_set=lane_set), engine), 0.25

    unbuilt = SimpleNamespace(warm_up=lambda *_: None)
    monkeypatch.setattr(CaseResponses, "_run", _answer)
    monkeypatch.setattr(module.PaperRuns, "timed", timed)
    monkeypatch.setattr(
        study, "run_batch", lambda engine, *a, **_: timed(None, engine, Batch(*a))[0]
    )
    monkeypatch.setattr(study, "engine_class", lambda _name: lambda *_: unbuilt)
    monkeypatch.setattr(
        module.PaperRuns,
        "oracle_peaks",
        lambda self, name: np.full(self.case(name).lane_set.lanes.lane_count, 0.2),
    )


FIGURES = {
    "fig4": {"fig4.png", "fig4-sensitivity.png", "fig4-study.png", "fig4-study.csv"},
    "fig5": {"fig5.png"},
    "fig7": {f"fig7{part}.png" for part in ("", "-displacement", "-acceleration", "-double-size")},
    "fig8": {"fig8.png"},
    "fig10": {
        f"fig10{part}.png" for part in ("", "-displacement", "-acceleration", "-double-size")
    },
    "fig11": {"fig11.png"},
}


@pytest.mark.parametrize(
    "target",
    # Figures 4, 7, 8 and 10 are drawn as 5 is.
    [
        pytest.param(
            n, marks=pytest.mark.thorough if n in ("fig4", "fig7", "fig8", "fig10") else ()
        )
        for n in FIGURES
    ],
)
def test_a_figure_target_writes_its_figures_and_its_numbers(target: str, tmp_path, answered):
    drawings: list[Drawing] = []
    found = reproduce(target, tmp_path / "new", drawings=drawings)
    names = {path.name for path in (tmp_path / "new").iterdir()}
    assert names == FIGURES[target] | {f"{target}.csv"}
    assert {f"{each.name}.png" for each in drawings} == {n for n in names if n.endswith(".png")}
    assert sorted(names) == sorted(file.rsplit("/", 1)[1] for file in found["files"])
    assert all(row.keys() >= KEYS for row in found["rows"])
    errors = [row["peak_error"] for row in rows_of(found, source="impulse")]
    np.testing.assert_allclose(errors, 0.01, atol=1e-12)
    json.dumps(found, allow_nan=False)


@pytest.mark.thorough
def test_all_makes_every_target_and_runs_a_case_once(tmp_path, answered, monkeypatch):
    runs = []
    monkeypatch.setattr(
        CaseResponses,
        "_run",
        lambda self, engine: (
            runs.append((self.case.name, self.case.overridden, engine)) or _answer(self, engine)
        ),
    )
    for name in FIGURES:
        monkeypatch.setitem(module._MAKERS, name, module._figure(lambda _runs: [], CASES_OF[name]))
    for name in ("fig12", "fig13", "fig14", "fig15"):
        monkeypatch.setitem(module._MAKERS, name, reproduce_stack._figure(lambda _runs: []))
    monkeypatch.setattr(reproduce_stack.figures, "collapse", lambda _runs: [])
    built = set()
    monkeypatch.setattr(
        paper_runs,
        "warm_up_together",
        lambda batches: built.update(e.module_of(*given).__name__ for e, *given in batches),
    )
    done = []
    found = reproduce("all", tmp_path, progress=done.append, members=2)
    assert {row["target"] for row in found["rows"]} == set(GROUPS["all"])
    # Those of the study, of the springs and of the run times, too.
    for part in ("still__1000__1", "dem.stack_run__float64__harmonic__20", "xpbd.stack_run"):
        assert any(part in name for name in built), part
    assert len(runs) == len(set(runs))
    # What is compiled beforehand is what runs.
    known = module._engines_of(GROUPS["all"])
    assert {(case, e) for case, engines in known.items() for e in engines} <= {
        (case, engine)
        for case, overridden, engine in runs
        if overridden <= {"ensemble.members"} and case != SENSITIVITY
    }
    assert done == sorted(done)
    assert set(found["seconds"]) == {"kernels", *GROUPS["all"]}
    assert {conflict["item"] for conflict in found["conflicts"]} == set(range(1, 14))


def test_runs_ahead_are_run_once_and_a_failing_one_fails_where_it_is_asked_for(monkeypatch):
    """Whoever asks for a run that another thread has in hand waits for it."""
    held, begun, ran = threading.Event(), threading.Event(), []

    def run(self, engine):
        ran.append(engine)
        if engine == "dem":
            raise InputError("case", "key", "value", "must be another")
        begun.set()
        assert held.wait(10.0)
        return _answer(self, engine)

    monkeypatch.setattr(CaseResponses, "_run", run)
    runs = module.PaperRuns()
    case = runs.case("free-b0")
    runs.run_ahead([(case, "impulse"), (case, "dem"), (case, "event")])
    assert begun.wait(10.0)
    threading.Timer(0.1, held.set).start()
    assert case["impulse"].engine == "impulse"
    with pytest.raises(InputError, match="must be another"):
        case["dem"]
    assert ran.count("impulse") == 1
    assert "event" not in ran


@pytest.mark.parametrize(
    ("asked", "few"), [({}, True), ({"full": True}, False), ({"members": 3}, None)]
)
def test_ensembles_have_fewer_members_than_their_cases_unless_all_are_asked_for(asked, few):
    runs = module.PaperRuns(**asked)
    for name, members in MEMBERS.items():
        case = runs.case(*name)
        most = load_case(name[0]).ensemble.members
        assert case.lane_set.members == {True: members, False: most, None: 3}[few]
        assert members < most
    # Blocks fall under one input alone, and few of them: its members are all those of the case.
    (falling, *_) = (case for case, _ in space_ensembles(runs) if len(case.lane_set.cells) == 1)
    assert falling.lane_set.members == (asked.get("members") or 128)


def test_groups_are_of_targets_and_all_is_every_one():
    assert set(GROUPS["all"]) == set(CASES_OF) == set(module._MAKERS)
    assert set(GROUPS["single-block"]) < set(CASES_OF)


def test_an_unknown_target_is_refused_before_anything_is_written(tmp_path):
    with pytest.raises(InputError, match=r"got 'table8'.*table6"):
        reproduce("table8", tmp_path / "new")
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_a_file_is_refused_before_anything_runs(tmp_path, monkeypatch):
    def run(_self, _engine):
        raise AssertionError("an engine ran")

    monkeypatch.setattr(CaseResponses, "_run", run)
    file = tmp_path / "results"
    file.write_text("")
    with pytest.raises(InputError, match="results"):
        reproduce("table6", file)
