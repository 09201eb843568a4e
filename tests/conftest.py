"""What several test files share: the sources, a fresh interpreter, a case's file, a small sweep."""

from __future__ import annotations

import base64
import contextlib
import dataclasses
import gc
import os
import pathlib
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

ROOT = pathlib.Path(__file__).resolve().parent.parent

settings.register_profile("any speed", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("any speed")  # no test depends on how fast the machine is

LONGEST = (
    "programs/test_newton.py",
    "engines/test_contract.py",
    "paper/test_stack.py",
    "engines/test_event_body.py",
    "engines/test_box_friction.py",
    "engines/test_event_space.py",
    "engines/test_forms.py",
    "engines/test_event_stack.py",
    "running/test_tolerance_truth.py",
    "cli/test_main.py",
    "engines/test_framed_stack.py",
    "oracle/test_pair.py",
    "figures/test_run.py",
    "engines/test_event_space_stack.py",
    "engines/test_contract_scenes.py",
    "measure/test_trade.py",
    "sweeps/test_harm.py",
    "engines/test_cuda.py",
    "paper/test_reproduce.py",
    "engines/test_vertical.py",
    "engines/test_two_block.py",
    "engines/test_assembly.py",
    "engines/test_dem_space.py",
    "engines/test_spatial_bodies.py",
)
"""Files that take the longest, under `tests/`; such as compile the same kernels stand apart."""

# The process that hands tests to the workers reads this file and no other: what it imports here it
# imports for nothing.

# Half a million objects are made while tests are imported, and stay. To look at all of them again
# for garbage takes half a second, several times a minute.
gc.disable()
gc.set_threshold(20_000)  # to look at every 700 objects, as Python does, takes a twelfth of a test


def pytest_collection_finish() -> None:
    """Garbage is looked for from here on, and only among what the tests themselves make."""
    gc.freeze()
    gc.enable()


class FromTheEnd(pytest.Dir):
    """A folder whose last file is imported first."""

    def collect(self) -> Iterable[pytest.Item | pytest.Collector]:
        """What lies in it, from the last to the first."""
        return reversed(list(super().collect()))


def pytest_collect_directory(path: pathlib.Path, parent: pytest.Collector) -> FromTheEnd | None:
    """One of two workers begins at the end.

    Where nothing is compiled to bytecode yet, as in a new environment, each finds done what the
    other has imported.
    """
    if os.environ.get("PYTEST_XDIST_WORKER") != "gw1":
        return None
    return FromTheEnd.from_parent(parent, path=path)


APART = ("speed", "thorough", "gpu")
"""Marks of runs of their own: what had two of them would run in both."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest files first: at the end no worker waits long for the other."""
    for item in items:
        if sum(item.get_closest_marker(mark) is not None for mark in APART) > 1:
            raise pytest.UsageError(f"{item.nodeid}: has more than one of the marks {APART}")
    places = {ROOT / "tests" / name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: (places.get(item.path, len(places)), item.path))


@pytest.fixture(autouse=True)
def figures_closed() -> Iterator[None]:
    """Closes the figures that a test kept to look at, so that they do not count in the next."""
    yield
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close("all")


ONE_PIXEL = (
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk"
    "YPhfDwAChwGA60e6kgAAAABJRU5ErkJggg=="
)
"""A PNG."""


@contextlib.contextmanager
def _no_figure_rendered() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("warprock.figures.drawing.Drawing.png", lambda _: base64.b64decode(ONE_PIXEL))
        patch.setattr("warprock.figures.drawing.Drawing.svg", lambda _: "<svg></svg>")
        yield


@pytest.fixture
def unrendered() -> Iterator[None]:
    """Figures are made, named and told in words, but their files hold one pixel: no test sees them.

    Every kind is laid out and rendered in `figures`, `tables/test_report.py`, or in the test of the
    command that draws it.
    """
    with _no_figure_rendered():
        yield


@pytest.fixture
def pages_bare(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are rendered as files, and not once more for the page."""
    monkeypatch.setattr("warprock.figures.drawing.Drawing.svg", lambda _: "<svg></svg>")


@pytest.fixture(scope="module")
def nothing_rendered() -> Iterator[None]:
    """The same for all tests of a file."""
    with _no_figure_rendered():
        yield


@pytest.fixture(scope="session")
def root() -> pathlib.Path:
    """The checkout."""
    return ROOT


@pytest.fixture(scope="session")
def python() -> Callable[..., subprocess.CompletedProcess[str]]:
    """Runs a fresh interpreter with some arguments and returns what it did."""

    def run(*arguments: str, cwd: pathlib.Path | None = None) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, *arguments],
            cwd=cwd or ROOT,
            capture_output=True,
            text=True,
            check=False,
            timeout=300,
        )

    return run


@pytest.fixture
def interruptible() -> Iterator[None]:
    """SIGINT interrupts, here and in what is started here.

    A shell without job control lets what it starts in the background ignore SIGINT, and so do the
    tests that it starts there, and all that they start.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="module")
def two_rooms() -> Iterator[None]:
    """Kernels of assemblies have room for 32 blocks and joints or for 112, and for trees.

    So that tests share them: each takes 4 s to compile. How much room there is changes no bit, as
    `test_no_lane_depends_on_its_neighbours` shows of both.
    """
    from warprock.engines import assembly

    own_room, kernel_of = assembly.room_for, assembly.Assembly.kernel_of

    def shared_room(count: int) -> int:
        return 33 if count <= 33 else max(113, own_room(count))

    def shared_kernel(engine: Any, scene: Any) -> Any:
        found = kernel_of(engine, scene)
        fits = found.name == "assembly_run" and not found.springs
        return dataclasses.replace(found, trees=True) if fits else found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(assembly, "room_for", shared_room)
        patch.setattr(assembly.Assembly, "kernel_of", shared_kernel)
        yield


@pytest.fixture
def unjudged(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets lanes through to the kernels that `run_batch` refuses: they, too, must hold them."""
    monkeypatch.setattr("warprock.running.batch.require_runnable", lambda *_: None)


@pytest.fixture
def write(tmp_path: pathlib.Path) -> Callable[[str], pathlib.Path]:
    """Writes the text of a case to a file of its own."""

    def written(text: str) -> pathlib.Path:
        file = tmp_path / "case.toml"
        file.write_text(text, encoding="utf-8")
        return file

    return written


@pytest.fixture(scope="session")
def case_file(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """The case of a small sweep."""
    from tests.shared.sweeps import write_case

    return write_case(tmp_path_factory.mktemp("case"))


@pytest.fixture(scope="session")
def undisturbed(case_file: pathlib.Path, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The merged table of that sweep, made in one chunk."""
    from tests.shared.sweeps import LANES, merged_bytes

    return merged_bytes(case_file, tmp_path_factory.mktemp("one"), LANES)
