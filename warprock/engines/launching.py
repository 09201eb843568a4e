"""Where and how kernels run, and the launch that every engine shares.

A kernel runs `LANES` lanes a thread: a pack side by side on the CPU, one on any other device. Every
array is made on the device by name, since Warp's default device is the same for all threads. Its
arrays of blocks are [block, lane], lowest block first, so that lanes lie side by side; a single
block is a stack of one. What a kernel takes besides its blocks it names in its signature.
"""

from __future__ import annotations

import dataclasses
import enum
import threading
from collections.abc import Mapping
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.errors import InputError
from warprock.kernels.launch.instance import BYTES, LANE_WIDTH
from warprock.kernels.motion.pool import ACCELERATION, AHEAD
from warprock.model.motion import GroundMotions, RecordMotions, SpatialMotions
from warprock.model.response import SampleTimes

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[Any]
Columns = Mapping[str, npt.NDArray[Any]]
"""Fields of a struct by name."""

NEVER = 1.0e30
"""What kernels give as the time of an event that did not occur."""


class Form(enum.StrEnum):
    """Form of the kernel: many lanes a thread side by side, or one."""

    PACKED = "packed"
    PLAIN = "plain"


@dataclasses.dataclass(frozen=True)
class Team:
    """Threads that may work on one lane, where its kernel is made for several.

    Attributes:
        threads: How many.
        stopped: Set once nobody waits for the lane any more.
    """

    threads: int = 1
    stopped: threading.Event = dataclasses.field(default_factory=threading.Event, compare=False)


@dataclasses.dataclass(frozen=True)
class Target:
    """Where and how a kernel runs.

    Attributes:
        precision: "float64" or "float32".
        device: Name of a Warp device, such as "cpu" or "cuda:0".
        form: Form of the kernel; packed needs the CPU.
        team: Threads for one lane of a large assembly.
    """

    precision: str = "float64"
    device: str = "cpu"
    form: Form | None = None
    team: Team = dataclasses.field(default_factory=Team)

    def __post_init__(self) -> None:
        if self.precision not in BYTES:
            allowed = f"must be one of {', '.join(BYTES)}"
            raise InputError("precision", "", self.precision, allowed)
        if self.form is not None:
            # Its value as a string would do in a comparison and not in the next.
            object.__setattr__(self, "form", Form(self.form))
        if self.form is Form.PACKED and not self.on_cpu:
            raise InputError("device", "", self.device, "must be the CPU for the packed form")

    @property
    def on_cpu(self) -> bool:
        """Whether the device is the CPU."""
        return self.device.startswith("cpu")

    @property
    def kernel_form(self) -> Form:
        """The form asked for, else the fast one for the device."""
        return self.form or (Form.PACKED if self.on_cpu else Form.PLAIN)

    @property
    def lanes(self) -> int:
        """Lanes that a thread runs side by side, in kernels that have both forms."""
        return LANE_WIDTH if self.kernel_form is Form.PACKED else 1


@dataclasses.dataclass(frozen=True)
class Kernel:
    """The kernel that an engine runs a scene with, and the constants it is compiled with.

    Attributes:
        scheme: Package of kernels of its scheme.
        name: Stem of its file there.
        lanes: Lanes that a thread runs side by side.
        iterations: Sweeps of its solver, or points of its springs, where they are a constant.
        friction: Law of friction where a block slides in two directions: cone or box.
        points: Contact points of a body, where they are a constant.
        thrown: Whether blocks in space start in motion, or bounce.
        bounces: Whether what strikes its base in `event` leaves it with a part of its speed.
        springs: Whether the contacts of an assembly are springs.
        bonds: Whether joints of an assembly have cohesion and tensile strength until they break.
        trees: Whether joints of some assemblies form trees.
    """

    scheme: ModuleType
    name: str
    lanes: int = 1
    iterations: int = 0
    friction: str = "cone"
    points: int = 0
    thrown: bool = False
    bounces: bool = False
    springs: bool = False
    bonds: bool = False
    trees: bool = False

    @property
    def file(self) -> str:
        """Path of its file in the folder of kernels, without its ending."""
        folder = self.scheme.__name__.removeprefix("warprock.kernels.").replace(".", "/")
        return f"{folder}/{self.name}"

    @property
    def packed(self) -> bool:
        """Whether a thread runs a pack of lanes side by side."""
        return self.lanes > 1


OF_LANES = ("starts", "rates")
"""Arguments that are arrays of numbers, one a lane."""


