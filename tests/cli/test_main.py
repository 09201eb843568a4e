"""The command line: what it refuses, what it prints where, what it leaves, how it exits."""

from __future__ import annotations

import importlib
import json
import math
import os
import pathlib
import pkgutil
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

import click
import pandas as pd
import pytest
from click.shell_completion import ShellComplete
from click.testing import Result

import warprock.cli
from tests.shared.blocks import single_block_engines
from tests.shared.commands import invoke, succeed
from tests.shared.marks import all_but, first
from tests.shared.shipped import RUNNABLE_CASES
from warprock.case.case import Case
from warprock.case.load import load_case
from warprock.case.text import case_names, template_kinds
from warprock.cli.main import main
from warprock.engines import ENGINES
from warprock.running import catalogue

Python = Callable[..., subprocess.CompletedProcess[str]]

FREE = """
title = "A block let go"
source = "made up"
[block]
width = "0.5 m"
height = "2 m"
depth = "0.5 m"
density = "2000 kg/m^3"
[contact]
friction = 1.0
[start]
rotation_ratio = 0.3
[run]
duration = "1 s"
sample_interval = "50 ms"
"""
RECORD = """
[motion]
waveform = "record"
record = "shake.csv"
"""
HEAVY = ("warp", "newton", "matplotlib", "pandas", "pydantic", "numpy", "pyarrow", "rich")
HEAVY += ("scipy", "scipy.integrate", "scipy.optimize", "scipy.sparse", "scipy.special")
HEAVY += ("scipy.linalg", "scipy.signal", "scipy.stats")
HEAVY += ("warprock.cli.sweep", "warprock.settings.programs")


@pytest.fixture
def case(tmp_path: pathlib.Path) -> pathlib.Path:
    file = tmp_path / "case.toml"
    file.write_text(FREE, encoding="utf-8")
    return file


def refused(result: Result, *words: str) -> None:
    """Exit code 2, one line on stderr that holds some words, nothing on stdout."""
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    line = result.stderr.rstrip("\n")
    assert "\n" not in line, line
    assert line.startswith("error: ")
    for word in words:
        assert word in line, f"{word!r} is not in {line!r}"


READS_MORE = (
    *("cube-tosses", "square-drops", "record-sample", "sobol-single-block", "single-spatial-sine"),
    *("stack-collapse", "stack-continuous-sine-ensemble", "stack-sine-pulse-ensemble"),
    "stack-spatial-sine",
)
"""Shipped cases with a table of lanes, which pandas reads, or with points that SciPy draws."""
EXPLAIN = f"""
from warprock.running import engine_choice
engine_choice.outside_model = lambda *_: 0  # which runs lanes that may leave Housner's model
for name in {[name for name in RUNNABLE_CASES if name not in READS_MORE]}:
    main(['explain', name], standalone_mode=False)
"""


@pytest.mark.parametrize(
    ("does", "needs"),
    [
        ("main(['--help'], standalone_mode=False)", set()),
        (
            "main(['run', 'free-b0'], standalone_mode=False)",
            {"rich", "pydantic", "numpy", "warp"},
        ),
        *first(
            1,
            [
                (EXPLAIN, {"rich", "pydantic", "numpy"}),
                ("main(['list'], standalone_mode=False)", {"rich", "numpy"}),
                ("import warprock; warprock.Case; warprock.run", {"pydantic", "numpy"}),
                (
                    "import warprock.paper.reproduce, warprock.paper.print_tables, "
                    "warprock.paper.page, warprock.report.writing",
                    {"rich", "pydantic", "numpy", "warprock.settings.programs"},
                ),
                (
                    "import warprock.findings.kinds as p; p.kinds()",
                    {"rich", "pydantic", "numpy", "pandas", "pyarrow", "warp", "scipy"}
                    | {"warprock.settings.programs"},
                ),
            ],
        ),
    ],
    ids=["help", "run", "explain", "list", "import", "table", "kinds"],
)
def test_the_command_line_starts_without_anything_heavy(does: str, needs: set[str], python: Python):
    used = f"print('uses:', *(set({HEAVY!r}) & sys.modules.keys()))"
    done = python("-c", f"import sys; from warprock.cli.main import main\n{does}\n{used}")
    assert done.returncode == 0, done.stderr
    assert set(done.stdout.split("uses:")[-1].split()) <= needs


