"""Volume, centre and inertia of meshes against closed forms; meshes that are refused."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest
import trimesh

from tests.shared.meshes import L_AREAS, L_DEPTH, l_profile, tetrahedron, turned, write
from warprock.bodies.mesh import read_solid
from warprock.errors import InputError

ROUND_OFF = 1e-6
"""Of PLY and STL, which hold coordinates in single precision, over the size."""


@pytest.mark.parametrize("name", ["a.ply", "a.obj", "a.stl", "a.STL"])
def test_a_box_weighs_what_it_does_wherever_it_lies(tmp_path: pathlib.Path, name: str):
    box = trimesh.creation.box((0.4, 0.6, 1.2))
    box.apply_translation((8.0, -5.0, 3.0))
    solid = read_solid(write(box, tmp_path, name))
    assert solid.volume == pytest.approx(0.288, rel=20 * ROUND_OFF)
    np.testing.assert_allclose(solid.centre, (8.0, -5.0, 3.0), rtol=0, atol=10 * ROUND_OFF)
    squares = np.array([0.4, 0.6, 1.2]) ** 2
    moments = np.diag(squares.sum() - squares) / 12.0
    np.testing.assert_allclose(solid.inertia, moments, rtol=0, atol=20 * ROUND_OFF)
    assert len(solid.corners) == 8


def test_a_tetrahedron_has_products_of_inertia(tmp_path: pathlib.Path):
    """About the centre: integral of x^2 is 3/80 of the volume, that of x y -1/80."""
    solid = read_solid(write(tetrahedron(), tmp_path))
    assert solid.volume == pytest.approx(1.0 / 6.0, rel=1e-12)
    np.testing.assert_allclose(solid.centre, 0.25, rtol=1e-12)
    expected = np.full((3, 3), 1.0 / 80.0) + np.eye(3) * (6.0 / 80.0 - 1.0 / 80.0)
    np.testing.assert_allclose(solid.inertia, expected, rtol=1e-12)


def test_an_l_is_its_two_parts(tmp_path: pathlib.Path):
    solid = read_solid(write(l_profile(), tmp_path))
    foot, upright = L_AREAS
    x = (foot * 0.15 + upright * 0.05) / (foot + upright)
    z = (foot * 0.05 + upright * 0.30) / (foot + upright)
    assert solid.volume == pytest.approx((foot + upright) * L_DEPTH, rel=ROUND_OFF)
    np.testing.assert_allclose(solid.centre, (x, 0.1, z), rtol=ROUND_OFF)
    # About y, each part's own and that of its distance.
    parts = (
        foot * ((0.3**2 + 0.1**2) / 12 + (0.15 - x) ** 2 + (0.05 - z) ** 2),
        upright * ((0.1**2 + 0.4**2) / 12 + (0.05 - x) ** 2 + (0.30 - z) ** 2),
    )
    assert solid.inertia[1, 1] == pytest.approx(sum(parts) / (foot + upright), rel=10 * ROUND_OFF)
    mixed = foot * (0.15 - x) * (0.05 - z) + upright * (0.05 - x) * (0.30 - z)
    assert solid.inertia[0, 2] == pytest.approx(-mixed / (foot + upright), rel=10 * ROUND_OFF)


def test_a_cylinder_comes_near_to_a_round_one(tmp_path: pathlib.Path):
    sides = 256
    drum = trimesh.creation.cylinder(0.5, 2.0, sections=sides)
    solid = read_solid(write(drum, tmp_path))
    # An inscribed polygon has less area by 2/3 (pi / sides)^2.
    missing = (np.pi / sides) ** 2
    assert solid.volume == pytest.approx(np.pi * 0.5, rel=missing)
    moments = (0.25 / 4 + 4.0 / 12, 0.25 / 4 + 4.0 / 12, 0.125)
    np.testing.assert_allclose(np.diag(solid.inertia), moments, rtol=2 * missing)


def test_lengths_in_millimetres_are_said_or_asked_for(tmp_path: pathlib.Path):
    box = trimesh.creation.box((400.0, 600.0, 1200.0))
    path = write(box, tmp_path)
    with pytest.raises(InputError, match=r"a body 1,200 m long.*looks like mm, say --unit mm"):
        read_solid(path)
    assert read_solid(path, "mm").volume == pytest.approx(0.288, rel=ROUND_OFF)
    assert read_solid(path, "m").volume == pytest.approx(2.88e8, rel=ROUND_OFF)
    with pytest.raises(InputError, match="--unit: got 'furlong', must be one of m, cm, mm"):
        read_solid(path, "furlong")
    with pytest.raises(InputError, match=r"a body 0\.0012 m long.*without --unit"):
        read_solid(write(trimesh.creation.box((4e-4, 6e-4, 12e-4)), tmp_path))


def test_a_mesh_that_looks_inwards_or_has_a_hollow_is_a_body(tmp_path: pathlib.Path):
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    inwards = box.copy()
    inwards.invert()
    assert read_solid(write(inwards, tmp_path)).volume == pytest.approx(1.0, rel=ROUND_OFF)
    hollow = trimesh.creation.box((0.5, 0.5, 0.5))
    hollow.invert()
    both = trimesh.util.concatenate([box, hollow])
    assert read_solid(write(both, tmp_path)).volume == pytest.approx(0.875, rel=ROUND_OFF)


def _holed() -> trimesh.Trimesh:
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    return trimesh.Trimesh(box.vertices, box.faces[:-1], process=False)


def _wound() -> trimesh.Trimesh:
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    faces = np.array(box.faces)
    faces[3] = faces[3][::-1]
    return trimesh.Trimesh(box.vertices, faces, process=False)


def _two() -> trimesh.Trimesh:
    first, second = trimesh.creation.box((1.0, 1.0, 1.0)), trimesh.creation.box((0.5, 0.5, 0.5))
    second.apply_translation((2.0, 0.0, 0.0))
    return trimesh.util.concatenate([first, second])


def _flat() -> trimesh.Trimesh:
    corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    return trimesh.Trimesh(corners, [(0, 1, 2), (0, 2, 1)], process=False)


@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        (_holed(), r"a mesh with holes, 3 open edges, must be closed"),
        (_wound(), r"3 edges between turned faces, must have faces that all look outwards"),
        (_two(), r"2 bodies, must be one: the largest has 88\.9% of the volume"),
        (_flat(), r"a mesh without a volume, must be a closed surface"),
    ],
)
def test_a_mesh_that_is_no_body_is_one_line(
    tmp_path: pathlib.Path, mesh: trimesh.Trimesh, said: str
):
    path = write(turned(mesh, 20.0, (1.0, 2.0, 3.0)), tmp_path)
    with pytest.raises(InputError, match=said) as error:
        read_solid(path)
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(str(path))


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.ply", b"no mesh\n\nat all", r"a file that is no mesh, must be a mesh as PLY"),
        ("a.stl", b"no mesh\n\nat all", r"no faces that can be used|a file that is no mesh"),
        ("a.obj", b"v 1 2 3\nv 2 3 4\n", r"no faces that can be used, must hold a mesh"),
        ("a.obj", b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", r"no faces that can be used"),
        ("a.step", b"", r"MESH: got .*must end in one of \.ply, \.obj, \.stl"),
    ],
)
def test_a_file_that_is_no_mesh_is_one_line(
    tmp_path: pathlib.Path, name: str, content: bytes, said: str
):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=said) as error:
        read_solid(tmp_path / name)
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_there_is_one_line(tmp_path: pathlib.Path):
    with pytest.raises(InputError, match=r"MESH: got .*no such file"):
        read_solid(tmp_path / "nobody.ply")
