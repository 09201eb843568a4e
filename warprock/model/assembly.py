"""Assemblies: blocks with dry joints, in the plane, and which of them touch where.

A joint is an edge that two blocks share: two contact points, its ends. Joints are found from the
polygons alone, so that a block that touches two others below it has a joint with each of them.
Edges of drawn blocks meet within a tolerance; then both are taken to lie on the line of the joint.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

SPACE = 3
"""Coordinates of a corner in space."""

FLUSH = 1e-7
"""Distance up to which edges touch, over the size of the assembly: far above round-off of
coordinates, far below any gap that is meant."""

SHORTEST = 10.0
"""Shortest joint over that distance."""

DOUBTFUL = 10.0
"""Gap between edges that face each other, over the tolerance of a drawing, below which it leaves
open whether they were meant to touch."""

STRAIGHT = 0.1
"""How far a corner of a drawing may be from the line of its neighbours, over that tolerance, and be
none."""


class Piece(NamedTuple):
    """A block before its joints are known.

    Attributes:
        name: What the block is called.
        corners: Corners of a convex polygon [m], shape [corner, 2]; in space of a convex body,
            shape [corner, 3].
        fixed: Whether it moves with the base.
    """

    name: str
    corners: Array
    fixed: bool = False


@dataclasses.dataclass(frozen=True, eq=False)
class Joints:
    """Edges that blocks share.

    Attributes:
        blocks: The two blocks of every joint, shape [joint, 2].
        ends: Its ends [m], shape [joint, end, 2].
        normal: Unit normal from the second block into the first, shape [joint, 2].
        friction: Coulomb friction coefficient, shape [joint].
        cohesion: Shear strength without load, until it breaks [Pa], shape [joint].
        tension: Tensile strength, until it breaks [Pa], shape [joint]; zero of a dry joint.
    """

    blocks: Places
    ends: Array
    normal: Array
    friction: Array
    cohesion: Array
    tension: Array

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.blocks)

    @property
    def lengths(self) -> Array:
        """Their lengths [m], shape [joint]."""
        return np.asarray(np.linalg.norm(self.ends[:, 1] - self.ends[:, 0], axis=1))

    @property
    def tangent(self) -> Array:
        """Unit vector along every joint, shape [joint, 2]: its normal turned by -90 degrees."""
        return np.stack([self.normal[:, 1], -self.normal[:, 0]], axis=1)

    @property
    def tangents(self) -> Array:
        """Unit vectors along which it may slide, shape [joint, 1, 2]."""
        return self.tangent[:, None]

    @property
    def end_count(self) -> Places:
        """Ends of every joint, shape [joint]."""
        return np.full(self.count, 2)


@dataclasses.dataclass(frozen=True, eq=False)
class Assembly:
    """Blocks with dry joints, at rest in the plane; those in space are a kind of it.

    Attributes:
        corners: Corners counterclockwise [m], shape [block, corner, 2]; of a block with fewer
            corners than others the last one is repeated.
        names: What the blocks are called.
        fixed: Whether a block moves with the base, shape [block].
        depth: Across the plane [m].
        density: [kg/m^3].
        joints: Where they touch.
        flush: Distance up to which edges touch [m].
        friction: Coefficient where blocks meet that no joint connects.
    """

    corners: Array
    names: tuple[str, ...]
    fixed: npt.NDArray[np.bool_]
    depth: float
    density: float
    joints: Joints
    flush: float
    friction: float

    @property
    def count(self) -> int:
        """How many blocks there are, fixed ones included."""
        return len(self.names)

    @functools.cached_property
    def area(self) -> Array:
        """Area of the blocks [m^2], shape [block]."""
        return _areas(self.corners)

    @functools.cached_property
    def centre(self) -> Array:
        """Centres of mass [m], shape [block, 2]."""
        # About a corner of its own, so that a block far from the origin loses no digits.
        first = self.corners[:, :1]
        here = self.corners - first
        after = np.roll(here, -1, axis=1)
        parts = (here + after) * _cross(here, after)[..., None]
        return np.asarray(first[:, 0] + parts.sum(axis=1) / (6.0 * self.area[:, None]))

    @functools.cached_property
    def gyration(self) -> Array:
        """Squares of the radii of gyration about the centres of mass [m^2], shape [block]."""
        here = self.corners - self.centre[:, None]
        after = np.roll(here, -1, axis=1)
        squares = (here * here + here * after + after * after).sum(axis=2)
        return np.asarray((squares * _cross(here, after)).sum(axis=1) / (12.0 * self.area))

    @property
    def mass(self) -> Array:
        """Mass of the blocks [kg], shape [block]."""
        return np.asarray(self.area * self.depth * self.density)

    @functools.cached_property
    def ground(self) -> float:
        """Level of the ground [m].

        That of the lowest blocks that can move, if they stand level on something fixed there; else
        that of the lowest corner of all: abutments stand on the ground.
        """
        level, every = float(self.corners[~self.fixed][..., -1].min()), self.corners[..., -1]
        held = self.fixed[self.joints.blocks].any(axis=1)
        flat = np.abs(self.joints.ends[..., -1] - level).max(axis=1) <= self.flush
        return level if (held & flat).any() else float(every.min())

    @property
    def size(self) -> Array:
        """Width and height of the blocks that can move, together [m]; in space x, y and z."""
        dimension = self.corners.shape[-1]
        return np.asarray(np.ptp(self.corners[~self.fixed].reshape(-1, dimension), axis=0))

    @property
    def spatial(self) -> bool:
        """Whether its blocks move in space."""
        return bool(self.corners.shape[-1] == SPACE)

    @functools.cached_property
    def longest_joints(self) -> Array:
        """Length of the longest joint of every block [m], shape [block]; 0 where it has none."""
        found = np.zeros(self.count)
        for side in (0, 1):
            np.maximum.at(found, self.joints.blocks[:, side], self.joints.lengths)
        return found

    @functools.cached_property
    def slenderness_angle(self) -> float:
        """What measures rotations of its blocks: about the one at which it collapses [rad].

        The angle whose tangent is the length of its joints over its height: of each block the
        longest joint, of the blocks the median; and the largest distance of a corner from the
        nearest joint with what is fixed. So it is that of a single block, but for the difference
        between its height and its diagonal, of a column as a whole, and of an arch its thickness
        over the distance from springing to crown.
        """
        return float(np.arctan2(np.median(self.longest_joints[~self.fixed]), self.reach))

    @functools.cached_property
    def reach(self) -> float:
        """The largest distance of a corner from the nearest joint with what is fixed [m]."""
        feet = self.joints.ends[self.fixed[self.joints.blocks].any(axis=1)].mean(axis=1)
        corners = self.corners[~self.fixed].reshape(-1, 1, 2)
        return float(np.linalg.norm(corners - feet, axis=2).min(axis=1).max())


@dataclasses.dataclass(frozen=True, eq=False)
class Assemblies:
    """The assemblies of lanes.

    Attributes:
        kinds: Those that differ.
        lane: The place of every lane's among them, shape [lane].
        room: Blocks that can move, blocks and joints that there is room for: the most of those that
            these were taken from; None where these are all.
    """

    kinds: tuple[Assembly, ...]
    lane: Places
    room: tuple[int, int, int] | None = None

    def of(self, lane: int) -> Assembly:
        """The assembly of a lane."""
        return self.kinds[int(self.lane[lane])]

    def take(self, lanes: slice | Places) -> Assemblies:
        """The assemblies of some lanes, by slice or by number."""
        used, place = np.unique(self.lane[lanes], return_inverse=True)
        kinds = tuple(self.kinds[kind] for kind in used)
        return Assemblies(kinds, place.reshape(-1), self._most)

    @property
    def slenderness_angle(self) -> Array:
        """Of every lane's, shape [lane]; see `Assembly`."""
        return np.array([kind.slenderness_angle for kind in self.kinds])[self.lane]

    @property
    def reach(self) -> Array:
        """Of every lane's [m], shape [lane]; see `Assembly`."""
        return np.array([kind.reach for kind in self.kinds])[self.lane]

    @property
    def _most(self) -> tuple[int, int, int]:
        if self.room is not None:
            return self.room
        return (
            max(int((~kind.fixed).sum()) for kind in self.kinds),
            max(kind.count for kind in self.kinds),
            max(kind.joints.count for kind in self.kinds),
        )

    @property
    def spatial(self) -> bool:
        """Whether the blocks move in space; then all kinds are of `model.solids`."""
        return self.kinds[0].spatial

    @property
    def bonded(self) -> bool:
        """Whether any joint has a tensile strength."""
        return any(bool(kind.joints.tension.any()) for kind in self.kinds)

    @property
    def most_blocks(self) -> int:
        """Most blocks that can move."""
        return self._most[0]

    @property
    def most_parts(self) -> int:
        """Most blocks, fixed ones included."""
        return self._most[1]

    @property
    def most_ends(self) -> int:
        """Most ends of joints."""
        return max(int(kind.joints.end_count.sum()) for kind in self.kinds)

    @property
    def most_joints(self) -> int:
        """Most joints."""
        return self._most[2]