def test_a_command_ends_without_a_last_look_for_garbage(python: Python):
    told = "import atexit, gc, sys; atexit.register(lambda: print(gc.get_freeze_count() > 0))"
    asked = "sys.argv = ['warprock', '--version']; from warprock.cli.main import entry; entry()"
    done = python("-c", f"{told}; {asked}")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "True"


def test_python_m_warprock_is_the_command_line(python: Python):
    done = python("-m", "warprock", "--version")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("warprock, version ")


# What is written in a case, what is replaced by what, and the words that the error must hold:
# the key, the value and the bound.
BAD_CASES = {
    "missing unit": ('"2 m"', "2.0", ("block.height", "2.0", "length with a unit")),
    "negative height": ('"2 m"', '"-2 m"', ("block.height", "-2 m", "must be")),
    "wrong unit": ('"2 m"', '"2 s"', ("block.height", "2 s", "length with a unit")),
    "unknown key": ("height =", "heigth =", ("block.heigth", "height")),
    "unknown table": ("[contact]", "[contacts]", ("contacts", "contact")),
    "beyond the angle": ("0.3", "1.5", ("start.rotation_ratio", "1.5", "1")),
    "no duration": ('"1 s"', '"0 s"', ("run.duration", "0 s")),
    "no friction": ("friction = 1.0", "friction = nan", ("contact.friction", "nan")),
    "broken text": ("[block]", "[block", ("[block", "TOML")),
    "zero lanes": (
        "[run]",
        "[[sweep]]\nblock.height = []\n[run]",
        ("sweep[0].block.height", "[]"),
    ),
    "empty grid": (
        "[run]",
        '[[sweep]]\nblock.height = { from = "1 m", to = "2 m", count = 0 }\n[run]',
        ("sweep[0].block.height", "0"),
    ),
    "unknown setting": (
        "[run]",
        "[engines.impulse]\nsubstep = 20\n[run]",
        ("engines.impulse.substep", "20", "substeps"),
    ),
    "setting beyond its bound": (
        "[run]",
        "[engines.impulse]\niterations = 0\n[run]",
        ("engines.impulse.iterations", "0", "from 1 to"),
    ),
}


@pytest.mark.parametrize("name", BAD_CASES)
def test_a_bad_case_is_one_line_and_nothing_is_written(name: str, case: pathlib.Path):
    before, after, words = BAD_CASES[name]
    text = FREE.replace(before, after, 1)
    assert text != FREE
    case.write_text(text, encoding="utf-8")
    result = invoke("run", case, "-o", case.parent / "results")
    refused(result, str(case), *words)
    assert [path.name for path in case.parent.iterdir()] == ["case.toml"]


BAD_OPTIONS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "engine": (("-e", "bullet"), ("--engine", "bullet", *ENGINES)),
    "precision": (("--precision", "float16"), ("--precision", "float16", "float64, float32")),
    "device": (("--device", "cuda:77"), ("--device", "cuda:77", "cpu")),
    "workers": (("--workers", "0"), ("--workers", "0", "at least 1")),
    "history": (("--history", "1"), ("--history", "1", "from 0 to 0")),
    "override": (("-s", "block.height"), ("-s", "block.height", "KEY=VALUE")),
    "overridden value": (("-s", "block.height=-1 m"), ("-s", "block.height", "-1 m", "must be")),
    "overridden key": (("-s", "block.tallness=1 m"), ("-s", "block.tallness", "unknown key")),
}


@pytest.mark.parametrize("name", BAD_OPTIONS)
def test_a_bad_option_is_one_line_and_nothing_is_written(name: str, case: pathlib.Path):
    options, words = BAD_OPTIONS[name]
    refused(invoke("run", case, "-o", case.parent / "results", *options), *words)
    assert [path.name for path in case.parent.iterdir()] == ["case.toml"]


@pytest.mark.parametrize("bad", ["nan", "inf", "1,2", "much"])
def test_a_bad_record_is_one_line_and_nothing_is_written(bad: str, case: pathlib.Path):
    case.write_text(FREE + RECORD, encoding="utf-8")
    rows = "\n".join(["0.0", "0.1", bad, "0.1", "0.0"])
    record = f"# unit: m/s^2\n# interval: 0.01 s\n{rows}\n"
    (case.parent / "shake.csv").write_text(record, encoding="utf-8")
    refused(invoke("run", case, "-o", case.parent / "results"), "shake.csv", bad)
    assert sorted(path.name for path in case.parent.iterdir()) == ["case.toml", "shake.csv"]


