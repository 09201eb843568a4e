"""The command `body`: what it writes, and how it refuses."""

from __future__ import annotations

import json
import pathlib

import pytest

from tests.shared.commands import invoke, succeed
from tests.shared.meshes import l_profile, write
from warprock.case.load import load_case

DENSITY = ("--density", "2700 kg/m^3")


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    return write(l_profile(), tmp_path_factory.mktemp("mesh"), "corbel.stl")


@pytest.mark.usefixtures("pages_bare")
def test_a_case_a_figure_and_a_page_lie_in_the_folder(mesh: pathlib.Path, tmp_path: pathlib.Path):
    folder = tmp_path / "corbel"
    done = succeed("body", mesh, *DENSITY, "-o", folder)
    names = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
    tables = {"directions.csv", "directions.parquet"}
    assert names == {"case.toml", "run.json", "body.png", "report.html", *tables}
    case = load_case(str(folder))
    assert (case.name, case.title, case.lane_count) == ("corbel", "corbel on a pulse", 8)
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "corbel is weakest towards 180 deg from x" in page
    assert "Poses in which it stands" in page
    assert f"next: warprock run {folder} -o results" in done.output
    again = invoke("body", mesh, *DENSITY, "-o", folder)
    assert again.exit_code == 2
    assert "--output: got" in again.stderr
    assert "must not exist already" in again.stderr


def test_json_says_what_was_found_and_nothing_is_written(mesh: pathlib.Path):
    done = invoke("body", mesh, "--mass", "30 kg", "--json")
    found = json.loads(done.stdout)
    assert found["body"]["mass_kg"] == 30.0
    assert found["body"]["volume_m3"] == pytest.approx(0.014, rel=1e-6)
    assert found["body"]["weakest_deg"] == pytest.approx(180.0)
    assert found["files"] == []
    assert [rest["pose"] for rest in found["rests"]] == [*range(1, len(found["rests"]) + 1)]
    assert "The file names no unit" in found["notes"][0]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((), "--density: got nothing, must be given, or --mass"),
        ((*DENSITY, "--pose", "-1"), "--pose: got -1, must be 0, the pose of the file, or from 1"),
        ((*DENSITY, "--unit", "mm"), "must be"),
    ],
)
def test_what_cannot_be_used_ends_with_2_in_one_line(
    mesh: pathlib.Path, options: tuple[str, ...], said: str, tmp_path: pathlib.Path
):
    folder = tmp_path / "none"
    done = invoke("body", mesh, *options, "-o", folder)
    assert done.exit_code == 2, done.output
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
    assert not folder.exists()
