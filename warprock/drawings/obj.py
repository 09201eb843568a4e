"""Sections in OBJ files: faces in one plane, each a block."""

from __future__ import annotations

import numpy as np

from warprock.drawings.outline import Drawing, Outline, named_apart, require_few, require_outlines
from warprock.drawings.sections import AXES, FLAT, PLANES, X, Y, Z
from warprock.errors import InputError
from warprock.quantity import Said

HOLDS = "faces (f) in one plane, a block each, named by objects (o) or groups (g)"


def read(content: bytes, source: str) -> Drawing:
    """The blocks of a file.

    A face is a block; what its object is called, or its group, is its name, and its material the
    group of blocks that it belongs to. Faces lie in the plane of x and y, of x and z (z upwards),
    or of y and z.

    Args:
        content: Its bytes.
        source: Its path, as errors name it.

    Raises:
        InputError: A line that cannot be used, or faces that lie in no such plane.
    """
    points: list[list[float]] = []
    faces: list[tuple[str, str, list[int]]] = []
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
    corners = np.array(points)
    used = corners[np.unique(np.concatenate([np.array(each) for _, _, each in faces]))]
    size = np.ptp(used, axis=0)
    across = next((axis for axis in (Z, Y, X) if size[axis] <= FLAT * size.max()), None)
    if across is None:
        got = Said(", ".join(f"{axis} over {s:g}" for axis, s in zip(AXES, size, strict=True)))
        raise InputError(source, "", got, "must be faces in one plane: one coordinate is the same")
    axes = PLANES[across]
    outlines = named_apart(
        Outline(own, group, corners[face][:, axes]) for own, group, face in faces
    )
    require_outlines(source, outlines, HOLDS)
    return Drawing(outlines)


def _place(text: str, count: int) -> int:
    """The place of a vertex that a face names: from 1, or backwards from -1."""
    number = int(text.partition("/")[0])
    place = number - 1 if number > 0 else count + number
    if not 0 <= place < count or number == 0:
        raise ValueError
    return place
