"""Every function of `import warprock` takes what is of the wrong kind, and refuses it by name."""

import functools
import inspect
import pickle
import re
import sys
from typing import Any

import click
import numpy as np
import pandas as pd
import pytest

import warprock as wr
from tests.shared.marks import first
from warprock.cli.main import main
from warprock.errors import InputError, written_as
from warprock.paper.reproduce import TARGETS

pytestmark = pytest.mark.usefixtures("nothing_rendered")

WRONG = (5, "x", None, [5], {"x": 1}, object(), np.nan)
RARELY_WRONG = (-1, "", b"x", True, [], {}, pd.DataFrame())
SHORT = {"run.duration": "0.05 s"}
HOW = {"overrides": SHORT, "precision": "float64", "device": "cpu", "workers": 1, "progress": False}
HELD = HOW | {"engine": "housner", "tolerance": 0.1}


@functools.cache
def lanes() -> pd.DataFrame:
    """A lane table."""
    fewer = {"sample.lanes": 16, "run.duration": "2 s"}
    return wr.run("sobol-single-block", "housner", overrides=fewer, progress=False).table


@pytest.fixture(scope="module")
def run() -> wr.Run:
    return wr.run("free-b0", "housner", overrides=SHORT, progress=False)


def calls(run: wr.Run) -> dict[Any, dict[str, Any]]:
    """Public functions, each with arguments of which one at a time is replaced."""
    tables, lane_set = dict(run.case.raw), run.found.lane_set
    batch = {"lanes": lane_set.lanes, "motions": lane_set.motions, "times": lane_set.times}
    batch |= {"settings": None, "form": None, "chunk_size": 8, "progress": None}
    ladder = {"from_": 1.0, "to": 2.0, "count": 2, "accuracy": 0.5, "im": "PGA", "by": []}
    fitted = {"table": lanes(), "im": "PGA", "limit": "0.5", "limit_slide": [], "by": []}
    mesh = {"mesh": "slab.ply", "density": "1 t/m^3", "unit": "m", "up": "z", "pose": 0}
    mesh |= {"base": "hull", "points": 8, "model": "planar", "direction": None, "record": None}
    block = {"width": "1 m", "height": "5 m", "slenderness": None, "frequency_parameter": None}
    block |= {"fit": "slenderness", "column": None, "unit": None}
    record = {"file": "r.csv", "samples": [0.0, 1.0], "interval": "0.1 s", "unit": "g"}
    return {
        wr.run: {"case": "free-b0", **HELD, "cheapest": False},
        wr.fragility: {**fitted, "max_doubt": 1.0},
        wr.ida: {"case": "free-b0", **HELD, **ladder, "folder": None},
        wr.map: {"case": "free-b0", **HOW, "engine": "housner", "accuracy": 0.1},
        wr.spectrum: {"case": "free-b0", **HELD},
        wr.sensitivity: {"case": "free-b0", **HELD, "of": "x", "resamples": 10},
        wr.study: {"case": "free-b0", **HOW, "engine": "direct"},
        wr.sweep: {"case": "free-b0", "folder": "sweep", **HELD, "chunk": 1},
        wr.compare: {"case": "free-b0", "engine": "housner", "workers": 1, "overrides": SHORT},
        wr.validate: {"case": "free-b0", "observed": None, "engine": "housner", "column": "x"},
        wr.body: {**mesh, "mass": None, "tolerance": None},
        wr.capacity: {"case": "free-b0", "overrides": SHORT},
        wr.identify: {"history": run.history(0, "10 ms"), **block},
        wr.trade: {"engine": "housner", "scene": "free", "folder": "trade"},
        wr.stability: {"engine": "housner", "map": "step", "points": 2, "steps": 50, "workers": 1},
        wr.load_case: {"name_or_path": "free-b0", "overrides": SHORT},
        wr.Case: {**{k: tables[k] for k in ("block", "contact", "start", "run")}, "name": "n"},
        wr.Case.from_dict: {"tables": tables, "name": "n", "folder": None},
        wr.Case.from_table: {"table": pd.DataFrame({"width_m": [0.4]})},
        run.case.override: {"changes": SHORT},
        wr.Sweep: {"keys": {}},
        wr.Grid: {"first": "1 m", "last": "2 m", "count": 2, "spacing": None},
        wr.Lognormal: {"median": 1.0, "dispersion": 0.5},
        wr.Sample: {"over": {}, "lanes": 2, "seed": 1, "sampling": "lhs"},
        wr.Ensemble: {"members": 2, "spread": {}, "time_step": "5 %"},
        wr.Study: {"engines": ["event"], "vary": {}},
        wr.with_unit: {"values": 1.0, "unit": "m"},
        wr.save_record: record,
        run.history: {"lane": 0, "interval": "10 ms"},
        run.plot: {"ax": None, "group": 0},
        run.save: {"folder": "saved"},
        wr.expand_lanes: {"case": run.case, "lanes": None},
        wr.run_batch: {"engine": "housner", "precision": "float64", "device": "cpu", **batch},
        wr.run_case: {"case": run.case, "engine": "housner", "options": run.found.options},
        wr.lane_table: {"lane_set": lane_set, "response": run.response},
        wr.write_run: {"run": run.found, "folder": "written"},
        wr.SampleTimes: {"duration": 1.0, "interval": 0.1, "places": False},
    }


