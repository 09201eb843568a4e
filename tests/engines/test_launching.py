"""What a kernel is given of a batch."""

from __future__ import annotations

import numpy as np
import pytest

from warprock.engines import launching
from warprock.kernels.launch.instance import LANE_WIDTH, kernel_module


@pytest.mark.parametrize("engine", ["housner", "event", "impulse"])
def test_lanes_that_fill_up_a_pack_start_as_the_last_one(engine: str) -> None:
    # A pack reads all of its lanes; beyond the end of an array lies anything.
    module = kernel_module(
        f"{engine}/block_run", precision="float64", motion="harmonic", lanes=LANE_WIDTH
    )
    starts = np.linspace(0.1, 0.2, 5)
    taken = {each.label: each for each in module.run_lanes.adj.args}["starts"]
    given = launching._argument(taken, starts, LANE_WIDTH, "cpu").numpy()
    np.testing.assert_array_equal(given[:5], starts)
    np.testing.assert_array_equal(given[5:], np.full(LANE_WIDTH - 5, starts[-1]))
