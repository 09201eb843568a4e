"""Meshes with closed forms, as files."""

from __future__ import annotations

import pathlib

import numpy as np
import trimesh

L_AREAS = (0.30 * 0.10, 0.10 * 0.40)
"""Areas of the two parts of the L: its foot, and its upright part above the foot [m^2]."""
L_DEPTH = 0.2


def l_profile() -> trimesh.Trimesh:
    """An L that stands on its foot: 0.3 m x 0.1 m, with 0.1 m x 0.4 m above its end at x = 0.

    Depth 0.2 m along y; as one closed surface.
    """
    outline = np.array([(0, 0), (0.3, 0), (0.3, 0.1), (0.1, 0.1), (0.1, 0.5), (0, 0.5)])
    front = np.column_stack([outline[:, 0], np.zeros(6), outline[:, 1]])
    back = front + np.array([0.0, L_DEPTH, 0.0])
    sides = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [*sides, *((c + 6, b + 6, a + 6) for a, b, c in sides)]
    for start in range(6):
        end = (start + 1) % 6
        faces += [(start, start + 6, end), (end, start + 6, end + 6)]
    return trimesh.Trimesh(np.vstack([front, back]), np.array(faces), process=False)


def tetrahedron() -> trimesh.Trimesh:
    """Corners at the origin and 1 m along x, y and z."""
    corners = np.vstack([np.zeros(3), np.eye(3)])
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    return trimesh.Trimesh(corners, faces, process=False)


def cap(height: float, *, upside_down: bool = False) -> trimesh.Trimesh:
    """The part of a ball of radius 0.5 m above (or below) a plane, as a convex polyhedron.

    Args:
        height: Height of the part [m].
        upside_down: Whether its round side is below.
    """
    ball = trimesh.creation.icosphere(4, 0.5).vertices
    base = 0.5 - height
    reach = np.sqrt(0.25 - base**2)
    around = np.linspace(0.0, 2.0 * np.pi, 97)[:-1]
    ring = np.column_stack([reach * np.cos(around), reach * np.sin(around), np.full(96, base)])
    found = trimesh.convex.convex_hull(np.vstack([ball[ball[:, 2] > base], ring]))
    if upside_down:
        found.apply_scale((1.0, 1.0, -1.0))
    return found


def turned(
    mesh: trimesh.Trimesh, degrees: float, axis: tuple[float, float, float]
) -> trimesh.Trimesh:
    """A mesh turned about an axis."""
    copy = mesh.copy()
    matrix = trimesh.transformations.rotation_matrix(np.radians(degrees), axis)
    copy.apply_transform(matrix)
    return copy


def write(mesh: trimesh.Trimesh, folder: pathlib.Path, name: str = "body.ply") -> pathlib.Path:
    """A mesh as a file."""
    mesh.export(folder / name)
    return folder / name
