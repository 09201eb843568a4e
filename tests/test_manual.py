"""The manual: its commands run when it is built (`.ci/run`); here, that none is left out."""

from __future__ import annotations

import importlib.util
import json
import pathlib
import re
import shlex
import sys

import click
import pytest

import warprock
from tests.shared.commands import succeed
from warprock.cli.main import main

ROOT = pathlib.Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
BUILT = ("_build", "_made", "jupyter_execute")
PAGES = sorted(p for p in DOCS.rglob("*.md") if p.relative_to(DOCS).parts[0] not in BUILT)
RUN = ("{command}", "{code-cell} ipython3")
"""Blocks that are run when the manual is built."""
SHOWN = (
    "{file}",
    "{figure}",
    "{toctree}",
    "{eval-rst}",
    "{registry}",
    "{math}",
    "{not-run}",
    "text",
)
"""Blocks that hold no command, or one that says why it is not run."""
_FENCE = re.compile(r"^(`{3,})([^\n]*)\n(.*?)^\1$", re.M | re.S)


def _name(page: pathlib.Path) -> str:
    return page.relative_to(DOCS).as_posix()


@pytest.mark.parametrize("page", PAGES, ids=_name)
def test_every_block_is_run_or_says_why_not(page: pathlib.Path):
    text = page.read_text(encoding="utf-8")
    assert text.startswith(("# ", "---\n"))
    for _, head, _ in _FENCE.findall(text):
        kind = head if head in RUN else head.partition(" ")[0]
        assert kind in (*RUN, *SHOWN), f"{_name(page)}: ```{head}: no command can be checked in it"
        if kind == "{not-run}":
            assert len(head.split()) > 3, f"{_name(page)}: {head}: needs a reason"


def _commands(text: str) -> list[str]:
    """Commands that a page names in its sentences, and those that it shows and does not run."""
    found = re.findall(r"`(warprock [^`]+)`", _FENCE.sub("", text))
    for _, head, body in _FENCE.findall(text):
        if head.startswith("{not-run}"):
            whole = body.replace("\\\n", " ")
            found += re.findall(r"^(?:\S*/bin/)?(warprock .*)$", whole, re.M)
    return found


@pytest.mark.parametrize("page", PAGES, ids=_name)
def test_commands_that_are_only_named_exist_with_their_options(page: pathlib.Path):
    for named in _commands(page.read_text(encoding="utf-8")):
        command, words = main, shlex.split(named)[1:]
        while words and isinstance(command, click.Group) and not words[0].startswith("-"):
            found = command.get_command(click.Context(command), words.pop(0))
            assert found is not None, f"{_name(page)}: {named}"
            command = found
        options = {
            option for each in command.params for option in (*each.opts, *each.secondary_opts)
        }
        options |= {"-h", "--help"}
        asked = {word.partition("=")[0] for word in words if re.match(r"-+[a-z]", word)}
        assert asked <= options, f"{_name(page)}: {named}"


def _run_commands(text: str) -> list[list[str]]:
    """Arguments of the commands that a page runs."""
    bodies = [body for _, head, body in _FENCE.findall(text) if head.startswith("{command}")]
    lines = "".join(bodies).replace("\\\n", " ").splitlines()
    return [shlex.split(line)[1:] for line in lines if line.startswith("warprock ")]


@pytest.mark.thorough
def test_the_maps_of_the_manual_show_more_than_one_colour():
    found = [each for page in PAGES for each in _run_commands(page.read_text(encoding="utf-8"))]
    maps = [each for each in found if each[0] == "map"]
    assert maps
    for asked in maps:
        bare = [word for n, word in enumerate(asked) if "-o" not in asked[max(n - 1, 0) : n + 1]]
        result = succeed(*bare, "--json")
        modes = json.loads(result.stdout)["modes"]
        falls = modes["with impact"] + modes["without impact"]
        share = falls / sum(modes.values())
        assert 0.2 < share < 0.8, f"{' '.join(asked)}: {share:.0%} of its pulses overturn the block"
        assert modes["with impact"] > 0.01 * falls


def test_every_public_name_is_on_the_page_of_python():
    page = (DOCS / "reference/python.md").read_text(encoding="utf-8")
    shown = {line.rpartition(".")[2].rpartition(" ")[2] for line in page.splitlines()}
    assert set(warprock.__all__) <= shown


def _extension():
    spec = importlib.util.spec_from_file_location("commands", DOCS / "_ext/commands.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_a_command_that_ends_as_it_should_not_is_told(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.syspath_prepend(DOCS / "_ext")
    pytest.importorskip("sphinx", reason="the extra [docs] brings it")
    commands = _extension()
    page = "# A\n\n```{command}\n:exit: 2\necho said >&2; exit 2\n```\n\n```{file} a.csv\n1\n```\n"
    refused, file = commands.blocks_of(page)
    assert (refused.line, file.argument, file.body) == (3, "a.csv", "1\n")
    assert commands.run_block(refused, tmp_path) == commands.Outcome(
        "said", "", pytest.approx(0, abs=60)
    )
    assert "exit code 2, must be 0" in commands.run_block(refused._replace(exit=0), tmp_path).wrong
    commands.run_block(file, tmp_path)
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == "1\n"
