"""Pages that Python saves have a player, as those of the commands have."""

from __future__ import annotations

import pathlib
from collections.abc import Callable
from typing import Any

import pytest

import warprock as wr
from tests.report.test_replays import scenes
from tests.shared.marks import first

pytestmark = pytest.mark.usefixtures("nothing_rendered")

PULSE = {"motion.waveform": "sine", "motion.cycles": 1, "run.duration": "4 s"}


def _ida() -> Any:
    over = PULSE | {"motion.frequency": "1 Hz", "motion.amplitude": "0.3 g"}
    asked: Any = {"from_": 0.2, "to": 3.0, "count": 4, "accuracy": 0.1, "im": "factor"}
    return wr.ida("single-sine-pulse", "housner", overrides=over, progress=False, **asked)


def _map() -> Any:
    over = PULSE | {"motion.frequency": ["1 Hz"], "motion.amplitude": ["0.01 g", "0.15 g"]}
    return wr.map("overturning-map", "housner", overrides=over, progress=False)


def _spectrum() -> Any:
    over = {"spectrum.period": ["2 s", "4 s"], "spectrum.slenderness": ["10 deg"]}
    shorter = over | {"run.duration": "4 s"}
    return wr.spectrum("rocking-spectrum", "housner", overrides=shorter, progress=False)


def _compare() -> Any:
    over = {"run.duration": "2 s"}
    return wr.compare("free-b0", ["housner", "event"], overrides=over, progress=False)


def _fragility() -> Any:
    run = wr.run("sobol-single-block", "housner", overrides={"sample.lanes": 64}, progress=False)
    return wr.fragility(run, limit="overturning", max_doubt=1)


@pytest.mark.parametrize("found", first(1, [_ida, _map, _spectrum, _compare, _fragility]))
def test_a_page_saved_from_python_plays_lanes(found: Callable[[], Any], tmp_path: pathlib.Path):
    found().save(tmp_path)
    played = scenes(tmp_path)
    assert played["lanes"]
    assert all(block["r"] for lane in played["lanes"] for block in lane["blocks"])
