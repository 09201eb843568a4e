"""Velocities and attitudes at the start, from the case to the lanes."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError

BOX = """
title = "t"
source = "s"
[block]
width = "0.2 m"
height = "1.0 m"
depth = "0.5 m"
density = "2000 kg/m^3"
[contact]
friction = 0.7
[run]
duration = "1 s"
[start]
"""
SIDE = "attitude_w = 0.7071\nattitude_x = 0.0\nattitude_y = 0.7071\nattitude_z = 0.0\n"
"""A turn of 90 degrees about y: the block lies on its side."""


def lanes_of(tmp_path: pathlib.Path, start: str, more: str = "") -> LaneSet:
    (tmp_path / "case.toml").write_text(BOX + start + more, encoding="utf-8")
    return expand_lanes(load_case(tmp_path))


def test_a_block_that_stands_turns_about_the_edge_that_goes_down(tmp_path):
    """v = w x r, and the edge at rest; in the plane, as it needs no space."""
    more = '[[sweep]]\nstart.angular_velocity_y = ["0.5 rad/s", "-30 deg/s"]\n'
    found = lanes_of(tmp_path, 'angular_velocity_y = "1 rad/s"\n', more)
    release = found.lanes.release
    assert not found.scene.spatial
    assert not release.thrown
    spin = np.array([0.5, -np.deg2rad(30.0)])
    np.testing.assert_allclose(release.angular_velocity[:, 1], spin, rtol=1e-12)
    wanted = np.stack([0.5 * spin, 0.0 * spin, 0.1 * np.abs(spin)], axis=-1)
    np.testing.assert_allclose(release.velocity, wanted, atol=1e-12)
    assert found.inputs["angular_velocity_y_start_rad_s"].tolist() == pytest.approx(spin.tolist())


def test_a_block_in_space_turns_about_the_corner_that_goes_down(tmp_path):
    start = 'angular_velocity_y = "1 rad/s"\nangular_velocity_x = "-0.1 rad/s"\n'
    release = lanes_of(tmp_path, start).lanes.release
    corner = np.array([0.1, 0.25, -0.5])
    np.testing.assert_allclose(release.velocity[0], -np.cross([-0.1, 1.0, 0.0], corner), atol=1e-12)


def test_a_velocity_that_is_given_is_taken_as_it_is(tmp_path):
    start = 'angular_velocity_y = "1 rad/s"\nvelocity_z = "2 m/s"\n'
    release = lanes_of(tmp_path, start).lanes.release
    assert release.velocity[0].tolist() == [0.0, 0.0, 2.0]


def test_a_thrown_block_without_a_height_touches_the_ground(tmp_path):
    """It lies on its side: its centre is half of its width high."""
    lanes = lanes_of(tmp_path, SIDE).lanes
    assert lanes.thrown
    assert lanes.release.height[0] == pytest.approx(0.1, rel=1e-12)
    assert np.linalg.norm(lanes.release.attitude[0]) == pytest.approx(1.0, rel=1e-15)


def test_a_body_of_eight_corners_is_thrown_as_a_box_with_its_inertia():
    lanes = expand_lanes(load_case("cube-tosses")).lanes
    assert lanes.body is None
    assert lanes.mass == pytest.approx(np.full(40, 0.37))
    np.testing.assert_allclose(lanes.release.gyration, 8.1e-4 / 0.37, rtol=1e-12)
    np.testing.assert_allclose([lanes.width, lanes.depth, lanes.height], 0.1048, rtol=1e-12)


@pytest.mark.parametrize(
    ("start", "text"),
    [
        ("attitude_w = 1.0\n", r"start.attitude_x: got nothing.*all four parts"),
        (SIDE.replace("0.0", "0.5"), "must make a quaternion of length 1 .this one has 1.225"),
        (SIDE + 'height = "5 cm"\n', "start.height: got 0.05 m, must be at least 0.1 m"),
        (SIDE + 'gap = "1 m"\nheight = "1 m"\n', "must not be given beside start.gap"),
        (SIDE + 'yaw = "3 deg"\n', "must not be given beside start.yaw"),
        ('velocity_x = "1 rad/s"\n', "must be a velocity with a unit"),
        ('angular_velocity_y = "1 m/s"\n', "a frequency with a unit .Hz, kHz, rad/s, deg/s."),
        ('angular_velocity_y = "1 rad/s"\nvelocity_q = 1\n', "velocity_q"),
    ],
)
def test_a_start_that_cannot_be_is_refused(tmp_path, start, text):
    with pytest.raises(InputError, match=text):
        lanes_of(tmp_path, start)


def test_a_box_with_its_centre_of_mass_aside_is_thrown_as_a_body(tmp_path):
    """Corners and height are seen from the centre of mass; on its side 9 cm are below it."""
    case = BOX.replace('depth = "0.5 m"', 'depth = "0.5 m"\ncentre_offset_x = "1 cm"') + SIDE
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    lanes = expand_lanes(load_case(tmp_path)).lanes
    points = lanes.body.points[0]
    assert points.min(axis=0).tolist() == pytest.approx([-0.11, -0.25, -0.5])
    assert points.max(axis=0).tolist() == pytest.approx([0.09, 0.25, 0.5])
    assert lanes.centre_offset_x[0] == 0.0
    assert lanes.release.height[0] == pytest.approx(0.09, rel=1e-4)


def test_a_body_is_thrown_whose_points_surround_its_centre_of_mass():
    lanes = expand_lanes(load_case("cube-tosses", ["block.centre=[0.0, 0.0, 0.01]"])).lanes
    assert lanes.thrown
    assert lanes.body.inner_radius == pytest.approx(np.full(40, 0.0424))


BODY = """
mass = "10 kg"
base = [[-0.1, -0.1, 0.0], [0.2, 0.0, 0.0], [-0.1, 0.1, 0.0]]
centre = [0.0, 0.0, 0.3]
inertia = ["1 kg m^2", "1 kg m^2", "1 kg m^2", "0 kg m^2", "0 kg m^2", "0 kg m^2"]
"""


def test_a_body_on_a_base_alone_is_pushed_and_not_thrown(tmp_path):
    """It turns about the point that goes down, as a box does."""
    body = BOX[: BOX.index("width")] + BODY + BOX[BOX.index("[contact]") :]
    (tmp_path / "case.toml").write_text(body + SIDE, encoding="utf-8")
    with pytest.raises(InputError, match=r"attitude_w: .* do not surround the centre of mass"):
        expand_lanes(load_case(tmp_path))
    (tmp_path / "case.toml").write_text(body + 'angular_velocity_y = "1 rad/s"', encoding="utf-8")
    release = expand_lanes(load_case(tmp_path)).lanes.release
    assert release.attitude is None
    np.testing.assert_allclose(release.velocity[0], [0.3, 0.0, 0.2], atol=1e-12)
