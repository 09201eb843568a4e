"""Speed and error of the engines on this machine, with ratios taken within one run.

Block-steps a second of every engine, precision and form of the kernel in free rocking of blocks B1
to B3. What an error costs, beside programs of others and plain loops, is measured in `peers`.

Absolute rates belong to the machine and the moment; the ratios (packed over plain kernel, two
workers over one) hold wherever the cores are idle.
"""

from __future__ import annotations

import dataclasses
import subprocess
import sys
import tempfile
import time
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines import ENGINES, engine_class, reference_engine
from warprock.engines.launching import Form
from warprock.model import rocking
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import GroundMotions, SpatialMotions, StillBase
from warprock.model.response import Response, SampleTimes
from warprock.model.scene import scene_kind
from warprock.running import machine
from warprock.running.batch import run_batch

Array = npt.NDArray[np.float64]

LANES = 2048
"""Enough for 64 packs, so that two workers share them evenly."""

LANES_MOST = 2**18
"""Lanes up to which a measurement that would be too short takes more of them."""

FREE_HEIGHTS = (0.75, 1.0, 1.25)
FREE_RATIOS = (0.2, 0.5, 0.99)
"""Heights [m] of B1 to B3 of the paper's Table 3, and their starts over the critical angle."""

ERROR_DURATION = 5.0
"""Time over which the error is taken [s], as in the paper's Fig. 5."""

REPEATS = 3
"""Runs of each measurement; the fastest counts, the others met other work on the machine."""


def free_lanes(count: int) -> Lanes:
    """Blocks B1 to B3, 0.5 m wide, from 0.2, 0.5 and 0.99 of the critical angle, in turn."""
    place = np.arange(count)
    height = np.asarray(FREE_HEIGHTS)[place // len(FREE_RATIOS) % len(FREE_HEIGHTS)]
    width = np.full(count, 0.5)
    angle = rocking.slenderness_angle(width, height)
    return Lanes(
        width=width,
        height=height,
        depth=np.full(count, 0.2),
        density=np.full(count, 2000.0),
        friction=np.ones(count),
        chamfer=np.zeros(count),
        offset=np.zeros(count),
        rotation_start=angle * np.asarray(FREE_RATIOS)[place % len(FREE_RATIOS)],
        angular_restitution=rocking.angular_restitution(angle),
    )


def in_space(lanes: Lanes) -> SpatialLanes:
    """The same single blocks in space, without an imperfection."""
    parts: dict[str, Any] = {f.name: getattr(lanes, f.name) for f in dataclasses.fields(lanes)}
    more = {field.name for field in dataclasses.fields(SpatialLanes)} - parts.keys()
    return SpatialLanes(**parts | dict.fromkeys(more, np.zeros(lanes.lane_count)))


@dataclasses.dataclass(frozen=True)
class Rate:
    """One measurement: block-steps in a second of wall time, CPU time of a simulated second."""

    block_steps_per_s: float
    cpu_s_per_simulated_s: float


def measure(
    engine: str,
    seconds: float,
    *,
    precision: str = "float64",
    form: Form,
    workers: int = 1,
    spatial: bool = False,
) -> Rate:
    """Rate of an engine in free rocking.

    Args:
        engine: Name in `ENGINES`.
        seconds: Wall time that the measurement takes, about [s].
        precision: "float64" or "float32".
        form: Form of the kernel.
        workers: Worker threads, all of them on this machine's cores.
        spatial: Whether the same blocks rock in space.
    """

    def run(duration: float, count: int) -> tuple[Response, float, float]:
        lanes: Lanes = free_lanes(count)
        still = StillBase(count)
        motions: GroundMotions = SpatialMotions(still, still, still) if spatial else still
        lanes = in_space(lanes) if spatial else lanes
        begin, begin_cpu = time.perf_counter(), time.process_time()
        response = run_batch(
            engine,
            lanes,
            motions,
            SampleTimes(duration),
            precision=precision,
            form=form,
            workers=workers,
            chunk_size=count // 16,
        )
        return response, time.perf_counter() - begin, time.process_time() - begin_cpu

    run(0.01, LANES)
    duration, count = 0.02, LANES
    response, took, cpu = run(duration, count)
    while took < 0.5 * seconds / REPEATS and count < LANES_MOST:
        if duration < ERROR_DURATION:
            duration = min(2.0 * duration, ERROR_DURATION)
        else:
            count *= 2
        response, took, cpu = run(duration, count)
    for _ in range(REPEATS - 1):
        _, again, again_cpu = run(duration, count)
        took, cpu = min(took, again), min(cpu, again_cpu)
    steps = float(np.sum(response["step_count"]))
    return Rate(steps / took, cpu / (count * duration))


def rocking_engines() -> list[str]:
    """Engines that run single blocks on a still base; the others are left out."""
    scene = scene_kind(free_lanes(9), StillBase(9), restitution_given=False)
    return [name for name in ENGINES if engine_class(name).supports(scene) is None]


def rotation_error(engine: str, precision: str) -> float:
    """Largest |rotation - housner| / slenderness angle of B1 to B3 over 5 s."""
    lanes, times = free_lanes(9), SampleTimes(ERROR_DURATION, 0.01)
    reference = run_batch(reference_engine(), lanes, StillBase(9), times)
    response = run_batch(engine, lanes, StillBase(9), times, precision=precision)
    gap = np.abs(response["rotation"] - reference["rotation"]).max(axis=1)
    return float(np.max(gap / lanes.slenderness_angle))


def command_seconds(*arguments: str) -> float:
    """Wall time of a warprock command in a process of its own [s], the fastest of three."""
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "warprock", *arguments], check=True, capture_output=True
        )
        times.append(time.perf_counter() - begin)
    return min(times)


