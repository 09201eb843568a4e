"""Assemblies in space: convex blocks with dry joints, and which of them touch where.

A joint is the part of a plane over which the faces of two blocks overlap, a convex polygon: its
corners are contact points. A block that touches two others below it has a joint with each of them.
Faces of drawn blocks meet within a tolerance; then both are taken to lie in the plane of the joint.
x and y are horizontal, z is upwards.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.model.assembly import (
    DOUBTFUL,
    FLUSH,
    SHORTEST,
    SPACE,
    Array,
    Assembly,
    Joints,
    Piece,
    Places,
    near,
    require_held,
    require_lifted,
    straightened,
)

Face = tuple[int, ...]

FACING = -0.9
"""Cosine of the angle between the outward normals of faces that may touch, at most."""

PAIRS_AT_ONCE = 20_000
"""Pairs of blocks whose faces are compared at once, so that memory stays below some 100 MB."""


@dataclasses.dataclass(frozen=True, eq=False)
class SpatialJoints(Joints):
    """Polygons that faces of blocks share.

    Their ends are the corners of these polygons, shape [joint, corner, 3], in the sense in which
    the first tangent turns towards the second; the last one is repeated where there are fewer.
    Blocks, friction, cohesion and tension are as in the plane; the normal, from the second block
    into the first, has the shape [joint, 3].

    Attributes:
        corner_count: Corners of every polygon, shape [joint].
    """

    corner_count: Places

    @property
    def end_count(self) -> Places:
        """Corners of every polygon, shape [joint]."""
        return self.corner_count

    @functools.cached_property
    def lengths(self) -> Array:
        """Least widths of the polygons [m], shape [joint]."""
        return np.array(
            [
                _least_width(_flat(ends[:count], axes))
                for ends, count, axes in zip(
                    self.ends, self.corner_count, self.tangents, strict=True
                )
            ]
        )

    @property
    def area(self) -> Array:
        """Areas of the polygons [m^2], shape [joint]."""
        arms = self.ends - self.ends[:, :1]
        turned = np.cross(arms, np.roll(arms, -1, axis=1)).sum(axis=1)
        return np.asarray(0.5 * (turned * self.normal).sum(axis=1))

    @property
    def middle(self) -> Array:
        """Middles of the areas of the polygons [m], shape [joint, 3]."""
        return self._sections[0]

    @property
    def second_moments(self) -> Array:
        """Second moments of the areas of the polygons about their middles [m^4].

        Shape [joint, 3, 3]: integrals of r r over the area, none along the normal.
        """
        return self._sections[1]

    @functools.cached_property
    def _sections(self) -> tuple[Array, Array]:
        # A polygon is a fan of triangles from its first corner. Over one with the corners a, b and
        # c the integral of r r is area / 12 (s s + a a + b b + c c), where s is their sum.
        arms = self.ends - self.ends[:, :1]
        fan = np.stack([np.zeros_like(arms), arms, np.roll(arms, -1, axis=1)], axis=2)
        area = 0.5 * np.einsum("jci,ji->jc", np.cross(fan[:, :, 1], fan[:, :, 2]), self.normal)
        middle = np.einsum("jc,jcki->ji", area, fan) / (3.0 * self.area[:, None])
        corners = fan - middle[:, None, None]
        total = corners.sum(axis=2)
        moments = np.einsum("jc,jci,jck->jik", area, total, total)
        moments = (moments + np.einsum("jc,jcli,jclk->jik", area, corners, corners)) / 12.0
        return self.ends[:, 0] + middle, moments

    @functools.cached_property
    def tangents(self) -> Array:
        """Unit vectors along every joint, shape [joint, 2, 3]; normal to its normal.

        The first is horizontal: along x in a level joint. The second is the normal times the first.
        """
        return tangents_of(self.normal)


def tangents_of(normal: Array) -> Array:
    """Two unit vectors along planes; see `SpatialJoints`.

    Args:
        normal: Unit normals, shape [plane, 3].
    """
    level = np.hypot(normal[:, 0], normal[:, 1]) < LEVEL
    first = np.where(level[:, None], _ALONG_X, np.cross(_UPWARDS, normal))
    first = first - (first * normal).sum(axis=1)[:, None] * normal
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(normal, first)], axis=1)


LEVEL = 1e-6
"""Horizontal part of a unit normal below which a joint is level."""

_ALONG_X, _UPWARDS = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


@dataclasses.dataclass(frozen=True, eq=False)
class SpatialAssembly(Assembly):
    """Convex blocks with dry joints, at rest in space.

    Corners have the shape [block, corner, 3], the last one repeated where a block has fewer; its
    depth is that of the blocks that can move, together, along y.

    Attributes:
        faces: Of every block and face the numbers of its corners, counterclockwise from outside.
    """

    faces: tuple[tuple[Face, ...], ...]
    joints: SpatialJoints

    @functools.cached_property
    def _moments(self) -> tuple[Array, Array, Array]:
        """Volumes [m^3], centres [m] and inertia about them over density [m^5], of all blocks."""
        found = [_moments(c, faces) for c, faces in zip(self.corners, self.faces, strict=True)]
        volume, centre, inertia = (np.array(each) for each in zip(*found, strict=True))
        return volume, centre, inertia

    @property
    def volume(self) -> Array:
        """Volume of the blocks [m^3], shape [block]."""
        return self._moments[0]

    @property
    def mass(self) -> Array:
        """Mass of the blocks [kg], shape [block]."""
        return np.asarray(self.volume * self.density)

    @property
    def centre(self) -> Array:
        """Centres of mass [m], shape [block, 3]."""
        return self._moments[1]

    @property
    def inertia(self) -> Array:
        """Inertia tensors about the centres of mass [kg m^2], shape [block, 3, 3]."""
        return np.asarray(self._moments[2] * self.density)

    @property
    def area(self) -> Array:
        """Mean areas of sections across y: volume over extent along y [m^2], shape [block]."""
        return np.asarray(self.volume / np.ptp(self.corners[..., 1], axis=1))

    @property
    def corner_count(self) -> Places:
        """Corners of the blocks, shape [block]."""
        return np.array([1 + max(max(face) for face in faces) for faces in self.faces])

    @functools.cached_property
    def reach(self) -> float:
        """The largest distance of a corner from the nearest joint with what is fixed [m]."""
        import scipy.spatial

        held = np.flatnonzero(self.fixed[self.joints.blocks].any(axis=1))
        feet = np.array([self.joints.ends[k, : self.joints.corner_count[k]].mean(0) for k in held])
        corners = self.corners[~self.fixed].reshape(-1, SPACE)
        return float(np.max(scipy.spatial.KDTree(feet).query(corners)[0]))


def assemble_solids(
    pieces: Sequence[Piece],
    *,
    density: float,
    friction: float,
    head_friction: float | None = None,
    tolerance: float | None = None,
    cohesion: float = 0.0,
    tension: float = 0.0,
) -> SpatialAssembly:
    """Convex blocks in space with the joints that their faces make.

    Args:
        pieces: The blocks by their corners, shape [corner, 3]: each is the convex hull of them.
        density: [kg/m^3].
        friction: Coefficient of every joint, and of blocks that meet elsewhere.
        head_friction: That of head joints, which are nearer to upright than to level; None where
            it is the same.
        tolerance: Distance up to which faces of drawn blocks touch [m]; None where coordinates are
            exact.
        cohesion: Shear strength of every joint without load, until it breaks [Pa].
        tension: Tensile strength of every joint, likewise; zero of dry joints.

    Raises:
        ValueError: A block is flat, two blocks overlap, a drawing leaves open whether they touch,
            or a block rests on nothing that is fixed. The message ends a sentence "must ...".
    """
    names = tuple(piece.name for piece in pieces)
    fixed = np.array([piece.fixed for piece in pieces])
    exact = FLUSH * max(np.ptp(np.concatenate([each.corners for each in pieces]), axis=0))
    flush = exact if tolerance is None else max(tolerance, exact)
    bodies = [_body(piece, flush) for piece in pieces]
    corners = _padded([each.corners for each in bodies])
    surfaces = _surfaces(bodies)
    _require_large(bodies, names, flush)
    pairs = near(corners, flush)
    _require_apart(corners, surfaces, names, pairs, flush)
    joints = _find_joints(bodies, surfaces, _one_moves(pairs, fixed), flush)
    if tolerance is not None:
        _require_no_gaps(bodies, surfaces, names, joints, flush, fixed)
    upright = np.abs(joints.normal[:, 2]) < np.linalg.norm(joints.normal[:, :2], axis=1)
    own = friction if head_friction is None else head_friction
    joints = dataclasses.replace(
        joints,
        friction=np.where(upright, own, friction),
        cohesion=np.full(joints.count, cohesion),
        tension=np.full(joints.count, tension),
    )
    require_held(joints, names, fixed, lambda a, b: max(_parted(corners, surfaces, a, b), 0.0))
    if tension == 0.0:
        require_lifted(joints, names, fixed)
    moving = np.concatenate([each.corners for each, f in zip(bodies, fixed, strict=True) if not f])
    return SpatialAssembly(
        corners=corners,
        names=names,
        fixed=fixed,
        depth=float(np.ptp(moving[:, 1])),
        density=density,
        joints=joints,
        flush=flush,
        friction=friction,
        faces=tuple(each.faces for each in bodies),
    )


class _Body(NamedTuple):
    """A convex block: corners, and of every face those on it, counterclockwise from outside."""

    corners: Array
    faces: tuple[Face, ...]
    normals: Array


def _body(piece: Piece, flush: float) -> _Body:
    """The convex hull of the corners of a piece."""
    import scipy.spatial

    try:
        hull = scipy.spatial.ConvexHull(piece.corners)
    except scipy.spatial.QhullError:
        raise ValueError(f"be bodies: block {piece.name} is flat") from None
    corners = piece.corners[hull.vertices]
    centre = corners.mean(axis=0)
    # Triangles of one face lie in one plane, but for round-off or the tolerance of a drawing.
    beside = np.abs(corners @ hull.equations[:, :3].T + hull.equations[:, 3]) <= 0.1 * flush
    found: dict[frozenset[int], Array] = {}
    for own, normal in zip(beside.T, hull.equations[:, :3], strict=True):
        found.setdefault(frozenset(np.flatnonzero(own).tolist()), normal)
    # What round-off leaves as a part of a larger face is none.
    whole = {key: n for key, n in found.items() if not any(key < other for other in found)}
    faces = tuple(_in_order(corners, sorted(key), normal) for key, normal in whole.items())
    normals = np.array([_normal(corners[list(face)]) for face in faces])
    outside = ((corners[[face[0] for face in faces]] - centre) * normals).sum(axis=1) > 0.0
    assert outside.all()
    return _Body(corners, faces, normals)


def _in_order(corners: Array, face: Sequence[int], normal: Array) -> Face:
    """Corners of a convex face, counterclockwise about its normal."""
    arms = corners[face] - corners[face].mean(axis=0)
    first, second = tangents_of(normal[None])[0]
    return tuple(np.asarray(face)[np.argsort(np.arctan2(arms @ second, arms @ first))].tolist())


def _normal(polygon: Array) -> Array:
    """Unit normal of a polygon, about which its corners turn counterclockwise."""
    arms = polygon - polygon[0]
    normal = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
    return np.asarray(normal / np.linalg.norm(normal))


def _moments(corners: Array, faces: Sequence[Face]) -> tuple[float, Array, Array]:
    """Volume, centre and inertia about it over density: sums over tetrahedra from a corner.

    Of a tetrahedron from the origin over a, b, c the integral of r r' is its volume / 20 times
    (a + b + c)(a + b + c)' + a a' + b b' + c c'.
    """
    here = corners - corners[0]
    triangles = [(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)]
    sides = here[np.array(triangles)]
    parts = np.linalg.det(sides) / 6.0
    volume = float(parts.sum())
    sums = sides.sum(axis=1)
    centre = (parts[:, None] * sums).sum(axis=0) / (4.0 * volume)
    squares = np.einsum("t,tij,tik->jk", parts, sides, sides)
    squares = (squares + np.einsum("t,tj,tk->jk", parts, sums, sums)) / 20.0
    squares = squares - volume * np.outer(centre, centre)
    return volume, corners[0] + centre, np.trace(squares) * np.eye(SPACE) - squares


def _padded(parts: Sequence[Array], most: int | None = None) -> Array:
    """Arrays of several lengths as one; the last row of each is repeated."""
    most = max(map(len, parts)) if most is None else most
    return np.stack([np.concatenate([p, np.repeat(p[-1:], most - len(p), axis=0)]) for p in parts])


class _Surfaces(NamedTuple):
    """Faces of all blocks; of a block with fewer than others the last one is repeated.

    Attributes:
        normals: Outward unit normals, shape [block, face, 3].
        levels: Distance of the face from the origin along it [m], shape [block, face].
        corners: Corners of the faces [m], shape [block, face, corner, 3].
        real: Whether a face is one of the block's own, shape [block, face].
    """

    normals: Array
    levels: Array
    corners: Array
    real: npt.NDArray[np.bool_]


def _surfaces(bodies: Sequence[_Body]) -> _Surfaces:
    most = max(len(face) for each in bodies for face in each.faces)
    polygons = [_padded([each.corners[list(f)] for f in each.faces], most) for each in bodies]
    normals, corners = _padded([each.normals for each in bodies]), _padded(polygons)
    counts = np.array([len(each.faces) for each in bodies])
    # The farthest corner: the plane of a face that is not quite flat has the block on one side.
    levels = (corners * normals[:, :, None]).sum(axis=3).max(axis=2)
    return _Surfaces(normals, levels, corners, np.arange(normals.shape[1]) < counts[:, None])


def _one_moves(pairs: tuple[Places, Places], fixed: npt.NDArray[np.bool_]) -> tuple[Places, Places]:
    """Pairs of blocks of which at least one can move."""
    first, second = pairs
    apart = ~(fixed[first] & fixed[second])
    return first[apart], second[apart]


def _require_large(bodies: Sequence[_Body], names: tuple[str, ...], flush: float) -> None:
    """Refuses blocks so thin that a face is hardly wider than the tolerance."""
    for each, name in zip(bodies, names, strict=True):
        thin = min(np.ptp(each.corners @ normal) for normal in each.normals)
        if thin <= SHORTEST * flush:
            raise ValueError(
                f"be thicker than {1e3 * SHORTEST * flush:g} mm, ten times the tolerance of "
                f"joints: block {name} is {1e3 * thin:.3g} mm thick"
            )


def _parted(corners: Array, surfaces: _Surfaces, a: int, b: int) -> float:
    """Distance of two blocks across the face that parts them most [m]; negative if none does."""
    pair = (np.array([a]), np.array([b]))
    return float(_parting(corners, surfaces, pair)[0])


def _parting(corners: Array, surfaces: _Surfaces, pairs: tuple[Places, Places]) -> Array:
    """Distance of pairs of blocks across the face that parts them most [m], shape [pair]."""
    found = np.full(len(pairs[0]), -np.inf)
    for one, other in (pairs, pairs[::-1]):
        along = np.einsum("pfi,pci->pfc", surfaces.normals[one], corners[other])
        found = np.maximum(found, (along.min(axis=2) - surfaces.levels[one]).max(axis=1))
    return found


def _require_apart(
    corners: Array,
    surfaces: _Surfaces,
    names: tuple[str, ...],
    pairs: tuple[Places, Places],
    flush: float,
) -> None:
    """Refuses blocks that overlap: those that no face parts, unless no ball fits into both."""
    for first, second in _some(pairs):
        parted = _parting(corners, surfaces, (first, second))
        for place in np.flatnonzero(parted < -flush):
            pair = [first[place], second[place]]
            if 2.0 * _largest_ball(surfaces, pair) > flush:
                a, b = (names[each] for each in pair)
                raise ValueError(
                    f"keep blocks apart: {a} and {b} overlap by {-1e3 * parted[place]:.3g} mm"
                )


def _some(pairs: tuple[Places, Places]) -> Iterator[tuple[Places, Places]]:
    for begin in range(0, len(pairs[0]), PAIRS_AT_ONCE):
        part = slice(begin, begin + PAIRS_AT_ONCE)
        yield pairs[0][part], pairs[1][part]


def _largest_ball(surfaces: _Surfaces, pair: Sequence[int]) -> float:
    """Radius of the largest ball that lies in two blocks [m]; negative if they are apart."""
    import scipy.optimize

    normals = surfaces.normals[pair].reshape(-1, SPACE)
    solved = scipy.optimize.linprog(
        [0.0, 0.0, 0.0, -1.0],
        A_ub=np.column_stack([normals, np.ones(len(normals))]),
        b_ub=surfaces.levels[pair].ravel(),
        bounds=[(None, None)] * 4,
        method="highs",
    )
    return -np.inf if solved.x is None else float(solved.x[-1])


def _find_joints(
    bodies: Sequence[_Body], surfaces: _Surfaces, pairs: tuple[Places, Places], flush: float
) -> SpatialJoints:
    """Faces of pairs of blocks that lie in one plane, face each other and overlap."""
    blocks, ends, normals = [], [], []
    for first, second in _some(pairs):
        facing = (
            np.einsum("pfi,pgi->pfg", surfaces.normals[first], surfaces.normals[second]) < FACING
        )
        facing &= surfaces.real[first][:, :, None] & surfaces.real[second][:, None, :]
        for pair, face, other in np.argwhere(facing):
            a, b = int(first[pair]), int(second[pair])
            normal = -surfaces.normals[a, face]
            across = surfaces.corners[b, other] @ -normal - surfaces.levels[a, face]
            if np.abs(across).max() > flush:
                continue
            own = bodies[a].corners[list(bodies[a].faces[face])]
            their = bodies[b].corners[list(bodies[b].faces[other])]
            polygon = _overlap(own, their, normal, flush)
            if polygon is not None:
                blocks.append((a, b))
                ends.append(polygon)
                normals.append(normal)
    count = len(blocks)
    return SpatialJoints(
        blocks=np.array(blocks, dtype=np.intp).reshape(-1, 2),
        ends=_padded(ends) if count else np.empty((0, 3, SPACE)),
        normal=np.array(normals).reshape(-1, SPACE),
        friction=np.zeros(count),
        cohesion=np.zeros(count),
        tension=np.zeros(count),
        corner_count=np.array([len(each) for each in ends], dtype=np.intp),
    )


def _flat(polygon: Array, axes: Array) -> Array:
    """Corners by their places along two axes [m], shape [corner, 2]."""
    return np.asarray(polygon @ axes.T)


def _least_width(polygon: Array) -> float:
    """Least distance between two parallel lines that have a convex polygon between them [m]."""
    along = np.roll(polygon, -1, axis=0) - polygon
    along = along[np.linalg.norm(along, axis=1) > 0.0]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    across /= np.linalg.norm(across, axis=1)[:, None]
    return float(np.ptp(polygon @ across.T, axis=0).min())


def _overlap(own: Array, their: Array, normal: Array, flush: float) -> Array | None:
    """The part of a face that another one covers, in its plane; None if it is no joint.

    The second face is cut by the edges of the first, one after another (Sutherland and Hodgman
    1974, Reentrant polygon clipping, *Communications of the ACM* 17).
    """
    axes, origin = tangents_of(normal[None])[0], own[0]
    # Seen against its outward normal a face is clockwise: turned, it is counterclockwise.
    cutter, found = _flat(own - origin, axes)[::-1], _flat(their - origin, axes)
    for here, there in zip(cutter, np.roll(cutter, -1, axis=0), strict=True):
        along = there - here
        inward = np.array([-along[1], along[0]]) / np.hypot(*along)
        depth = (found - here) @ inward
        if (depth >= 0.0).all():
            continue
        if (depth <= 0.0).all():
            return None
        cut = []
        for k in range(len(found)):
            after = (k + 1) % len(found)
            if depth[k] >= 0.0:
                cut.append(found[k])
            if depth[k] * depth[after] < 0.0:
                part = depth[k] / (depth[k] - depth[after])
                cut.append(found[k] + part * (found[after] - found[k]))
        found = np.array(cut)
    found = straightened(found, flush)
    if len(found) < SPACE or _least_width(found) <= SHORTEST * flush:
        return None
    return np.asarray(origin + found @ axes)


def _require_no_gaps(
    bodies: Sequence[_Body],
    surfaces: _Surfaces,
    names: tuple[str, ...],
    joints: SpatialJoints,
    flush: float,
    fixed: npt.NDArray[np.bool_],
) -> None:
    """Refuses faces that face each other at a distance a little above that at which they touch."""
    wide, corners = DOUBTFUL * flush, _padded([each.corners for each in bodies])
    known = set(map(tuple, joints.blocks.tolist()))
    pairs = _one_moves(near(corners, wide), fixed)
    for a, b in _find_joints(bodies, surfaces, pairs, wide).blocks.tolist():
        if (a, b) not in known:
            gap = _parted(corners, surfaces, a, b)
            raise ValueError(
                f"touch within {1e3 * flush:g} mm or lie more than {1e3 * wide:g} mm apart: faces "
                f"of {names[a]} and {names[b]} face each other over {1e3 * gap:.3g} mm"
            )
