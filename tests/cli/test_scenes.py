"""The commands `animate` and `view`."""

from __future__ import annotations

import json
import pathlib
import shutil

import pytest

from tests.shared.commands import invoke
from warprock.case.load import load_case
from warprock.running.case_run import run_case
from warprock.running.results import write_run


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    where = tmp_path_factory.mktemp("run")
    case = load_case("free-b0", ["run.duration=0.4 s"])
    write_run(run_case(case, "housner", histories=False), where)
    return where


def test_animate_writes_a_picture_beside_the_run(folder: pathlib.Path) -> None:
    result = invoke("animate", folder, "--rate", 10)
    assert result.exit_code == 0, result.output
    assert (folder / "lane-0.gif").stat().st_size > 5000
    assert "lane-0.gif" in result.stdout


def test_animate_writes_gltf(folder: pathlib.Path, tmp_path: pathlib.Path) -> None:
    result = invoke("animate", folder, "-o", tmp_path / "lane.glb")
    assert result.exit_code == 0, result.output
    assert (tmp_path / "lane.glb").read_bytes().startswith(b"glTF")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--lane", 7), "--lane: got 7, must be a lane from 0 to 1"),
        (("-o", "lane.avi"), "must end in one of .gif, .mp4, .png, .glb"),
        (("--speed", 0.001), "must make at most 3,000 pictures"),
    ],
)
def test_what_cannot_be_made_is_one_line(
    folder: pathlib.Path, arguments: tuple[object, ...], words: str
) -> None:
    result = invoke("animate", folder, *arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert result.stderr.count("\n") == 1


def test_animate_holds_facts_to_the_shape_of_their_kind(
    folder: pathlib.Path, tmp_path: pathlib.Path
) -> None:
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    facts = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    (tmp_path / "run.json").write_text(json.dumps(facts | {"modes": "none"}), encoding="utf-8")
    result = invoke("animate", tmp_path)
    assert result.exit_code == 2
    assert "modes: got 'none', must be an object" in result.output


def test_view_refuses_a_folder_without_a_run(tmp_path: pathlib.Path) -> None:
    result = invoke("view", tmp_path, "--viewer", "viser")
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
