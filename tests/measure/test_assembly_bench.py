"""How collapse loads are found and costs are held against one another; nothing runs."""

from __future__ import annotations

import numpy as np
import pytest

from warprock.measure.assembly_bench import CLOSE, FAR, _collapse, bench_scenes, cheaper_than


@pytest.mark.parametrize("at_once", [1, 5, 32])
def test_a_collapse_load_is_found_as_closely_as_asked_for(at_once: int):
    scene = bench_scenes()[0]
    true = 1.07 * scene.low

    def moves(_kind, loads):
        return np.where(loads > true, 2.0 * FAR, 0.0)

    assert _collapse(scene, moves, at_once) == pytest.approx(true, abs=CLOSE * scene.low)


def test_costs_are_held_against_runs_that_err_no_more():
    def row(engine: str, error: float, cpu: float):
        return {"engine": engine, "error_mm": error, "cpu_ms": cpu}

    rows = [row("assembly", 0.4, 10.0), row("assembly", 0.1, 30.0), row("bullet", 0.2, 900.0)]
    assert cheaper_than(rows) == {"bullet": pytest.approx(30.0)}
    rows += [row("bullet", 1.0, 200.0), row("mujoco", 0.05, 50.0)]
    assert cheaper_than(rows) == {"bullet": pytest.approx(20.0)}
