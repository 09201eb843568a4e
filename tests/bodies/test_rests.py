"""Poses at rest of bodies whose poses are known, and the height of a centre that rolls."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from tests.shared.meshes import cap, l_profile, tetrahedron, turned
from warprock.bodies.mesh import Solid, solid_of
from warprock.bodies.rests import (
    DOWN,
    heights_at,
    hull_points,
    rest_at,
    rests_of,
    stands,
    turns_over,
)

TOLERANCE = 1e-3


def _solid(mesh: trimesh.Trimesh) -> Solid:
    return solid_of(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces))


def _stands(solid: Solid) -> bool:
    points = hull_points(solid) - solid.centre
    return stands(points, rest_at(points, DOWN, TOLERANCE).footing)


def test_a_box_rests_on_its_six_faces_the_scanned_one_first():
    rests = rests_of(_solid(trimesh.creation.box((0.4, 0.6, 1.2))), TOLERANCE)
    turns = np.degrees([rest.turn for rest in rests])
    np.testing.assert_allclose(turns, [0, 90, 90, 90, 90, 180], atol=1e-6)
    heights = [rest.footing.height for rest in rests]
    np.testing.assert_allclose(heights, [0.6, *sorted(heights[1:5]), 0.6])
    np.testing.assert_allclose(sorted(heights), [0.2, 0.2, 0.3, 0.3, 0.6, 0.6])
    assert rests[0].footing.slenderness_angle == pytest.approx(np.arctan(0.2 / 0.6))


def test_a_tetrahedron_turned_by_ten_degrees_settles_back():
    mesh = turned(tetrahedron(), 10.0, (1.0, -2.0, 0.0))
    solid = _solid(mesh)
    assert not _stands(solid)
    rest = rests_of(solid, TOLERANCE)[0]
    assert np.degrees(rest.turn) == pytest.approx(10.0, abs=1e-6)
    # The face below: a right triangle, its centre over (1/4, 1/4), nearest to a leg.
    assert rest.footing.height == pytest.approx(0.25)
    assert rest.footing.arm == pytest.approx(0.25)
    points = (solid.corners - solid.centre) @ rest.rotation.T
    assert np.sort(points[:, 2])[:3] == pytest.approx(-0.25)


def test_an_l_that_stands_on_its_foot_is_weaker_towards_its_upright_part():
    solid = _solid(l_profile())
    foot = next(r for r in rests_of(solid, TOLERANCE) if r.turn < 1e-6).footing
    assert foot.in_plane(np.array([np.pi]))[0] == pytest.approx(foot.slenderness_angle)
    assert foot.arm == pytest.approx(solid.centre[0])
    assert foot.height == pytest.approx(solid.centre[2])


def test_a_half_ball_stands_on_its_flat_side_alone():
    flat = _solid(cap(0.5))
    rest = rests_of(flat, TOLERANCE)[0]
    assert rest.turn < 1e-6
    # Its centre is 3/8 of the radius above the flat side; the ring has 96 corners.
    assert rest.footing.height == pytest.approx(3.0 / 16.0, rel=5e-3)
    assert rest.footing.arm == pytest.approx(0.5, rel=(np.pi / 96.0) ** 2)
    assert _stands(flat)


@pytest.mark.parametrize(
    "mesh",
    [
        trimesh.creation.icosphere(3, 0.5),
        turned(trimesh.creation.cylinder(0.3, 1.0, sections=64), 90.0, (0.0, 1.0, 0.0)),
    ],
    ids=["ball", "lying drum"],
)
def test_what_rolls_does_not_stand(mesh: trimesh.Trimesh):
    assert not _stands(_solid(mesh))
    assert not any(rest.turn < 0.5 for rest in rests_of(_solid(mesh), TOLERANCE))


def test_a_standing_drum_rests_on_its_two_ends():
    rests = rests_of(_solid(trimesh.creation.cylinder(0.3, 1.0, sections=64)), TOLERANCE)
    np.testing.assert_allclose(np.degrees([r.turn for r in rests]), [0.0, 180.0], atol=1e-6)


def test_a_pose_is_found_wherever_a_body_was_scanned():
    box = trimesh.creation.box((0.4, 0.6, 1.2))
    box.apply_translation((4e5, 5e6, 300.0))
    rests = rests_of(_solid(turned(box, 33.0, (1.0, 2.0, 3.0))), TOLERANCE)
    heights = sorted(rest.footing.height for rest in rests)
    # Coordinates of a map, 5e6 m, leave 1e-9 m.
    np.testing.assert_allclose(heights, [0.2, 0.2, 0.3, 0.3, 0.6, 0.6], atol=1e-7)


def test_the_centre_of_a_box_that_leans_is_on_a_circle():
    solid = _solid(trimesh.creation.box((0.4, 0.6, 1.2)))
    points = hull_points(solid) - solid.centre
    leans = np.radians([0.0, 10.0, 30.0])
    slender, radius = np.arctan2(0.2, 0.6), np.hypot(0.2, 0.6)
    found = heights_at(points, np.array([0.0]), leans)
    np.testing.assert_allclose(found[0], radius * np.cos(slender - leans), rtol=1e-12)
    over = turns_over(points, np.array([0.0, np.pi / 2]))
    np.testing.assert_allclose([fall.lean for fall in over], np.arctan([1 / 3, 0.5]), rtol=1e-12)
    rises = [np.hypot(0.2, 0.6) - 0.6, np.hypot(0.3, 0.6) - 0.6]
    np.testing.assert_allclose([fall.rise for fall in over], rises, rtol=1e-12)
