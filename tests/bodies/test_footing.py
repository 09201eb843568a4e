"""Slenderness angles by direction against those of a rectangle; polygons and their thinning."""

from __future__ import annotations

import numpy as np
import pytest

from warprock.bodies.footing import Footing, footing_of, hull_of, thin_polygon

RECTANGLE = np.array([(-0.1, -0.3), (0.2, -0.3), (0.2, 0.3), (-0.1, 0.3)])


def test_a_rectangle_beside_its_centre_is_weakest_across_its_nearest_edge():
    foot = Footing(RECTANGLE, 1.0)
    assert foot.arm == pytest.approx(0.1)
    assert sorted(foot.edge_directions()) == pytest.approx([-np.pi / 2, 0.0, np.pi / 2, np.pi])
    assert foot.slenderness_angle == pytest.approx(np.arctan(0.1))
    around = np.radians([0.0, 90.0, 180.0, 270.0, 45.0, 60.0])
    space = np.tan(foot.in_space(around))
    # At 45 degrees the edge x = 0.2 is met at 0.2 sqrt 2, at 60 degrees the edge y = 0.3.
    expected = [0.2, 0.3, 0.1, 0.3, 0.2 * np.sqrt(2.0), 0.3 / np.sin(np.pi / 3.0)]
    np.testing.assert_allclose(space, expected, rtol=1e-12)
    plane = np.tan(foot.in_plane(around))
    corner = [0.2 * c + 0.3 * s for c, s in ((0.5**0.5, 0.5**0.5), (0.5, 0.75**0.5))]
    np.testing.assert_allclose(plane, [0.2, 0.3, 0.1, 0.3, *corner], rtol=1e-12)


def test_both_angles_are_least_and_the_same_in_the_weakest_direction():
    random = np.random.default_rng(3)
    for _ in range(20):
        foot = Footing(hull_of(random.normal((0.05, 0.0), 0.3, (12, 2))), 0.8)
        if foot.arm <= 0.0:
            continue
        around = np.linspace(-np.pi, np.pi, 721)
        edges = foot.edge_directions()
        weakest = edges[[int(np.argmin(foot.in_plane(edges)))]]
        for angles in (foot.in_space, foot.in_plane):
            assert angles(weakest)[0] == pytest.approx(foot.slenderness_angle, rel=1e-9)
            assert angles(around).min() >= foot.slenderness_angle - 1e-12
        assert (foot.in_plane(around) >= foot.in_space(around) - 1e-12).all()


def test_the_tolerance_says_what_touches_the_ground():
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0.0005), (1, 1, 0.002), (0.5, 0.5, 2.0)])
    centre = np.array([0.4, 0.4, 1.0])
    assert len(footing_of(points, centre, 1e-4).polygon) == 2
    assert len(footing_of(points, centre, 1e-3).polygon) == 3
    found = footing_of(points, centre, 5e-3)
    assert len(found.polygon) == 4
    assert found.height == 1.0
    assert found.arm == pytest.approx(0.4)
    assert footing_of(points, centre, 1e-4).slenderness_angle == -np.pi / 2


def test_points_on_a_line_and_in_one_place_have_no_polygon():
    line = np.array([(0.0, 0.0), (1.0, 2.0), (0.5, 1.0), (2.0, 4.0)])
    np.testing.assert_array_equal(np.sort(hull_of(line), axis=0), [(0.0, 0.0), (2.0, 4.0)])
    assert len(hull_of(np.ones((3, 2)))) == 1


def test_a_round_base_is_thinned_evenly_and_by_what_that_costs():
    around = 2.0 * np.pi * np.arange(96) / 96
    base = Footing(np.column_stack([np.cos(around), np.sin(around)]), 1.0)
    few = Footing(thin_polygon(base.polygon, 24), 1.0)
    assert len(few.polygon) == 24
    # An inscribed polygon of 24 corners has its edges at cos(pi / 24).
    np.testing.assert_allclose(few._edges()[1], np.cos(np.pi / 24.0), rtol=1e-9)


def test_corners_on_straight_edges_go_and_others_stay():
    sides = np.array([(0, 0), (0.5, 0), (1, 0), (1, 0.3), (1, 1), (0, 1), (0, 0.5)], dtype=float)
    np.testing.assert_array_equal(thin_polygon(sides, 24), [(0, 0), (1, 0), (1, 1), (0, 1)])


def test_what_a_body_turns_about_in_a_direction_of_shaking_stays():
    random = np.random.default_rng(11)
    for _ in range(30):
        count = int(random.integers(20, 200))
        around = 2.0 * np.pi * (np.arange(count) + random.uniform()) / count
        sizes = random.uniform(0.2, 1.0, 2)
        polygon = hull_of(sizes * np.column_stack([np.cos(around), np.sin(around)]))
        direction = float(random.uniform(-np.pi, np.pi))
        most = int(random.integers(4, 24))
        few = Footing(thin_polygon(polygon, most, direction), 1.0)
        assert len(few.polygon) <= most
        both = np.array([direction, direction + np.pi])
        np.testing.assert_array_equal(few.in_plane(both), Footing(polygon, 1.0).in_plane(both))
