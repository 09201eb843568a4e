"""Plain loops over Housner's equation: right, or they would be no rivals."""

from __future__ import annotations

import math
import sys

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.blocks import make_lanes
from tests.shared.marks import first
from warprock.model.motion import StillBase
from warprock.model.response import SampleTimes
from warprock.programs.loops import numba_loop, plain_loop, scipy_loop
from warprock.running.batch import run_batch
from warprock.units import GRAVITY

WIDTH, HEIGHT = 0.4, 1.7
TIMES = SampleTimes(3.0, 0.01)
RATIOS = np.array([-0.87, -0.31, 0.12, 0.55, 0.93])


def right() -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], tuple[float, float, float]]:
    """Starts and rotations of `housner`, and the block as loops take it."""
    lanes = make_lanes(WIDTH, HEIGHT, RATIOS)
    square = 1.5 * GRAVITY / math.hypot(WIDTH, HEIGHT)
    block = float(lanes.slenderness_angle[0]), square, float(lanes.angular_restitution[0])
    rotation = run_batch("housner", lanes, StillBase(len(RATIOS)), TIMES)["rotation"]
    return lanes.rotation_start, rotation, block


def test_the_loop_of_steps_is_of_fourth_order_through_impacts() -> None:
    starts, rotation, block = right()
    loop, errors = plain_loop(lambda function: function), []
    for step in (0.02, 0.01):
        seen = np.empty_like(rotation)
        loop(starts, *block, step, 0.01, seen)
        errors.append(np.abs(seen - rotation).max())
    assert errors[0] < 1e-6
    # 16 for the fourth order; the step that an impact cuts is short by chance.
    assert errors[0] / errors[1] > 8.0


@pytest.mark.parametrize("method", first(1, ["DOP853", "RK45", "LSODA"]))
def test_the_loop_in_scipy_goes_to_the_answer_with_its_tolerance(method: str) -> None:
    starts, rotation, block = right()

    def error(tolerance: float) -> float:
        found = [scipy_loop(s, *block, method, tolerance, TIMES.times) for s in starts]
        return float(np.abs(np.array(found) - rotation).max())

    assert error(1e-10) < 1e-7 < error(1e-4)


@pytest.mark.parametrize("step", [0.4, 0.05])
def test_a_block_that_has_come_to_rest_stays(step: float) -> None:
    """A swing shorter than a step, or than times resolve, neither hangs nor lifts it again."""
    _, _, block = right()
    seen = np.empty((2, 4001))
    plain_loop(lambda function: function)(np.array([1e-6, -1e-3]), *block, step, 0.01, seen)
    assert np.all(seen[:, -1] == 0.0)
    assert np.abs(seen).max() <= 1e-3


def test_numba_gives_what_python_gives() -> None:
    pytest.importorskip("numba", reason="pip install numba")
    starts, rotation, block = right()
    seen, compiled = np.empty_like(rotation), np.empty_like(rotation)
    plain_loop(lambda function: function)(starts, *block, 0.03, 0.01, seen)
    numba_loop()(starts, *block, 0.03, 0.01, compiled)
    np.testing.assert_allclose(compiled, seen, rtol=0.0, atol=1e-11)


def test_without_numba_one_line_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)
    with pytest.raises(ImportError, match="pip install numba installs it"):
        numba_loop()