@dataclasses.dataclass(frozen=True)
class Found:
    """What a kernel has left of a batch of lanes.

    Attributes:
        lanes: Rows of its struct `Result`, shape [lane].
        blocks: Rows of its struct `BlockResult`, shape [lane, block].
        history: At the samples, if asked for: in the plane rotations [rad], shape
            [lane, block, sample]; in space attitudes (quaternions), [lane, block, sample, 4].
        places: Centres of mass at the samples from the origin of the base [m], if asked for: x and
            z, shape [lane, block, sample, 2]; in space x, y and z, [lane, block, sample, 3]. None,
            too, of a kernel whose blocks do not slide: there rotations tell where they are.
        sides: Largest rotation of a body to -x and to +x at the end of a step [rad], both >= 0,
            shape [lane, 2]; None of a kernel that does not tell.
        contacts: Rows of its struct `ContactResult`, shape [lane, contact]; None of a kernel that
            does not tell.
        breaks: Rows of its struct `Breaks`, shape [lane]; None of a kernel without bonds.
        bonds: 1 where the joint of a contact is bonded at the end, shape [lane, contact]; likewise.
        drums: Rows of its struct `DrumResult`, shape [lane, block]; None of a kernel that does not
            run columns.
    """

    lanes: Rows
    blocks: Rows
    history: Array | None
    places: Array | None
    sides: Array | None = None
    contacts: Rows | None = None
    breaks: Rows | None = None
    bonds: Rows | None = None
    drums: Rows | None = None

    def above_ground(self, block_count: int) -> Found:
        """What is left of the highest blocks: a kernel may have the ground as its first body."""
        own = slice(-block_count, None)
        history, places = (
            None if part is None else part[:, own] for part in (self.history, self.places)
        )
        return dataclasses.replace(self, blocks=self.blocks[:, own], history=history, places=places)


