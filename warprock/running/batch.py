"""Runs lanes in chunks on worker threads; a Warp launch on the CPU releases the interpreter lock.

A lane's result does not depend on its chunk, its place or the number of workers.
"""

from __future__ import annotations

import collections
import dataclasses
import threading
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from warprock.arguments import at_the_door
from warprock.engines import engine_class
from warprock.engines.base import AbstractEngine, KernelEngine
from warprock.engines.launching import Form, Target, Team
from warprock.engines.workload import MOST_STEPS, require_workload
from warprock.errors import InputError
from warprock.kernels.launch.instance import LANE_WIDTH
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.painleve import mark_ambiguous
from warprock.model.response import Response, SampleTimes, join_responses, take_lanes
from warprock.model.runnable import require_runnable
from warprock.running.devices import keeping_kernels, require_device, start_warp
from warprock.running.machine import core_count, require_workers

CHUNK_STEPS = 2.0e7
"""Target number of steps in a chunk: about a second of work, so that Ctrl-C and progress are
prompt."""

STEPS_PER_SECOND_OF_MOTION = 100.0
"""Rough steps of one lane in a second of motion where the engine has no time step of its own."""

_WARMING_UP = threading.Lock()
"""Lock while kernels are built, so that two threads with batches never build the same one."""

LANE_QUANTUM: int = LANE_WIDTH
"""Chunks are a multiple of the lanes of a pack."""

DEVICE_CHUNK = 2**17
"""Lanes in a chunk on a GPU: enough to fill it. While it runs one, workers write the lanes of the
next and read the results of the last, which takes several times as long."""

CHUNK_BYTES, DEVICE_CHUNK_BYTES = 2**26, 2**31
"""Memory of the lanes of a chunk, on a CPU and on a GPU [bytes]: a lane of 60 bricks in space takes
more than a megabyte."""

MOST_HISTORY = 500_000_000
"""Numbers in the histories of a batch: 4 GB."""


def require_room(blocks: int, times: SampleTimes, source: str = "run_batch") -> None:
    """Refuses histories that do not fit into memory.

    Args:
        blocks: Number of blocks of all lanes together.
        times: Duration and sampling.
        source: Source that errors name.

    Raises:
        InputError: The histories are too large.
    """
    if times.interval is None or blocks * times.count <= MOST_HISTORY:
        return
    allowed = (
        f"must make at most {MOST_HISTORY:,} numbers, 4 GB, in the histories of all blocks: "
        f"{blocks:,} blocks x {times.count:,} samples are {blocks * times.count:,}"
    )
    raise InputError(source, "run.sample_interval", f"{times.interval:g} s", allowed)


def default_chunk_size(lane_count: int, steps_per_lane: float, workers: int) -> int:
    """Lanes in a chunk: prompt progress, and at least four chunks a worker where lanes allow."""
    prompt = CHUNK_STEPS / max(steps_per_lane, 1.0)
    shared = lane_count / (4 * workers)
    return max(1, round(min(prompt, shared) / LANE_QUANTUM)) * LANE_QUANTUM