def test_an_engine_that_cannot_do_the_scene_says_why(case: pathlib.Path):
    options = ("-s", "contact.angular_restitution=0.9", "-o", case.parent / "results")
    refused(invoke("run", case, "-e", "impulse", *options), str(case), "impulse", "restitution")
    assert [path.name for path in case.parent.iterdir()] == ["case.toml"]


@pytest.mark.parametrize("arguments", [("run", "free-b0"), ("reproduce", "table6")])
def test_an_unwritable_folder_is_refused_before_anything_runs(
    arguments: tuple[str, ...], case: pathlib.Path
):
    folder = case / "results"
    refused(invoke(*arguments, "-o", folder), "--output", str(folder), "written to")
    assert case.read_text(encoding="utf-8") == FREE


def test_windows_marks_and_line_ends_change_nothing(case: pathlib.Path):
    plain = invoke("run", case, "--json")
    case.write_bytes(b"\xef\xbb\xbf" + FREE.replace("\n", "\r\n").encode())
    marked = invoke("run", case, "--json")
    assert marked.exit_code == 0, marked.stderr
    assert json.loads(marked.stdout)["rows"] == json.loads(plain.stdout)["rows"]


@pytest.mark.parametrize("seconds", ["nan", "-1", "1e9"])
def test_a_benchmark_has_a_length(seconds: str):
    refused(invoke("bench", "--seconds", seconds), "--seconds", "must be from 0.0 to 3600")


def test_unknown_names_are_one_line_with_what_is_allowed(tmp_path: pathlib.Path):
    for command in ("run", "explain", "check"):
        refused(invoke(command, "free-bO"), "free-bO", "free-b0, free-b1-b3", "warprock list")
    refused(invoke("reproduce", "table99", "-o", tmp_path / "new"), "table99", "table6", "all")
    refused(invoke("compare", "free-b0", "-e", "bulllet"), "bulllet", "bullet")
    refused(invoke("init", "freee", tmp_path / "case.toml"), "freee", *template_kinds())
    refused(invoke("bench", "--workers", "0"), "--workers", "0", "at least 1")
    assert list(tmp_path.iterdir()) == []


def test_a_history_needs_a_folder(case: pathlib.Path):
    refused(invoke("run", case, "--history", "0"), "--history", "--output")


def test_run_prints_one_json_object_on_stdout(case: pathlib.Path):
    done = succeed("run", case, "--json")
    found = json.loads(done.stdout, parse_constant=pytest.fail)
    assert found["engine"]["name"] == "housner"
    assert found["lanes"] == len(found["rows"]) == 1
    # Released from rest the block only loses energy: its peak is its start.
    assert found["rows"][0]["peak_rotation_ratio"] == pytest.approx(0.3, rel=1e-12)
    assert found["files"] == []


@pytest.mark.usefixtures("pages_bare")
def test_run_writes_a_table_that_the_screen_agrees_with(case: pathlib.Path):
    folder = case.parent / "results"
    result = invoke("run", case, "-e", "event", "-o", folder, "--history", 0)
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in folder.iterdir()) == [
        ".warprock.json",
        "histories.png",
        "history-lane-0.csv",
        "lanes.csv",
        "lanes.parquet",
        "peaks.png",
        "report.html",
        "run.json",
    ]
    table = pd.read_parquet(folder / "lanes.parquet")
    assert list(pd.read_csv(folder / "lanes.csv")) == list(table)
    assert_screen_shows(result.stdout, "event", table.iloc[0])


def assert_screen_shows(screen: str, engine: str, row: Mapping[str, Any]) -> None:
    assert f"{row['peak_rotation_ratio']:#.3g}" in screen
    assert row["outcome"] in screen
    assert engine in screen


@pytest.mark.parametrize("engine", all_but(("direct", "xpbd", "dem"), single_block_engines()))
def test_the_screen_shows_what_json_says(engine: str, case: pathlib.Path):
    (row,) = json.loads(invoke("run", case, "-e", engine, "--json").stdout)["rows"]
    assert_screen_shows(invoke("run", case, "-e", engine).stdout, engine, row)


def test_an_override_changes_the_run(case: pathlib.Path):
    result = invoke("run", case, "-s", "start.rotation_ratio=0.4", "--json")
    assert json.loads(result.stdout)["rows"][0]["peak_rotation_ratio"] == pytest.approx(0.4)


