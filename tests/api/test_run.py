"""What a run gives: tables, histories, plots, files; and functions that refuse as commands do."""

import functools
import json

import numpy as np
import pandas as pd
import pytest

import warprock as wr
from tests.shared.commands import succeed
from warprock.running.case_run import run_case, run_lane

pytestmark = pytest.mark.usefixtures("nothing_rendered")


@pytest.fixture(scope="module")
def run() -> wr.Run:
    return wr.run("free-b0", progress=False)


def test_a_run_has_the_numbers_of_the_command(run, tmp_path):
    succeed("run", "free-b0", "-o", tmp_path / "cli")
    of_command = pd.read_parquet(tmp_path / "cli/lanes.parquet")
    pd.testing.assert_frame_equal(run.table, of_command, check_exact=True, check_categorical=False)
    assert run.table.attrs["columns"]["height_m"]["unit"] == "m"
    files = run.save(tmp_path / "api")
    names = {path.name for path in (tmp_path / "cli").iterdir()}
    assert {path.name for path in files} | {".warprock.json"} >= names
    facts = json.loads((tmp_path / "api/run.json").read_text())
    assert facts["engine"] == run.facts["engine"]
    assert facts["status"] == {"ok": 2} | {k: 0 for k in facts["status"] if k != "ok"}


def test_a_history_is_the_lane_again(run):
    history = run.history(1)
    wanted = run_lane(run_case(wr.load_case("free-b0"), run.engine), 1)
    assert np.array_equal(history["rotation_rad"], wanted["rotation"][0])
    finer = run.history(1, "5 ms")
    # Every second sample is at the same time but for round-off.
    np.testing.assert_allclose(finer["rotation_rad"][::2], history["rotation_rad"], atol=1e-12)
    peak = run.table["peak_rotation_rad"].iloc[1]
    assert finer["rotation_rad"].abs().max() == pytest.approx(peak)


def test_a_case_that_samples_no_histories_has_one_of_a_thousand_samples():
    case = wr.load_case("free-b0")
    tables = {**case.raw, "run": {"duration": "20 s"}, "check": []}
    quiet = wr.run({k: v for k, v in tables.items() if v}, progress=False)
    assert len(quiet.history(0)) == 1001


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda run: run.history(2), "lane: got 2, must be a lane from 0 to 1"),
        (lambda run: run.history(0, "0 s"), "interval: sample_interval: got '0 s', must be"),
        (lambda run: run.plot_peaks("hight_m"), "did you mean height_m?"),
        (lambda run: wr.run("free-b0", "evnt"), "engine: got 'evnt', allowed: "),
        (lambda run: wr.run("free-b0", tolerance=2), "tolerance: got 2, must be > 0 and < 1"),
        (lambda run: wr.run("free-bo"), "case: got 'free-bo', must be a shipped case"),
        (lambda run: wr.run("sensitivity-b0"), "must not be given: warprock.study runs"),
        (lambda run: wr.study("free-b0"), "study: got nothing, must be given"),
        (lambda run: wr.ida("free-b0"), "motion: got nothing, must be given"),
        (lambda run: wr.ida("free-b0", from_=0.0), "from_: got 0.0, must be from 1e-6 to 1e6"),
        (lambda run: wr.map("free-b0"), "motion: got nothing, must be given: a map needs a pulse"),
        (lambda run: wr.spectrum("free-b0"), "spectrum: got nothing, must be given"),
        (lambda run: wr.sensitivity("free-b0"), "sample: got nothing, must be given"),
        (lambda run: wr.sensitivity("free-b0", resamples=1), "resamples: got 1, must be from 10"),
        (lambda run: wr.compare("free-b0", ["hausner"]), "engine: got 'hausner', allowed: housner"),
        (lambda run: wr.compare("free-b0", []), "engine: got nothing, must be given, once for"),
        (lambda run: wr.fragility(run), "im: got 'peak_acceleration_m_s2', must be a col"),
        (lambda run: wr.fragility(run.table, limit=[-1]), "limit: got '-1', must be uplift"),
        (lambda run: wr.fragility("nowhere"), "table: got 'nowhere', must be a Parquet file"),
        (lambda run: wr.sweep("free-b0", "x", chunk=0), "chunk: got 0, must be"),
    ],
)
def test_bad_input_names_the_argument(run, ask, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(wr.InputError) as error:
        ask(run)
    assert said in str(error.value)
    assert "\n" not in str(error.value)
    assert not list(tmp_path.iterdir())


def test_an_argument_that_a_command_does_not_have_is_a_type_error():
    with pytest.raises(TypeError, match=r"ida\(\) got an unexpected keyword argument 'toleranse'"):
        wr.ida("free-b0", toleranse=0.1)


def test_plots_take_axes_and_give_them(run):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2)
    assert run.plot_history(0, ax=axes[0]) is axes[0]
    assert run.plot_history(1, ax=axes[0]) is axes[0]
    assert run.plot_peaks("height_m", ax=axes[1]) is axes[1]
    assert [text.get_text() for text in axes[0].get_legend().get_texts()] == [
        "lane 0, housner",
        "lane 1, housner",
    ]
    assert np.array_equal(axes[0].lines[0].get_xdata(), run.history(0)["time_s"])
    assert axes[1].get_xlabel() == "Full height of the block [m]"
    assert figure.get_axes() == list(axes)
    own = run.plot_peaks()
    assert own.figure is not figure
    assert own.get_title(loc="left").startswith("free-b0, housner: ")


