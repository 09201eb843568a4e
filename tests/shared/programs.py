"""Programs that we did not write, as tests look for them."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Callable
from typing import Any

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


def outside(test: Callable[..., None]) -> Any:
    """Marks a test that takes up to a minute to compile."""
    reason = "takes up to a minute to compile; WARPROCK_OUTSIDE=1 runs it"
    skip = pytest.mark.skipif("WARPROCK_OUTSIDE" not in os.environ, reason=reason)
    return pytest.mark.extra(skip(test))


def in_newton_xpbd(test: Callable[..., None]) -> Any:
    """Marks a test of Newton's SolverXPBD: one worker runs all of them and compiles it once."""
    return pytest.mark.xdist_group("newton-xpbd")(outside(test))
