"""Bodies with what was asked of them, and their cases."""

from __future__ import annotations

import math
import pathlib

import numpy as np
import pytest
import trimesh

from tests.shared.marks import first
from tests.shared.meshes import cap, l_profile, turned, write
from warprock.bodies.body import Asked, Body, Texts, find_body, read_asked
from warprock.bodies.case_text import case_of
from warprock.bodies.rests import heights_at
from warprock.case.lanes import expand_lanes
from warprock.case.load import build_case
from warprock.case.text import parse_case
from warprock.errors import InputError
from warprock.findings.body import body_notes


def _body(folder: pathlib.Path, mesh: trimesh.Trimesh, **asked: object) -> Body:
    return find_body(write(mesh, folder), Asked(**({"density": 2000.0} | asked)))


def _lanes(body: Body):
    text = case_of(body).text
    return expand_lanes(build_case("body", "case.toml", None, parse_case(text, "case.toml"))).lanes


def test_the_case_of_an_l_is_the_l(tmp_path: pathlib.Path):
    body = _body(tmp_path, l_profile())
    assert body.mass == pytest.approx(2000.0 * 0.014, rel=1e-6)
    lanes = _lanes(body)
    found = lanes.body
    assert found is not None
    # Shaken to the weakest side, -x, which is the side ahead in the plane: figures of 10 um.
    assert found.base_ends[0] == pytest.approx([-0.3 + 0.0928571, 0.0928571], abs=2e-5)
    assert found.centre_height[0] == pytest.approx(0.1928571, abs=2e-5)
    gyration = body.inertia[1, 1]
    assert found.gyration[0] == pytest.approx(gyration, rel=1e-5)
    assert found.frequency_parameter[0] == pytest.approx(body.frequency_parameter, rel=1e-4)
    right = found.slenderness_angles[0, 1]
    assert right == pytest.approx(body.base.slenderness_angle, abs=1e-4)


def test_a_case_in_space_keeps_points_and_tensor(tmp_path: pathlib.Path):
    body = _body(tmp_path, l_profile(), model="spatial", direction=math.radians(30.0))
    found = _lanes(body).body
    assert found is not None
    assert found.spatial
    np.testing.assert_allclose(
        np.sort(found.gyration[0]), np.linalg.eigvalsh(body.inertia), rtol=1e-4
    )
    np.testing.assert_allclose(found.centre_height, body.base.height, atol=1e-5)


def test_the_first_lane_is_below_uplift_and_others_are_above(tmp_path: pathlib.Path):
    text = case_of(_body(tmp_path, l_profile())).text
    set_ = expand_lanes(build_case("b", "case.toml", None, parse_case(text, "case.toml")))
    ratios = set_.inputs["normalised_acceleration"].to_numpy()
    # Amplitudes have two digits.
    np.testing.assert_allclose(ratios, np.linspace(0.5, 4.0, 8), rtol=0.05)


def test_a_scan_out_of_level_settles_unless_its_pose_is_asked_for(tmp_path: pathlib.Path):
    mesh = turned(l_profile(), 3.0, (1.0, 1.0, 0.0))
    body = _body(tmp_path, mesh)
    assert math.degrees(body.pose.turn) == pytest.approx(3.0, abs=1e-4)
    assert body.base.height == pytest.approx(0.1928571, rel=1e-6)
    with pytest.raises(InputError, match="does not stand as scanned"):
        _body(tmp_path, mesh, pose=0)
    # Level, it stands as it is.
    assert _body(tmp_path, l_profile(), pose=0).pose.turn == 0.0


def test_the_axis_that_points_upwards_is_asked_for(tmp_path: pathlib.Path):
    box = trimesh.creation.box((0.4, 0.6, 1.2))
    for up, height, slender in (("z", 1.2, 0.4), ("y", 0.6, 0.4), ("-x", 0.4, 0.6)):
        body = _body(tmp_path, box, up=up)
        assert body.sizes[2] == pytest.approx(height, rel=1e-6)
        assert body.base.arm == pytest.approx(slender / 2, rel=1e-6)
        assert np.linalg.det(body.pose.rotation) == pytest.approx(1.0)


def test_a_pose_by_its_number_settles_the_body(tmp_path: pathlib.Path):
    mesh = turned(l_profile(), 6.0, (1.0, 1.0, 0.0))
    with pytest.raises(InputError, match=r"--pose 1, turned by 6 deg, does") as error:
        _body(tmp_path, mesh)
    assert "does not stand as scanned" in str(error.value)
    body = _body(tmp_path, mesh, pose=1)
    assert body.base.height == pytest.approx(0.1928571, rel=1e-6)
    # Turned back about the same axis, so that x and y are where they were.
    assert math.degrees(abs(body.weakest)) == pytest.approx(180.0, abs=1e-4)
    np.testing.assert_allclose(
        np.linalg.eigvalsh(body.inertia), np.linalg.eigvalsh(_body(tmp_path, l_profile()).inertia)
    )
    with pytest.raises(InputError, match="--pose: got 40, must be 0, the pose of the file, or"):
        _body(tmp_path, mesh, pose=40)


@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        (trimesh.creation.icosphere(3, 0.5), "a body without a stable rest"),
        (
            turned(trimesh.creation.cylinder(0.3, 1.0), 90.0, (0.0, 1.0, 0.0)),
            "does not stand as scanned",
        ),
        (trimesh.creation.box((0.01, 1.0, 1.0)), r"falls at a lean of 0\.57 deg"),
    ],
)
def test_a_body_that_does_not_stand_is_one_line(
    tmp_path: pathlib.Path, mesh: trimesh.Trimesh, said: str
):
    with pytest.raises(InputError, match=said) as error:
        _body(tmp_path, mesh)
    assert "\n" not in str(error.value)