def launch(
    module: ModuleType,
    target: Target,
    motions: GroundMotions,
    times: SampleTimes,
    blocks: Columns,
    **others: Any,
) -> Found:
    """Runs the kernel `run_lanes` of a kernel file over a batch of lanes.

    Args:
        module: Instance of a `*_run` kernel file, with the struct `Found`, and `LANES`, the lanes
            of a thread.
        target: Precision and device.
        motions: Ground motions of the lanes.
        times: Duration and sampling.
        blocks: Fields of the struct of its argument `blocks`, shape [lane, block] each.
        others: What the kernel takes besides, by the names of its arguments: fields of the struct
            of `lanes`, shape [lane] each, or [lane, number] where it takes several of a lane; an
            array, shape [lane]; numbers; a Warp struct.
    """
    import warp as wp

    lane_count, block_count = next(iter(blocks.values())).shape
    count = -(-lane_count // module.LANES) * module.LANES
    takes = {each.label: each.type for each in module.run_lanes.adj.args}
    pool, motion_rows = pool_and_rows(takes["motions"].dtype, motions, count)
    given = {"blocks": blocks, "motions": motion_rows, "pool": pool, "sample_times": times.times}
    in_space, real = isinstance(motions, SpatialMotions), getattr(wp, target.precision)
    sampled = times.count if times.interval is not None else 0
    device = target.device
    found = module.Found()
    leaves = {name: field.type.dtype for name, field in module.Found.vars.items()}
    found.results = wp.empty(count, dtype=leaves["results"], device=device)
    found.blocks = wp.empty((block_count, count), dtype=leaves["blocks"], device=device)
    seen = samples_of((sampled, block_count, *((4,) if in_space else ()), count), real, device)
    setattr(found, "attitudes" if in_space else "rotations", seen)
    placed = hasattr(found, "places")
    if placed:
        wanted = sampled if times.places else 0
        found.places = samples_of((wanted, block_count, 3 if in_space else 2, count), real, device)
    if hasattr(found, "sides"):
        found.sides = wp.zeros((2, count), dtype=real, device=device)
    if hasattr(found, "ties"):
        tie_count = next(iter(others["ties"].values())).shape[1]
        found.ties = wp.empty((tie_count, count), dtype=leaves["ties"], device=device)
    if hasattr(found, "contacts"):
        contact_count = 2 * next(iter(others["joints"].values())).shape[1]
        found.contacts = wp.zeros((contact_count, count), dtype=leaves["contacts"], device=device)
    if hasattr(found, "drums"):
        shape = (block_count, count)
        found.drums = wp.empty(shape, dtype=leaves["drums"], device=device)
    bonded = hasattr(found, "bonds")
    if bonded:
        found.breaks = wp.empty(count, dtype=leaves["breaks"], device=device)
        found.bonds = wp.ones((contact_count, count), dtype=leaves["bonds"], device=device)
    kernel = module.run_lanes
    given |= others | {"found": found}
    wp.launch(
        kernel,
        dim=(count // module.LANES, 1),
        inputs=[_argument(each, given[each.label], count, device) for each in kernel.adj.args],
        device=device,
    )
    results = found.results.numpy()[:lane_count]
    per_block = found.blocks.numpy()[:, :lane_count].T
    history = lanes_first(seen, lane_count) if sampled else None
    places = lanes_first(found.places, lane_count) if placed and wanted else None
    sides = None
    if hasattr(found, "sides"):
        sides = found.sides.numpy()[:, :lane_count].T.astype(np.float64)
    contacts = None
    if hasattr(found, "contacts"):
        contacts = found.contacts.numpy()[:, :lane_count].T
    drums = found.drums.numpy()[:, :lane_count].T if hasattr(found, "drums") else None
    breaks, bonds = None, None
    if bonded:
        breaks = found.breaks.numpy()[:lane_count]
        bonds = found.bonds.numpy()[:, :lane_count].T
    return Found(results, per_block, history, places, sides, contacts, breaks, bonds, drums)


def samples_of(shape: tuple[int, ...], real: Any, device: str) -> Any:
    """An array of samples, [sample, block, ..., lane], for a kernel to fill; empty if of none."""
    import warp as wp

    own = shape if shape[0] else (0,) * len(shape)
    return wp.full(own, value=np.inf, dtype=real, device=device)


def lanes_first(samples: Any, lane_count: int) -> Array:
    """Samples of a kernel as [lane, block, sample, ...]."""
    moved = np.moveaxis(samples.numpy()[..., :lane_count], (-1, 1, 0), (0, 1, 2))
    return np.ascontiguousarray(moved, dtype=np.float64)


def _argument(argument: Any, value: Any, count: int, device: str) -> Any:
    """What a kernel takes as one of its arguments: arrays of the type that it names.

    A kernel that names an axis less, of blocks or of directions, has the first of them alone. (One
    of single blocks with a second index in its loop over lanes is not made vector code.)
    """
    import warp as wp

    if isinstance(value, Mapping):
        rows = struct_rows if next(iter(value.values())).ndim == 1 else block_rows
        value = rows(argument.type.dtype, value, count)
    if isinstance(value, np.ndarray):
        value = value[0] if value.ndim > argument.type.ndim else value
        if argument.label in OF_LANES:
            value = pad(value, count)
        return wp.array(value, dtype=argument.type.dtype, device=device)
    return value


def struct_rows(struct: Any, columns: Columns, count: int) -> Rows:
    """Rows of a Warp struct from its fields by name, padded to a count of lanes.

    The fields of a struct within it are among the columns, too.
    """
    rows = np.zeros(count, dtype=struct.numpy_dtype())
    _fill(rows, columns)
    return rows


def _fill(rows: Rows, columns: Columns) -> None:
    for name in rows.dtype.names or ():
        if rows.dtype[name].names:
            _fill(rows[name], columns)
        else:
            rows[name] = pad(np.asarray(columns[name]), len(rows))


def block_rows(struct: Any, columns: Columns, count: int) -> Rows:
    """Rows of a struct of blocks, shape [block, lane], padded to a count of lanes."""
    block_count = next(iter(columns.values())).shape[1]
    rows = np.zeros((block_count, count), dtype=struct.numpy_dtype())
    for name in rows.dtype.names or ():
        for block in range(block_count):
            rows[name][block] = pad(columns[name][:, block], count)
    return rows


def pad(values: Rows, count: int) -> Rows:
    """Repeats the values of the last lane up to a count of lanes."""
    return np.concatenate([values, np.repeat(values[-1:], count - len(values))])


def strongest_ahead(values: Array, count: int) -> Array:
    """Largest |value| of each sample and the `count` after it, shape [sample]."""
    found, seen = np.abs(values), 1
    while seen <= count:
        shift = min(seen, count + 1 - seen)
        found[:-shift] = np.maximum(found[:-shift], found[shift:])
        seen += shift
    return found


def pool_and_rows(struct: Any, motions: GroundMotions, count: int) -> tuple[Array, Rows]:
    """Samples of the records of all directions, [row, sample], and rows of `Motion`.

    The rows of the pool are those of kernels/motion/pool.py. Shape of the rows of motions:
    [direction, lane].
    """
    pools, rows, first = [], [], 0
    for part in motions.components:
        placed = part.compact()
        if isinstance(placed, RecordMotions):
            placed = dataclasses.replace(placed, offset=(placed.offset + first).astype(np.int32))
        pool = placed.pool
        names = np.dtype(struct.numpy_dtype()).names or ()
        rows.append(struct_rows(struct, {name: getattr(placed, name) for name in names}, count))
        pools.append(np.concatenate([pool, strongest_ahead(pool[ACCELERATION], AHEAD)[None]]))
        first += pool.shape[1]
    return np.concatenate(pools, axis=1), np.stack(rows)
