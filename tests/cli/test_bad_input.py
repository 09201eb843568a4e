"""Bad input ends in one line, soon, with exit code 2 and nothing written."""

from __future__ import annotations

import dataclasses
import json
import os
import pathlib
from typing import Any

import numpy as np
import pandas as pd
import pytest
from click.testing import Result

from tests.shared.blocks import make_lanes, sines
from tests.shared.commands import invoke
from warprock.case.load import load_case
from warprock.case.text import parse_case
from warprock.errors import InputError, list_allowed
from warprock.model.motion import Control, StillBase
from warprock.model.response import SampleTimes
from warprock.recordings.loading import read_channels
from warprock.running.batch import run_batch
from warprock.running.results import list_results

DEEP = 5000


def refused(*arguments: object) -> str:
    """The one line that a command says."""
    result: Result = invoke(*arguments)
    assert result.exit_code == 2, result.output
    assert isinstance(result.exception, SystemExit)
    (line,) = result.stderr.splitlines()
    assert line.startswith("error: ")
    assert len(line) < 600
    return line


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * DEEP + "]" * DEEP,
        "a = " + "{b = " * DEEP + "1" + "}" * DEEP,
        ".".join("a" * DEEP) + " = 1",
        "[" + ".".join("a" * DEEP) + "]",
    ],
    ids=["list", "inline table", "key", "table"],
)
def test_what_nests_without_end_is_refused(text: str):
    with pytest.raises(InputError, match="at most 16 tables or lists inside one another"):
        parse_case(text, "case.toml")
    key, _, value = text.partition(" = ")
    assert "inside one another" in refused("run", "free-b0", "-s", f"{key}={value or 1}")


def test_lines_end_as_toml_says():
    with pytest.raises(InputError, match="LF or CRLF"):
        parse_case('# a comment\rtitle = "t"\r', "case.toml")
    assert parse_case('# a comment\r\ntitle = "t"\r\n', "case.toml") == {"title": "t"}


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("run.sample_interval=1e-12 s", "less than 1,000,000 samples of 20 s"),
        ("contact.friction=" + "9" * 400, "and finite"),
        ("engines.impulse.substeps=0x" + "f" * 5000, "must be from 0 to 10000"),
        ("title=\u0007", "without control characters"),
        ("block.widht=1", "did you mean width?"),
        ("bloc.width=1", "block, "),
        ("block.width=1" + " " * 10**5 + "m", "must be a length"),
        ("block.7.width=1 m", "-s: block.7: "),
    ],
)
def test_values_that_no_run_could_hold_are_one_line(override: str, words: str):
    assert words in refused("run", "free-b0", "-s", override)


def test_a_stack_is_numbered_before_it_is_read():
    assert "-s: block.21: " in refused("explain", "stack-sine-pulse", "-s", "block.21.width=1 m")
    assert "-s: block.width: " in refused("explain", "stack-sine-pulse", "-s", "block.width=1 m")


def test_more_lanes_than_memory_holds_are_a_sweep():
    line = refused("run", "record-sample", "-s", "sample.lanes=100000000")
    assert "at most 5,000,000 lanes" in line
    assert "some 100 GB" in line
    assert "warprock sweep" in line
    grid = '{"block.width" = {from = "1 m", to = "2 m", count = 1000000}}'
    other = grid.replace("width", "depth")
    line = refused("run", "free-b0", "-s", f"sweep=[{grid}, {other}]")
    assert "1,000,000,000,000 lanes" in line


def test_the_nearest_names_are_listed():
    known = [f"name_{letter}" for letter in "abcdefghijkl"] + ["width", "motion.frequency"]
    assert list_allowed("widht", known).startswith("width, ")
    assert list_allowed("motion.freqency", known).startswith("motion.frequency, ")
    assert list_allowed("x", known).endswith(" and 9 more")
    assert list_allowed("x", "abc") == "a, b, c"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes that are files")
