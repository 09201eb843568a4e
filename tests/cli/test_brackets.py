"""Text of a user is printed as it was written: square brackets and colons are no markup."""

from __future__ import annotations

import pathlib
import re

import numpy as np
import pytest
import rich.progress

import warprock as wr
from tests.shared.commands import succeed
from warprock.tables import terminal

NAME = "vase [draft]"
TITLE = "A [bold]heavy[/bold] vase [/red] [broken] :bomb:"
LABELS = ("as [built]", "as [/dim] mended", "[link=x]worn :wave:", "[red]glued[/red]")
CASE = f"""
title = "{TITLE}"
source = "Made for [this] test."

[block]
width = "0.2 m"
height = "1 m"
depth = "0.5 m"
density = "2400 kg/m^3"

[contact]
friction = 0.9

[motion]
record = "quake [raw].csv"
waveform = "record"
target_pga = "0.3 g"

[run]
duration = "1 s"

[[sweep]]
motion.target_pga = ["0.1 g", "0.4 g", "0.6 g", "2 g"]
label.state = {list(LABELS)}
"""


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    folder = tmp_path_factory.mktemp("cases") / NAME
    motion = np.sin(2.0 * np.pi * 2.0 * np.arange(200) * 0.01)
    wr.save_record(folder / "quake [raw].csv", motion, interval="0.01 s", unit="g")
    (folder / "case.toml").write_text(CASE, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def out(case: pathlib.Path) -> pathlib.Path:
    folder = case.parent / "out [of] it"
    printed("run", case, "-o", folder, "-e", "housner")
    return folder


def printed(*arguments: object) -> str:
    """What a command prints, without the breaks of its lines."""
    result = succeed(*arguments)
    return re.sub(r"\s+", " ", result.stdout)


def test_a_run_prints_names_and_labels(case: pathlib.Path, out: pathlib.Path):
    text = printed("run", case, "-e", "housner")
    assert NAME in text
    assert [label for label in LABELS if label not in text] == []
    one = printed("run", case, "-e", "housner", "-s", "sweep=[]")
    assert NAME in one
    assert f"wrote {out}/run.json" in printed("run", case, "-e", "housner", "-o", out)


def test_a_case_is_explained_in_its_own_words(case: pathlib.Path):
    text = printed("explain", case)
    assert f"{NAME}: {TITLE}" in text
    assert "Made for [this] test." in text
    assert "quake [raw]" in text


def test_a_record_is_listed_by_its_name(case: pathlib.Path):
    assert "quake [raw]" in printed("records", "info", case / "quake [raw].csv")


def test_an_analysis_names_its_groups(out: pathlib.Path):
    text = printed("fragility", out, "--by", "state", "--max-doubt", 1)
    assert "out [of] it" in text
    assert [label for label in LABELS if label not in text] == []


def test_a_comparison_prints_names_and_labels(case: pathlib.Path):
    text = printed("compare", case, "-e", "housner", "-e", "event")
    assert NAME in text
    assert [label for label in LABELS if label not in text] == []


def test_a_sweep_prints_its_folder(case: pathlib.Path, tmp_path: pathlib.Path):
    folder = tmp_path / "sweep [1]"
    for command in (("plan", case, "-e", "housner", "-o", folder), ("run", folder)):
        assert str(folder) in printed("sweep", *command)
    assert NAME in printed("sweep", "status", folder)
    assert str(folder) in printed("sweep", "merge", folder)


def test_only_one_place_makes_a_terminal():
    """Another would read names as markup."""
    room = pathlib.Path(wr.__file__).parent
    made = [
        path.relative_to(room).as_posix()
        for path in sorted(room.rglob("*.py"))
        if re.search(r"(?<!\w)Console\(|rich\.markup|from_markup", path.read_text("utf-8"))
    ]
    assert made == ["tables/terminal.py"]


@pytest.mark.parametrize("name", ["[draft]", "[/bold]", "[", "[[x]]", ":bomb:", r"\[a]", "{0} [b]"])
def test_progress_shows_a_name_as_it_is(name: str):
    column = terminal.progress_text()
    task = rich.progress.Task(0, name, 1, 0, lambda: 0.0)
    assert column.render(task).plain == name