def assemble(
    pieces: Sequence[Piece],
    *,
    depth: float,
    density: float,
    friction: float,
    head_friction: float | None = None,
    cohesion: float = 0.0,
    tension: float = 0.0,
    tolerance: float | None = None,
) -> Assembly:
    """Blocks with the joints that their edges make.

    Args:
        pieces: The blocks.
        depth: Across the plane [m].
        density: [kg/m^3].
        friction: Coefficient of every joint, and of blocks that meet elsewhere.
        head_friction: That of head joints, which are nearer to upright than to level; None where
            it is the same.
        cohesion: Shear strength of every joint without load, until it breaks [Pa].
        tension: Tensile strength of every joint, likewise; zero of dry joints.
        tolerance: Distance up to which edges of drawn blocks touch [m]; None where coordinates are
            exact.

    Raises:
        ValueError: A block is not convex, two blocks overlap, a drawing leaves open whether they
            touch, or a block rests on nothing that is fixed. The message ends a sentence "must
            ...".
    """
    polygons = [piece.corners for piece in pieces]
    if tolerance is not None:
        polygons = [straightened(each, STRAIGHT * tolerance) for each in polygons]
    corners = _padded(polygons)
    names = tuple(piece.name for piece in pieces)
    fixed = np.array([piece.fixed for piece in pieces])
    exact = FLUSH * float(np.ptp(corners.reshape(-1, 2), axis=0).max())
    flush = exact if tolerance is None else max(tolerance, exact)
    if tolerance is not None:
        _require_large(corners, names, flush)
    _require_convex(corners, names, flush)
    first, second = near(corners, flush)
    _require_apart(corners, names, (first, second), flush)
    apart = ~(fixed[first] & fixed[second])
    joints = _find_joints(corners, (first[apart], second[apart]), flush)
    if tolerance is not None:
        _require_no_gaps(corners, names, fixed, joints, flush)
    upright = np.abs(joints.normal[:, 0]) > np.abs(joints.normal[:, 1])
    own = friction if head_friction is None else head_friction
    joints = dataclasses.replace(
        joints,
        friction=np.where(upright, own, friction),
        cohesion=np.full(joints.count, cohesion),
        tension=np.full(joints.count, tension),
    )
    require_held(joints, names, fixed, lambda a, b: _gap(corners[a], corners[b]))
    if tension == 0.0:
        require_lifted(joints, names, fixed)
    return Assembly(corners, names, fixed, depth, density, joints, flush, friction)


