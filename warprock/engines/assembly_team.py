"""One assembly of many blocks as kernels/assembly/team_run.py takes it, and the team that runs it.

On the CPU the team are threads of Python. Each launches the same kernel, with a rank of its own;
Warp lets go of the interpreter meanwhile. A launch takes steps for about `SLICE` and ends, so that
a run of hours can be stopped.
"""

from __future__ import annotations

import concurrent.futures
import ctypes
import dataclasses
import sys
import threading
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines.assembly_packs import NONE
from warprock.engines.launching import (
    NEVER,
    Columns,
    Found,
    Target,
    lanes_first,
    pool_and_rows,
    samples_of,
    struct_rows,
)
from warprock.model.assembly import Assembly
from warprock.model.motion import GroundMotions
from warprock.model.response import SampleTimes

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

BUNDLE = 4
"""Packs of joints or blocks that one thread takes at a time: enough to hide what adding up their
lanes costs, few enough to share a colour out among threads."""

SLICE = 0.3
"""Time that a launch is to take [s]."""

BLOCK_OF_THREADS = 256
"""Threads of the team where the device is no CPU: the kernel's registers allow no more."""

FAR_APART = {"a_x": 10.0, "a_along_x": 1.0, "b_along_x": 1.0}
"""The edges of a joint that fills up a pack: one metre each, and too far apart to touch."""


@dataclasses.dataclass(frozen=True)
class Given:
    """What the kernel takes of a lane.

    Attributes:
        columns: Fields of the structs of blocks and joints, shape [1, block] and [1, joint] each.
        laid: Where blocks may meet, the kernel's struct `Laid`.
        knobs: Settings, the kernel's struct `Knobs`.
    """

    columns: tuple[Columns, Columns]
    laid: Any
    knobs: Any


@dataclasses.dataclass(frozen=True)
class Layout:
    """Where the joints of an assembly lie in the kernel's arrays.

    Attributes:
        joint: The number of the joint at every place, -1 where there is none, [place].
        colours: How many packs of joints every colour has, shape [colour].
    """

    joint: Places
    colours: Places


def colours_of(kind: Assembly) -> Places:
    """A colour of every joint, shape [joint]: of one colour no two share a block that can move.

    Greedy: joint by joint the first colour that neither of its blocks has yet.
    """
    taken = [0] * kind.count
    fixed = kind.fixed.tolist()
    found = []
    for a, b in kind.joints.blocks.tolist():
        both = taken[a] | taken[b]
        free = ~both & (both + 1)
        found.append(free.bit_length() - 1)
        taken[a] = 0 if fixed[a] else taken[a] | free
        taken[b] = 0 if fixed[b] else taken[b] | free
    return np.asarray(found, dtype=np.intp)


