"""Each command to try next works as it is printed, on the case of the command before."""

from __future__ import annotations

import pathlib
import re
import shlex

import click
import pytest

from tests.shared.case_texts import pulse_text
from tests.shared.commands import invoke
from tests.shared.marks import first
from warprock.cli.main import main

RECORD = """
title = "a block under a record"
source = "a test"
[block]
width = "0.25 m"
height = "1 m"
depth = "0.5 m"
density = "2400 kg/m^3"
[contact]
friction = 2.0
[motion]
waveform = "record"
record = "ridgecrest-2019-ccc-360"
[run]
duration = "30 s"
[[sweep]]
motion.scale = [0.3, 1.5]
"""
PULSE = pulse_text(
    width="0.25 m", friction=2.0, amplitude="3 m/s^2", frequency="1.5 Hz", duration="10 s"
)
MAP = """
[[sweep]]
motion.frequency = ["1 Hz", "2 Hz"]
[[sweep]]
motion.amplitude = ["3 m/s^2", "6 m/s^2"]
"""
SAMPLE = """
[sample]
lanes = 16
[sample.over]
block.width = { distribution = "uniform", from = "0.2 m", to = "0.3 m" }
"""
SWEEP = """
[[sweep]]
motion.amplitude = { from = "1 m/s^2", to = "8 m/s^2", count = 8 }
"""
SPECTRUM = """
title = "blocks of many sizes"
source = "a test"
[block]
depth = "0.5 m"
density = "2400 kg/m^3"
[contact]
friction = 10.0
[motion]
waveform = "sine"
control = "acceleration"
amplitude = "3 m/s^2"
frequency = "1 Hz"
cycles = 1
[run]
duration = "10 s"
[spectrum]
period = ["2 s", "4 s"]
slenderness = ["10 deg", "15 deg"]
"""


@pytest.fixture
def own(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The folder of a user, with blanks in its name, in which cases of their own lie."""
    monkeypatch.chdir(tmp_path)
    for name, text in (
        ("record", RECORD),
        ("pulses", PULSE + SWEEP),
        ("map", PULSE + MAP),
        ("sample", PULSE + SAMPLE),
        ("spectrum", SPECTRUM),
    ):
        folder = tmp_path / "my cases" / name
        folder.mkdir(parents=True)
        (folder / "case.toml").write_text(text, encoding="utf-8")
    (tmp_path / "quake.csv").write_text(
        "time,acceleration\n" + "".join(f"{0.01 * n:g},{n % 7 - 3}\n" for n in range(200)),
        encoding="utf-8",
    )
    return "my cases"


def _next(arguments: list[str]) -> list[str]:
    """Arguments of the command to try after another one, which works."""
    done = invoke(*arguments)
    assert done.exit_code == 0, f"{shlex.join(arguments)}: {done.output}"
    found = re.findall(r"^next: warprock (.*)$", done.stdout, re.M)
    return shlex.split(found[0]) if found else []


def _parsed(arguments: list[str]) -> None:
    """Reads a command as the command line does, and runs nothing."""
    command: click.Command = main
    words = list(arguments)
    while isinstance(command, click.Group):
        command = command.commands[words.pop(0)]
    command.make_context("warprock", words)


CHAINS = [
    ["run", "{own}/record", "-e", "housner"],
    ["run", "{own}/record", "-e", "housner", "-s", "motion.scale=1"],
    ["run", "{own}/pulses", "-e", "housner", "-s", 'block.width="0.22 m"'],
    ["explain", "{own}/pulses", "-s", "block.width=0.22 m"],
    ["compare", "{own}/pulses", "-e", "housner", "-e", "impulse", "-s", "block.width=0.22 m"],
    ["ida", "{own}/record", "-e", "housner", "-s", "motion.scale=0.8", "--count", "3"],
    ["map", "{own}/map", "-e", "housner"],
    ["map", "{own}/map", "-e", "housner", "-s", "run.duration=2 s"],
    ["spectrum", "{own}/spectrum", "-e", "housner"],
    ["sensitivity", "{own}/sample", "-e", "housner"],
]


@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize("arguments", first(1, CHAINS), ids=lambda chain: " ".join(chain[:2]))
def test_what_is_named_next_works_on_the_users_own_case(arguments: list[str], own: str):
    asked = [word.format(own=own) for word in arguments]
    second = _next(asked)
    analysed = asked[0] not in ("explain", "compare")
    if analysed:
        assert second == [*asked, "-o", "results"]
    third = _next(second) if analysed else second
    # Of the same case with the same overrides, or of the results that it left.
    overrides = [word for n, word in enumerate(asked) if asked[n - 1] == "-s"]
    mine = pathlib.Path(third[1]) in (pathlib.Path(asked[1]), pathlib.Path(asked[1], "case.toml"))
    mine &= all(word in third for word in overrides if "duration" not in word)
    assert mine or "results" in third
    fourth = _next(third)
    if fourth:
        _parsed(fourth)


@pytest.mark.usefixtures("unrendered")
def test_after_one_record_no_fragility_is_named(own: str):
    out = ["-e", "housner", "-o", "results"]
    assert _next(["run", f"{own}/record", *out])[:2] == ["ida", f"{own}/record"]
    assert _next(["run", f"{own}/pulses", *out])[0] == "fragility"


@pytest.mark.thorough
@pytest.mark.usefixtures("unrendered")
def test_after_a_fit_the_case_is_that_of_its_table_or_none(own: str):
    case = f"{own}/pulses"
    _next(["run", case, "-e", "housner", "-o", "as it is"])
    named = _next(["fragility", "as it is", "-o", "curves"])
    assert named[:1] == ["ida"]
    assert pathlib.Path(named[1]).resolve() == (pathlib.Path(case) / "case.toml").resolve()
    _next(["run", case, "-e", "housner", "-s", 'block.width="0.2 m"', "-o", "other"])
    assert _next(["fragility", "other", "-o", "curves"]) == []


@pytest.mark.usefixtures("unrendered")
def test_what_was_said_of_a_record_is_said_again(own: str):
    asked = ["--unit", "m/s^2", "--column", "acceleration"]
    named = _next(["records", "info", "quake.csv", *asked])
    assert named[:2] == ["init", "record"]
    run = _next(named)
    assert run[0] == "run"
    _next([*run[:2], "-e", "housner", *run[2:]])
