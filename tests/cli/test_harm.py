"""Results that were edited or damaged end a command in one line; what is stopped leaves no half."""

from __future__ import annotations

import copy
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
import pytest

import warprock as wr
from tests.shared.commands import invoke, succeed
from tests.shared.marks import first
from warprock.running.files import replacing_together

CASE = """
title = "A block under pulses"
source = "Made for this test."
block = {width = "0.2 m", height = "1 m", depth = "0.5 m", density = "2400 kg/m^3"}
contact.friction = 1.0
motion = {waveform = "record", record = "quake.csv", target_pga = "0.3 g"}
run = {duration = "0.5 s", sample_interval = "50 ms"}

[[sweep]]
motion.target_pga = ["0.25 g", "0.3 g", "0.9 g"]
label.name = ["weak", "usual", "strong"]
"""
JSON = [None, -1, 1e308, float("nan"), "", "x", [], {}, [1], {"a": 1}, True, 10**400, "\ud800"]
COLUMNS: list[Any] = ["x", np.nan, None, -1e300, pd.Timestamp(0), b"\xff"]


@pytest.fixture(autouse=True)
def interruptible() -> Iterator[None]:
    """Ctrl-C is heard: a shell that starts the tests in the background has it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def ends_in_one_line(*arguments: object) -> None:
    result = invoke(*arguments)
    if result.exit_code:
        assert isinstance(result.exception, SystemExit), result.exception
        assert result.exit_code in (1, 2)
        assert result.stderr.startswith("error: ")
        assert result.stderr.count("\n") == 1


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    folder = tmp_path_factory.mktemp("case")
    motion = np.sin(2.0 * np.pi * 3.0 * np.arange(50) * 0.01)
    wr.save_record(folder / "quake.csv", motion, interval="0.01 s", unit="g")
    (folder / "case.toml").write_text(CASE, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def whole(case: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """A run, as if the command had been given the case by a path from its own folder."""
    folder = tmp_path_factory.mktemp("run") / "out"
    before = pathlib.Path.cwd()
    os.chdir(case.parent)
    try:
        made = invoke("run", case.name, "-e", "event", "-o", folder)
    finally:
        os.chdir(before)
    assert made.exit_code == 0, made.output
    return folder


@pytest.fixture
def folder(whole: pathlib.Path, tmp_path: pathlib.Path) -> pathlib.Path:
    shutil.copytree(whole, tmp_path / "out")
    return tmp_path / "out"


def commands(folder: pathlib.Path, lane: int = 0) -> tuple[tuple[object, ...], ...]:
    return (
        ("report", folder),
        ("animate", folder, "--lane", lane, "-o", folder.parent / "lane.glb"),
        ("fragility", folder, "--max-doubt", 1),
    )


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Paths to everything inside a value."""
    inner: Any = value.items() if isinstance(value, dict) else ()
    for key, each in enumerate(value) if isinstance(value, list) else inner:
        yield (*path, key)
        yield from places(each, (*path, key))


@pytest.mark.parametrize("seed", first(1, range(4)))
def test_facts_that_were_changed_end_in_one_line(folder: pathlib.Path, seed: int):
    draw, file = random.Random(seed), folder / "run.json"
    facts = json.loads(file.read_text(encoding="utf-8"))
    for _ in range(6):
        changed = copy.deepcopy(facts)
        path = draw.choice([place for place in places(facts) if len(place) < draw.randint(2, 6)])
        inside = changed
        for key in path[:-1]:
            inside = inside[key]
        if draw.random() < 0.3:
            del inside[path[-1]]
        else:
            inside[path[-1]] = draw.choice(JSON)
        file.write_text(json.dumps(changed), encoding="utf-8")
        for command in commands(folder)[:2]:
            ends_in_one_line(*command)


@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize("value", first(1, COLUMNS), ids=str)
def test_tables_that_were_changed_end_in_one_line(folder: pathlib.Path, value: Any):
    draw, file = random.Random(str(value)), folder / "lanes.parquet"
    table = pd.read_parquet(file)
    needed = ["lane", "outcome", "status", "peak_rotation_ratio", "time_step_s", "undecided"]
    for name in [*needed, draw.choice(list(table.columns))]:
        changed = table.drop(columns=name) if draw.random() < 0.2 else table.assign(**{name: value})
        changed.to_parquet(file, index=False)
        for command in commands(folder):
            ends_in_one_line(*command)
    for part in (table.iloc[:0], table.iloc[:1], table.assign(peak_rotation_ratio=[[1]] * 3)):
        part.to_parquet(file, index=False)
        for command in commands(folder, lane=2):
            ends_in_one_line(*command)