@pytest.mark.parametrize(
    "wrongs", first(1, [list(WRONG), list(RARELY_WRONG)]), ids=["often", "rarely"]
)
def test_a_wrong_argument_is_an_input_error(wrongs, run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # A wrong word may be a good name of a folder: what is measured then takes a minute.
    monkeypatch.setattr("warprock.api.trade.trade_of", lambda *_: None)
    # Nor do all engines run where none is named.
    monkeypatch.setattr("warprock.api.stability.Atlas.run", lambda *_: None)
    bare = []
    for function, given in calls(run).items():
        for name in given:
            for wrong in wrongs:
                try:
                    function(**{**given, name: wrong})
                except wr.InputError:
                    pass
                except Exception as error:
                    bare.append(f"{function.__name__}({name}={wrong!r}): {error!r}")
    assert not bare


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda: wr.run(5), "case: got 5, must be a Case, a dict, text or a path"),
        (
            lambda: wr.run("free-b0", workers="2"),
            "workers: got '2', must be a whole number",
        ),
        (
            lambda: wr.run("free-b0", tolerance=True),
            "tolerance: got True, must be a number",
        ),
        (lambda: wr.ida("free-b0", by=5), "by: got 5, must be text or a list of texts"),
        (lambda: wr.fragility(lanes(), by="item"), "by: got 'item', must be a column"),
        (lambda: wr.ida("free-b0", from_=3.0, to=2.0), "to: got 2.0, must be above from_, 3"),
    ],
)
def test_the_error_names_the_argument(ask, said):
    with pytest.raises(wr.InputError) as error:
        ask()
    assert str(error.value).startswith(said)


@pytest.mark.parametrize(
    "command", ["fragility", "risk", "ida", "map", "spectrum", "sensitivity", "body"]
)
def test_arguments_are_named_as_options(command):
    own = set(inspect.signature(getattr(wr, command)).parameters)
    options = {
        name for each in main.get_command(click.Context(main), command).params for name in each.opts
    }
    of_options = {name.removeprefix("--").replace("-", "_") for name in options}
    # `from` is a word of Python's; overrides are values by key, not texts KEY=VALUE; what a command
    # was called with, shows or writes is not an option.
    other = {"from_", "overrides", "case", "table", "mesh", "folder", "progress"}
    assert own - other <= of_options


def test_one_is_as_good_as_a_list():
    for several in ("0.5", 0.5, ["0.5"], ("0.5",), np.array(["0.5"])):
        (limit,) = wr.fragility(lanes(), limit=several, max_doubt=1).table["limit_state"]
        assert limit == "0.5"


def test_a_run_can_be_pickled(run):
    run.figures()
    again = pickle.loads(pickle.dumps(run))
    assert again.table.equals(run.table)
    assert repr(again) == repr(run)
    assert np.array_equal(again.history(1)["rotation_rad"], run.history(1)["rotation_rad"])
    assert [each.title for each in again.figures()] == [each.title for each in run.figures()]


def test_what_an_analysis_found_can_be_pickled():
    found = wr.fragility(lanes(), max_doubt=1)
    found.figures()
    again = pickle.loads(pickle.dumps(found))
    assert again.table.equals(found.table)


def test_a_near_keyword_is_suggested():
    with pytest.raises(TypeError, match=re.escape("did you mean tolerance?")):
        wr.run("free-b0", tolerence=0.1)


@pytest.mark.parametrize(
    "im", first(2, ["pga", "Peak-Acceleration-m-s2", "PGA", "PEAK_ACCELERATION_M_S2"])
)
def test_an_intensity_measure_is_known_however_it_is_written(im):
    plain = wr.fragility(lanes(), max_doubt=1)
    found = wr.fragility(lanes(), im=im, max_doubt=1)
    assert found.title == plain.title
    assert found.table.equals(plain.table)


@pytest.mark.parametrize("target", ["Table-6", "table_6", "TABLE 6", "table6"])
def test_a_table_of_the_paper_is_known_however_it_is_written(target):
    assert written_as(target, TARGETS) == "table6"
    assert written_as("single_block", TARGETS) == "single-block"
    assert written_as("table-66", TARGETS) == "table-66"


def test_a_table_is_asked_for_where_nobody_has_loaded_pandas(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delitem(sys.modules, "pandas", raising=False)
    with pytest.raises(InputError, match=r"keys: got 3, must be a dict or a DataFrame"):
        wr.Sweep(3)  # type: ignore[arg-type]
    assert "pandas" not in sys.modules
    assert list(wr.Sweep({"block.height": ["1 m"]})) == ["block.height"]
