"""Springs under bodies in space, in NumPy: where they are those of a box, and what they bear."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.space_bodies import (
    ROCK_POINTS,
    ROCK_TENSOR,
    body_lanes,
    box_as_body,
    some_boxes,
)
from warprock.engines.dem import Dem
from warprock.engines.dem_bodies_space import PointSprings, base_area
from warprock.engines.dem_springs_space import spatial_frequencies, start_in_space
from warprock.model.turning import rotate
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

CORNERS = DemSettings(subcontacts=2, subcontacts_across=2)


def test_springs_under_the_corners_of_a_box_are_those_of_the_box():
    boxes = some_boxes()
    springs = PointSprings.of(box_as_body(boxes), CORNERS)
    np.testing.assert_allclose(4.0 * springs.area, boxes.width * boxes.depth)
    expected = spatial_frequencies(boxes, CORNERS)[:, -1]
    # The box's are rounded to 30 bits.
    np.testing.assert_allclose(springs.stiffest_frequency(), expected, rtol=1e-8)
    place, attitude = springs.start()
    start = start_in_space(boxes, CORNERS)
    for axis, name in enumerate("xyz"):
        np.testing.assert_allclose(place[:, axis], start[name][:, 0], atol=1e-12)
    for part, name in enumerate(("qx", "qy", "qz", "qw")):
        np.testing.assert_allclose(attitude[:, part], start[name][:, 0], atol=1e-12)
    reserve = Dem(CORNERS).reserve
    np.testing.assert_allclose(reserve(box_as_body(boxes))[0], reserve(boxes)[0], rtol=1e-12)


def test_a_body_at_rest_is_borne_where_its_weight_is():
    lanes = body_lanes(ROCK_POINTS, ROCK_TENSOR, 1, yaw_start=0.7)
    springs = PointSprings.of(lanes, CORNERS)
    place, attitude = springs.start()
    arms = rotate(attitude[:, None], springs.body.points_in_block_axes)[0]
    # Heights are over that of the rigid body at rest; the sixth point hangs 5 cm above the base.
    depth = -(place[0, 2] + springs.body.centre_height[0] + arms[:, 2])
    force = springs.stiffness[0] * np.maximum(depth, 0.0)
    assert force[5] == 0.0
    weight = GRAVITY * springs.body.mass[0]
    # What is left is of second order in a lean of some 1e-5, over an overlap of 1e-5 m.
    assert force.sum() == pytest.approx(weight, rel=1e-4)
    np.testing.assert_allclose(force @ arms[:, :2], 0.0, atol=1e-4 * weight * 0.3)


def test_the_area_of_a_base_is_that_of_its_hull():
    square = [(-0.1, -0.1, -0.3), (0.1, 0.1, -0.3), (-0.1, 0.1, -0.3), (0.1, -0.1, -0.3)]
    inside = [(0.0, 0.0, -0.3), (0.05, 0.02, -0.3), (0.1, 0.0, -0.3), (0.3, 0.0, -0.2)]
    lanes = body_lanes(np.array(square + inside), ROCK_TENSOR, 2)
    assert lanes.body is not None
    np.testing.assert_allclose(base_area(lanes.body), 0.04)
    # Of two lowest points all make the base.
    lanes = body_lanes(np.array([*square[:2], (0.2, -0.2, -0.29)]), ROCK_TENSOR, 1)
    assert lanes.body is not None
    np.testing.assert_allclose(base_area(lanes.body), 0.04)