def lay_out(kind: Assembly, width: int) -> Layout:
    """The places of joints, in packs of a width."""
    colours = colours_of(kind)
    places, packs = [], []
    for colour in range(int(colours.max()) + 1):
        own = np.flatnonzero(colours == colour)
        spare = -len(own) % width
        places.append(np.concatenate([own, np.full(spare, -1)]))
        packs.append(len(places[-1]) // width)
    return Layout(np.concatenate(places), np.asarray(packs))


def run_team(
    module: ModuleType,
    target: Target,
    own: Assembly,
    given: Given,
    motions: GroundMotions,
    times: SampleTimes,
) -> Found:
    """Runs one lane.

    Args:
        module: Instance of the kernel file.
        target: Precision, device, and how many threads there are.
        own: Its assembly.
        given: What the kernel takes of it.
        motions: Its ground motion.
        times: Duration and sampling.

    Returns:
        What it leaves, contacts in the order of the assembly's joints.
    """
    import warp as wp

    layout = lay_out(own, module.LANES)
    device, real = target.device, getattr(wp, target.precision)
    size = target.team.threads if target.on_cpu else BLOCK_OF_THREADS
    made = {each.label: each.type for each in module.run_lanes.adj.args}
    pool, rows = pool_and_rows(made["motions"].dtype, motions, 1)
    sampled = times.count if times.interval is not None else 0
    found = module.Found()
    leaves = {name: field.type.dtype for name, field in module.Found.vars.items()}
    found.results = wp.zeros(1, dtype=leaves["results"], device=device)
    found.blocks = wp.zeros((own.count, 1), dtype=leaves["blocks"], device=device)
    contacts = 2 * len(layout.joint)
    found.contacts = wp.zeros((contacts, 1), dtype=leaves["contacts"], device=device)
    found.rotations = samples_of((sampled, own.count, 1), real, device)
    placed = sampled if times.places else 0
    found.places = samples_of((placed, own.count, 2, 1), real, device)
    scene = _scene(module, own, layout, given, device)
    store = _store(module, own, layout, size, device)
    arguments = [
        scene,
        store,
        wp.array(rows[0], dtype=made["motions"].dtype, device=device),
        wp.array(pool, dtype=real, device=device),
        wp.array(times.times, dtype=real, device=device),
        given.knobs,
        found,
    ]
    _work(module, target, arguments, store)
    return _left(own, layout, module.LANES, found, (sampled, placed))


def _work(module: ModuleType, target: Target, given: list[Any], store: Any) -> None:
    """Launches the team again and again until the lane has ended.

    Raises:
        CancelledError: Nobody waits for the lane any more.
    """
    import warp as wp

    on_cpu = target.on_cpu
    size = target.team.threads if on_cpu else BLOCK_OF_THREADS
    gate = wp.zeros(32, dtype=int, device=target.device)
    give_way = _give_way() if on_cpu else 0
    steps = 1
    while True:
        began = time.perf_counter()

        def launch(rank: int, steps: int = steps) -> None:
            crew = module.Crew()
            crew.rank, crew.size, crew.steps = rank, size, steps
            crew.gate, crew.give_way = gate, give_way
            wide = 1 if on_cpu else size
            inputs = [*given, crew]
            wp.launch(
                module.run_lanes, dim=(1, wide), inputs=inputs, device=target.device, block_dim=wide
            )

        if on_cpu:
            _together(launch, size)
        else:
            launch(0)
        if store.clock.numpy()[0]["ended"]:
            return
        if target.team.stopped.is_set():
            raise concurrent.futures.CancelledError
        spent = max(time.perf_counter() - began, 1e-6)
        steps = int(np.clip(steps * SLICE / spent, 1, 4 * steps))


def _together(launch: Callable[[int], None], size: int) -> None:
    """Launches ranks side by side, one of them on this thread; none before all threads are there.

    A rank that never came would leave the others waiting for it.
    """
    ready = threading.Barrier(size)

    def work(rank: int) -> None:
        ready.wait()
        launch(rank)

    others = [threading.Thread(target=work, args=(rank,)) for rank in range(1, size)]
    try:
        for each in others:
            each.start()
    except RuntimeError:
        ready.abort()
        raise
    work(0)
    for each in others:
        each.join()


def _give_way() -> int:
    """Address of the system's function by which a thread lets others run; 0 if there is none."""
    if sys.platform == "win32":
        function: Any = ctypes.windll.kernel32.SwitchToThread
    else:
        function = getattr(ctypes.CDLL(None), "sched_yield", None)
    return ctypes.cast(function, ctypes.c_void_p).value or 0 if function else 0


def _scene(
    module: ModuleType,
    own: Assembly,
    layout: Layout,
    given: Given,
    device: str,
) -> Any:
    """The kernel's struct `Scene`."""
    width, count = module.LANES, own.count
    there = layout.joint >= 0
    taken = np.maximum(layout.joint, 0)
    blocks = {name: each[0] for name, each in given.columns[0].items()}
    room = _blocks_of_packs(count, width)
    edges = {}
    for name, each in given.columns[1].items():
        edges[name] = np.where(there, each[0][taken], FAR_APART.get(name, 0.0))
    between = np.where(there[:, None], own.joints.blocks[taken], count)
    numbers = np.stack([blocks["inverse_mass"], blocks["inverse_inertia"]], axis=1)
    # What fills up a pack has masses, so that none of its numbers is infinite.
    numbers = np.concatenate([numbers, np.ones((1, 2))])
    masses = numbers[between].reshape(-1, width, 4).transpose(0, 2, 1).reshape(-1)
    bundles, colours, first = [], [0], 0
    for packs in layout.colours.tolist():
        bundles.append(np.arange(first, first + packs, BUNDLE))
        colours.append(colours[-1] + len(bundles[-1]))
        first += packs
    scene = module.Scene()
    for name, rows in (
        ("blocks", _filled(struct_rows(module.Block, blocks, count), room)),
        ("joints", struct_rows(module.Edges, edges, len(layout.joint))),
        ("pairs", struct_rows(module.Pair, {"a": between[:, 0], "b": between[:, 1]}, len(between))),
        ("masses", np.ascontiguousarray(masses)),
        ("bundles", np.append(np.concatenate(bundles), first).astype(np.int32)),
        ("colours", np.asarray(colours, dtype=np.int32)),
    ):
        setattr(scene, name, _array(module.Scene, name, rows, device))
    scene.laid, scene.count = given.laid, count
    scene.block_packs = BUNDLE
    return scene


def _store(module: ModuleType, own: Assembly, layout: Layout, size: int, device: str) -> Any:
    """The kernel's struct `Store` before the first step."""
    import warp as wp

    width, count = module.LANES, own.count
    room = _blocks_of_packs(count, width)
    packs = len(layout.joint) // width
    bundles = max(
        sum(-(-packs_of // BUNDLE) for packs_of in layout.colours.tolist()),
        -(-count // (width * BUNDLE)),
    )
    mass, centre, moves = own.mass, own.centre, ~own.fixed
    inverse = {"m": moves / mass, "j": moves / (mass * own.gyration)}
    zero = np.zeros(count)
    pose = {"x": centre[:, 0], "z": centre[:, 1], "theta": zero, "s": zero}
    pose = {name: np.pad(each, (0, room - count)) for name, each in pose.items()}
    pose["c"] = np.ones(room)
    track = np.zeros((2 * packs, width), dtype=module.Track.numpy_dtype())
    track["since"] = NEVER
    seen = np.zeros((size, width), dtype=module.Seen.numpy_dtype())
    for name in ("uplift_time", "collapse_time"):
        seen[name] = NEVER
    near = np.zeros(1, dtype=module.Near.numpy_dtype())
    near["pairs"] = NONE
    store = module.Store()
    for name, rows in (
        ("mass", _filled(struct_rows(module.Mass, inverse, count), room)),
        ("pose", struct_rows(module.Pose, pose, room)),
        ("track", track),
        ("seen", seen),
        ("lane", seen[0, :1]),
        ("near", near),
    ):
        setattr(store, name, _array(module.Store, name, rows, device))
    for name, shape in {
        "past": room,
        "now": room,
        "peak": room,
        "trail": 6 * room,
        "contact": 24 * packs * width,
        "force": 12 * packs * width,
        "sums": bundles + 1,
        "heaps": bundles + 1,
        "clock": 1,
        "account": 1,
    }.items():
        dtype = module.Store.vars[name].type.dtype
        setattr(store, name, wp.zeros(shape, dtype=dtype, device=device))
    return store


def _array(struct: Any, name: str, rows: npt.NDArray[Any], device: str) -> Any:
    import warp as wp

    return wp.array(rows, dtype=struct.vars[name].type.dtype, device=device)


def _blocks_of_packs(count: int, width: int) -> int:
    """Places for blocks: whole packs, and one more place, of what fills up packs of joints."""
    return -(-(count + 1) // width) * width


def _filled(rows: npt.NDArray[Any], room: int) -> npt.NDArray[Any]:
    """Rows with zeros after them."""
    return np.concatenate([rows, np.zeros(room - len(rows), dtype=rows.dtype)])


def _left(own: Assembly, layout: Layout, width: int, found: Any, taken: tuple[int, int]) -> Found:
    """What the kernel left, joints in the order of the assembly."""
    sampled, placed = taken
    rows = found.contacts.numpy()[:, 0]
    there = np.flatnonzero(layout.joint >= 0)
    # A pack has one end of all its joints, then the other.
    ends = rows.reshape(-1, 2, width).transpose(0, 2, 1).reshape(-1, 2)
    contacts = np.empty((own.joints.count, 2), dtype=rows.dtype)
    contacts[layout.joint[there]] = ends[there]
    return Found(
        lanes=found.results.numpy(),
        blocks=found.blocks.numpy().T,
        history=lanes_first(found.rotations, 1) if sampled else None,
        places=lanes_first(found.places, 1) if placed else None,
        contacts=contacts.reshape(1, -1),
    )
