"""How many lanes a second another device than the CPU runs, by the number of lanes."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp

from warprock.engines import ENGINES, engine_class
from warprock.measure.bench import ERROR_DURATION, REPEATS, free_lanes, in_space
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import GroundMotions, SpatialMotions, StillBase
from warprock.model.response import SampleTimes
from warprock.model.scene import scene_kind
from warprock.running import machine
from warprock.running.batch import run_batch

Batch = tuple[Lanes, GroundMotions]

COUNTS = tuple(10**exponent for exponent in range(3, 8))
"""Numbers of lanes that are tried, as long as a run stays short."""

CPU_LANES = 10_000
"""Lanes that the CPU runs for comparison, on all cores."""


def _blocks(count: int) -> Batch:
    return free_lanes(count), StillBase(count)


def _pairs(count: int) -> Batch:
    """Each block with another of its size on it, let go as one from a third of its start."""
    stacks = as_stacks(free_lanes(count))
    parts: dict[str, Any] = {
        name: np.repeat(each, 2, axis=1)
        for name, each in stacks.arrays.items()
        if name != "angular_restitution"
    }
    parts["rotation_start"] /= 3.0
    return dataclasses.replace(stacks, **parts), StillBase(count)


def _blocks_in_space(count: int) -> Batch:
    still = StillBase(count)
    return in_space(free_lanes(count)), SpatialMotions(still, still, still)


SCENES: dict[str, Callable[[int], Batch]] = {
    "block": _blocks,
    "stack of two": _pairs,
    "block in space": _blocks_in_space,
}
"""Blocks B1 to B3 in free rocking, by the name of the scene."""


def run_device_bench(device: str, seconds: float, workers: int | None = None) -> dict[str, Any]:
    """Measures every engine on a device, for 5 s of motion of 10^3 to 10^7 lanes.

    Args:
        device: Name of a Warp device, such as "cuda:0".
        seconds: Time that a measurement takes, about [s]: one that would take more than ten times
            as long is left out, and so are those of more lanes.
        workers: Threads that prepare lanes and read results; as many as there are cores where
            None.

    Returns:
        device (its name), machine, duration [s], and rows: engine, scene, precision, lanes,
        lanes_per_s (preparation and results included), kernel_lanes_per_s (the kernel alone) and
        cpu_lanes_per_s (the packed or only kernel on all cores of the CPU, 10,000 lanes).
    """
    rows = []
    for name, scene in SCENES.items():
        kind = scene_kind(*scene(9), restitution_given=False)
        for engine in ENGINES:
            if engine_class(engine).supports(kind) is None:
                for precision in ("float64", "float32"):
                    found = _rows(engine, scene, precision, device, seconds, workers)
                    rows += [{"engine": engine, "scene": name, **row} for row in found]
    return {
        "device": str(wp.get_device(device).name),
        "machine": {"cpu": machine.cpu_name(), "cores": machine.core_count()},
        "duration": ERROR_DURATION,
        "rows": rows,
    }


def _rows(
    engine: str,
    scene: Callable[[int], Batch],
    precision: str,
    device: str,
    seconds: float,
    workers: int | None,
) -> list[dict[str, Any]]:
    """Rows of an engine in a scene, fewest lanes first."""

    def best(place: str, count: int) -> tuple[float, float]:
        """Wall time of a run and of its kernel [s]: the fastest of some, or of one long one."""
        batch, runs = scene(count), list[tuple[float, float]]()
        while len(runs) < REPEATS and sum(took for took, _kernel in runs) < seconds:
            runs.append(_time_run(engine, batch, precision, place, workers))
        return min(runs)

    for place, count in (("cpu", CPU_LANES), (device, COUNTS[0])):
        _time_run(engine, scene(count), precision, place, workers, duration=0.01)
    cpu, _kernel = best("cpu", CPU_LANES)
    rows = list[dict[str, Any]]()
    for count in COUNTS:
        took, kernel = best(device, count)
        rows.append(
            {
                "precision": precision,
                "lanes": count,
                "lanes_per_s": count / took,
                "kernel_lanes_per_s": count / kernel if kernel else None,
                "cpu_lanes_per_s": CPU_LANES / cpu,
            }
        )
        if took > seconds:
            break
    return rows


def _time_run(
    engine: str,
    batch: Batch,
    precision: str,
    device: str,
    workers: int | None,
    duration: float = ERROR_DURATION,
) -> tuple[float, float]:
    """Wall time of one run, and of its kernel where the device tells [s]."""
    wp.timing_begin(cuda_filter=wp.TIMING_KERNEL)
    begin = time.perf_counter()
    run_batch(
        engine,
        *batch,
        SampleTimes(duration),
        precision=precision,
        device=device,
        workers=workers,
    )
    took = time.perf_counter() - begin
    return took, 1e-3 * sum(found.elapsed for found in wp.timing_end())
