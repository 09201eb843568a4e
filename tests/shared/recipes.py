"""The worked examples of CONTRIBUTING: changes as diffs, made on a copy of the tree."""

from __future__ import annotations

import os
import pathlib
import re
import shutil
import subprocess
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[2]
COPIED = ("warprock", "kernels", "cases", "tools", "pyproject.toml", "README.md")
"""What a copy of the tree holds; the sources of all commands."""


class Recipe(NamedTuple):
    """A section of CONTRIBUTING that has a worked example.

    Attributes:
        title: Its heading.
        text: What it says.
        diff: The change, a file of `tests/recipes`.
        commands: What to run after it.
    """

    title: str
    text: str
    diff: pathlib.Path
    commands: tuple[str, ...]


def recipes() -> list[Recipe]:
    """The sections of CONTRIBUTING that name a diff."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    found = []
    for section in text.split("\n## ")[1:]:
        title, _, body = section.partition("\n")
        named = re.search(r"`(tests/recipes/[\w-]+\.diff)`", body)
        if named:
            blocks = re.findall(r"```sh\n(.*?)```", body, re.DOTALL)
            lines = [line for block in blocks for line in block.splitlines()]
            commands = tuple(line for line in lines if line.startswith("warprock "))
            found.append(Recipe(title, body, ROOT / named[1], commands))
    return found


def copy_of_the_tree(where: pathlib.Path) -> pathlib.Path:
    """A copy of the sources in a folder, which it gives back."""
    skip = shutil.ignore_patterns("__pycache__", "*.egg-info")
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, where / name, ignore=skip)
        else:
            shutil.copy(source, where / name)
    return where


def files_of(diff: str) -> list[str]:
    """The files that a diff changes or adds."""
    return re.findall(r"^\+\+\+ b/(.+)$", diff, re.MULTILINE)


def apply(diff: pathlib.Path, root: pathlib.Path) -> None:
    """Makes the changes of a diff as CONTRIBUTING says, with `git apply`.

    Args:
        diff: The file.
        root: Where the tree is, outside of any repository.

    Raises:
        ValueError: It does not fit, with what git says.
    """
    command = ["git", "apply", "--whitespace=nowarn", str(diff)]
    outside = os.environ | {"GIT_CEILING_DIRECTORIES": str(root.parent)}
    done = subprocess.run(
        command, cwd=root, env=outside, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise ValueError(f"{diff.name}: {done.stderr}")
