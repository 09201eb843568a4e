"""Bodies: hulls, arcs, principal axes, and what follows from a base in the plane and in space."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.planar_bodies import planar_bodies
from warprock.model import rocking
from warprock.model.bodies import Bodies
from warprock.model.hull import lower_hull, rounded_centres
from warprock.model.turning import inverse, principal_axes, rotate
from warprock.units import GRAVITY

STEPPED = np.array([[-0.14, -0.3], [0.1, -0.3], [0.16, -0.285], [0.2, -0.25]])


def in_space(points: np.ndarray, tensor: np.ndarray, mass: float = 100.0) -> Bodies:
    """One body in space, its points from the centre of mass along the axes of the block."""
    moments, axes = principal_axes(tensor)
    back = inverse(axes)
    return Bodies(
        mass=np.array([mass]),
        gyration=moments[None] / mass,
        points=rotate(back, points)[None],
        count=np.array([len(points)], np.int32),
        corner_radius=np.zeros(1),
        axes=axes[None],
    )


def test_a_rectangle_has_the_closed_forms_of_housner():
    width, height, mass = 0.4, 1.1, 250.0
    inertia = mass * (width**2 + height**2) / 12.0
    base = 0.5 * np.array([[-width, -height], [width, -height]])
    body = planar_bodies(mass=mass, inertia=inertia, points=base)
    angle = rocking.slenderness_angle(width, height)
    np.testing.assert_allclose(body.slenderness_angles, angle, rtol=1e-15)
    np.testing.assert_allclose(body.uplift_ratios, width / height, rtol=1e-15)
    np.testing.assert_allclose(
        body.angular_restitutions, rocking.angular_restitution(angle), rtol=1e-14
    )
    np.testing.assert_allclose(
        body.frequency_parameter, rocking.frequency_parameter(width, height), rtol=1e-14
    )
    np.testing.assert_allclose(body.reaches, rocking.half_diagonal(width, height), rtol=1e-15)


def test_the_lower_hull_keeps_what_can_touch_flat_ground():
    inner, beside = [[0.0, -0.29], [0.15, -0.28]], [[0.1, 0.4], [-0.14, 0.1], [-0.14, -0.3]]
    middle = [[0.0, -0.3]]
    shuffled = np.concatenate([STEPPED[::-1], inner, beside, middle])
    found = lower_hull(shuffled)
    np.testing.assert_array_equal(found, np.insert(STEPPED, 1, middle, axis=0))


def test_arcs_touch_both_edges_that_meet_in_a_corner():
    radius = 0.02
    (centres,) = rounded_centres(STEPPED[None], np.array([radius]))
    for first, second, a, b in zip(
        STEPPED[:-1], STEPPED[1:], centres[:-1], centres[1:], strict=True
    ):
        along = (second - first) / np.linalg.norm(second - first)
        for centre in (a, b):
            far = along[0] * (centre - first)[1] - along[1] * (centre - first)[0]
            assert far == pytest.approx(radius, rel=1e-12)
    # Beside the ends the vertical is the other edge.
    assert centres[0, 0] == pytest.approx(STEPPED[0, 0] + radius)
    assert centres[-1, 0] == pytest.approx(STEPPED[-1, 0] - radius)
    repeated = np.concatenate([STEPPED, STEPPED[-1:]])
    (padded,) = rounded_centres(repeated[None], np.array([radius]))
    np.testing.assert_array_equal(padded, np.concatenate([centres, centres[-1:]]))


def test_the_centre_of_mass_moves_as_of_a_body_that_rolls():
    body = planar_bodies(mass=300.0, inertia=12.0, points=STEPPED, corner_radius=0.02)
    turn = np.linspace(-1.2, 1.2, 10_001)[None]
    x, z = body.roll_centres(turn)
    # What the centre moves along is its height times the turn; the rule errs by (1e-4)^2.
    moved = np.cumsum(0.5 * (z[0, 1:] + z[0, :-1]) * np.diff(turn[0]))
    np.testing.assert_allclose(x[0, 1:] - x[0, 0], moved, atol=1e-8)
    assert z[0, 5000] == pytest.approx(0.3)
    assert x[0, 5000] == pytest.approx(0.0, abs=1e-15)


def test_the_highest_centre_is_that_of_the_slenderness_angle():
    body = planar_bodies(mass=300.0, inertia=12.0, points=STEPPED, corner_radius=0.01)
    turn = np.linspace(-1.5, 1.5, 300_001)
    _, z = body.roll_centres(turn[None])
    left, right = turn <= 0.0, turn >= 0.0
    highest = [-turn[left][np.argmax(z[0, left])], turn[right][np.argmax(z[0, right])]]
    np.testing.assert_allclose(body.slenderness_angles[0], highest, atol=1e-5)


def test_in_space_the_base_is_left_where_the_line_leaves_its_hull():
    # A triangle with a point inside and one above the ground, which say nothing at rest.
    points = np.array(
        [[-0.3, -0.2, -0.5], [0.4, -0.2, -0.5], [0.0, 0.3, -0.5], [0.0, 0.0, -0.5], [2.0, 2.0, 0.0]]
    )
    tensor = np.array([[9.0, 0.4, 0.2], [0.4, 7.0, -0.3], [0.2, -0.3, 5.0]])
    body = in_space(points, tensor)
    assert body.standing.tolist() == [[True, True, True, True, False]]
    np.testing.assert_allclose(body.centre_height, 0.5)
    # Along x the sides of the triangle are met where y = 0.
    np.testing.assert_allclose(body.base_ends, [[-0.18, 0.24]], rtol=1e-12)
    np.testing.assert_allclose(body.reach(np.array([0.5 * np.pi])), [[-0.2, 0.3]], rtol=1e-12)
    np.testing.assert_allclose(body.uplift_ratios, [[0.36, 0.48]], rtol=1e-12)
    about_y = np.array([0.0, 1.0, 0.0]) @ tensor @ np.array([0.0, 1.0, 0.0])
    np.testing.assert_allclose(body.gyration_in_plane, about_y / 100.0, rtol=1e-12)
    radius = np.hypot(0.18, 0.5)
    rate = np.sqrt(GRAVITY * radius / (about_y / 100.0 + radius**2))
    np.testing.assert_allclose(body.frequency_parameter, rate, rtol=1e-12)


def test_some_of_many_bodies():
    body = planar_bodies(mass=[1.0, 2.0, 3.0], inertia=0.5, points=STEPPED)
    part = body.take(np.array([2, 0]))
    assert part.mass.tolist() == [3.0, 1.0]
    for field in dataclasses.fields(part):
        assert len(getattr(part, field.name)) == 2
