"""Assemblies in space as kernels/assembly_space/assembly_run.py takes them.

Every lane has the shapes of its blocks in arrays of its own: corners, faces and edges of all blocks
one behind the other. The axes of a block are the principal axes of its inertia.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from warprock.engines.assembly_packs import falls_by, least_reach, reach_of
from warprock.engines.launching import NEVER
from warprock.errors import InputError
from warprock.model.assembly import Assemblies
from warprock.model.solids import SpatialAssembly
from warprock.model.turning import inverse, principal_axes, rotate

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]
Rows = npt.NDArray[np.void]

MOST_CORNERS = 12
"""Most corners of a face, and half of those that two faces may have in common."""

PAIRS_PER_BLOCK = 12
"""Room for pairs of blocks without a joint that may touch soon, over the number of blocks."""

SPARE_PER_BLOCK = 8
"""Room for contacts besides those of joints at the start, over the number of blocks: four between
every block and a face that it lies on in a heap, twice."""

FILLED, SPARE_ROWS = 4, 64
"""Contacts of a row of eight at least, on average, and rows besides: what has few blocks fills
none."""

MET_PER_BLOCK, SPARE_COLOURS = 4, 16
"""Room for packs of eight meetings besides those of joints at the start: meetings over the number
of blocks, and colours that a heap has more than twice the joints of a block."""

PARALLEL = 1e-6
"""Sine of the angle up to which edges have one direction."""

FLAT = 1e-9
"""Second moments of a joint along its normal, over the others: round-off."""

FLUSH = 1e-6
"""Distance up to which something lies on the ground, over the size of the assembly: round-off."""


@dataclasses.dataclass(frozen=True, eq=False)
class Shapes:
    """The shapes of the blocks of an assembly, one behind the other, in the axes of the blocks.

    Attributes:
        principal: Moments of inertia [kg m^2], shape [block, 3].
        attitude: Quaternions of their axes at the start, shape [block, 4].
        corners: From the centres of the blocks [m], shape [corner, 3].
        corner_of: Where the corners of each block begin, shape [block + 1].
        normals: Of faces, shape [face, 3].
        levels: Distances of faces from the centres [m], shape [face].
        face_of: Where the faces of each block begin, shape [block + 1].
        rings: Corners of faces, numbered in their blocks, shape [ring].
        ring_of: Where those of each face begin, shape [face + 1].
        lines: Directions of edges, shape [line, 3].
        line_of: Where those of each block begin, shape [block + 1].
        edges: Two corners and a direction, numbered in their blocks, shape [edge, 3].
        edge_of: Where those of each block begin, shape [block + 1].
        across: Unit vectors across the edges of the largest joint of each block that can move, one
            of each direction, shape [span, 3].
        width: How wide the joint is along each [m], shape [span].
        span_of: Where those of each block begin, shape [block + 1].
    """

    principal: Array
    attitude: Array
    corners: Array
    corner_of: Places
    normals: Array
    levels: Array
    face_of: Places
    rings: Places
    ring_of: Places
    lines: Array
    line_of: Places
    edges: Places
    edge_of: Places
    across: Array
    width: Array
    span_of: Places


@functools.lru_cache(maxsize=64)
def shapes_of(kind: SpatialAssembly) -> Shapes:
    """The shapes of an assembly.

    Raises:
        InputError: A face has more corners than the kernel has room for.
    """
    principal = [principal_axes(tensor) for tensor in kind.inertia]
    moments, attitude = (np.array(each) for each in zip(*principal, strict=True))
    corners, normals, levels, rings, lines, edges = ([] for _ in range(6))
    spans = [_spans(kind, block, attitude[block]) for block in range(kind.count)]
    for block in range(kind.count):
        offset = kind.corners[block, : kind.corner_count[block]] - kind.centre[block]
        own = rotate(inverse(attitude[block]), offset)
        corners.append(own)
        directions: list[Array] = []
        between: dict[tuple[int, int], int] = {}
        for ring in kind.faces[block]:
            if len(ring) > MOST_CORNERS:
                allowed = f"must have faces of at most {MOST_CORNERS} corners"
                raise InputError("assembly", f"block {kind.names[block]}", len(ring), allowed)
            normal = _normal(own[list(ring)])
            normals.append(normal)
            levels.append(float((own[list(ring)] @ normal).mean()))
            rings.append(np.asarray(ring, dtype=np.intp))
            for start, stop in zip(ring, (*ring[1:], ring[0]), strict=True):
                pair = (min(start, stop), max(start, stop))
                if pair not in between:
                    between[pair] = _direction(directions, own[stop] - own[start])
        lines.append(np.asarray(directions))
        edges.append(np.array([(*pair, line) for pair, line in between.items()], dtype=np.intp))
    return Shapes(
        principal=moments,
        attitude=attitude,
        corners=np.concatenate(corners),
        corner_of=_starts(corners),
        normals=np.asarray(normals),
        levels=np.asarray(levels),
        face_of=_starts(kind.faces),
        rings=np.concatenate(rings),
        ring_of=_starts(rings),
        lines=np.concatenate(lines),
        line_of=_starts(lines),
        edges=np.concatenate(edges),
        edge_of=_starts(edges),
        across=np.concatenate([across for across, _ in spans]),
        width=np.concatenate([width for _, width in spans]),
        span_of=_starts([width for _, width in spans]),
    )


def _spans(kind: SpatialAssembly, block: int, attitude: Array) -> tuple[Array, Array]:
    """Across the edges of the largest joint of a block in its axes, and its widths there [m]."""
    joints = kind.joints
    own = np.flatnonzero((joints.blocks == block).any(axis=1))
    if kind.fixed[block] or not len(own):
        return np.empty((0, 3)), np.empty(0)
    joint = own[np.argmax(joints.area[own])]
    corners = joints.ends[joint, : joints.corner_count[joint]]
    directions: list[Array] = []
    for edge in np.roll(corners, -1, axis=0) - corners:
        _direction(directions, np.cross(joints.normal[joint], edge))
    across = np.asarray(directions)
    return rotate(inverse(attitude), across), np.ptp(corners @ across.T, axis=0)


def _starts(parts: Any) -> Places:
    """Where each of several lists begins if they lie one behind the other, and their end."""
    return np.concatenate([[0], np.cumsum([len(part) for part in parts])]).astype(np.intp)


def _normal(corners: Array) -> Array:
    """Unit normal of a polygon, by all of its corners (Newell)."""
    area = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    return np.asarray(area / np.linalg.norm(area))


def _direction(known: list[Array], along: Array) -> int:
    """The number of a direction among those known, to which a new one is added."""
    unit = along / np.linalg.norm(along)
    for number, each in enumerate(known):
        if np.linalg.norm(np.cross(each, unit)) <= PARALLEL:
            return number
    known.append(unit)
    return len(known) - 1


@functools.lru_cache(maxsize=64)
def below_ground(kind: SpatialAssembly) -> npt.NDArray[np.bool_]:
    """Which blocks are fixed and nowhere above the ground, shape [block]: the ground itself."""
    size = float(np.ptp(kind.corners.reshape(-1, 3), axis=0).max())
    top = kind.corners[..., 2].max(axis=1)
    return np.asarray(kind.fixed & (top <= kind.ground + max(FLUSH * size, kind.flush)))


def _kinds(assemblies: Assemblies) -> tuple[SpatialAssembly, ...]:
    return cast(tuple[SpatialAssembly, ...], assemblies.kinds)


def block_columns(assemblies: Assemblies) -> dict[str, Array]:
    """Fields of the struct of blocks of the kernel, shape [lane, block] each."""
    kinds = [_blocks(kind, assemblies.most_parts) for kind in _kinds(assemblies)]
    return {name: np.stack([kind[name] for kind in kinds])[assemblies.lane] for name in kinds[0]}


def _blocks(kind: SpatialAssembly, room: int) -> dict[str, Array]:
    shapes, free = shapes_of(kind), ~kind.fixed
    columns = {"light": free / kind.mass, "reach": reach_of(kind), "fall": falls_by(kind)}
    columns |= dict(zip(("x", "y", "z"), kind.centre.T, strict=True))
    columns |= dict(zip(("qx", "qy", "qz", "qw"), shapes.attitude.T, strict=True))
    inverse = free[:, None] / shapes.principal
    columns |= dict(zip(("inverse_x", "inverse_y", "inverse_z"), inverse.T, strict=True))
    return {name: np.pad(each, (0, room - kind.count)) for name, each in columns.items()}


@functools.lru_cache(maxsize=64)
def _links(kind: SpatialAssembly, struct: Any) -> Rows:
    """Rows of the struct `Link`, in the order of their blocks."""
    shapes, ground = shapes_of(kind), below_ground(kind)
    rows = np.zeros(kind.joints.count, dtype=struct.numpy_dtype())
    first, second = kind.joints.blocks.T
    turned = ground[first]
    for name, own, other, sign in (("a", first, second, -1.0), ("b", second, first, 1.0)):
        block = np.where(turned, other, own)
        rows[name] = np.where(ground[block], kind.count, block)
        normals = np.where(turned, -sign, sign)[:, None] * kind.joints.normal
        for joint, place in enumerate(block):
            if not ground[place]:
                rows[f"face_{name}"][joint] = _face_along(kind, shapes, int(place), normals[joint])
    rows["friction"], rows["number"] = kind.joints.friction, np.arange(kind.joints.count)
    if "tension" in rows.dtype.names:
        for name, values in _sections(kind, shapes, rows["a"]).items():
            rows[name] = values
    least = np.array(
        [
            shapes.width[start:stop].min(initial=NEVER)
            for start, stop in itertools.pairwise(shapes.span_of)
        ]
    )
    rows["least"] = least[kind.joints.blocks].min(axis=1)
    return rows[np.lexsort((rows["b"], rows["a"]))]


def _sections(kind: SpatialAssembly, shapes: Shapes, first: Places) -> dict[str, Array]:
    """Fields of `Link` that say what bonded joints bear, in the axes of their first blocks."""
    joints = kind.joints
    middle, moments = joints.middle, joints.second_moments
    bending: Array = np.linalg.pinv(moments, rcond=FLAT, hermitian=True).astype(np.float64)
    axes = shapes.attitude[first]
    turned = rotate(inverse(axes)[:, None], bending)
    return {
        "cohesion": joints.cohesion,
        "tension": joints.tension,
        "area": joints.area,
        "middle": rotate(inverse(axes), middle - kind.centre[first]),
        "bending": rotate(inverse(axes)[:, None], turned.swapaxes(1, 2)),
        "twisting": 1.0 / np.trace(moments, axis1=1, axis2=2),
    }


def _face_along(kind: SpatialAssembly, shapes: Shapes, block: int, normal: Array) -> int:
    """The face of a block whose outward normal is nearest to a normal in the axes of the base."""
    first, last = shapes.face_of[block : block + 2]
    own = rotate(inverse(shapes.attitude[block]), normal)
    return int(np.argmax(shapes.normals[first:last] @ own))


def rows_of(assemblies: Assemblies, structs: dict[str, Any]) -> dict[str, npt.NDArray[Any]]:
    """Arrays of the struct `Laid` that say where blocks are and may touch, shape [lane, ...]."""
    parts = [_rows(kind, structs) for kind in _kinds(assemblies)]
    found = {}
    for name in parts[0]:
        most = max(1, *(len(part[name]) for part in parts))
        first = parts[0][name]
        values = np.zeros((len(parts), most, *first.shape[1:]), dtype=first.dtype)
        for row, part in zip(values, parts, strict=True):
            row[: len(part[name])] = part[name]
        found[name] = values[assemblies.lane]
    kinds = _kinds(assemblies)
    found["scale"] = np.array([least_reach(kind) for kind in kinds])[assemblies.lane]
    found["friction"] = np.array([kind.friction for kind in kinds])[assemblies.lane]
    return found


def _rows(kind: SpatialAssembly, structs: dict[str, Any]) -> dict[str, npt.NDArray[Any]]:
    shapes, count = shapes_of(kind), kind.count
    solids = np.zeros(count + 1, dtype=structs["solids"].numpy_dtype())
    starts = {
        "corner": shapes.corner_of,
        "face": shapes.face_of,
        "line": shapes.line_of,
        "edge": shapes.edge_of,
        "span": shapes.span_of,
    }
    for name, start in starts.items():
        solids[name] = start
        solids[f"{name}s"][:count] = np.diff(start)
    for name in ("corners", "faces", "lines", "edges"):
        solids[name][:count][below_ground(kind)] = 0
    solids["faces"][count] = 1
    solids["reach"][:count] = reach_of(kind)
    solids["moves"][:count] = ~kind.fixed
    faces = np.zeros(len(shapes.normals) + 1, dtype=structs["faces"].numpy_dtype())
    faces["normal"][:-1], faces["level"][:-1] = shapes.normals, shapes.levels
    faces["ring"], faces["corners"][:-1] = shapes.ring_of, np.diff(shapes.ring_of)
    faces["normal"][-1] = 0.0, 0.0, 1.0
    edges = np.zeros(len(shapes.edges), dtype=structs["edges"].numpy_dtype())
    for name, values in zip(("start", "stop", "line"), shapes.edges.T, strict=True):
        edges[name] = values
    spans = np.zeros(len(shapes.width), dtype=structs["spans"].numpy_dtype())
    spans["across"], spans["width"] = shapes.across, shapes.width
    places = np.zeros(count + 1, dtype=structs["places"].numpy_dtype())
    places["at"][count] = 0.0, 0.0, kind.ground
    places["q"][count] = 0.0, 0.0, 0.0, 1.0
    places["r"][count] = np.eye(3)
    return {
        "sizes": np.array([count, kind.joints.count]),
        "solids": solids,
        "corners": shapes.corners,
        "faces": faces,
        "rings": shapes.rings,
        "lines": shapes.lines,
        "edges": edges,
        "spans": spans,
        "links": _links(kind, structs["links"]),
        "places": places,
    }


def room_for_pairs(assemblies: Assemblies) -> int:
    """Pairs of blocks without a joint for which a lane has room."""
    return PAIRS_PER_BLOCK * (assemblies.most_parts + 1)


def room_for_contacts(assemblies: Assemblies) -> int:
    """Contacts for which a lane has room."""
    of_joints = max(int(kind.joints.corner_count.sum()) for kind in _kinds(assemblies))
    return of_joints + SPARE_PER_BLOCK * (assemblies.most_parts + 1)


def room_for_rows(assemblies: Assemblies) -> int:
    """Rows of contacts side by side for which a lane has room; see kernels' packing.py."""
    return room_for_contacts(assemblies) // FILLED + SPARE_ROWS