def test_init_writes_a_case_and_never_overwrites(tmp_path: pathlib.Path):
    named = re.search(r"KIND is ([^.]*)\.", invoke("init", "--help").output)
    assert named is not None
    assert sorted(re.split(r", +| +or +", " ".join(named[1].split()))) == sorted(template_kinds())
    for kind in template_kinds():
        file = tmp_path / kind / "case.toml"
        result = invoke("init", kind, file)
        assert result.exit_code == 0, result.output
        assert result.stdout.splitlines()[0] == str(file)
        limits = dict.fromkeys(("arch", "corner", "vault"), "limit")
        command = {"map": "map", "spectrum": "spectrum", **limits}.get(kind, "run")
        assert f"warprock {command}" in result.stdout
        assert load_case(file).lane_count >= 1
        text = file.read_text(encoding="utf-8")
        refused(invoke("init", kind, file), str(file), "must not exist")
        assert file.read_text(encoding="utf-8") == text


def test_init_into_what_is_no_folder_is_refused(case: pathlib.Path):
    refused(invoke("init", "free", case / "case.toml"), "PATH", "must be a folder")
    assert case.read_text(encoding="utf-8") == FREE


def test_list_names_every_case_and_engine():
    result = invoke("list", "--json")
    found = json.loads(result.stdout)
    assert [row["name"] for row in found["cases"]] == case_names()
    assert [row["name"] for row in found["engines"]] == list(ENGINES)
    printed = invoke("list").stdout
    assert all(name in printed for name in (*case_names(), *ENGINES))


@pytest.mark.parametrize("name", RUNNABLE_CASES)
def test_explain_says_what_runs_or_why_not(name: str, monkeypatch: pytest.MonkeyPatch):
    # Some cases have many lanes, and the choice of an engine runs them: once for both commands.
    explained: dict[str, Any] = {}
    honest = catalogue.explain_case

    def once(case: Case) -> dict[str, Any]:
        return explained.get(case.name) or explained.setdefault(case.name, honest(case))

    monkeypatch.setattr(catalogue, "explain_case", once)
    found = json.loads(invoke("explain", name, "--json").stdout)
    assert list(explained) == [name]
    assert found["lanes"] == math.prod(axis["length"] for axis in found["sweep"])
    for engine in found["engines"]:
        assert bool(engine["declines"]) != bool(engine["kernel"])
    printed = invoke("explain", name).stdout
    assert all(engine["name"] in printed for engine in found["engines"])
    left_out = found["scene"]["left_out"]
    # A block that is thrown falls on any of its sides.
    thrown = name in ("cube-tosses", "square-drops")
    assert any("sides of blocks" in text for text in left_out) != thrown
    assert any("out of the plane" in text for text in left_out) != bool(
        found["scene"]["spatial_because"]
    )


def test_a_failed_check_exits_with_3(monkeypatch: pytest.MonkeyPatch):
    from warprock.verification import checks

    row = checks.CheckRow("free-b0", "made up", "housner", "all", 1.0, 0.5, False, "it is", "")
    monkeypatch.setattr(checks, "run_checks", lambda case: [row])
    assert invoke("check", "free-b0").exit_code == 3
    result = invoke("check", "free-b0", "--json")
    assert result.exit_code == 3
    assert json.loads(result.stdout)["rows"][0]["ok"] is False


