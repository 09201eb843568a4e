"""Contact points above the ground: those that touch as a body leans, and no others."""

from __future__ import annotations

import numpy as np
import pytest

from warprock.bodies.footing import footing_of
from warprock.bodies.raised import AROUND, LEANS, flat_points, raise_points
from warprock.bodies.rests import heights_at

TOLERANCE = 1e-3
FOOT, SKIRT, TOP = 0.1, 0.2, 0.15


def _ring(radius: float, height: float) -> np.ndarray:
    around = 2.0 * np.pi * np.arange(8) / 8
    return np.column_stack(
        [radius * np.cos(around), radius * np.sin(around), np.full(8, height - 0.5)]
    )


def test_a_skirt_above_the_foot_touches_as_the_body_leans():
    """Foot of 0.1 m, skirt of 0.2 m at a height of 20 mm: it touches at a lean of atan(0.2)."""
    hull = np.vstack([_ring(FOOT, 0.0), _ring(SKIRT, 0.02), _ring(TOP, 1.0)])
    footing = footing_of(hull, np.zeros(3), TOLERANCE)
    found = raise_points(hull, footing, 24, TOLERANCE)
    np.testing.assert_allclose(np.sort(found[:, 2]), np.repeat([-0.5, -0.48], 8))
    # With all that can touch, the centre is as high as on the whole hull, however it leans.
    np.testing.assert_allclose(
        heights_at(found, AROUND, LEANS), heights_at(hull, AROUND, LEANS), atol=1e-12
    )
    assert len(flat_points(footing, 24)) == 8


def test_few_points_are_those_that_matter_most():
    hull = np.vstack([_ring(FOOT, 0.0), _ring(SKIRT, 0.02)])
    footing = footing_of(hull, np.zeros(3), TOLERANCE)
    errors = []
    for most in (8, 12, 16):
        found = raise_points(hull, footing, most, TOLERANCE)
        assert len(found) == most
        error = heights_at(hull, AROUND, LEANS) - heights_at(found, AROUND, LEANS)
        assert error.min() >= 0.0
        errors.append(error.max())
    assert errors[0] > errors[1] > errors[2] == pytest.approx(0.0, abs=1e-12)


def test_a_flat_base_has_none_above_it():
    box = np.array([(x, y, z) for x in (-0.2, 0.2) for y in (-0.3, 0.3) for z in (-0.6, 0.6)])
    footing = footing_of(box, np.zeros(3), TOLERANCE)
    found = raise_points(box, footing, 24, TOLERANCE)
    assert sorted(map(tuple, found)) == sorted(map(tuple, box[box[:, 2] < 0.0]))