def most_corners(assemblies: Assemblies) -> int:
    """Corners of all blocks of a lane, at most."""
    return max(len(shapes_of(kind).corners) for kind in _kinds(assemblies))


def room_for_packs(assemblies: Assemblies) -> int:
    """Packs of eight meetings for which a lane has room; see kernels' packing.py.

    A meeting takes the first colour that none of its two blocks has: of d joints that a block has
    at most there are fewer than 2 d colours, and each has one pack that is not full.
    """
    kinds = _kinds(assemblies)
    meetings = assemblies.most_joints + MET_PER_BLOCK * (assemblies.most_parts + 1)
    joints = max(
        int(np.bincount(kind.joints.blocks.ravel(), minlength=kind.count)[~kind.fixed].max())
        for kind in kinds
    )
    return meetings // 8 + 2 * joints + SPARE_COLOURS


def turns_back(assemblies: Assemblies) -> Array:
    """Quaternions that turn from the principal axes at the start to none, shape [lane, block, 4].

    A block that a lane has not is zero.
    """
    starts = np.zeros((len(assemblies.kinds), assemblies.most_parts, 4))
    for row, kind in zip(starts, _kinds(assemblies), strict=True):
        row[: kind.count] = inverse(shapes_of(kind).attitude)
    return np.asarray(starts[assemblies.lane])