def test_ctrl_c_exits_with_130_and_leaves_nothing(
    case: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    from warprock.running import case_run as runner

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(runner, "run_to_tolerance", interrupted)
    result = invoke("run", case, "-o", case.parent / "results")
    assert result.exit_code == 130
    assert [path.name for path in case.parent.iterdir()] == ["case.toml"]


def test_a_full_disk_exits_with_1_and_leaves_no_half_file(
    case: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pyarrow.parquet.write_table", full)
    result = invoke("run", case, "-o", case.parent / "results")
    assert result.exit_code == 1
    assert "No space left on device" in result.stderr
    assert list((case.parent / "results").iterdir()) == []


@pytest.mark.skipif(os.name != "posix", reason="pipes and shells of POSIX systems")
@pytest.mark.parametrize("unbuffered", ["", pytest.param("1", marks=pytest.mark.thorough)])
def test_output_that_nobody_reads_ends_quietly(unbuffered: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "warprock", "keys", "--json"]
    with open(writer, "wb") as pipe:
        done = subprocess.run(command, stdout=pipe, stderr=subprocess.PIPE, check=False, timeout=60)
    assert (done.returncode, done.stderr) == (1, b"")
    closed = shlex.join(command) + " >&-"
    done = subprocess.run(closed, shell=True, capture_output=True, check=False, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


def test_json_has_no_nan_and_no_infinity():
    import numpy as np

    from warprock.tables.terminal import plain

    found = plain({"a": float("nan"), "b": [np.float64("inf"), np.int32(3)], "c": np.arange(2)})
    assert found == {"a": None, "b": [None, 3], "c": [0, 1]}


TOLD = """if 1:
    import sys, warp
    from warprock.cli.main import entry
    launch = warp.launch
    def told(*given, **named):
        print("launched", file=sys.stderr, flush=True)
        return launch(*given, **named)
    warp.launch = told
    entry()
"""
"""The command line, which tells of each launch."""


@pytest.mark.thorough
def test_ctrl_c_does_not_wait_for_the_launch_in_hand(tmp_path, interruptible):
    # One pack of 96 million steps, of the 1e8 steps that a lane may have: a launch of many minutes,
    # which nothing can interrupt.
    command = [sys.executable, "-c", TOLD, "run", "free-b0", "-e", "impulse"]
    knobs = ["-s", "engines.impulse.substeps=2000"]
    knobs += ["-s", "run.duration=200 s", "-s", "run.sample_interval=1 s"]
    folder = tmp_path / "out"
    with subprocess.Popen(
        [*command, *knobs, "-o", folder],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            before = ""
            while (line := process.stderr.readline()) and line != "launched\n":
                before += line
            assert line, before
            time.sleep(0.2)
            assert process.poll() is None
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=60.0)
        finally:
            process.kill()
    assert process.returncode == 130
    assert "interrupted" in errors
    assert not list(folder.glob("*")) if folder.exists() else True


def test_every_command_of_the_folder_can_be_called():
    def reachable(command: click.Command) -> set[click.Command]:
        below = command.commands.values() if isinstance(command, click.Group) else ()
        return {command}.union(*map(reachable, below))

    context = click.Context(main)
    names = main.list_commands(context)
    assert [name for name in names if main.get_command(context, name) is None] == []
    # Which imports the files of all commands.
    main.get_command(context, "no command")
    assert set(names) == main.commands.keys()
    found = reachable(main)
    for module in pkgutil.iter_modules(warprock.cli.__path__, "warprock.cli."):
        for value in vars(importlib.import_module(module.name)).values():
            assert not isinstance(value, click.Command) or value in found, value


def test_help_shows_every_command_in_its_section():
    printed = invoke("--help").stdout
    sections = printed.partition("Start:")[2]
    assert "Other" not in sections
    names = main.list_commands(click.Context(main))
    assert all(re.search(rf"^  {name} ", sections, re.MULTILINE) for name in names)
    assert max(map(len, printed.splitlines())) <= 80


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        (["run", "free"], "free-b0"),
        (["run", "free-b0", "-e", "h"], "housner"),
        (["run", "free-b0", "-s", "motion.a"], "motion.amplitude="),
        (["compare", "free-b0", "-e", "muj"], "mujoco"),
        (["init", "re"], "record"),
        (["keys", "mot"], "motion"),
        (["reproduce", "table1"], "table12"),
        (["records", "info", "ridge"], "ridgecrest-2019-ccc-090"),
    ],
)
def test_shells_complete_what_is_typed(typed: list[str], offered: str):
    *before, incomplete = typed
    complete = ShellComplete(main, {}, "warprock", "_WARPROCK_COMPLETE")
    assert offered in [item.value for item in complete.get_completions(before, incomplete)]
    assert "_WARPROCK_COMPLETE" in invoke("completion", "zsh").stdout


@pytest.mark.parametrize(
    "arguments",
    [("list",), ("explain", "free-b0"), ("run", "free-b0"), ("keys", "run"), ("records", "list")],
)
def test_a_command_ends_with_what_came_out_and_a_command_that_there_is(arguments: tuple[str, ...]):
    *_, sentence, last = invoke(*arguments).stdout.splitlines()
    assert sentence.endswith(".")
    program, command = last.removeprefix("next: ").split()[:2]
    assert program == "warprock"
    assert command in main.commands
    for text in ("list", "--json"), ("run", "free-b0", "--json"):
        assert "next: " not in invoke(*text).stdout