def run_bench(seconds: float, workers: int | None = None) -> dict[str, Any]:
    """Measures every engine and the commands a user starts with.

    Args:
        seconds: Wall time of one measurement, about [s].
        workers: Workers of the threaded measurement; as many as there are cores where None.

    Returns:
        rows (one an engine, precision and form), ratios by name, commands by name [s].
    """
    threads = workers or machine.core_count()
    engines = rocking_engines()
    rows: list[dict[str, Any]] = []
    ratios: dict[str, float] = {}
    for engine in engines:
        for precision in ("float64", "float32"):
            # The reference has no error against itself; its tests hold it to the oracle.
            reference = (engine, precision) == (reference_engine(), "float64")
            error = float("nan") if reference else rotation_error(engine, precision)
            rates: dict[tuple[Form, int], float] = {}
            for form, count in ((Form.PLAIN, 1), (Form.PACKED, 1), (Form.PACKED, threads)):
                if (form, count) in rates:
                    continue
                rate = measure(engine, seconds, precision=precision, form=form, workers=count)
                rates[form, count] = rate.block_steps_per_s
                rows.append(
                    {
                        "engine": engine,
                        "precision": precision,
                        "form": form.value,
                        "workers": count,
                        **dataclasses.asdict(rate),
                        "rotation_error_5s": error,
                    }
                )
            name = f"{engine} {precision}"
            packed = rates[Form.PACKED, 1]
            ratios[f"{name} packed / plain"] = packed / rates[Form.PLAIN, 1]
            if threads > 1:
                ratios[f"{name} {threads} workers / 1"] = rates[Form.PACKED, threads] / packed
    with tempfile.TemporaryDirectory() as folder:
        commands = {
            "warprock --help": command_seconds("--help"),
            "warprock reproduce table6": command_seconds("reproduce", "table6", "-o", folder),
        }
    return {
        "machine": {
            "cpu": machine.cpu_name(),
            "vector_flags": machine.cpu_vector_flags(),
            "cores": machine.core_count(),
        },
        "rows": rows,
        "ratios": ratios,
        "commands": commands,
    }
