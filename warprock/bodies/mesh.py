"""A rigid body from the file of its surface: PLY, OBJ or STL, as scanners write it.

The surface has to be closed and one body. Volume, centre of mass and inertia are then exact for the
polyhedron: sums over the tetrahedra between its triangles and a point (B. Mirtich, 1996, Fast and
accurate computation of polyhedral mass properties, *Journal of Graphics Tools* 1(2)).
"""

from __future__ import annotations

import dataclasses
import hashlib
import importlib.util
import io
import pathlib
import re
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.errors import InputError, Said, is_plain
from warprock.reading import read_bytes, reason
from warprock.units import UNITS, Dimension

Array = npt.NDArray[np.float64]

FORMS = (".ply", ".obj", ".stl")
LARGEST, SMALLEST = 20.0, 0.01
"""Sizes of a body between which its lengths are taken for metres where no unit is named [m]."""
THINNEST = 1e-6
"""Volume over that of the box around a body at which it is a sheet and no body."""
EXTRA = "mesh"
"""The extra of ours that brings what reads meshes."""


@dataclasses.dataclass(frozen=True, eq=False)
class Solid:
    """A closed surface, and what it holds at a density of one.

    Attributes:
        corners: Vertices [m], shape [vertex, 3].
        faces: Numbers of the vertices of the triangles, shape [face, 3].
        volume: Volume [m^3].
        centre: Centre of volume [m], shape [3].
        inertia: Inertia tensor about the centre, over the volume [m^2], shape [3, 3].
        sha256: SHA-256 of its file; empty without one.
    """

    corners: Array
    faces: npt.NDArray[np.int64]
    volume: float
    centre: Array
    inertia: Array
    sha256: str = ""


def read_solid(path: pathlib.Path, unit: str | None = None) -> Solid:
    """The body in a file.

    Args:
        path: A file that ends in .ply, .obj or .stl.
        unit: Unit of its lengths; None takes metres if its size looks like that.

    Returns:
        The body in metres, in the axes of the file.

    Raises:
        InputError: The file cannot be read or holds no mesh, the surface is open, there are several
            bodies, or the size looks like another unit.
    """
    source = str(path)
    content = _content(path)
    corners, faces = _join_vertices(_mesh(path, content))
    if not len(faces):
        allowed = "must hold a mesh of triangles, as PLY, OBJ or STL: a cloud of points is none"
        raise InputError(source, "", Said("no faces that can be used"), allowed)
    size = _unit_size(source, corners, unit)
    corners = corners * size
    _require_closed(source, faces)
    faces = _outwards(source, corners, faces)
    digest = hashlib.sha256(content).hexdigest()
    return dataclasses.replace(solid_of(corners, faces), sha256=digest)


def solid_of(corners: Array, faces: npt.NDArray[np.int64]) -> Solid:
    """A body from its closed surface.

    Args:
        corners: Vertices [m], shape [vertex, 3].
        faces: Numbers of the vertices of the triangles, seen from outside against the clock.
    """
    import trimesh

    # From the middle: a scan may lie kilometres from the origin of its map.
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    found = trimesh.triangles.mass_properties((corners - middle)[faces], density=1.0)
    volume = float(found.volume)
    centre = np.asarray(found.center_mass, dtype=np.float64) + middle
    inertia = np.asarray(found.inertia, dtype=np.float64) / volume
    return Solid(corners, faces, volume, centre, inertia)


def _content(path: pathlib.Path) -> bytes:
    """The bytes of a file that may be a mesh."""
    if not is_plain(path.name):
        allowed = "must have a name that is text (UTF-8) in one line: the case has it, too"
        raise InputError("MESH", "", str(path), allowed)
    if path.suffix.lower() not in FORMS:
        raise InputError("MESH", "", str(path), f"must end in one of {', '.join(FORMS)}")
    try:
        content = read_bytes(path)
    except OSError as error:
        allowed = f"must be a file that can be read ({reason(error)})"
        raise InputError("MESH", "", str(path), allowed) from None
    if importlib.util.find_spec("trimesh") is None:
        allowed = f"must be installed to read meshes: pip install 'warprock[{EXTRA}]'"
        raise InputError("MESH", "", Said("no package trimesh"), allowed)
    return content