def test_a_pipe_is_never_waited_for(tmp_path: pathlib.Path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    (tmp_path / "plan.json").symlink_to(pipe)
    given = ("-s", "motion.waveform=record", "-s", f"motion.record={pipe}")
    assert "a pipe" in refused("run", "free-b0", *given)
    assert "a pipe" in refused("records", "info", pipe)
    assert "a pipe" in refused("run", pipe)
    assert "a pipe" in refused("sweep", "status", tmp_path)
    assert "a pipe" in refused("fragility", pipe)


def test_files_and_folders_are_not_taken_for_one_another(tmp_path: pathlib.Path):
    (tmp_path / "lanes.parquet").mkdir()
    assert "a folder named lanes.parquet" in refused("run", "free-b0", "-o", tmp_path)
    record = "ridgecrest-2019-ccc-090"
    assert "not a folder" in refused("records", "import", record, "-o", tmp_path)
    assert "a folder" in refused("records", "info", tmp_path)


@pytest.mark.parametrize("workers", ["0", "-1", "1025", "1000000000"])
def test_workers_are_bounded(workers: str):
    assert "at least 1 and at most 1024" in refused("run", "free-b0", "--workers", workers)


@pytest.mark.parametrize(
    "change",
    [
        {"case_folder": 5},
        {"chunk_lanes": "9"},
        {"chunk_lanes": 0},
        {"chunk_lanes": True},
        {"content": []},
        {"content": {"lanes": float("nan")}},
        {"id": None},
    ],
)
def test_a_plan_of_another_form_is_refused(change: dict[str, Any], tmp_path: pathlib.Path):
    file = tmp_path / "plan.json"
    plan = {"id": "x", "chunk_lanes": 1, "case_folder": None, "content": {}} | change
    file.write_text(json.dumps(plan), encoding="utf-8")
    assert str(file) in refused("sweep", "status", tmp_path)


@pytest.mark.parametrize(
    "text", ["[" * DEEP, "[" * DEEP + "]" * DEEP, "5", "null", '{"a": [[[]]]}']
)
def test_a_plan_that_is_none_is_refused(text: str, tmp_path: pathlib.Path):
    (tmp_path / "plan.json").write_text(text, encoding="utf-8")
    for command in ("status", "run", "merge"):
        assert "plan.json" in refused("sweep", command, tmp_path)


def lane_table(**columns: object) -> pd.DataFrame:
    """A lane table of three lanes, with other columns."""
    plain = {
        "peak_acceleration_m_s2": [1.0, 2.0, 3.0],
        "peak_rotation_ratio": [0.1, 0.2, 0.3],
        "uplift_time_s": [np.nan, 0.1, 0.1],
        "outcome": ["at_rest"] * 3,
        "status": ["ok"] * 3,
    }
    table = {**plain, **columns}
    return pd.DataFrame({name: values for name, values in table.items() if values is not None})


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"peak_rotation_ratio": None}, "peak_rotation_ratio: got nothing"),
        ({"peak_rotation_ratio": ["a", "b", "c"]}, "must be a column of numbers"),
        ({"peak_rotation_ratio": [0.1, np.inf, 0.2]}, "(row 1)"),
        ({"uplift_time_s": ["a", "b", "c"]}, "must be a column of numbers"),
        ({"outcome": ["at_rest", "flew_away", "at_rest"]}, "got 'flew_away', must be one of at_r"),
        ({"outcome": [0, 1, 2]}, "must be one of at_rest"),
        ({"status": ["ok", "fine", "ok"]}, "got 'fine'"),
        ({"peak_acceleration_m_s2": [1.0, np.inf, 2.0]}, "(row 1)"),
        ({"record": [["a"], ["b"], ["c"]]}, "must hold texts or numbers"),
    ],
)
def test_a_table_that_is_no_lane_table_is_refused(
    columns: dict[str, Any], words: str, tmp_path: pathlib.Path
):
    file = tmp_path / "lanes.parquet"
    lane_table(**columns).to_parquet(file)
    assert words in refused("fragility", file)


