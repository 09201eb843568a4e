"""Engines that other packages bring: the one in `examples/engine` keeps the contract."""

from __future__ import annotations

import inspect
import pathlib
import shutil
import tomllib
from collections.abc import Iterator

import numpy as np
import pytest

from tests.engines import test_contract
from tests.shared.blocks import free_lanes
from tests.shared.commands import invoke, succeed
from warprock import plugins
from warprock.engines import ENGINES, engine_class
from warprock.errors import InputError
from warprock.model.motion import StillBase
from warprock.model.response import SampleTimes
from warprock.running.batch import run_batch
from warprock.settings.engines import SETTINGS

EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples" / "engine"

CONTRACT = {
    name: test
    for name, test in vars(test_contract).items()
    if name.startswith("test_") and "engine" in inspect.signature(test).parameters
}


def bring(folder: pathlib.Path, monkeypatch: pytest.MonkeyPatch, points: dict[str, str]) -> None:
    """Lays a package with entry points where Python finds it, as an installation would."""
    info = folder / "rocking_rk4-1.0.dist-info"
    info.mkdir()
    head = "Metadata-Version: 2.1\nName: rocking-rk4\nVersion: 1.0\n"
    (info / "METADATA").write_text(head, encoding="utf-8")
    rows = "\n".join(f"{name} = {value}" for name, value in points.items())
    (info / "entry_points.txt").write_text(f"[{plugins.GROUP}]\n{rows}\n", encoding="utf-8")
    monkeypatch.syspath_prepend(folder)
    plugins.brought.cache_clear()


@pytest.fixture
def forgotten() -> Iterator[None]:
    """What other packages bring is looked for again after the test."""
    yield
    plugins.brought.cache_clear()


@pytest.fixture
def rk4(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, forgotten: None) -> str:
    """The engine of the example, as if it were installed."""
    shutil.copy(EXAMPLE / "rocking_rk4.py", tmp_path)
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    bring(tmp_path, monkeypatch, project["entry-points"][plugins.GROUP])
    return "rk4"


def test_it_is_there_by_its_name(rk4: str) -> None:
    assert rk4 in ENGINES
    assert list(ENGINES)[-1] == rk4
    assert "rk4 " in succeed("list").output
    explained = succeed("explain", "free-b0").output
    assert "rocking_rk4, of the package rocking-rk4" in explained
    assert "time_step = 0.002 s" in explained
    assert "rk4: declines: rk4 runs single blocks" in succeed("explain", "stack-sine-pulse").output


def test_it_runs_a_case_with_settings_and_refuses_others(rk4: str) -> None:
    short = ("-e", rk4, "-s", "run.duration=0.5 s", "--no-estimate")
    told = succeed("run", "free-b0", *short, "-s", "engines.rk4.time_step=5 ms", "--json").output
    assert '"engine"' in told
    refused = invoke("run", "free-b0", *short, "-s", "engines.rk4.time_step=1 s")
    assert refused.exit_code == 2
    assert "engines.rk4.time_step" in refused.stderr
    assert refused.stderr.count("\n") == 1


def test_its_error_falls_at_least_with_the_first_power_of_its_step(rk4: str) -> None:
    lanes, still, times = free_lanes(), StillBase(9), SampleTimes(1.5, 0.05)
    exact = run_batch("housner", lanes, still, times)["rotation"]
    error = [
        np.abs(
            run_batch(rk4, lanes, still, times, settings=SETTINGS[rk4](time_step=step))["rotation"]
            - exact
        ).max()
        for step in (8e-3, 4e-3, 2e-3)
    ]
    # The lane from 0.99 of its slenderness angle is not yet in the range of the asymptote.
    assert np.all(np.diff(np.log2(error)) < -0.9)
    assert error[-1] < 1e-3


@pytest.mark.thorough
@pytest.mark.usefixtures("unjudged")
@pytest.mark.parametrize("promise", CONTRACT)
def test_it_keeps_the_contract(rk4: str, promise: str) -> None:
    test = CONTRACT[promise]
    more = {"unjudged": None} if "unjudged" in inspect.signature(test).parameters else {}
    test(rk4, **more)


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ({"housner": "rocking_rk4:RungeKutta"}, "must not be the name of an engine that warprock"),
        ({"rk4": "no_such_module:RungeKutta"}, "must load: No module named 'no_such_module'"),
        ({"rk4": "rocking_rk4:Nothing"}, "must load: module 'rocking_rk4' has no attribute"),
        ({"rk4": "rocking_rk4:RungeKuttaSettings"}, "must be a class of AbstractEngine"),
        ({"rk": "rocking_rk4:RungeKutta"}, "must be rk, the name of its entry point"),
    ],
    ids=["name taken", "no module", "no class", "another class", "another name"],
)
def test_one_that_breaks_the_contract_is_refused_by_the_name_of_its_package(
    points: dict[str, str],
    said: str,
    tmp_path: pathlib.Path,
    monkeypatch: pytest.MonkeyPatch,
    forgotten: None,
) -> None:
    shutil.copy(EXAMPLE / "rocking_rk4.py", tmp_path)
    bring(tmp_path, monkeypatch, points)
    with pytest.raises(InputError, match=said) as error:
        [engine_class(name) for name in ENGINES]
    assert str(error.value).startswith("rocking-rk4: ")
