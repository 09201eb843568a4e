"""The recipes of CONTRIBUTING are carried out on a copy of the tree, and what they add is run."""

from __future__ import annotations

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

import pytest

from tests.shared.recipes import ROOT, Recipe, apply, copy_of_the_tree, files_of, recipes

RECIPES = recipes()
WANTED = {"engine", "case", "key", "waveform", "law of impact", "analysis", "command"}
MOST_FILES = {"analysis": 3, "waveform": 4}
PUBLIC_NAMES = "warprock/__init__.py"
"""The one list of public names, which a public function has a line in."""


def test_every_kind_of_change_has_a_recipe():
    assert {
        recipe.title.removeprefix("Add a").removeprefix("n").strip() for recipe in RECIPES
    } == WANTED


def test_files_that_it_names_are_there():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`((?:cases|kernels|tests|tools|warprock)/[\w./-]+)`", text))
    named = {path for path in named if "NAME" not in path}
    assert len(named) > 40
    assert [path for path in sorted(named) if not (ROOT / path).exists()] == []


def test_names_that_it_places_in_a_file_are_there():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    placed = re.findall(
        r"`(\w+)`(?:, the [^`,]*)?,? (?:in|of) `((?:kernels|warprock)/[\w/]+\.py)`", text
    )
    assert len(placed) > 12
    for name, file in placed:
        source = (ROOT / file).read_text(encoding="utf-8")
        assert re.search(rf"^(?:def |class |){name}\b", source, re.MULTILINE), f"{name} in {file}"


@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: recipe.diff.stem)
def test_a_recipe_names_the_files_that_it_changes(recipe: Recipe):
    changed = files_of(recipe.diff.read_text(encoding="utf-8"))
    text = recipe.text
    for file in changed:
        # NAME stands for what the reader calls the thing: a file, or a folder.
        *folders, name = pathlib.PurePosixPath(file).parts
        as_file = [*folders, f"NAME{pathlib.PurePath(name).suffix}"]
        as_folder = [*folders[:-1], "NAME", name]
        general = {file, "/".join(as_file), "/".join(as_folder)}
        assert any(f"`{each}`" in text for each in general), f"{file} is not in the recipe"
    for kind, most in MOST_FILES.items():
        if recipe.title.endswith(f" {kind}"):
            assert len(set(changed) - {PUBLIC_NAMES}) <= most


@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: recipe.diff.stem)
def test_a_recipe_fits_the_tree(recipe: Recipe, tmp_path: pathlib.Path):
    for file in files_of(recipe.diff.read_text(encoding="utf-8")):
        if (ROOT / file).exists():
            (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / file, tmp_path / file)
    apply(recipe.diff, tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: recipe.diff.stem)
def test_a_recipe_runs(recipe: Recipe, tmp_path: pathlib.Path):
    tree = copy_of_the_tree(tmp_path / "tree")
    apply(recipe.diff, tree)
    assert recipe.commands
    for command in recipe.commands:
        words = shlex.split(command.partition("  #")[0])
        done = subprocess.run(
            [sys.executable, "-m", *words],
            cwd=tree,
            env={**os.environ, "PYTHONPATH": str(tree), "COLUMNS": "200"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
        expected = command.partition("  # ")[2]
        assert expected in done.stdout, f"{command}\n{done.stdout}"
    assert ROOT not in tree.parents
