"""Cases with a [study]: what may be written, what is run, what is said and written."""

from __future__ import annotations

import io
import json

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from tests.shared.commands import invoke
from warprock.case.load import load_case
from warprock.case.text import case_names
from warprock.engines.launching import Form
from warprock.errors import InputError
from warprock.running.batch import run_batch
from warprock.settings.engines import ImpulseSettings
from warprock.tables.study import print_study, print_study_run
from warprock.tables.terminal import plain_console
from warprock.verification.checks import compare, run_checks
from warprock.verification.housner import compare_with_housner
from warprock.verification.study import COLUMNS, run_count, run_study

BODY = """
title = "A block and two solvers"
source = "made up"
[block]
width = "0.5 m"
height = "1 m"
depth = "0.5 m"
density = "2000 kg/m^3"
[contact]
friction = 1.0
[start]
rotation_ratio = 0.5
[run]
duration = "1 s"
sample_interval = "10 ms"
[[sweep]]
label.reading = ["low", "high"]
block.height = ["1 m", "1.2 m"]
"""
STUDY = """
[engines.impulse]
iterations = 10
[study]
engines = ["impulse", "direct"]
[study.vary]
substeps = [2, 20]
collision_margin = [1e-8, 1e-3]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("study")


@pytest.fixture(scope="module")
def file(folder):
    path = folder / "case.toml"
    path.write_text(BODY + STUDY, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def case(file):
    return load_case(file)


@pytest.fixture(scope="module")
def study(case):
    return run_study(case)


def printed(rows, case, width: int = 80) -> str:
    console = plain_console(file=io.StringIO(), width=width)
    print_study(console, rows, case)
    return console.file.getvalue()


def test_one_setting_at_a_time_leaves_the_cases_own(case):
    own = case.engine_settings("impulse")
    assert own == ImpulseSettings(iterations=10)
    runs = case.study.variations("impulse")
    assert [(run.setting, run.value, run.baseline, run.unit) for run in runs] == [
        ("substeps", 2, False, "-"),
        ("substeps", 20, True, "-"),
        ("collision_margin", 1e-8, True, "m"),
        ("collision_margin", 1e-3, False, "m"),
    ]
    for run in runs:
        assert (run.settings == own) is run.baseline
        assert getattr(run.settings, run.setting) == run.value
    assert run_count(case) == 3 + 2
    assert run_count(case, "direct") == 2


def test_a_setting_that_an_engine_lacks_is_left_out_of_its_runs(case):
    assert case.study.lacks("impulse") == []
    assert case.study.lacks("direct") == ["collision_margin"]
    assert {run.setting for run in case.study.variations("direct")} == {"substeps"}


OF_DIRECT = '[study]\nengines = ["direct"]\n'
VARY = f"{OF_DIRECT}[study.vary]\n"
REFUSED = [
    ("study = 3", "study", 3, "must be a table"),
    ("[study]\nengine = []", "study.engine", [], "did you mean engines?"),
    ("[study]", "study.engines", "nothing", "must be a list of engines"),
    ("[study]\nengines = []", "study.engines", [], "must be a list of engines"),
    ('[study]\nengines = ["impuls"]', "study.engines[0]", "impuls", "did you mean impulse?"),
    ("[study]\nengines = [[]]", "study.engines[0]", [], "must be one of housner, impulse"),
    ('[study]\nengines = ["dem", "dem"]', "study.engines[1]", "dem", "must not be there twice"),
    (OF_DIRECT, "study.vary", "nothing", "must be a table"),
    (f"{OF_DIRECT}vary = {{}}", "study.vary", {}, "must be a table"),
    (f"{VARY}substep = [2, 20]", "study.vary.substep", [2, 20], "did you mean substeps?"),
    (f"{VARY}iterations = [2]", "study.vary.iterations", [2], "must be a setting of direct ("),
    (f"{VARY}compliance = [0, 1]", "study.vary.compliance", [0, 1], "; xpbd has it"),
    (
        VARY.replace('["', '["impulse", "') + "iterations = [2, 10]",
        "study.engines",
        "direct",
        "must have a setting that is varied (iterations)",
    ),
    (f"{VARY}substeps = 2", "study.vary.substeps", 2, "must be a list of at least 2 values"),
    (f"{VARY}substeps = [20]", "study.vary.substeps", [20], "must be a list of at least 2 values"),
    (f"{VARY}substeps = [20, -1]", "study.vary.substeps[1]", -1, "from 0 to 10000 (direct)"),
    (f"{VARY}substeps = [20, 2.5]", "study.vary.substeps[1]", 2.5, "a whole number (direct)"),
    (f"{VARY}substeps = [20, 20]", "study.vary.substeps[1]", 20, "must not be there twice"),
    (
        f"{VARY}substeps = [2, 200]",
        "study.vary.substeps",
        [2, 200],
        "must hold the case's own value, 20 (engines.direct.substeps)",
    ),
]


@pytest.mark.parametrize(("written", "key", "got", "allowed"), REFUSED)
def test_what_cannot_be_studied_is_refused_by_key(written, key, got, allowed, tmp_path):
    path = tmp_path / "case.toml"
    table, _, _ = written.partition("\n")
    body = f"{table}\n{BODY}" if table == "study = 3" else f"{BODY}\n{written}\n"
    path.write_text(body, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_case(path)
    error = caught.value
    assert (error.source, error.key) == (str(path), key)
    assert error.got == got
    assert allowed in error.allowed
    assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("change", "key", "allowed"),
    [
        (("sample_interval", "#"), "run.sample_interval", "must be given for [study]"),
        (
            ("[[sweep]]", '[ensemble]\nmembers = 4\ntime_step = "5 %"\n[[sweep]]'),
            "study",
            "must not be beside [ensemble]",
        ),
        (
            ('height = ["1 m"', '1.height = ["1 m"'),
            "study",
            "must not be on a stack",
        ),
    ],
)
def test_lanes_that_housner_cannot_be_held_against_are_refused(change, key, allowed, tmp_path):
    text = BODY.replace(*change)
    if "stack" in allowed:
        text = text.replace("[block]", "[block.1]").replace("[start]\nrotation_ratio = 0.5\n", "")
    path = tmp_path / "case.toml"
    path.write_text(text + STUDY, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_case(path)
    assert (caught.value.key, allowed in caught.value.allowed) == (key, True)


def test_an_override_asks_for_other_values_and_the_cases_own_is_added(file):
    changed = load_case(file, ["study.vary.substeps=[5,10]"])
    assert changed.study.values["impulse"]["substeps"] == (5, 10, 20)
    changed = load_case(file, ["engines.direct.substeps=7"])
    assert changed.study.values["direct"]["substeps"] == (2, 20, 7)
    assert changed.study.values["impulse"]["substeps"] == (2, 20)
    with pytest.raises(InputError, match=r"^-s: study.vary.substeps\[0\]: got 'two'"):
        load_case(file, ["study.vary.substeps=['two', 3]"])


def test_a_run_of_a_study_is_the_engines_run(study):
    """As the batch runner gives it, held against Housner as `compare` does."""
    lane_set = study.lane_set
    given = (lane_set.lanes, lane_set.motions, lane_set.times)
    reference = run_batch("housner", *given)
    settings = ImpulseSettings(iterations=10, substeps=2)
    response = run_batch("impulse", *given, settings=settings, form=Form.PLAIN)
    expected = compare_with_housner(lane_set, response, reference)
    found = study.table.query("engine == 'impulse' and setting == 'substeps' and value == 2")
    for column in ("error_5s_ratio", "error_run_ratio", "peak_rotation_ratio", "holds"):
        np.testing.assert_array_equal(found[column], expected[column])
    ratio = response["rotation"][-1] / lane_set.lanes.slenderness_angle[-1]
    np.testing.assert_array_equal(study.histories["impulse", "substeps", 2], ratio)


def test_the_baseline_is_one_run_whatever_is_varied(study):
    own = study.table[study.table["baseline"]]
    assert len(own) == 2 * (2 + 1)
    assert (own["baseline_difference_ratio"] == 0.0).all()
    for _, rows in own.groupby(["engine", "lane"]):
        for column in ("error_run_ratio", "cpu_s", "step_count"):
            assert rows[column].nunique() == 1
    assert (study.table[~study.table["baseline"]]["baseline_difference_ratio"] > 0.0).all()


def test_the_error_is_of_the_order_of_the_step(study):
    """Seven times the step in 1 s: several times the error, which chance can halve or double."""
    table = study.table[study.table["setting"] == "substeps"]
    for _, rows in table.groupby(["engine", "lane"]):
        coarse, fine = rows.sort_values("value")["error_run_ratio"]
        assert coarse > 2.0 * fine
        steps = rows.sort_values("value")["time_step_s"]
        assert steps.iloc[0] / steps.iloc[1] == pytest.approx(7.0, rel=1e-12)


def test_one_engine_alone_gives_the_same_rows(case, study):
    alone = run_study(case, "direct")
    assert alone.engines == ("direct",)
    both = study.table[study.table["engine"] == "direct"].reset_index(drop=True)
    pd.testing.assert_frame_equal(
        alone.table.drop(columns="cpu_s"), both.drop(columns="cpu_s"), check_exact=True
    )
    with pytest.raises(InputError, match=r"--engine: got 'event', must be an engine of the study"):
        run_study(case, "event")


def test_an_engine_that_cannot_do_the_scene_is_refused_before_anything_runs(file):
    given = load_case(file, ["contact.angular_restitution=0.9"])
    done = []
    with pytest.raises(InputError, match="cannot do this scene"):
        run_study(given, finished=done.append)
    assert done == []


@pytest.mark.thorough
@pytest.mark.usefixtures("pages_bare")
def test_run_writes_the_table_with_units_where_from_and_figures(file, folder):
    result = invoke("run", file, "-o", folder / "out", "--json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    names = ["study.parquet", "study.csv", "run.json", "study.png", "histories.png", "report.html"]
    assert found["files"] == [str(folder / "out" / name) for name in names]
    names.append(".warprock.json")
    assert sorted(path.name for path in (folder / "out").iterdir()) == sorted(names)
    table = pd.read_csv(folder / "out" / "study.csv")
    assert len(found["rows"]) == len(table) == 2 * (4 + 2)
    schema = pq.read_schema(folder / "out" / "study.parquet")
    assert schema.names == list(table.columns)
    for name, (unit, text) in COLUMNS.items():
        meta = schema.field(name).metadata
        assert (meta[b"unit"].decode(), meta[b"text"].decode()) == (unit, text)
        assert name.endswith("_s") is (unit == "s")
    where_from = json.loads((folder / "out" / "run.json").read_text(encoding="utf-8"))
    assert where_from["case"]["resolved"]["study"]["vary"]["substeps"] == [2, 20]
    assert len(where_from["runs"]) == 4 + 2
    assert where_from["runs"][0]["settings"]["substeps"] == 2
    assert where_from["kernel_sha256"] == found["kernel_sha256"]


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (("--history", "0"), "--history: got [0]"),
        (("--estimate",), "--estimate: got True"),
        (("--cheapest",), "--cheapest: got True"),
        (("-e", "xpbd"), "--engine: got 'xpbd', must be an engine of the study (impulse, direct)"),
        (("--workers", "0"), "--workers: got 0"),
    ],
)
def test_options_that_a_study_has_no_use_for_are_refused(options, named, file, tmp_path):
    result = invoke("run", file, *options, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert named in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_run_prints_a_table_an_engine(file):
    result = invoke("run", file, "-e", "direct", "--no-estimate")
    assert result.exit_code == 0, result.output
    assert "direct: one setting at a time, against Housner" in " ".join(result.stdout.split())
    assert "impulse: one" not in result.stdout
    assert "direct has no collision_margin." in result.stdout
    assert "lane 0: low; lane 1: high" in result.stdout


def test_the_tables_fit_an_80_column_terminal(study, case):
    text = printed(study.rows, case)
    assert "…" not in text
    assert all(len(line) <= 80 for line in text.splitlines())
    assert text.count("20*") == 2
    assert "Peak rotation / slenderness angle of low: 0.5000 in all runs." in text
    assert printed([], case) == ""


def test_many_lanes_are_printed_by_the_largest(study, case):
    third = [row | {"lane": 2, "error_run_ratio": 0.5} for row in study.rows if row["lane"] == 1]
    text = printed(study.rows + third, case)
    assert text.split().count("0.50") == len(third)
    assert "The largest of 3 lanes each, those where Housner holds." in text
    failing = [row | {"holds": False, "why": "slides 3 mm"} for row in third]
    text = printed(study.rows + failing, case)
    assert "0.50" not in text.split()
    assert "direct: Housner does not hold in 1 of 3 lanes: slides by more than" in text


def test_where_housner_does_not_hold_is_said(study, case):
    rows = [dict(row) for row in study.rows]
    rows[0] |= {"holds": False, "why": "slides 3 mm; status unstable", "error_run_ratio": 0.5}
    text = printed(rows, case)
    assert "impulse: Housner does not hold in 1 of 2 lanes: slides by more than" in text
    assert "status unstable" in text
    assert "0.50" in text.split()


def test_the_whole_print_names_the_case(study, case):
    console = plain_console(file=io.StringIO(), width=100)
    print_study_run(study, console)
    text = console.file.getvalue()
    assert text.startswith(f"{case.name}: {case.title}")


def test_explain_says_what_will_be_run(file):
    found = json.loads(invoke("explain", file, "--json").stdout)["study"]
    assert [(plan["engine"], plan["runs"], plan["lacks"]) for plan in found] == [
        ("impulse", 3, []),
        ("direct", 2, ["collision_margin"]),
    ]
    text = invoke("explain", file).stdout
    assert "collision_margin [m]: 1e-08, 0.001 (the case's own: 1e-08)" in text
    assert "it has no collision_margin" in text
    assert json.loads(invoke("explain", "free-b0", "--json").stdout)["study"] is None


def test_check_and_compare_run_the_cases_own_settings(file, study):
    check = '[[check]]\nkind = "housner"\nengine = "direct"\nlimit_5s = 1e-2\nbecause = "so"\n'
    path = file.with_name("checked.toml")
    path.write_text(BODY + STUDY + check, encoding="utf-8")
    own = study.table.query("engine == 'direct' and baseline")["error_5s_ratio"]
    (row,) = run_checks(load_case(path))
    # The packed kernel and the plain one differ by round-off.
    assert row.value == pytest.approx(own.max(), rel=1e-6)
    assert row.ok
    rows = compare(load_case(path), ["direct"])["rows"]
    np.testing.assert_allclose([r["error_5s_ratio"] for r in rows], own, rtol=1e-6)


def test_the_shipped_study_is_the_papers_tables_1_and_2():
    assert "sensitivity-b0" in case_names()
    study = load_case("sensitivity-b0").study
    values = study.values["impulse"]
    assert values == {
        "substeps": (2, 20, 200),
        "frames_per_second": (10.0, 50.0, 240.0),
        "collision_margin": (1e-3, 1e-5, 1e-6),
        "iterations": (10, 100, 1000),
    }
    assert study.values["direct"] == {k: values[k] for k in ("substeps", "frames_per_second")}
    own = study.baseline["impulse"]
    assert (own.iterations, own.substeps, own.frames_per_second) == (1000, 200, 240.0)
    assert own.collision_margin == 1e-6
    assert (study.baseline["direct"].substeps, run_count(load_case("sensitivity-b0"))) == (200, 14)
