"""Blocks in OBJ files: faces in one plane, each a block, or the surfaces of bodies in space."""

from __future__ import annotations

import numpy as np

from warprock.drawings.outline import (
    Array,
    Drawing,
    Outline,
    Solid,
    named_apart,
    require_few,
    require_outlines,
)
from warprock.drawings.sections import AXES, FLAT, PLANES, Surface, X, Y, Z, convex_corners
from warprock.errors import InputError, Said

HOLDS = "faces (f) in one plane, a block each, named by objects (o) or groups (g)"


def read(content: bytes, source: str) -> Drawing:
    """The blocks of a file in the plane.

    A face is a block; what its object is called, or its group, is its name, and its material the
    group of blocks that it belongs to. Faces lie in the plane of x and y, of x and z (z upwards),
    or of y and z.

    Args:
        content: Its bytes.
        source: Its path, as errors name it.

    Raises:
        InputError: A line that cannot be used, or faces that lie in no such plane.
    """
    corners, faces = _read(content, source)
    size, across = _plane(corners, faces)
    if across is None:
        got = Said(", ".join(f"{axis} over {s:g}" for axis, s in zip(AXES, size, strict=True)))
        allowed = (
            "must be faces in one plane: one coordinate is the same; bodies in space with "
            'model = "spatial"'
        )
        raise InputError(source, "", got, allowed)
    axes = PLANES[across]
    outlines = named_apart(
        Outline(own, group, corners[face][:, axes]) for own, group, face in faces
    )
    require_outlines(source, outlines, HOLDS)
    return Drawing(outlines)


def read_solids(content: bytes, source: str) -> Drawing:
    """The blocks of a file in space, or in a plane where all of its faces lie in one.

    The faces of an object, or of a group, are the surface of a block. z is upwards.

    Args:
        content: Its bytes.
        source: Its path, as errors name it.

    Raises:
        InputError: A line that cannot be used, or a block that is not closed or not convex.
    """
    corners, faces = _read(content, source)
    if _plane(corners, faces)[1] is not None:
        return read(content, source)
    surfaces: dict[tuple[str, str], list[list[int]]] = {}
    for own, group, face in faces:
        surfaces.setdefault((own, group), []).append(face)
    solids = named_apart(
        Solid(
            own,
            group,
            convex_corners(source, Surface(own or group, corners, [np.array(f) for f in sides])),
        )
        for (own, group), sides in surfaces.items()
    )
    return Drawing((), solids=solids)


Faces = list[tuple[str, str, list[int]]]
"""Name of the object, material, and numbers of the corners of each face."""


def _plane(corners: Array, faces: Faces) -> tuple[Array, int | None]:
    """Extents of the faces, and the axis across the plane in which all of them lie."""
    used = corners[np.unique(np.concatenate([np.array(each) for _, _, each in faces]))]
    size = np.ptp(used, axis=0)
    return size, next((axis for axis in (Z, Y, X) if size[axis] <= FLAT * size.max()), None)


def _read(content: bytes, source: str) -> tuple[Array, Faces]:
    """Vertices and faces of a file.

    Raises:
        InputError: A line that cannot be used, or there are no faces.
    """
    points: list[list[float]] = []
    faces: Faces = []
    name = material = ""
    for number, line in enumerate(content.decode("utf-8", "replace").splitlines(), 1):
        mark, *rest = line.split() or [""]
        try:
            if mark == "v":
                x, y, z = rest[:3]
                points.append([float(x), float(y), float(z)])
            elif mark in ("o", "g"):
                name = " ".join(rest)
            elif mark == "usemtl":
                material = " ".join(rest)
            elif mark == "f":
                require_few(source, len(faces))
                faces.append((name, material, [_place(each, len(points)) for each in rest]))
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            allowed = "must be v x y z, or f with the numbers of vertices above"
            raise InputError(source, f"line {number}", line.strip(), allowed) from None
    require_outlines(source, [Outline("", "", np.zeros((3, 2)))] * len(faces), HOLDS)
    return np.array(points), faces


def _place(text: str, count: int) -> int:
    """The place of a vertex that a face names: from 1, or backwards from -1."""
    number = int(text.partition("/")[0])
    place = number - 1 if number > 0 else count + number
    if not 0 <= place < count or number == 0:
        raise ValueError
    return place
