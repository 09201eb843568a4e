"""What a lane of an assembly costs by its number of blocks."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from warprock.case.assembly import MOST_ASSEMBLED
from warprock.engines.assembly import Assembly as Engine
from warprock.errors import InputError
from warprock.measure.assembly_bench import ASKEW, THICK, lanes_of, sines, towards
from warprock.model import patterns
from warprock.model.assembly import Assembly, assemble
from warprock.model.response import SampleTimes, Status
from warprock.model.solids import assemble_solids
from warprock.running.batch import run_batch
from warprock.units import GRAVITY

BLOCKS = (10, 30, 100, 300, 1_000, 3_000, 10_000)
"""Blocks of the walls, about: as many courses as blocks in a course."""

BLOCKS_IN_SPACE = (10, 30, 100, 300)
"""The same in space, where steps cost more."""

LENGTH, HEIGHT, FRICTION = 0.4, 0.2, 0.6
"""Of a block [m], and of its joints."""

AMPLITUDE, FREQUENCY = 0.2, 2.0
"""Of the sine that moves the base [g], [Hz]: the walls stand, and forces change in every step."""

FIRST, LAST = 0.005, 0.025
"""The two ends of the runs whose costs are subtracted [s]: what is left is without the start, in
which contacts find their first forces."""

TRIES = 5
"""Runs of each length, of which the quickest counts; one of a large lane."""


def run_blocks_bench(
    blocks: Sequence[int] = (),
    *,
    space: bool = False,
    workers: int | None = None,
    report: Callable[[str], None] | None = None,
) -> list[dict[str, Any]]:
    """Measures walls in running bond at the beginning of a sine.

    Args:
        blocks: Blocks of each wall, about; those of `BLOCKS` where empty.
        space: Whether the walls are of bricks in space, and the sine comes at an angle to them.
        workers: Worker threads; the cores at hand where None.
        report: Called with what is about to be measured.

    Returns:
        One row a wall: blocks, joints, kernel, lanes (a full pack, or one), cpu_us_per_step (of one
        lane in a step of 1e-3 s), cpu_per_motion (CPU seconds of one lane for a second of motion),
        start_cpu_s (of one lane, before the run), status (of all lanes: ok, or the number that are
        not).

    Raises:
        InputError: A number of blocks out of bounds.
    """
    rows = []
    counts = blocks or (BLOCKS_IN_SPACE if space else BLOCKS)
    for count in counts:
        if not 2 <= count <= MOST_ASSEMBLED:
            allowed = f"must be a number of blocks from 2 to {MOST_ASSEMBLED:,}"
            raise InputError("--blocks", "", count, allowed)
    for count in counts:
        if report is not None:
            report(f"bench blocks: a wall of some {count:,} blocks")
        rows.append(_measure(count, workers, space=space))
    return rows


def _wall(count: int, *, space: bool) -> Assembly:
    """A wall of about so many blocks."""
    side = max(1, round(math.sqrt(count)))
    wall = patterns.wall(LENGTH, HEIGHT, side, side, whole_first=True)
    if space:
        return assemble_solids(patterns.extruded(wall, THICK), density=2000.0, friction=FRICTION)
    return assemble(wall, depth=1.0, density=2000.0, friction=FRICTION)


def _measure(count: int, workers: int | None, *, space: bool) -> dict[str, Any]:
    """The row of a wall."""
    kind, engine = _wall(count, space=space), Engine()
    kernel = engine.kernel_of(lanes_of(kind, 1))
    count = 1 if kernel.name == "team_run" else kernel.lanes
    lanes = lanes_of(kind, count)
    # The same sine for every lane, a little less from lane to lane.
    size = AMPLITUDE * GRAVITY * np.linspace(1.0, 0.95, count)
    motions = towards(kind, sines(size, FREQUENCY), ASKEW)
    # Compiles the kernel.
    engine.warm_up(lanes, motions)

    def spent(end: float) -> tuple[float, int]:
        begin = time.process_time()
        found = run_batch("assembly", lanes, motions, SampleTimes(end), workers=workers)
        bad = int((found["status"] != Status.OK).sum())
        return (time.process_time() - begin) / count, bad

    # Short runs are repeated: the least time has the least of what else the machine does.
    tries = 1 if kernel.name == "team_run" else TRIES
    first = min(spent(FIRST)[0] for _ in range(tries))
    last, bad = min(spent(LAST) for _ in range(tries))
    a_second = (last - first) / (LAST - FIRST)
    return {
        "blocks": int((~kind.fixed).sum()),
        "joints": kind.joints.count,
        "kernel": kernel.name,
        "lanes": count,
        "cpu_us_per_step": 1e6 * a_second * engine.settings.time_step,
        "cpu_per_motion": a_second,
        "start_cpu_s": first - FIRST * a_second,
        "status": f"{bad} not ok" if bad else "ok",
    }
