"""Sections of blocks in the plane, from the faces of their surfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.errors import InputError, Said

Array = npt.NDArray[np.float64]

FLAT = 1e-6
"""Distance from a plane up to which a corner lies in it, over the size of the assembly."""

X, Y, Z = 0, 1, 2
AXES = "xyz"
PLANES: dict[int, tuple[int, int]] = {Y: (X, Z), X: (Y, Z), Z: (X, Y)}
"""Axis across a plane -> the axes along it and upwards, the most usual plane first."""


class Surface(NamedTuple):
    """The surface of a block.

    Attributes:
        name: What it is called, as errors name it.
        corners: Its vertices, shape [vertex, 3].
        faces: Numbers of the vertices of each face.
    """

    name: str
    corners: Array
    faces: Sequence[npt.NDArray[np.intp]]


def plane_sections(source: str, surfaces: Mapping[str, Surface]) -> dict[str, Array]:
    """Sections of prisms that stand side by side in one plane.

    The plane is that of x and z, of y and z, or of x and y: the first across which all blocks are
    prisms whose middles lie in one plane.

    Args:
        source: The file, as errors name it.
        surfaces: Blocks by key.

    Returns:
        Corners of the section of each block in the plane, shape [corner, 2].

    Raises:
        InputError: There is no such plane, or a section is not convex.
    """
    every = np.concatenate([each.corners for each in surfaces.values()])
    flat = FLAT * float(np.ptp(every, axis=0).max())
    for across, axes in PLANES.items():
        if _are_prisms(surfaces, across, flat):
            return {
                key: _section(source, each, across, axes, flat) for key, each in surfaces.items()
            }
    got = Said(f"{len(surfaces):,} blocks in space")
    allowed = (
        "must be prisms side by side in one plane, of x and z, y and z, or x and y; in space with "
        'model = "spatial"'
    )
    raise InputError(source, "", got, allowed)


def convex_corners(source: str, surface: Surface) -> Array:
    """Corners of a convex body, shape [corner, 3].

    Args:
        source: The file, as errors name it.
        surface: Its surface.

    Raises:
        InputError: The surface is not closed, is flat, or its body is not convex.
    """
    import scipy.spatial

    used = np.unique(np.concatenate(list(surface.faces)))
    corners = surface.corners[used]
    if len(corners) < 4 or not np.isfinite(corners).all():
        allowed = "must be at least 4 corners with finite coordinates"
        raise InputError(source, surface.name, Said(f"{len(corners)} corners"), allowed)
    try:
        hull = scipy.spatial.ConvexHull(corners)
    except scipy.spatial.QhullError:
        raise InputError(source, surface.name, Said("a flat block"), "must be a body") from None
    fans = (((f[0], f[k], f[k + 1]) for k in range(1, len(f) - 1)) for f in surface.faces)
    triangles = np.array([each for fan in fans for each in fan])
    a, b, c = (surface.corners[triangles[:, k]] - corners.mean(axis=0) for k in range(3))
    vectors = np.cross(b - a, c - a)
    if np.abs(vectors.sum(axis=0)).max() > NOTCH * np.linalg.norm(vectors, axis=1).sum():
        got, allowed = Said("an open surface"), "must be closed, its faces turned to one side"
        raise InputError(source, surface.name, got, allowed)
    volume = abs(float(np.einsum("ti,ti->", a, np.cross(b, c)))) / 6.0
    if hull.volume - volume > NOTCH * hull.volume:
        allowed = "must be convex: split it into several"
        raise InputError(source, surface.name, Said("a body that is not convex"), allowed)
    return np.asarray(corners)


NOTCH = 1e-3
"""Part of its convex hull that a body may lack, or that its surface may gape, and be taken for
convex and closed: corners of drawn faces do not quite lie in a plane."""


def _are_prisms(surfaces: Mapping[str, Surface], across: int, flat: float) -> bool:
    middles = []
    for each in surfaces.values():
        place = each.corners[:, across]
        low, high = place.min(), place.max()
        if (np.minimum(place - low, high - place) > flat).any() or high - low <= flat:
            return False
        middles.append(0.5 * (low + high))
    return float(np.ptp(middles)) <= flat


def _section(
    source: str, surface: Surface, across: int, axes: tuple[int, int], flat: float
) -> Array:
    """The faces of a prism at its lower end as one polygon."""
    place = surface.corners[:, across]
    ends = place - place.min() <= flat
    parts = [surface.corners[face][:, axes] for face in surface.faces if ends[face].all()]
    if len(parts) == 1:
        return parts[0]
    area = sum(abs(polygon_area(part)) for part in parts)
    corners = np.concatenate(parts) if parts else np.empty((0, 2))
    if area > flat * flat:
        import scipy.spatial

        hull = scipy.spatial.ConvexHull(corners)
        # In the plane the volume of a hull is its area.
        if hull.volume - area <= FLAT * hull.volume:
            return np.asarray(corners[hull.vertices])
    allowed = "must be a prism with a convex section: split it into several"
    raise InputError(source, surface.name, Said("a section that is not convex"), allowed)


def polygon_area(corners: Array) -> float:
    """Area of a polygon, negative where it is clockwise; corners of shape [corner, 2]."""
    here = corners - corners[0]
    after = np.roll(here, -1, axis=0)
    return float(0.5 * (here[:, 0] * after[:, 1] - here[:, 1] * after[:, 0]).sum())
