"""Assemblies in space: which blocks touch where, masses, and what is refused."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import scipy

from tests.shared.assemblies import assembly_lanes
from warprock.measure.bench import in_space
from warprock.model import patterns
from warprock.model.assembly import Piece, assemble
from warprock.model.solids import SpatialAssembly, assemble_solids

TURN = scipy.spatial.transform.Rotation.from_rotvec([0.3, -0.2, 0.9]).as_matrix()
"""Any rotation."""


def built(pieces: list[Piece], tolerance: float | None = None) -> SpatialAssembly:
    return assemble_solids(pieces, density=2000.0, friction=0.6, tolerance=tolerance)


def box(low: list[float], high: list[float]) -> np.ndarray:
    return np.array(list(itertools.product(*zip(low, high, strict=True))))


GROUND = Piece("ground", box([-1.0, -1.0, -1.0], [3.0, 1.0, 0.0]), fixed=True)


def touching(assembly: SpatialAssembly) -> set[tuple[str, ...]]:
    return {tuple(assembly.names[k] for k in pair) for pair in assembly.joints.blocks}


def test_a_box_and_a_tetrahedron_have_the_masses_of_closed_forms():
    edges = np.array([0.4, 0.6, 0.8])
    corners = box([0.0] * 3, edges.tolist())
    tetrahedron = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    found = built(
        [
            GROUND,
            Piece("box", corners),
            Piece("tetrahedron", tetrahedron + np.array([1.0, 0.0, 0.0])),
        ]
    )
    assert found.mass[1:] == pytest.approx(2000.0 * np.array([edges.prod(), 1.0 / 6.0]))
    assert found.centre[1] == pytest.approx(0.5 * edges)
    assert found.centre[2] == pytest.approx([1.25, 0.25, 0.25])
    squares = edges**2
    assert np.diag(found.inertia[1]) == pytest.approx(
        found.mass[1] / 12.0 * (squares.sum() - squares)
    )
    # Of a tetrahedron of three edges of 1 at a right angle 3 m / 40, and m / 80 off the diagonal.
    own = found.mass[2] / 80.0 * (np.ones((3, 3)) + 5.0 * np.eye(3))
    assert found.inertia[2] == pytest.approx(own)


@pytest.mark.parametrize(
    "pieces",
    [
        patterns.wall(
            0.4, 0.2, 3, 3, whole_first=True, openings=[patterns.Opening(0.3, 0.2, 0.4, 0.2)]
        ),
        patterns.arch(5.0, 0.8, np.radians(140.0), 6),
    ],
    ids=["wall", "arch"],
)
def test_blocks_of_the_plane_have_the_same_joints_in_space(pieces: list[Piece]):
    flat = assemble(pieces, depth=0.5, density=2000.0, friction=0.6)
    found = built(patterns.extruded(pieces, 0.5))
    assert found.joints.blocks.tolist() == flat.joints.blocks.tolist()
    assert found.joints.area == pytest.approx(0.5 * flat.joints.lengths)
    assert found.joints.normal[:, [0, 2]] == pytest.approx(flat.joints.normal)
    assert found.mass == pytest.approx(flat.mass)
    assert found.centre[:, [0, 2]] == pytest.approx(flat.centre)
    assert found.inertia[:, 1, 1] == pytest.approx(flat.mass * flat.gyration)
    assert found.size[[0, 2]] == pytest.approx(flat.size)


def test_lanes_in_space_measure_rotations_as_those_in_the_plane():
    arch = patterns.arch(5.0, 0.8, np.pi, 11)
    space = in_space(assembly_lanes([built(patterns.extruded(arch, 1.0))]))
    plane = assembly_lanes([assemble(arch, depth=1.0, density=2000.0, friction=0.6)])
    # In space a corner is farther from the middle of a joint, by half of the depth.
    assert space.slenderness_angle == pytest.approx(plane.slenderness_angle, rel=0.01)
    assert space.slenderness_angle_across == space.slenderness_angle


def test_joints_turn_with_the_scene():
    pieces = patterns.corner(0.4, 0.2, 2, 2, 0.2, return_blocks=1, returns=1)
    found = built(pieces)
    turned = built([each._replace(corners=each.corners @ TURN.T + 7.0) for each in pieces])
    assert touching(turned) == touching(found)
    assert np.sort(turned.joints.area) == pytest.approx(np.sort(found.joints.area))
    for joints in (found.joints, turned.joints):
        first, second = joints.tangents[:, 0], joints.tangents[:, 1]
        assert np.cross(first, second) == pytest.approx(joints.normal, abs=1e-12)
    away = found.centre[found.joints.blocks[:, 0]] - found.centre[found.joints.blocks[:, 1]]
    assert ((away * found.joints.normal).sum(axis=1) > 0.0).all()


def test_a_joint_is_what_two_faces_share():
    """A square that is turned by 45 degrees on a square: an octagon."""
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    turn = np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2.0)
    lower = np.concatenate([np.insert(square, 2, level, axis=1) for level in (0.0, 1.0)])
    upper = np.concatenate([np.insert(square @ turn, 2, level, axis=1) for level in (1.0, 2.0)])
    found = built([GROUND, Piece("a", lower), Piece("b", upper)])
    assert found.joints.end_count.tolist() == [4, 8]
    # Two squares of width 1 share a regular octagon of width 1.
    assert found.joints.area == pytest.approx([1.0, 2.0 * (np.sqrt(2.0) - 1.0)])


def test_vaults_are_laid_in_bond_and_corners_are_bonded():
    found = built(patterns.vault(2.0, 0.4, 2.6, 4, 2, 1.2, whole_first=True))
    names = [name for name in found.names if name.startswith("2.")]
    assert names == ["2.1", "2.2", "2.3"]
    assert {("1.1", "2.1"), ("1.1", "2.2"), ("1.2", "2.2"), ("1.2", "2.3")} <= touching(found)
    volume = found.volume[~found.fixed].sum()
    # Of the ring sector under straight sides: sin(a) / a of it, a the angle of a course.
    a = 2.6 / 4
    assert volume == pytest.approx(2.6 * 2.0 * 0.4 * 1.2 * np.sin(a) / a)
    wall = built(patterns.corner(0.4, 0.2, 3, 2, 0.2, return_blocks=2, returns=2))
    assert {("1.1", "left 2.1"), ("1.3", "right 2.1"), ("1.1", "left 1.1")} <= touching(wall)


def test_what_overlaps_floats_or_is_flat_is_refused():
    first = Piece("a", box([0.0] * 3, [1.0] * 3))
    with pytest.raises(ValueError, match="blocks apart: a and b overlap by 10 mm"):
        built([GROUND, first, Piece("b", box([0.99, 0.0, 0.0], [2.0, 1.0, 1.0]))])
    with pytest.raises(
        ValueError, match=r"block b touches nothing that does; the nearest is a, 10"
    ):
        built([GROUND, first, Piece("b", box([0.0, 0.0, 1.01], [1.0, 1.0, 2.0]))])
    with pytest.raises(ValueError, match="be bodies: block b is flat"):
        built([GROUND, first, Piece("b", box([0.0, 0.0, 1.0], [1.0, 1.0, 1.0]))])
    hung = Piece("c", box([0.0, 0.0, -2.0], [1.0, 1.0, -1.0]))
    with pytest.raises(ValueError, match="block c hangs below all that touches it"):
        built([GROUND, first, hung])
    near = Piece("b", box([1.002, 0.0, 0.0], [2.0, 1.0, 1.0]))
    with pytest.raises(ValueError, match="faces of a and b face each other over 2 mm"):
        built([GROUND, first, near], tolerance=1e-3)
    # Edges that cross, and corners that meet, do not overlap.
    ridge = box([-0.5] * 3, [0.5] * 3) @ TURN.T
    ridge[:, 2] += 1.0 - ridge[:, 2].min()
    stand = Piece("d", box([-0.2, -0.2, 2.5], [0.2, 0.2, 2.6]))
    with pytest.raises(ValueError, match="rest on something fixed: block ridge touches nothing"):
        built([GROUND, first, Piece("ridge", ridge), stand])
