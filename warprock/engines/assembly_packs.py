"""Assemblies as kernels/assembly/assembly_run.py takes them: packs of lanes that touch alike.

The kernel looks up which blocks a joint is between once for all lanes of a pack. So lanes lie side
by side whose joints are between the same blocks; of what size these are does not matter. The last
pack of each sort is filled up with its last lane.
"""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.model.assembly import Assemblies, Assembly

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]
Rows = npt.NDArray[np.void]

WIDEST = ((100, 32), (400, 16), (1200, 8))
"""Lanes of a pack by the joints that it has room for, so that what the sweeps read stays in the
cache of a core."""

LARGE = WIDEST[-1][0]
"""Joints of a lane above which a team of threads runs it by itself (`team_run.py`): some 400 blocks
of a wall. From 150 blocks on both ways cost about the same."""

BEYOND = 1e3
"""Length by which the edges of what is fixed go on to either side, over the size of the assembly:
ground does not end where the blocks on it do."""

PARTS_OF_AN_OCTAVE = 4
"""Sizes for which kernels are compiled, from one number of blocks or joints to its double."""

FLUSH = 1e-6
"""Distance up to which a corner lies on a joint, or a joint on the ground, over the size of the
assembly: round-off of coordinates."""

NONE = -1
"""No edge, as in the kernel."""

PAIRS_PER_BLOCK = 6
"""Room for pairs of blocks that may touch soon, over the number of blocks: of those that touch in
the plane there are fewer than three a block, and a list looks ahead."""

EDGE = ("x", "z", "along_x", "along_z")


def sorts_of(assemblies: Assemblies) -> Places:
    """A number of each lane: the same where joints are between the same blocks, shape [lane]."""
    known: dict[bytes, int] = {}
    of_kinds = [
        known.setdefault(kind.fixed.tobytes() + kind.joints.blocks.tobytes(), len(known))
        for kind in assemblies.kinds
    ]
    return np.asarray(of_kinds, dtype=np.intp)[assemblies.lane]


def pack_up(assemblies: Assemblies, steps: Array, width: int) -> tuple[Places, Places]:
    """Lanes in packs of a width, each of one sort and with one time step.

    Args:
        assemblies: Those of the lanes.
        steps: Their time steps [s], shape [lane].
        width: Lanes of a pack.

    Returns:
        Numbers of the lanes as they lie side by side, some of them several times; where each lane
        lies there, shape [lane].
    """
    _, paces = np.unique(steps, return_inverse=True)
    sorts = sorts_of(assemblies) * (paces.max() + 1) + paces
    order: list[Places] = []
    for each in np.unique(sorts):
        lanes = np.flatnonzero(sorts == each)
        spare = -len(lanes) % width
        order.append(np.concatenate([lanes, np.repeat(lanes[-1:], spare)]))
    side_by_side = np.concatenate(order)
    _, where = np.unique(side_by_side, return_index=True)
    return side_by_side, where


