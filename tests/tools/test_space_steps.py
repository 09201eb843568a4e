"""Scenes whose steps in space are timed."""

from __future__ import annotations

import numpy as np
import pytest

from tools.space_steps import LANES, lane_set


@pytest.mark.parametrize("points", [4, 8])
def test_a_body_on_points_is_the_box(points: int) -> None:
    box, body = lane_set("block").lanes, lane_set(f"body, {points} points").lanes
    assert box.lane_count == body.lane_count == LANES
    assert body.body is not None
    assert body.body.points.shape[1] == points
    np.testing.assert_allclose(body.body.mass, box.mass, rtol=1e-9)
    # They stand as wide and as deep.
    sizes = np.ptp(body.body.points[0], axis=0)[:2]
    np.testing.assert_allclose(sorted(sizes), [0.2, 0.4], rtol=1e-9)