def test_files_that_are_no_tables_are_refused(tmp_path: pathlib.Path):
    file = tmp_path / "lanes.parquet"
    for content in (b"", b"PAR1" + bytes(50) + b"PAR1", b"lane,status\n"):
        file.write_bytes(content)
        assert "must be a Parquet file" in refused("fragility", file)
    lane_table().iloc[:0].to_parquet(file)
    assert "at least one lane" in refused("fragility", file)


def test_a_setting_is_given_once():
    line = refused("compare", "free-b0", "-e", "event@time_step=1e-3,time_step=1e-2")
    assert "time_step" in line
    assert "once" in line


def test_a_header_says_a_thing_once():
    head = "# unit: m/s^2\n# interval: 0.01 s\n"
    read_channels("a.csv", f"{head}# note: a\n# note: b\n1\n2\n".encode())
    with pytest.raises(InputError, match=r"line 3: .* must not give unit a second time"):
        read_channels("a.csv", f"{head}# unit: cm/s^2\n1\n2\n".encode())


def test_samples_are_as_many_as_the_header_says():
    head = "PEER NGA\nEvent, 1, 90\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 4, DT= .01 SEC\n"
    read_channels("a.at2", f"{head}.1 .2 .3 .4\n\n".encode())
    with pytest.raises(InputError, match=r"line 5: got '\.5', must not follow the 4 samples"):
        read_channels("a.at2", f"{head}.1 .2 .3 .4 .5\n".encode())


def bad_lanes() -> list[tuple[str, dict[str, Any], dict[str, Any], str]]:
    """Fields of three lanes and of their motions that are wrong, and what is said."""
    three, two = np.ones(3), np.ones(2)
    return [
        ("negative", {"width": np.array([0.3, -0.3, 0.3])}, {}, r"lanes.width: got -0.3, .*lane 1"),
        ("no height", {"height": 0.0 * three}, {}, r"lanes.height: got 0.0, must be more than 0"),
        ("short", {"height": two}, {}, r"lanes.height: got \[2\], the shape .* \[3\]"),
        ("flat", {"friction": np.ones((3, 2))}, {}, r"lanes.friction: got \[3, 2\]"),
        ("no number", {"friction": np.array([1.0, np.nan, 1.0])}, {}, r"finite \(lane 1\)"),
        ("list", {"depth": [1.0, 1.0, 1.0]}, {}, r"lanes.depth: got 'list', must be a NumPy array"),
        ("text", {"depth": np.array(["a"] * 3)}, {}, r"lanes.depth: got '<U1'"),
        (
            "lying",
            {"rotation_start": 2.0 * three},
            {},
            "rotation_start: got 2.0, must be less than",
        ),
        ("motion", {}, {"frequency": -three}, r"motions.frequency: got -1.0, must be more than 0"),
        ("short motion", {}, {"start": two}, r"motions.lane_count: got 2, must be as many as the"),
        ("motion nan", {}, {"phase": np.nan * three}, r"motions.phase: got nan, must be finite"),
    ]


@pytest.mark.parametrize(("lanes", "motion", "said"), [row[1:] for row in bad_lanes()])
def test_arrays_that_no_engine_could_run_are_refused(
    lanes: dict[str, Any], motion: dict[str, Any], said: str
):
    good = make_lanes(np.full(3, 0.3), 1.0)
    motions = sines(Control.ACCELERATION, np.full(3, 2.0), 2.0, cycles=1.0)
    with pytest.raises(InputError, match=said):
        run_batch(
            "housner",
            dataclasses.replace(good, **lanes),
            dataclasses.replace(motions, **motion),
            SampleTimes(0.5),
        )


