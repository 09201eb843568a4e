"""The README's two commands: they are what continuous integration runs and what exists."""

from __future__ import annotations

import contextlib
import os
import pathlib
import re
import shlex
import shutil
import subprocess
from typing import Any

import click
import trimesh

from tests.shared.commands import invoke, succeed
from warprock.cli.main import main

ROOT = pathlib.Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
FIRST_SCREEN = 40
"""Lines that a newcomer sees without scrolling."""


def test_the_first_screen_holds_the_two_commands():
    head = "\n".join(README.splitlines()[:FIRST_SCREEN])
    blocks = re.findall(r"^```bash\n(.*?)\n```$", head, re.M | re.S)
    assert len(blocks) == 2
    assert blocks[0].endswith("warprock reproduce single-block -o results")
    assert blocks[1].endswith("-m pytest")
    for block in blocks:
        # A pip of today chooses among files far faster than the one that Python brings.
        assert block.startswith("python3 -m venv --upgrade-deps .venv && ")
        assert " && .venv/bin/python -m pip install --no-compile -e " in block


def test_ci_runs_the_readmes_test_command_and_then_programs_of_others(tmp_path: pathlib.Path):
    """Runs .ci/run with every program replaced by one that writes down how it was called."""
    shutil.copytree(ROOT / ".ci", tmp_path / ".ci")
    for environment in (".venv", ".venv-readers"):
        (tmp_path / environment / "bin").mkdir(parents=True)
    (tmp_path / "tools").symlink_to(ROOT / "tools")
    log = tmp_path / "log"
    real = subprocess.check_output(["bash", "-c", "type -P python3"], text=True).strip()
    echo = f'#!/usr/bin/env bash\necho "$0 $*" >> {shlex.quote(str(log))}\n'
    pass_on = f'case "$1" in tools/*) exec {shlex.quote(real)} "$@";; esac\n'
    (tmp_path / "bin").mkdir()
    programs = ("python", "ruff", "mypy", "sphinx-build")
    own = [f".venv/bin/{program}" for program in programs]
    for name in ("bin/python3", ".venv-readers/bin/python", *own):
        (tmp_path / name).write_text(echo + pass_on, encoding="utf-8")
        (tmp_path / name).chmod(0o755)
    path = os.pathsep.join([str(tmp_path / "bin"), os.environ["PATH"]])
    done = subprocess.run(
        ["bash", ".ci/run"],
        cwd=tmp_path,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    calls = log.read_text(encoding="utf-8").splitlines()
    test_command = re.findall(r"^```bash\n(.*?)\n```$", README, re.M | re.S)[1]
    wanted = [shlex.split(part) for part in test_command.split(" && ")]
    got = [[pathlib.PurePath(call.split()[0]).name, *call.split()[1:]] for call in calls]
    assert got[-12:-9] == [[pathlib.PurePath(part[0]).name, *part[1:]] for part in wanted]
    assert got[-9][1:] == ["-m", "pytest", "-m", "thorough"]
    assert got[-8][-1] == ".[docs,mujoco,bullet,dask,fragility]"
    # Side by side: the manual, and what the extras bring.
    manual = ["sphinx-build", "-W", "--keep-going", "-q", "docs", "docs/_build"]
    beside = got[-7:-1]
    assert manual in beside
    beside.remove(manual)
    assert beside[0][1:] == ["-m", "venv", ".venv-readers"]
    assert [each[1:4] for each in beside[1:3]] == [["-m", "pip", "install"]] * 2
    assert beside[3][1:3] == ["-m", "pytest"]
    assert beside[4][1:4] == ["-m", "tools.notebooks", "--run"]
    assert got[-1][1:] == ["-m", "pytest", "-n", "0", "-m", "speed"]
    names = [" ".join(pathlib.PurePath(call).name.split()) for call in calls]
    assert {"ruff check", "ruff format --check", "mypy"} <= set(names)


def test_the_readme_is_short_and_its_links_lead_somewhere():
    assert len(README.splitlines()) <= 150
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert {"CONTRIBUTING.md", "CHANGELOG.md"} < set(links)
    assert all((ROOT / link).exists() for link in links)


def test_the_python_of_the_readme_runs():
    (text,) = re.findall(r"^```python\n(.*?)\n```$", README, re.M | re.S)
    names: dict[str, Any] = {}
    exec(text, names)
    assert len(names["run"].table) == 21


def test_the_commands_of_the_readme_run(tmp_path: pathlib.Path, unrendered: None):
    """As they stand there, with fewer lanes, and a box for a statue."""
    trimesh.creation.box((0.4, 0.3, 1.0)).export(tmp_path / "statue.ply")
    (text,) = re.findall(r"^```sh\n(.*?)\n```$", README, re.M | re.S)
    with contextlib.chdir(tmp_path):
        for line in text.splitlines():
            words = shlex.split(line.replace("lanes=2000", "lanes=40"), comments=True)
            assert words[0] == "warprock"
            result = invoke(*(words[1:]))
            assert result.exit_code == 0, (line, result.output)


def test_every_command_explains_itself():
    for name in main.list_commands(click.Context(main)):
        result = succeed(name, "--help")
        assert len(result.output.splitlines()) > 3
