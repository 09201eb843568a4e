"""The worked examples of CONTRIBUTING: changes as diffs, made on a copy of the tree."""

from __future__ import annotations

import pathlib
import re
import shutil
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


def apply(diff: str, root: pathlib.Path) -> None:
    """Makes the changes of a diff; line numbers do not matter, the lines around do.

    Raises:
        ValueError: Lines that it changes are not there, or there more than once.
    """
    for part in re.split(r"^diff --git .*\n", diff, flags=re.MULTILINE)[1:]:
        (name,) = files_of(part)
        file = root / name
        new = "\n--- /dev/null\n" in f"\n{part}"
        text = "" if new else file.read_text(encoding="utf-8")
        for hunk in re.split(r"^@@ .*\n", part, flags=re.MULTILINE)[1:]:
            lines = hunk.splitlines(keepends=True)
            old = "".join(line[1:] for line in lines if line[0] in " -")
            fresh = "".join(line[1:] for line in lines if line[0] in " +")
            if new:
                text = fresh
                continue
            if text.count(old) != 1:
                raise ValueError(f"{name} has {text.count(old)} places with these lines:\n{old}")
            text = text.replace(old, fresh)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
