"""Assemblies as kernels/assembly/assembly_run.py takes them: packs of lanes that touch alike.

The kernel looks up which blocks a joint is between once for all lanes of a pack. So lanes lie side
by side whose joints are between the same blocks; of what size these are does not matter. The last
pack of each sort is filled up with its last lane.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import numpy.typing as npt

from warprock.model.assembly import Assemblies, Assembly

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

BEYOND = 1e3
"""Length by which the edges of what is fixed go on to either side, over the size of the assembly:
ground does not end where the blocks on it do."""

PARTS_OF_AN_OCTAVE = 4
"""Sizes for which kernels are compiled, from one number of blocks or joints to its double."""

EDGE = ("x", "z", "along_x", "along_z")


def sorts_of(assemblies: Assemblies) -> Places:
    """A number of each lane: the same where joints are between the same blocks, shape [lane]."""
    known: dict[bytes, int] = {}
    of_kinds = [
        known.setdefault(np.int64(kind.count).tobytes() + kind.joints.blocks.tobytes(), len(known))
        for kind in assemblies.kinds
    ]
    return np.asarray(of_kinds, dtype=np.intp)[assemblies.lane]


def pack_up(assemblies: Assemblies, width: int) -> tuple[Places, Places]:
    """Lanes in packs of a width, each of one sort.

    Returns:
        Numbers of the lanes as they lie side by side, some of them several times; where each lane
        lies there, shape [lane].
    """
    sorts = sorts_of(assemblies)
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


def graph_of(assemblies: Assemblies, width: int, joints: int) -> npt.NDArray[np.int32]:
    """A row a pack: its counts of blocks and joints, then the two blocks of each joint."""
    first = assemblies.lane[::width]
    rows = np.zeros((len(first), 2 + 2 * joints), dtype=np.int32)
    for row, place in zip(rows, first, strict=True):
        kind = assemblies.kinds[place]
        row[:2] = kind.count, kind.joints.count
        row[2 : 2 + 2 * kind.joints.count] = kind.joints.blocks.reshape(-1)
    return rows


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
    offset = kind.corners - kind.centre[:, None]
    columns = {
        "inverse_mass": free / kind.mass,
        "inverse_inertia": free / (kind.mass * kind.gyration),
        "x": kind.centre[:, 0],
        "z": kind.centre[:, 1],
        "reach": np.hypot(offset[..., 0], offset[..., 1]).max(axis=1),
        "fall": falls_by(kind),
    }
    return {name: _padded(each, room) for name, each in columns.items()}


def falls_by(kind: Assembly) -> Array:
    """How far the centre of every block sinks until it has fallen [m], shape [block].

    Half of the length of its longest joint: what a block that stood on it lies lower on its side.
    """
    return 0.5 * kind.longest_joints


def _joints(kind: Assembly, room: int) -> dict[str, Array]:
    columns: dict[str, Array] = {"friction": _padded(kind.joints.friction, room)}
    for side, name in enumerate(("a", "b")):
        edge = _edges(kind, side)
        parts = np.concatenate([edge[:, 0], edge[:, 1] - edge[:, 0]], axis=1)
        for field, values in zip(EDGE, parts.T, strict=True):
            columns[f"{name}_{field}"] = _padded(values, room)
    return columns


def _edges(kind: Assembly, side: int) -> Array:
    """The edge of one block of every joint, along the joint's tangent, from the block's centre [m].

    Of what is fixed it goes on beyond the joint.

    Returns:
        Its two ends, shape [joint, 2, 2].
    """
    block = kind.joints.blocks[:, side]
    tangent, middle = kind.joints.tangent, kind.joints.ends.mean(axis=1)
    corners = kind.corners[block]
    here = corners - middle[:, None]
    across = np.abs((here * kind.joints.normal[:, None]).sum(axis=2))
    # The edge's two corners are the two that are nearest to the line of the joint.
    along = (here * tangent[:, None]).sum(axis=2)
    flush = across <= across.min(axis=1, keepdims=True) + max(1e-6 * _size(kind), kind.flush)
    low = np.where(flush, along, np.inf).min(axis=1)
    high = np.where(flush, along, -np.inf).max(axis=1)
    beyond = np.where(kind.fixed[block], BEYOND * _size(kind), 0.0)
    places = np.stack([low - beyond, high + beyond], axis=1)
    ends = middle[:, None] + places[..., None] * tangent[:, None]
    return np.asarray(ends - kind.centre[block][:, None])


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
