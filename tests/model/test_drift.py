"""A record that carries its base away is told from one that does not."""

import numpy as np
import pytest

import warprock as wr
from warprock.model.drift import drift_text

TIMES = np.arange(0.0, 20.005, 0.01)


def said(folder, offset: float) -> str:
    """Of an acceleration with an offset [m/s^2]: it leaves offset T^2 / 2 behind."""
    acceleration = offset + 0.0 * TIMES
    file = wr.save_record(folder / "q.csv", acceleration, interval="10 ms", unit="m/s^2")
    tables = {"motion.record": file, "motion.scale": 1.0, "check": [], "run.duration": "20 s"}
    return drift_text(wr.expand_lanes(wr.load_case("record-ridgecrest", tables)).motions)


@pytest.mark.parametrize("left", [1.2, 15.7, -15.7])
def test_what_is_left_behind_is_said(tmp_path, left):
    offset = 2.0 * left / TIMES[-1] ** 2
    assert said(tmp_path, offset).startswith(f"the base ends {abs(left):.3g} m from where")


def test_little_is_no_drift(tmp_path):
    assert said(tmp_path, 2.0 * 0.8 / TIMES[-1] ** 2) == ""
    for name in ("record-ridgecrest", "free-b0", "single-sine-pulse", "space-biaxial"):
        assert drift_text(wr.expand_lanes(wr.load_case(name)).motions) == ""