@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize(
    "name", first(2, ["run.json", "lanes.parquet", "report.html", "peaks.png"])
)
def test_bytes_that_were_changed_end_in_one_line(folder: pathlib.Path, name: str):
    draw, file = random.Random(name), folder / name
    if not file.is_file():
        (file,) = list(folder.glob("*.png"))[:1]
    bytes_ = file.read_bytes()
    turned = bytearray(bytes_)
    for _ in range(8):
        turned[draw.randrange(len(turned))] = draw.randrange(256)
    for content in (b"", b'{"a": 1}', bytes_[: draw.randrange(len(bytes_))], bytes(turned)):
        file.write_bytes(content)
        for command in commands(folder):
            ends_in_one_line(*command)


@pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="a file without an end")
@pytest.mark.parametrize("name", ["lanes.parquet", "run.json", "figure"])
def test_a_file_without_an_end_is_never_waited_for(folder: pathlib.Path, name: str):
    file = next(folder.glob("*.png")) if name == "figure" else folder / name
    file.unlink()
    file.symlink_to("/dev/zero")
    for command in commands(folder):
        ends_in_one_line(*command)


def test_a_lane_is_run_again_from_any_folder(
    folder: pathlib.Path, case: pathlib.Path, tmp_path: pathlib.Path, monkeypatch
):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    result = succeed("animate", folder, "-o", tmp_path / "lane.glb")
    facts = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    facts["case"]["folder"] = str(tmp_path / "gone")
    (folder / "run.json").write_text(json.dumps(facts), encoding="utf-8")
    result = invoke("animate", folder, "-o", tmp_path / "lane.glb")
    assert result.exit_code == 2
    assert f"the case is no longer in {tmp_path / 'gone'}" in result.stderr


@pytest.mark.parametrize("text", ["abc", "0", "-1", "1.5", "2,x", ","])
def test_threads_of_the_environment_are_numbers(text: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("OMP_NUM_THREADS", text)
    result = invoke("list")
    assert result.exit_code == 2
    assert result.stderr.startswith("error: OMP_NUM_THREADS: got ")
    assert result.stderr.count("\n") == 1


def test_the_first_of_several_levels_of_threads_is_taken(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "4,2")
    assert invoke("list").exit_code == 0
    assert os.environ["OMP_NUM_THREADS"] == "4"


def test_a_mesh_whose_name_is_no_text_is_one_line(tmp_path: pathlib.Path):
    try:
        (tmp_path / "m\udcff.ply").write_bytes(b"ply\n")
    except OSError:
        pytest.skip("names of files are text here")
    given = ["body", str(tmp_path / "m\udcff.ply"), "--density", "1 kg/m^3", "-o", str(tmp_path)]
    result = invoke(*given)
    assert result.exit_code == 2
    assert "must have a name that is text" in result.stderr


SLOW = """
import sys, time
from warprock.running import results
honest = results.arrow_table
def slow(table):
    print("writing", flush=True)
    time.sleep(20.0)
    return honest(table)
results.arrow_table = slow
from warprock.cli.main import entry
entry()
"""


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("number", first(1, [signal.SIGINT, signal.SIGTERM]))
def test_a_command_that_is_stopped_while_it_writes_leaves_nothing(number, tmp_path: pathlib.Path):
    out = tmp_path / "out"
    command = [sys.executable, "-c", SLOW, "run", "free-b0", "-e", "housner", "-o", str(out)]
    root = str(pathlib.Path(wr.__file__).parent.parent)
    process = subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": root},
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "writing\n"
    time.sleep(0.2)
    process.send_signal(number)
    _, said = process.communicate(timeout=30)
    assert process.returncode == 130
    assert said.splitlines()[-1] == "interrupted"
    assert list(out.iterdir()) == []


def test_files_take_their_places_together(tmp_path: pathlib.Path):
    for name in ("a", "b"):
        (tmp_path / name).write_text("before")

    def one_of_two() -> None:
        with replacing_together() as writing:
            with writing(tmp_path / "a") as temporary:
                temporary.write_text("after")
            with writing(tmp_path / "b") as temporary:
                temporary.write_text("half")
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        one_of_two()
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {
        "a": "before",
        "b": "before",
    }


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_a_signal_between_two_files_waits_for_the_last(tmp_path, monkeypatch):
    honest, came = os.replace, []

    def interrupted(*paths: pathlib.Path) -> None:
        honest(*paths)
        signal.raise_signal(signal.SIGINT)
        came.append(paths)

    monkeypatch.setattr(os, "replace", interrupted)

    def both() -> None:
        with replacing_together() as writing:
            for name in ("a", "b"):
                with writing(tmp_path / name) as temporary:
                    temporary.write_text("after")

    with pytest.raises(KeyboardInterrupt):
        both()
    assert len(came) == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"]
