"""What a user may call: one list, and each name of it known by that name wherever it comes up."""

from __future__ import annotations

import ast
import pathlib
import pickle
import pydoc
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest

import warprock as wr

FRONT = pathlib.Path(wr.__file__)


def _imported_for_editors() -> dict[str, str]:
    """Name -> room, of the imports that only tools see which read the sources."""
    checked = next(
        node
        for node in ast.parse(FRONT.read_text(encoding="utf-8")).body
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    )
    return {
        alias.name: (node.module or "").removeprefix("warprock.")
        for node in checked.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


def test_there_is_one_list_of_public_names():
    assert dir(wr) == wr.__all__
    assert _imported_for_editors() == wr._HOME
    code = "import warprock, warprock.api.run, warprock.cli.main; print(*dir(warprock))"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.split() == wr.__all__


@pytest.mark.parametrize("name", wr.__all__)
def test_a_public_name_pickles_and_is_known_by_it(name: str):
    value = getattr(wr, name)
    again = pickle.loads(pickle.dumps(value))
    if callable(value):
        assert again is value
        assert (value.__module__, value.__qualname__) == ("warprock", name)
        shown = pydoc.render_doc(value, renderer=pydoc.plaintext).splitlines()[0]
        assert shown.endswith(f"{name} in module warprock")
    else:
        assert again == value


def test_runs_go_to_worker_processes():
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        change = {"run.duration": "1 s"}
        run = pool.submit(wr.run, "free-b0", "housner", overrides=change, progress=False).result()
    assert run.engine == "housner"
    assert len(run.table) == 2


def test_no_room_has_the_name_of_a_command():
    rooms = {path.parent.name for path in FRONT.parent.glob("*/__init__.py")}
    assert not rooms & set(wr.__all__)