@pytest.mark.thorough
def test_a_bowl_stands_and_is_said_to_roll_on(tmp_path: pathlib.Path):
    """A half ball on its round side: its centre only rises, so it never turns over."""
    flat = _body(tmp_path, cap(0.5, upside_down=True), base="flat")
    assert math.degrees(flat.base.slenderness_angle) < 10.0
    assert flat.turns_over(0.0)[0].lean == pytest.approx(float(flat.in_plane(0.0)[0]))
    assert "rolls on, and turns over at 90 deg" in " ".join(body_notes(flat))
    # With the points that touch as it leans it only rises.
    hull = _body(tmp_path, cap(0.5, upside_down=True), points=48)
    heights = heights_at(hull.contacts, np.array([0.0]), np.radians([0.0, 10.0, 20.0, 30.0]))[0]
    assert (np.diff(heights) > 0.0).all()


def test_the_points_of_a_case_turn_over_where_the_body_does(tmp_path: pathlib.Path):
    """A foot of 0.1 m below a bulge of 0.2 m, 20 mm above the ground, in every direction."""
    outline = np.array([(0.0, 0.0), (0.1, 0.0), (0.2, 0.02), (0.15, 1.0), (0.0, 1.0)])
    body = _body(tmp_path, trimesh.creation.revolve(outline, sections=32))
    height = body.base.height
    fall = body.turns_over(body.weakest)[0]
    # Across an edge of its 32-sided outline the bulge lies at 0.2 m cos(pi / 32).
    aside = 0.2 * np.cos(np.pi / 32)
    assert fall.lean == pytest.approx(np.arctan2(aside, height - 0.02), rel=0.02)
    assert fall.rise == pytest.approx(np.hypot(aside, height - 0.02) - height, rel=0.05)
    assert math.tan(float(body.in_plane(body.weakest)[0])) == pytest.approx(0.1 / height, rel=0.02)
    assert body.points[:, 2].max() == pytest.approx(0.02, rel=1e-4)


def test_a_base_thinned_too_far_is_refused(tmp_path: pathlib.Path):
    drum = trimesh.creation.cylinder(0.3, 1.0, sections=64)
    assert len(_body(tmp_path, drum, points=12).points) == 12
    leaning = drum.copy()
    leaning.vertices[:, 0] -= 0.5 * (leaning.vertices[:, 2] + 0.5)
    assert _body(tmp_path, leaning).base.arm > 0.0
    with pytest.raises(InputError, match="--points: got 3, must be more"):
        _body(tmp_path, leaning, points=3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"density": None}, "--density: got nothing, must be given, or --mass"),
        ({"mass": "3 kg"}, "--density: got both, must be given, or --mass"),
        ({"density": "2700"}, "--density: got '2700', must be a density with a unit"),
        ({"density": None, "mass": "-3 kg"}, "--mass: got '-3 kg', must be at least 1e-6 kg"),
        ({"tolerance": "2 m"}, "--tolerance: got '2 m', must be at least 1e-6 m and at most 1 m"),
        ({"direction": "north"}, "--direction: got 'north', must be an angle"),
        ({"up": "w"}, "--up: got 'w', must be one of z, y, x"),
        ({"model": "flat"}, "--model: got 'flat', must be one of planar, spatial"),
        ({"base": "round"}, "--base: got 'round', must be one of flat, hull"),
        ({"points": 2}, "--points: got 2, must be from 3 to 48"),
    ],
)
def test_what_cannot_be_asked_is_one_line(change: dict[str, object], said: str):
    given = {"density": "2000 kg/m^3"} | change
    texts = Texts(**{name: given.pop(name) for name in Texts._fields if name in given})
    with pytest.raises(InputError, match=said):
        read_asked(Asked(**given), texts)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", first(1, range(2)))
@pytest.mark.parametrize("base", first(1, ["flat", "hull"]))
def test_the_weakest_direction_of_a_symmetric_statue_is_that_of_all_its_points(
    tmp_path: pathlib.Path, seed: int, base: str
):
    """An elliptic base is weakest across its short axis, whatever points a case keeps of it."""
    random = np.random.default_rng(seed)
    count = 4 * int(random.integers(6, 40))
    short = random.uniform(0.15, 0.35)
    sizes = np.array([short, short * random.uniform(1.02, 1.6)])
    around = 2.0 * np.pi * np.arange(count) / count
    ring = sizes * np.column_stack([np.cos(around), np.sin(around)])
    levels = ((0.0, 1.0), (0.03, 1.05 if seed % 2 else 1.0), (1.2, random.uniform(0.3, 0.8)))
    corners = np.vstack(
        [np.column_stack([scale * ring, np.full(count, height)]) for height, scale in levels]
    )
    mesh = turned(trimesh.convex.convex_hull(corners), 30.0, (0.0, 0.0, 1.0))
    path = write(mesh, tmp_path)
    # A polygon of so many corners tells its axis up to half of an edge of it.
    edge = 360.0 / count * sizes.max() / sizes.min()
    for model, points in (("planar", 24), ("planar", 8), ("spatial", 12)):
        found = find_body(path, Asked(density=2400.0, base=base, model=model, points=points))
        off = (np.degrees(found.weakest) - 30.0 + 90.0) % 180.0 - 90.0
        assert abs(off) <= edge
        both = found.weakest + np.array([0.0, np.pi])
        known = found.footing.in_plane(both)
        np.testing.assert_allclose(found.in_plane(*both), known, rtol=1e-12)
