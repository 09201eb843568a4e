"""Scenes whose steps in space are timed."""

from __future__ import annotations

import numpy as np
import pytest

from tools.space_steps import LANES, lane_set, microseconds


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


@pytest.mark.speed
@pytest.mark.parametrize(
    ("engine", "scene", "most"),
    [
        # Measured: 1.2, 1.5, 1.8, .72 and 8.2; with arrays of structs and sweeps of bodies at rest
        # 1.8, 2.3, 3.1, 1.05 and 9.1.
        ("impulse", "body, 4 points", 1.5),
        ("impulse", "body, 8 points", 2.0),
        ("impulse", "body, 12 points", 2.3),
        ("dem", "body, 4 points", 0.9),
        ("impulse", "two blocks", 9.0),
    ],
)
def test_a_step_in_space_costs_at_most_so_many_times_a_block(
    engine: str, scene: str, most: float
) -> None:
    sets = (lane_set("block"), lane_set(scene))
    runs = [[microseconds(engine, lanes) for lanes in sets] for _ in range(12)]
    # The first ones load the kernels. What else runs slows neighbours alike.
    assert np.median([other / block for block, other in runs[1:]]) <= most