def room_for(count: int) -> int:
    """The least number of a row of sizes that is not below a count, and odd."""
    octave = 1 << max(count - 1, 1).bit_length()
    step = max(octave // 2 // PARTS_OF_AN_OCTAVE, 1)
    return (-(-count // step) * step) | 1


def graph_of(assemblies: Assemblies, width: int, joints: int, blocks: int) -> npt.NDArray[np.int32]:
    """A row a pack: its counts of blocks and joints, the two blocks of each joint, and its tree.

    Where the tree stands says `TREE` of kernels/assembly/assembly_run.py.

    Args:
        assemblies: Those of the lanes.
        width: Lanes of a pack.
        joints: For how many the kernel has room.
        blocks: Likewise.
    """
    first = assemblies.lane[::width]
    rows = np.zeros((len(first), 3 + 3 * joints + 2 * blocks), dtype=np.int32)
    for row, place in zip(rows, first, strict=True):
        kind = assemblies.kinds[place]
        count = kind.joints.count
        row[:2] = kind.count, count
        row[2 : 2 + 2 * count] = kind.joints.blocks.reshape(-1)
        tree = tree_of(kind)
        own = row[2 + 2 * joints :]
        own[0] = len(tree.order)
        own[1 : 1 + 2 * len(tree.order)] = tree.order.reshape(-1)
        own[1 + 2 * blocks : 1 + 2 * blocks + count] = tree.child
    return rows


@dataclasses.dataclass(frozen=True)
class Tree:
    """The tree of an assembly's blocks that can move, with their joints.

    Attributes:
        order: Each block and its parent from the leaves to the roots, whose parent is the number of
            blocks, shape [block, 2]; empty where joints form no tree, or the blocks are few, or so
            many that a team of threads runs the lane.
        child: Of each joint 0 if its child is its first block, 1 if its second, and 2 more where
            the other one is fixed, shape [joint].
    """

    order: Places
    child: Places


LEAST_TREE = 5
"""Blocks that can move from which on a lane leaps (kernels/assembly/tree.py). Sweeps alone solve
fewer in the same time."""


@functools.lru_cache(maxsize=64)
def tree_of(kind: Assembly) -> Tree:
    """The tree of an assembly."""
    between, fixed = kind.joints.blocks, kind.fixed
    child = np.zeros(len(between), dtype=np.intp)
    none = Tree(np.zeros((0, 2), dtype=np.intp), child)
    free = np.flatnonzero(~fixed)
    links = ~fixed[between].any(axis=1)
    around: dict[int, set[int]] = {block: set() for block in free.tolist()}
    for a, b in between[links].tolist():
        around[a].add(b)
        around[b].add(a)
    order, parent = [], {}
    leaves = [block for block in free.tolist() if len(around[block]) <= 1]
    while leaves:
        block = leaves.pop()
        parent[block] = min(around[block], default=kind.count)
        order.append((block, parent[block]))
        for other in around[block]:
            around[other].remove(block)
            if len(around[other]) == 1:
                leaves.append(other)
        around[block] = set()
    unfit = len(free) < LEAST_TREE or kind.joints.count > LARGE
    if unfit or len(order) < len(free):
        return none
    for joint, (a, b) in enumerate(between.tolist()):
        if fixed[a] or fixed[b]:
            child[joint] = 2 + int(fixed[a])
        else:
            child[joint] = parent[b] == a
    return Tree(np.asarray(order, dtype=np.intp), child)


def block_columns(assemblies: Assemblies, room: int) -> dict[str, Array]:
    """Fields of the struct of blocks of the kernel, shape [lane, block] each."""
    return _columns(assemblies, [_blocks(kind, room) for kind in assemblies.kinds])


def joint_columns(assemblies: Assemblies, room: int) -> dict[str, Array]:
    """Fields of the struct of joints of the kernel, shape [lane, joint] each."""
    return _columns(assemblies, [_joints(kind, room) for kind in assemblies.kinds])


def _columns(assemblies: Assemblies, kinds: list[dict[str, Array]]) -> dict[str, Array]:
    return {name: np.stack([kind[name] for kind in kinds])[assemblies.lane] for name in kinds[0]}


def _padded(values: Array, room: int) -> Array:
    return np.concatenate([values, np.zeros(room - len(values))])


def _blocks(kind: Assembly, room: int) -> dict[str, Array]:
    free = ~kind.fixed
    columns = {
        "inverse_mass": free / kind.mass,
        "inverse_inertia": free / (kind.mass * kind.gyration),
        "x": kind.centre[:, 0],
        "z": kind.centre[:, 1],
        "theta": np.zeros(kind.count),
        "reach": reach_of(kind),
        "fall": falls_by(kind),
    }
    return {name: _padded(each, room) for name, each in columns.items()}


def falls_by(kind: Assembly) -> Array:
    """How far the centre of every block sinks until it has fallen [m], shape [block].

    Half of the length of its longest joint: what a block that stood on it lies lower on its side.
    """
    return 0.5 * kind.longest_joints


def _joints(kind: Assembly, room: int) -> dict[str, Array]:
    area = kind.joints.lengths * kind.depth
    columns: dict[str, Array] = {
        "friction": _padded(kind.joints.friction, room),
        "cohesion": _padded(kind.joints.cohesion * area, room),
        "tension": _padded(kind.joints.tension * area, room),
    }
    for side, name in enumerate(("a", "b")):
        edge = _edges(kind, side)
        parts = np.concatenate([edge[:, 0], edge[:, 1] - edge[:, 0]], axis=1)
        for field, values in zip(EDGE, parts.T, strict=True):
            columns[f"{name}_{field}"] = _padded(values, room)
    return columns


@functools.lru_cache(maxsize=64)
def _along(kind: Assembly, side: int) -> Array:
    """Places of the corners of one block of every joint along its tangent, from its middle [m].

    Returns:
        Of the corners of the block's edge there, inf of others, shape [joint, corner].
    """
    here = kind.corners[kind.joints.blocks[:, side]] - kind.joints.ends.mean(axis=1)[:, None]
    across = np.abs((here * kind.joints.normal[:, None]).sum(axis=2))
    along = (here * kind.joints.tangent[:, None]).sum(axis=2)
    # The edge's two corners are the two that are nearest to the line of the joint.
    flush = across <= across.min(axis=1, keepdims=True) + _flush(kind)
    return np.where(flush, along, np.inf)


def _edges(kind: Assembly, side: int) -> Array:
    """The edge of one block of every joint, along the joint's tangent, from the block's centre [m].

    What is fixed goes on beyond the joint along the ground.

    Returns:
        Its two ends, shape [joint, 2, 2].
    """
    block = kind.joints.blocks[:, side]
    tangent, middle = kind.joints.tangent, kind.joints.ends.mean(axis=1)
    along = _along(kind, side)
    low = along.min(axis=1)
    high = np.where(along < np.inf, along, -np.inf).max(axis=1)
    beyond = np.where(kind.fixed[block] & _on_ground(kind), BEYOND * _size(kind), 0.0)
    places = np.stack([low - beyond, high + beyond], axis=1)
    ends = middle[:, None] + places[..., None] * tangent[:, None]
    return np.asarray(ends - kind.centre[block][:, None])


@functools.lru_cache(maxsize=64)
def _on_ground(kind: Assembly) -> npt.NDArray[np.bool_]:
    """Whether a joint lies on the ground, shape [joint]."""
    level = np.abs(kind.joints.ends[..., 1] - kind.ground).max(axis=1)
    return np.asarray(level <= _flush(kind))


def room_for_pairs(assemblies: Assemblies) -> int:
    """Pairs of blocks for which a lane has room."""
    return PAIRS_PER_BLOCK * (assemblies.most_parts + 1)


def around_rows(assemblies: Assemblies, struct: Any) -> Rows:
    """Rows of the struct `Around` of meeting.py, shape [lane]."""
    rows = np.zeros(len(assemblies.kinds), dtype=struct.numpy_dtype())
    for row, kind in zip(rows, assemblies.kinds, strict=True):
        row["scale"] = least_reach(kind)
        row["friction"] = kind.friction
    return np.asarray(rows[assemblies.lane])


def corner_rows(assemblies: Assemblies, struct: Any) -> Rows:
    """Rows of the struct `Corner`, of all blocks of a lane, shape [lane, corner]."""
    most = max(kind.corners.shape[0] * kind.corners.shape[1] for kind in assemblies.kinds)
    rows = np.zeros((len(assemblies.kinds), most), dtype=struct.numpy_dtype())
    for row, kind in zip(rows, assemblies.kinds, strict=True):
        own = _distinct(kind)
        block, place = np.nonzero(own)
        counts = own.sum(axis=1)
        last = np.cumsum(counts) - 1
        following = np.append(place[1:], 0)
        following[last] = place[last - counts + 1]
        start = kind.corners[block, place]
        along = kind.corners[block, following] - start
        length = np.hypot(along[:, 0], along[:, 1])
        count = len(block)
        row["x"][:count], row["z"][:count] = (start - kind.centre[block]).T
        row["nx"][:count], row["nz"][:count] = along[:, 1] / length, -along[:, 0] / length
        row["length"][:count] = length
    return np.asarray(rows[assemblies.lane])


@functools.lru_cache(maxsize=64)
def _distinct(kind: Assembly) -> npt.NDArray[np.bool_]:
    """Which corners are no repetition of the one before, shape [block, corner]."""
    before = np.concatenate([kind.corners[:, -1:], kind.corners[:, :-1]], axis=1)
    return np.asarray((kind.corners != before).any(axis=2))


def side_rows(assemblies: Assemblies, struct: Any, room: int) -> Rows:
    """Rows of the struct `Sides`, shape [lane, joint]."""
    rows = np.zeros((len(assemblies.kinds), room), dtype=struct.numpy_dtype())
    for row, kind in zip(rows, assemblies.kinds, strict=True):
        for side, name in enumerate(("a", "b")):
            row[name][: kind.joints.count] = _edge_starts(kind, side)
    return np.asarray(rows[assemblies.lane])


@functools.lru_cache(maxsize=64)
def _edge_starts(kind: Assembly, side: int) -> Places:
    """The corner at which the edge of a joint begins, among those that differ, shape [joint]."""
    along, block = _along(kind, side), kind.joints.blocks[:, side]
    # Counterclockwise, the edge of the first block, which lies to the left of the joint's tangent,
    # runs along it, that of the second one against it.
    sign = 1.0 if side == 0 else -1.0
    own = _distinct(kind)[block]
    start = np.where(own & (along < np.inf), sign * along, np.inf).argmin(axis=1)
    number = np.cumsum(own, axis=1) - 1
    return np.asarray(np.take_along_axis(number, start[:, None], axis=1)[:, 0])


def body_rows(assemblies: Assemblies, struct: Any) -> Rows:
    """Rows of the struct `Body`, the ground behind the blocks of a lane, shape [lane, block]."""
    rows = np.zeros((len(assemblies.kinds), assemblies.most_parts + 1), struct.numpy_dtype())
    for row, kind in zip(rows, assemblies.kinds, strict=True):
        count, own = kind.count, _distinct(kind).sum(axis=1)
        row["stands"] = NONE
        grounded = _on_ground(kind)
        for side in (0, 1):
            stands = grounded & kind.fixed[kind.joints.blocks[:, 1 - side]]
            places = kind.joints.blocks[stands, side]
            row["stands"][places] = _edge_starts(kind, side)[stands]
        row["first"][:count] = np.cumsum(own) - own
        below = kind.fixed & (kind.corners[..., 1].max(axis=1) <= kind.ground + _flush(kind))
        row["count"][:count] = np.where(below, 0, own)
        row["reach"][:count] = reach_of(kind)
        row["mass"]["m"][:count] = ~kind.fixed / kind.mass
        row["mass"]["j"][:count] = ~kind.fixed / (kind.mass * kind.gyration)
        row["pose"]["z"][count] = kind.ground
        row["pose"]["c"] = 1.0
    return np.asarray(rows[assemblies.lane])


def least_reach(kind: Assembly) -> float:
    """Half diagonal of the smallest block that can move [m]: of its farthest corner."""
    return float(reach_of(kind)[~kind.fixed].min())


@functools.lru_cache(maxsize=64)
def reach_of(kind: Assembly) -> Array:
    """Distance of the farthest corner of a block from its centre [m], shape [block]."""
    offset = kind.corners - kind.centre[:, None]
    return np.asarray(np.sqrt((offset * offset).sum(axis=-1).max(axis=1)))


def _flush(kind: Assembly) -> float:
    """Distance up to which a corner lies on a joint, or a joint on the ground [m]."""
    return max(FLUSH * _size(kind), kind.flush)


@functools.lru_cache(maxsize=64)
def _size(kind: Assembly) -> float:
    return float(np.ptp(kind.corners.reshape(-1, 2), axis=0).max())


@dataclasses.dataclass(frozen=True)
class JointsMoved:
    """What joints did in a run, lane by lane; a joint that a lane has not is all zeros.

    Attributes:
        opening: Widest gap of either end [m], shape [lane, joint, end].
        slide: Largest |slide| [m], shape [lane, joint].
        last: Slide at the end of the run [m], likewise.
        length: Of the joints [m], likewise.
    """

    opening: Array
    slide: Array
    last: Array
    length: Array

    @property
    def opened(self) -> npt.NDArray[np.bool_]:
        """Whether a joint opened by more than `NOTABLE` of its length, shape [lane, joint]."""
        return np.asarray(self.opening.max(axis=2) > NOTABLE * self.length) & (self.length > 0.0)

    @property
    def slid(self) -> npt.NDArray[np.bool_]:
        """Whether it slid by more than that, likewise."""
        return np.asarray(self.slide > NOTABLE * self.length) & (self.length > 0.0)


NOTABLE = 1e-3
"""Gap or slide from which a joint counts as opened or slid, over its length: an angle of a
milliradian, far above what steps leave of a joint that holds."""


def joints_moved(assemblies: Assemblies, contacts: npt.NDArray[np.void]) -> JointsMoved:
    """What joints did, from rows of `ContactResult`, shape [lane, contact]."""
    count = contacts.shape[1] // 2
    length = np.stack([_padded(kind.joints.lengths, count) for kind in assemblies.kinds])

    def of(name: str) -> Array:
        return contacts[name].astype(np.float64).reshape(len(contacts), count, 2)

    slides = of("most")
    last = of("slide")
    # A contact that opens stops sliding; the other end tells more.
    further = slides.argmax(axis=2)[..., None]
    return JointsMoved(
        opening=of("opening"),
        slide=slides.max(axis=2),
        last=np.take_along_axis(last, further, axis=2)[..., 0],
        length=length[assemblies.lane],
    )
