"""A barrel vault of hexagons, as an OBJ: in bond both ways, with half blocks at its free edges."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

Array = npt.NDArray[np.float64]

RADIUS, THICKNESS, EMBRACE, LENGTH = 1.5, 0.35, np.radians(150.0), 2.0
"""Of the middle surface, along its normals, of the arch, and along the axis y [m, rad]."""
ROWS, COLUMNS, STRAIGHT = 8, 2, 0.35
"""Rows over the arch, whole blocks of one along the axis, and the straight part of a side."""


def hexagonal_vault() -> str:
    """Blocks between tangent planes; `left` and `right` are what it springs from."""
    row, part = EMBRACE / ROWS, 0.5 * LENGTH / COLUMNS
    blocks = {}
    for i, j in itertools.product(range(ROWS + 1), range(2 * COLUMNS + 1)):
        if (i + j) % 2 == 0:
            middle = -0.5 * EMBRACE + i * row
            found = _corners(_hexagon(middle, row, j * part, part))
            blocks |= {f"h{i}.{j}": found} if found is not None else {}
    for name, side in (("left", -1.0), ("right", 1.0)):
        foot = RADIUS * abs(np.sin(0.5 * EMBRACE))
        planes = [(-side * _across(0.5 * side * EMBRACE), 0.0), *_along(-0.2, LENGTH + 0.2)]
        planes += [
            (_axis(2, -1.0), 0.5),
            (_axis(0, side), foot + 0.6),
            (_axis(0, -side), 0.5 - foot),
        ]
        corners = _corners(planes)
        assert corners is not None
        blocks[name] = corners
    return _text(blocks)


Plane = tuple[Array, float]


def _hexagon(middle: float, row: float, y: float, part: float) -> list[Plane]:
    """Half-spaces n . x <= d whose common part is a block about an angle and a place along y."""
    flat, tip = STRAIGHT * part, (1.0 - STRAIGHT) * part
    low, high = max(middle - row, -0.5 * EMBRACE), min(middle + row, 0.5 * EMBRACE)
    planes = _along(0.0, LENGTH)
    for side in (-1.0, 1.0):
        planes.append((side * _across(middle + side * row), 0.0))
        planes.append((side * _across(0.5 * side * EMBRACE), 0.0))
        for end in (-1.0, 1.0):
            a = RADIUS * _up(middle + side * row) + _axis(1, y + end * flat)
            b = RADIUS * _up(middle) + _axis(1, y + end * tip)
            n = np.cross(b - a, _up(middle + 0.5 * side * row))
            n *= np.sign(n @ (a - RADIUS * _up(middle) - _axis(1, y))) / np.linalg.norm(n)
            planes.append((n, float(n @ a)))
    n = _up(0.5 * (low + high))
    planes.append((n, RADIUS + 0.5 * THICKNESS))
    planes.append((-n, 0.5 * THICKNESS - RADIUS))
    return planes


def _up(angle: float) -> Array:
    return np.array([np.sin(angle), 0.0, np.cos(angle)])


def _across(angle: float) -> Array:
    return np.array([np.cos(angle), 0.0, -np.sin(angle)])


def _axis(number: int, size: float) -> Array:
    return size * np.eye(3)[number]


def _along(low: float, high: float) -> list[Plane]:
    return [(_axis(1, 1.0), high), (_axis(1, -1.0), -low)]


def _corners(planes: list[Plane]) -> Array | None:
    """Corners of the common part of half-spaces; None where that is thinner than a millimetre."""
    normals, offsets = np.array([n for n, _ in planes]), np.array([d for _, d in planes])
    inner = linprog(
        [0.0, 0.0, 0.0, -1.0],
        A_ub=np.c_[normals, np.ones(len(planes))],
        b_ub=offsets,
        bounds=[(None, None)] * 3 + [(0.0, 1.0)],
    )
    if inner.status != 0 or inner.x[3] < 1e-3:
        return None
    found = HalfspaceIntersection(np.c_[normals, -offsets], inner.x[:3]).intersections
    return np.unique(np.round(found, 10), axis=0)


def _text(blocks: dict[str, Array]) -> str:
    lines, count = [], 1
    for name, corners in blocks.items():
        hull = ConvexHull(corners)
        lines += [f"o {name}", *(f"v {x:.10g} {y:.10g} {z:.10g}" for x, y, z in corners)]
        for (a, b, c), (*n, _) in zip(hull.simplices, hull.equations, strict=True):
            turn = np.dot(np.cross(corners[b] - corners[a], corners[c] - corners[a]), n)
            order = (a, b, c) if turn > 0.0 else (a, c, b)
            lines.append("f " + " ".join(str(count + k) for k in order))
        count += len(corners)
    return "\n".join(lines) + "\n"
