"""What is installed is what is in the tree: source distribution -> wheel -> import."""

from __future__ import annotations

import os
import pathlib
import shutil
import subprocess
import sys
import tomllib
import zipfile

import pytest

import warprock
from warprock.measure import doctor

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ("warprock", "kernels", "cases", "tests", "tools")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """A wheel built from the source distribution of a clean copy of the tree, without a network."""
    source = tmp_path_factory.mktemp("source")
    for name in FOLDERS:
        ignore = shutil.ignore_patterns("__pycache__", "*.egg-info")
        shutil.copytree(ROOT / name, source / name, ignore=ignore)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    out = tmp_path_factory.mktemp("dist")
    done = subprocess.run(
        [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(out), str(source)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return next(out.glob("*.whl"))


def _tree() -> set[str]:
    """Where every file of the tree that belongs in the wheel lies in it."""
    inside = {"warprock": "warprock", "kernels": "warprock/kernels", "cases": "warprock/cases"}
    return {
        f"{target}/{path.relative_to(ROOT / folder).as_posix()}"
        for folder, target in inside.items()
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


@pytest.mark.thorough
def test_the_wheel_holds_the_tree_and_nothing_else(wheel: pathlib.Path):
    with zipfile.ZipFile(wheel) as archive:
        packed = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert packed == _tree()


def test_every_package_is_declared():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    declared = set(project["tool"]["setuptools"]["packages"])
    found = {"warprock.cases"} | {
        ".".join(("warprock", *path.parent.relative_to(ROOT / above).parts))
        for above, folder in (("warprock", "warprock"), (".", "kernels"))
        for path in (ROOT / folder).rglob("__init__.py")
    }
    assert declared == found


def test_doctor_says_that_pyarrow_does_not_load(monkeypatch: pytest.MonkeyPatch):
    """As pyarrow 26 beside NumPy 1.26, which the extra for Blender brings with an older pyarrow."""
    assert not any("pyarrow" in line for line in doctor.examine()["missing"])
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    (line,) = (line for line in doctor.examine()["missing"] if "pyarrow" in line)
    assert line.startswith("package pyarrow does not load: ")


@pytest.mark.thorough
def test_the_licence_and_the_command_are_in_the_wheel(wheel: pathlib.Path):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        entry_points = next(name for name in names if name.endswith("entry_points.txt"))
        text = archive.read(entry_points).decode()
        licence = next(name for name in names if name.endswith("licenses/LICENSE"))
        assert archive.read(licence) == (ROOT / "LICENSE").read_bytes()
    assert "warprock = warprock.cli.main:entry" in text


@pytest.mark.thorough
def test_the_wheel_works_away_from_the_checkout(wheel: pathlib.Path, tmp_path: pathlib.Path):
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    code = (
        "import warprock, warprock.kernels\n"
        "print(warprock.__file__, warprock.kernels.__file__, len(warprock.__path__))\n"
        "print(*warprock.case_names())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    where, cases = done.stdout.splitlines()
    inside = site / "warprock"
    assert where == f"{inside / '__init__.py'} {inside / 'kernels/__init__.py'} 1"
    assert cases.split() == sorted(path.parent.name for path in ROOT.glob("cases/*/case.toml"))


def test_a_bare_checkout_bridges_to_kernels_and_cases(tmp_path: pathlib.Path):
    """A copy that nobody installed finds its own kernels/, not those of an installed one."""
    for name in ("warprock", "kernels", "cases"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    code = (
        "import warprock.kernels, warprock.cases as c; print(warprock.kernels.__file__, c.__file__)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    wanted = (tmp_path / "kernels/__init__.py", tmp_path / "cases/__init__.py")
    assert done.stdout.split() == [str(path) for path in wanted]


def test_every_public_name_is_found_where_it_lives():
    for name in warprock.__all__:
        assert getattr(warprock, name) is not None
    assert sorted(warprock.__all__) == sorted(warprock._HOME)
    assert callable(warprock.load_case)