@at_the_door
def run_batch(
    engine: str,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
    *,
    settings: Any = None,
    precision: str = "float64",
    device: str = "cpu",
    form: Form | None = None,
    workers: int | None = None,
    chunk_size: int | None = None,
    most_steps: float = MOST_STEPS,
    progress: Callable[[int], None] | None = None,
) -> Response:
    """Runs all lanes of a batch with one engine; the response has them in their order.

    Args:
        engine: Name in `ENGINES`.
        lanes: The lanes.
        motions: Their ground motions.
        times: Duration and sampling.
        settings: Settings of the engine; its defaults where None.
        precision: "float64" or "float32".
        device: Name of a Warp device.
        form: Form of the kernel; the fast one for the device where None.
        workers: Worker threads; as many as there are cores where None.
        chunk_size: Lanes in a chunk; chosen from the work where None.
        most_steps: Steps that a lane may need, at most.
        progress: Called with the lanes finished so far.

    Raises:
        InputError: The engine or the device is unknown, or the settings are of another engine.
            There are no lanes, or some cannot be run (see `require_runnable`) or need too many
            steps. There is less than one worker, or less than one lane in a chunk. Histories are
            too large to be held. A kernel is not built yet, and its folder cannot be written to.

    Example:
        >>> import warprock as wr
        >>> found = wr.expand_lanes(wr.load_case("free-b0"))
        >>> wr.run_batch("housner", found.lanes, found.motions, found.times).lane_count
        2
    """
    require_runnable(lanes, motions)
    count = lanes.lane_count
    blocks = lanes.block_count if lanes.assembly is None else 4 * lanes.assembly.most_blocks
    require_room(count * blocks, times)
    _require_spread(workers, chunk_size)
    built = _build(engine, settings, Target(precision, device, form))
    most = built.highest[lanes.spatial]
    if lanes.assembly is None and lanes.block_count > most:
        allowed = f"must have at most {most} blocks a lane in {engine}"
        raise InputError("run_batch", "lanes.width", list(lanes.width.shape), allowed)
    require_workload(built, lanes, motions, times, most_steps=most_steps)
    threads, size = workers or core_count(), chunk_size or DEVICE_CHUNK
    if built.target.on_cpu:
        time_step = getattr(built.settings, "time_step", 1.0 / STEPS_PER_SECOND_OF_MOTION)
        size = chunk_size or default_chunk_size(count, times.duration / time_step, threads)
    room = CHUNK_BYTES if built.target.on_cpu else DEVICE_CHUNK_BYTES
    if chunk_size is None and (each := built.lane_bytes(lanes, motions)):
        size = max(1, min(size, room // each))
    if built.shares(lanes):
        size, team = 1, Team(max(1, threads // count))
        built = dataclasses.replace(built, target=dataclasses.replace(built.target, team=team))
    with _WARMING_UP, keeping_kernels():
        built.warm_up(lanes, motions)
    slices = [slice(low, min(low + size, count)) for low in range(0, count, size)]
    run_chunk = _chunk_runner(built, lanes, motions, times)
    try:
        return join_responses(_run_all(run_chunk, slices, threads, progress))
    finally:
        built.target.team.stopped.set()


def _build(engine: str, settings: Any, target: Target) -> AbstractEngine:
    """An engine with its settings on a device; refuses unknown engines, devices and settings."""
    require_device(target.device)
    wanted = engine_class(engine).settings_type
    if settings is not None and not isinstance(settings, wanted):
        raise InputError("settings", "", settings, f"must be a {wanted.__name__} or None")
    return engine_class(engine)(settings, target)


def warm_up_together(batches: Iterable[tuple[AbstractEngine, Lanes, GroundMotions]]) -> None:
    """Compiles or loads the kernels of several runs side by side, on all cores.

    A run alone compiles its kernels on one core. Work that needs many kernels ends sooner if they
    are known beforehand. Warp compiles its headers for each set of flags that finds none
    (`share_headers` in devices.py), which takes as long as two kernels. So kernels with the same
    flags follow one another, and threads begin at both ends of the list.

    Args:
        batches: For each run its engine, its lanes and their ground motions.

    Raises:
        InputError: The folder of the kernels cannot be written to.
    """
    import concurrent.futures

    import warp as wp

    start_warp()
    with _WARMING_UP, keeping_kernels():
        names = {
            engine.module_of(lanes, motions).__name__
            for engine, lanes, motions in batches
            if isinstance(engine, KernelEngine)
        }
        modules = [wp.get_module(name) for name in sorted(names)]
        modules.sort(key=lambda module: str(module.options["cpu_compiler_flags"]))
        left = collections.deque(modules)

        def load(from_end: int) -> None:
            while True:
                try:
                    module = left.pop() if from_end else left.popleft()
                except IndexError:
                    return
                wp.force_load("cpu", [module], max_workers=0)

        with concurrent.futures.ThreadPoolExecutor(core_count()) as pool:
            for done in [pool.submit(load, thread % 2) for thread in range(core_count())]:
                done.result()


def _chunk_runner(
    built: AbstractEngine, lanes: Lanes, motions: GroundMotions, times: SampleTimes
) -> Callable[[slice], Response]:
    """A function that runs a chunk of the lanes."""

    def run_chunk(part: slice) -> Response:
        some, moves = lanes.take(part), motions.take(part)
        order = built.alike_order(some, moves)
        if order is None:
            response = built.run(some, moves, times)
        else:
            sorted_by_work = built.run(some.take(order), moves.take(order), times)
            response = take_lanes(sorted_by_work, np.argsort(order))
        return mark_ambiguous(some, response) if built.slides else response

    return run_chunk


def _require_spread(workers: int | None, chunk_size: int | None) -> None:
    """Refuses fewer than one worker, or than one lane of a chunk."""
    require_workers(workers)
    if chunk_size is not None and chunk_size < 1:
        raise InputError("run_batch", "chunk_size", chunk_size, "must be at least 1")


def _run_all(
    run_chunk: Callable[[slice], Response],
    slices: Sequence[slice],
    threads: int,
    progress: Callable[[int], None] | None,
) -> list[Response]:
    """Responses of all chunks in their order; after an error the waiting chunks are dropped."""
    import concurrent.futures

    done = 0
    pool = concurrent.futures.ThreadPoolExecutor(threads)
    try:
        futures = [pool.submit(run_chunk, part) for part in slices]
        for future in concurrent.futures.as_completed(futures):
            done += future.result().lane_count
            if progress is not None:
                progress(done)
        return [future.result() for future in futures]
    finally:
        # A running launch cannot be stopped; it is not waited for.
        pool.shutdown(wait=False, cancel_futures=True)