def _mesh(path: pathlib.Path, content: bytes) -> Any:
    """The mesh in a file, as trimesh reads it."""
    import trimesh

    ending = path.suffix.lower()
    known = {"skip_materials": True} if ending == ".obj" else {}
    try:
        return trimesh.load_mesh(io.BytesIO(content), file_type=ending[1:], process=False, **known)
    except Exception as error:
        # Readers of bytes that are no mesh fail in many ways: struct.error, IndexError, ...
        said = re.sub(r"\s+", " ", str(error)).strip()[:80]
        why = f"{type(error).__name__}: {said}" if said else type(error).__name__
        allowed = f"must be a mesh as {ending[1:].upper()} ({why})"
        raise InputError(str(path), "", Said("a file that is no mesh"), allowed) from None


def _join_vertices(mesh: Any) -> tuple[Array, npt.NDArray[np.int64]]:
    """Vertices and faces, with one vertex a place: STL repeats them, OBJ for its textures.

    A triangle of which two corners then are one has no area and closes nothing. No faces are left
    where one has a corner that is not there, or nowhere.
    """
    corners = np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3)
    faces = np.asarray(getattr(mesh, "faces", ()), dtype=np.int64).reshape(-1, 3)
    if faces.size and (faces.min() < 0 or faces.max() >= len(corners)):
        return corners[:0], faces[:0]
    if not np.isfinite(corners[faces]).all():
        return corners[:0], faces[:0]
    used, places = np.unique(faces, return_inverse=True)
    corners, joined = np.unique(corners[used], axis=0, return_inverse=True)
    faces = joined.reshape(-1)[places.reshape(-1, 3)]
    whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return corners, faces[whole]


def _unit_size(source: str, corners: Array, unit: str | None) -> float:
    """Metres in a unit; judges the size of the body where none is named."""
    units = UNITS[Dimension.LENGTH]
    if unit is not None:
        if unit not in units:
            raise InputError("--unit", "", unit, f"must be one of {', '.join(units)}")
        return float(units[unit])
    largest = float(np.ptp(corners, axis=0).max())
    if largest > LARGEST:
        allowed = (
            f"must be at most {LARGEST:g} m without --unit: it looks like mm, say --unit mm "
            "(or cm, in, ft; m where it is so)"
        )
        raise InputError(source, "", Said(f"a body {largest:,.4g} m long"), allowed)
    if largest < SMALLEST:
        allowed = f"must be at least {SMALLEST:g} m without --unit: say --unit, such as --unit m"
        raise InputError(source, "", Said(f"a body {largest:.3g} m long"), allowed)
    return float(units["m"])


def _require_closed(source: str, faces: npt.NDArray[np.int64]) -> None:
    """Refuses an open surface; a closed one passes each edge as often one way as the other.

    Raises:
        InputError: An edge has one face alone, or two that are wound against one another.
    """
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    forward = np.where(edges[:, 0] < edges[:, 1], 1, -1)
    _, place, count = np.unique(
        np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    balance = np.bincount(place.reshape(-1), weights=forward).astype(int)
    odd = int((count % 2 == 1).sum())
    if odd:
        allowed = (
            "must be closed: fill its holes in the program that made it (MeshLab: Close Holes)"
        )
        raise InputError(source, "", Said(f"a mesh with holes, {odd:,} open edges"), allowed)
    turned = int((balance != 0).sum())
    if turned:
        allowed = "must have faces that all look outwards (MeshLab: Re-Orient All Faces Coherently)"
        raise InputError(source, "", Said(f"{turned:,} edges between turned faces"), allowed)


def _outwards(source: str, corners: Array, faces: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Faces that look outwards, of one body; what lies inside it and looks inwards is a hollow.

    Raises:
        InputError: There are several bodies, or none with a volume.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(corners)
    links = np.concatenate([faces[:, :2], faces[:, 1:]])
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    _, part = connected_components(graph, directed=False)
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    first, second, third = np.moveaxis((corners - middle)[faces], 1, 0)
    volumes = np.einsum("ij,ij->i", first, np.cross(second, third)) / 6.0
    parts = np.bincount(part[faces[:, 0]], weights=volumes)
    if parts.sum() < 0.0:
        faces, parts = faces[:, ::-1], -parts
    box = float(np.prod(np.maximum(np.ptp(corners, axis=0), 1e-30)))
    if parts.sum() < THINNEST * box:
        allowed = "must be a closed surface around a body"
        raise InputError(source, "", Said("a mesh without a volume"), allowed)
    bodies = int((parts > 0.0).sum())
    if bodies > 1:
        share = parts.max() / parts[parts > 0.0].sum()
        allowed = f"must be one: the largest has {share:.1%} of the volume, take the others out"
        raise InputError(source, "", Said(f"{bodies:,} bodies"), allowed)
    return faces
