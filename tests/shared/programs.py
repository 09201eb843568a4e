"""Programs that we did not write, as tests look for them."""

from __future__ import annotations

import importlib.util
import sys

import pytest

from warprock.programs.table import PROGRAMS

PACKAGES = {"mujoco": "mujoco", "bullet": "pybullet", "blender": "bpy"}
"""Name of a program, and of its extra -> the package that it is."""


def absent(monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    """Lets Python find no such package: None in `sys.modules` is what it takes for that."""
    monkeypatch.setitem(sys.modules, package, None)


def present(program: str) -> str:
    """A program whose package is there; the test is skipped where it is not."""
    if importlib.util.find_spec(PACKAGES[program]) is None:
        pytest.skip(f"{PACKAGES[program]} is not installed; {PROGRAMS[program].install} does it")
    return program