def test_a_notebook_sees_a_table_and_a_picture_with_words(run):
    page = run._repr_html_()
    assert "<table" in page
    assert 'src="data:image/png;base64,' in page
    assert 'alt="' in page
    assert "peak_rotation_ratio" in page
    assert "<script" not in page
    assert len(repr(run)) < 120
    assert len(repr(run.found)) < 120


def test_an_ensemble_has_cells_and_another_run_says_that_it_has_none(run):
    spread = {"members": 8, "spread": {"block.height": "1 %"}}
    both = {"engine": "housner", "overrides": {"ensemble": spread}, "progress": False}
    found = wr.run({k: v for k, v in wr.load_case("free-b0").raw.items() if k != "check"}, **both)
    assert found.cells["members"].tolist() == [8, 8]
    assert list(found.tables) == ["lanes.parquet", "cells.csv"]
    with pytest.raises(ValueError, match="has no ensemble"):
        _ = run.cells


@pytest.mark.thorough
def test_the_cheapest_engine_is_picked_and_says_why():
    run = wr.run("free-b0", cheapest=True, overrides={"run.duration": "2 s"}, progress=False)
    assert run.cheapest is not None
    assert run.engine == run.cheapest.engine
    assert run.found.options.precision == run.cheapest.precision
    assert run.found.options.tolerance == 1e-2
    assert "0.01" in run.cheapest.why
    assert wr.run("free-b0", "housner", progress=False).cheapest is None


@pytest.mark.thorough
def test_the_cheapest_keeps_a_precision_that_is_named():
    """A precision that was named is not one that was left out, which `cheapest` may choose."""
    ask = functools.partial(wr.run, "free-b0", overrides={"run.duration": "2 s"}, progress=False)
    for precision in ("float64", "float32"):
        run = ask(cheapest=True, precision=precision)
        assert run.cheapest is not None
        assert run.cheapest.precision == run.found.options.precision == precision
    assert ask("housner").found.options.precision == "float64"


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"tolerance": 2.0}, "tolerance: got 2.0, must be > 0 and < 1"),
        ({"tolerance": None}, "tolerance: got None, must be given with cheapest"),
        ({"overrides": {"engines.event.time_step": 1e-3}}, "chooses the settings itself"),
    ],
)
def test_the_cheapest_needs_a_tolerance_and_sets_the_settings_itself(asked, said):
    with pytest.raises(wr.InputError) as refused:
        wr.run("free-b0", **{"cheapest": True, "progress": False, **asked})
    assert said in str(refused.value)