def straightened(corners: Array, least: float) -> Array:
    """A polygon without corners that repeat others or lie on the line of their neighbours.

    Args:
        corners: Corners [m], shape [corner, 2].
        least: Distance from that line up to which they do [m].
    """
    found = np.asarray(corners, dtype=np.float64)
    while len(found) > 3:
        before, after = np.roll(found, 1, axis=0), np.roll(found, -1, axis=0)
        along = after - before
        length = np.linalg.norm(along, axis=1)
        beside = np.abs(_cross(along, found - before)) / np.where(length > 0.0, length, 1.0)
        near = np.minimum(
            np.linalg.norm(found - before, axis=1), np.linalg.norm(found - after, axis=1)
        )
        away = np.minimum(near, np.where(length > least, beside, 0.0))
        place = int(np.argmin(away))
        if away[place] > least:
            return found
        found = np.delete(found, place, axis=0)
    return found


def _padded(polygons: Sequence[Array]) -> Array:
    """Corners of all polygons, counterclockwise, shape [block, corner, 2]."""
    most = max(map(len, polygons))
    found = np.empty((len(polygons), most, 2))
    for place, polygon in enumerate(polygons):
        found[place, : len(polygon)] = polygon
        found[place, len(polygon) :] = polygon[-1]
    clockwise = _areas(found) < 0.0
    found[clockwise] = found[clockwise, ::-1]
    return found


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _areas(corners: Array) -> Array:
    here = corners - corners[:, :1]
    return np.asarray(0.5 * _cross(here, np.roll(here, -1, axis=1)).sum(axis=1))