def test_options_of_a_batch_are_bounded():
    lanes = make_lanes(np.full(3, 0.3), 1.0)
    motions = sines(Control.ACCELERATION, np.full(3, 2.0), 2.0, cycles=1.0)
    with pytest.raises(InputError, match="workers: got 0"):
        run_batch("housner", lanes, motions, SampleTimes(0.5), workers=0)
    with pytest.raises(InputError, match="chunk_size: got 0"):
        run_batch("housner", lanes, motions, SampleTimes(0.5), chunk_size=0)
    with pytest.raises(ValueError, match="GB a history"):
        SampleTimes(20.0, 1e-12)
    with pytest.raises(InputError, match="4 GB, in the histories of all blocks"):
        run_batch("housner", make_lanes(np.full(50, 0.3), 1.0), StillBase(50), SampleTimes(1, 1e-7))


def test_a_folder_holds_one_set_of_results(tmp_path: pathlib.Path):
    old, kept, changed, own = (
        tmp_path / f"{name}.csv" for name in ("old", "kept", "changed", "own")
    )
    for file in (old, kept, changed, own):
        file.write_text("before", encoding="utf-8")
    assert list_results(tmp_path, [old, kept, changed]) == []
    changed.write_text("by the user", encoding="utf-8")
    kept.write_text("after", encoding="utf-8")
    assert list_results(tmp_path, [kept], beside=True) == []
    assert old.exists()
    assert list_results(tmp_path, [kept]) == ["old.csv"]
    assert [file.exists() for file in (old, kept, changed, own)] == [False, True, True, True]


def test_a_list_of_results_names_nothing_elsewhere(tmp_path: pathlib.Path):
    folder, outside = tmp_path / "results", tmp_path / "mine.csv"
    folder.mkdir()
    outside.write_text("mine", encoding="utf-8")
    (folder / ".warprock.json").write_text('{"../mine.csv": "0", "a": 5}', encoding="utf-8")
    assert list_results(folder, []) == []
    assert outside.exists()


def no_screen() -> None:
    """Takes back the screen that Matplotlib was given, or other tests in this process lack one."""
    import matplotlib

    matplotlib.rcParams["backend"] = "agg"


def test_labels_are_drawn_as_they_are_written(tmp_path: pathlib.Path, monkeypatch, request):
    # As a notebook sets it: Matplotlib itself may refuse it.
    monkeypatch.setenv("MPLBACKEND", "module://no_such_screen")
    request.addfinalizer(no_screen)
    from warprock.figures.drawing import Drawing, write_drawings
    from warprock.figures.scales import logarithmic
    from warprock.figures.sheet import style, subplots

    with style():
        figure, grid = subplots(1, 1, (4.0, 3.0))
        axes = grid[0, 0]
        axes.set_title("$\\foo$ 5 $ and 6 $ a\\b")
        logarithmic(axes.yaxis)
        axes.plot([1, 2], [1e-3, 1e3], label="$x_$")
        axes.legend()
    write_drawings([Drawing("a", figure, "$5", "$6")], tmp_path)
    assert (tmp_path / "a.png").stat().st_size > 0
    assert os.environ["MPLBACKEND"] == "module://no_such_screen"


def test_a_case_of_many_lanes_is_still_explained():
    case = load_case("record-sample", ["sample.lanes=100000000"])
    from warprock.running.catalogue import explain_case

    found = explain_case(case)
    assert found["lanes"] == 100_000_000
    assert found["inputs_of_lanes"] == 100_000


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("view", "free-b0", "--port", "abc"), "--port: got 'abc', must be a whole number, at lea"),
        (("view", "free-b0", "--port", 70000), "and at most 65535"),
        (("animate", "free-b0", "--speed", "x"), "--speed: got 'x', must be a number"),
        (("animate", "free-b0", "--speed", "nan"), "--speed: got nan, must be above 0 and at most"),
        (("viw", "free-b0"), "Did you mean 'view'? See "),
        (("ida", "free-b0", "--count", "2.5"), "--count: got '2.5', must be a whole number"),
        (("verdict", "--body", "statue", "--record", "nope"), "--record: got 'nope', must be a fi"),
    ],
)
def test_a_value_of_an_option_is_named_with_its_bound(arguments: tuple[object, ...], said: str):
    assert said in refused(*arguments)
