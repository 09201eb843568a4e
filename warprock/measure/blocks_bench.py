"""What a lane of an assembly costs by its number of blocks."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from warprock.case.assembly import MOST_ASSEMBLED
from warprock.engines.assembly import Assembly
from warprock.errors import InputError
from warprock.model import patterns
from warprock.model.assembly import Assemblies, assemble
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, HarmonicMotions, Waveform, harmonic_motions
from warprock.model.response import SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.units import GRAVITY

BLOCKS = (10, 30, 100, 300, 1_000, 3_000, 10_000)
"""Blocks of the walls, about: as many courses as blocks in a course."""


LENGTH, HEIGHT, FRICTION = 0.4, 0.2, 0.6
"""Of a block [m], and of its joints."""

AMPLITUDE, FREQUENCY = 0.2, 2.0
"""Of the sine that moves the base [g], [Hz]: the walls stand, and forces change in every step."""

FIRST, LAST = 0.005, 0.025
"""The two ends of the runs whose costs are subtracted [s]: what is left is without the start, in
which contacts find their first forces."""


TRIES = 5


def run_blocks_bench(
    blocks: Sequence[int] = BLOCKS,
    *,
    workers: int | None = None,
    report: Callable[[str], None] | None = None,
) -> list[dict[str, Any]]:
    """Measures walls in running bond at the beginning of a sine.

    Args:
        blocks: Blocks of each wall, about.
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
    for count in blocks:
        if not 2 <= count <= MOST_ASSEMBLED:
            allowed = f"must be a number of blocks from 2 to {MOST_ASSEMBLED:,}"
            raise InputError("--blocks", "", count, allowed)
    for count in blocks:
        if report is not None:
            report(f"bench blocks: a wall of some {count:,} blocks")
        rows.append(_measure(count, workers))
    return rows


def _measure(count: int, workers: int | None) -> dict[str, Any]:
    """The row of a wall."""
    side = max(1, round(math.sqrt(count)))
    wall = patterns.wall(LENGTH, HEIGHT, side, side, whole_first=True)
    kind = assemble(wall, depth=1.0, density=2000.0, friction=FRICTION)
    engine = Assembly()
    kernel = engine.kernel_of(_lanes(Assemblies((kind,), np.zeros(1, dtype=np.intp))))
    count = 1 if kernel.name == "team_run" else kernel.lanes
    lanes = _lanes(Assemblies((kind,), np.zeros(count, dtype=np.intp)))
    motions = _motions(count)
    # Compiles the kernel.
    engine.warm_up(lanes, motions)

    def spent(end: float) -> tuple[float, int]:
        begin = time.process_time()
        found = run_batch("assembly", lanes, motions, SampleTimes(end), workers=workers)
        bad = int((found["status"] != Status.OK).sum())
        return (time.process_time() - begin) / count, bad

    # Short runs are repeated: the least time has the least of what else the machine does.
    tries = TRIES if count > 1 else 1
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


def _motions(count: int) -> HarmonicMotions:
    """The same sine for every lane, a little less from lane to lane."""
    each = AMPLITUDE * GRAVITY * np.linspace(1.0, 0.95, count)
    same = np.ones(count)
    control = [Control.ACCELERATION] * count
    return harmonic_motions(
        Waveform.SINE, control, each, FREQUENCY * same, 0.0 * same, same / FREQUENCY
    )


def _lanes(own: Assemblies) -> Lanes:
    """Lanes of the same wall."""
    kind, same = own.of(0), np.ones(len(own.lane))
    width, height = kind.size
    return Lanes(
        width=width * same,
        height=height * same,
        depth=kind.depth * same,
        density=kind.density * same,
        friction=FRICTION * same,
        chamfer=0.0 * same,
        offset=0.0 * same,
        rotation_start=0.0 * same,
        angular_restitution=0.0 * same,
        assembly=own,
    )