def _edges(corners: Array) -> tuple[Array, Array]:
    """Unit vectors along the edges, shape [block, corner, 2], and lengths; of none 0."""
    along = np.roll(corners, -1, axis=1) - corners
    length = np.linalg.norm(along, axis=2)
    return along / np.where(length > 0.0, length, 1.0)[..., None], length


def _require_convex(corners: Array, names: tuple[str, ...], flush: float) -> None:
    unit, length = _edges(corners)
    beside = corners[:, None, :, :] - corners[:, :, None, :]
    right = (_cross(unit[:, :, None, :], beside) < -flush) & (length > 0.0)[..., None]
    for place in np.flatnonzero(right.any(axis=(1, 2))):
        raise ValueError(f"be convex: block {names[place]} is not")


def _require_large(corners: Array, names: tuple[str, ...], flush: float) -> None:
    """Refuses blocks so small that none of their edges could be a joint."""
    longest = _edges(corners)[1].max(axis=1)
    for place in np.flatnonzero(longest <= SHORTEST * flush):
        raise ValueError(
            f"have edges longer than {1e3 * SHORTEST * flush:g} mm, ten times the tolerance of "
            f"joints: those of block {names[place]} are at most {1e3 * longest[place]:.3g} mm long"
        )


def near(corners: Array, flush: float) -> tuple[Places, Places]:
    """Pairs of blocks whose boxes touch; the first of a pair comes before the second.

    Args:
        corners: Corners of the blocks [m], shape [block, corner, 2] or [block, corner, 3].
        flush: Distance up to which boxes touch [m].
    """
    low, high = corners.min(axis=1) - flush, corners.max(axis=1) + flush
    # Along the axis on which fewer boxes lie over one another.
    axis = int(np.argmax(np.ptp(low, axis=0) / (high - low).mean(axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    ends = np.searchsorted(low[order, axis], high[order, axis], side="right")
    count = ends - np.arange(1, len(order) + 1)
    here = np.repeat(np.arange(len(order)), count)
    there = np.arange(len(here)) - np.repeat(np.cumsum(count) - count, count) + here + 1
    a, b = order[here], order[there]
    level = ((low[a] <= high[b]) & (low[b] <= high[a])).all(axis=1)
    first, second = np.minimum(a, b)[level], np.maximum(a, b)[level]
    sort = np.lexsort((second, first))
    return first[sort], second[sort]


def _require_apart(
    corners: Array, names: tuple[str, ...], pairs: tuple[Places, Places], flush: float
) -> None:
    """Refuses blocks that overlap: convex polygons do where no edge of either parts them."""
    unit, length = _edges(corners)
    parted = np.full(len(pairs[0]), -np.inf)
    for one, other in (pairs, pairs[::-1]):
        beyond = corners[other][:, None, :, :] - corners[one][:, :, None, :]
        # The interior lies to the left of an edge.
        outside = (-_cross(unit[one][:, :, None, :], beyond)).min(axis=2)
        outside[length[one] == 0.0] = -np.inf
        parted = np.maximum(parted, outside.max(axis=1))
    for place in np.flatnonzero(parted < -flush):
        a, b = (names[pair[place]] for pair in pairs)
        raise ValueError(f"keep blocks apart: {a} and {b} overlap by {-1e3 * parted[place]:.3g} mm")


def _find_joints(corners: Array, pairs: tuple[Places, Places], flush: float) -> Joints:
    """Edges of pairs of blocks that lie on one line, face each other and overlap."""
    first, second = pairs
    unit, length = _edges(corners)
    along, start = unit[first][:, :, None, :], corners[first][:, :, None, :]
    near = corners[second][:, None, :, :] - start
    far = np.roll(corners, -1, axis=1)[second][:, None, :, :] - start
    on_line = (np.abs(_cross(along, near)) <= flush) & (np.abs(_cross(along, far)) <= flush)
    ends = np.stack([(along * near).sum(axis=-1), (along * far).sum(axis=-1)], axis=-1)
    low = np.maximum(ends.min(axis=-1), 0.0)
    high = np.minimum(ends.max(axis=-1), length[first][:, :, None])
    facing = ends[..., 1] < ends[..., 0]
    pair, edge, other = np.nonzero(on_line & facing & (high - low > SHORTEST * flush))
    direction, origin = unit[first[pair], edge], corners[first[pair], edge]
    places = np.stack([low[pair, edge, other], high[pair, edge, other]], axis=1)
    return Joints(
        blocks=np.stack([first[pair], second[pair]], axis=1),
        ends=origin[:, None, :] + places[..., None] * direction[:, None, :],
        normal=np.stack([-direction[:, 1], direction[:, 0]], axis=1),
        friction=np.zeros(len(pair)),
        cohesion=np.zeros(len(pair)),
        tension=np.zeros(len(pair)),
    )


def _require_no_gaps(
    corners: Array,
    names: tuple[str, ...],
    fixed: npt.NDArray[np.bool_],
    joints: Joints,
    flush: float,
) -> None:
    """Refuses edges that face each other at a distance a little above that at which they touch."""
    wide = DOUBTFUL * flush
    first, second = near(corners, wide)
    apart = ~(fixed[first] & fixed[second])
    known = set(map(tuple, joints.blocks.tolist()))
    for pair in _find_joints(corners, (first[apart], second[apart]), wide).blocks.tolist():
        if tuple(pair) not in known:
            a, b = pair
            gap = _gap(corners[a], corners[b])
            raise ValueError(
                f"touch within {1e3 * flush:g} mm or lie more than {1e3 * wide:g} mm apart: edges "
                f"of {names[a]} and {names[b]} face each other over {1e3 * gap:.3g} mm"
            )


def _gap(a: Array, b: Array) -> float:
    """Least distance between the corners of two convex polygons and the edges of the other [m]."""
    found = np.inf
    for corners, other in ((a, b), (b, a)):
        along = np.roll(other, -1, axis=0) - other
        square = np.maximum((along * along).sum(axis=1), np.finfo(np.float64).tiny)
        beyond = corners[:, None] - other
        part = np.clip((beyond * along).sum(axis=2) / square, 0.0, 1.0)
        found = min(found, np.linalg.norm(beyond - part[..., None] * along, axis=2).min())
    return float(found)


def require_held(
    joints: Joints,
    names: tuple[str, ...],
    fixed: npt.NDArray[np.bool_],
    gap_between: Callable[[int, int], float],
) -> None:
    """Refuses a block that no joints connect with a fixed one.

    Args:
        joints: The joints.
        names: What the blocks are called.
        fixed: Whether a block moves with the base, shape [block].
        gap_between: The distance between two blocks [m].
    """
    if not fixed.any():
        raise ValueError("have a block that is fixed: all of them would fall")
    held, before = fixed.copy(), np.zeros_like(fixed)
    first, second = joints.blocks.T
    while (held != before).any():
        before = held.copy()
        held[first[before[second]]] = True
        held[second[before[first]]] = True
    for place in np.flatnonzero(~held):
        one = int(place)
        gap, other = min((gap_between(one, k), k) for k in np.flatnonzero(held).tolist())
        raise ValueError(
            f"rest on something fixed: block {names[place]} touches nothing that does; the nearest "
            f"is {names[other]}, {1e3 * gap:.3g} mm away"
        )


def require_lifted(joints: Joints, names: tuple[str, ...], fixed: npt.NDArray[np.bool_]) -> None:
    """Refuses a block that no dry joint can push upwards."""
    lifted = fixed.copy()
    for side, sign in ((0, 1.0), (1, -1.0)):
        level = np.linalg.norm(joints.normal[:, :-1], axis=1)
        upright = sign * joints.normal[:, -1]
        lifted[joints.blocks[upright + joints.friction * level > 0.0, side]] = True
    for place in np.flatnonzero(~lifted):
        raise ValueError(f"rest on something: block {names[place]} hangs below all that touches it")
