"""Lanes of a case that run together: those of one time step and one duration.

An ensemble may deal time steps to its members, and lanes may have durations of their own. A kernel
has one step and one end for all of its lanes, so that each lane is the one that it would be alone.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.case.lanes import LaneSet
from warprock.engines.launching import Form
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Response, SampleTimes, join_responses, take_lanes
from warprock.running.machine import core_count
from warprock.running.options import Counted, RunOptions
from warprock.settings.engines import has_time_step

FEW_LANES = 8
"""Number of lanes below which the plain form is faster: a pack takes as long for one lane as for
all. In the plane both give the same bits. One lane under a record took a tenth of the time."""


@dataclasses.dataclass(frozen=True)
class Part:
    """Lanes of a case that run together: those of one time step and one duration.

    Attributes:
        numbers: Their places among the lanes wanted.
        lanes: The lanes.
        motions: Their ground motions.
        times: Duration and sampling.
        settings: Settings of the engine.
    """

    numbers: npt.NDArray[np.intp]
    lanes: Lanes
    motions: GroundMotions
    times: SampleTimes
    settings: Any


def run_parts(
    run: Callable[[Part, RunOptions], Response],
    lane_set: LaneSet,
    chosen: npt.NDArray[np.intp] | None,
    times: SampleTimes,
    settings: Any,
    options: RunOptions,
) -> Response:
    """Runs lanes of a case, those that run alike together, and puts them in order again.

    Parts run side by side, for one of few lanes does not keep all workers busy.

    Args:
        run: What runs a part.
        lane_set: Lanes of the case, with the factors on the time step that an ensemble asks for
            (an engine without a time step has no use for them) and the durations they may have.
        chosen: Numbers of the lanes wanted, in the order wanted; None is all.
        times: Sampling of the histories; how long lanes run is said by the lanes.
        settings: Settings of the engine, with the time step that the factors change.
        options: How they are run.
    """
    parts = _parts(lane_set, chosen, times, settings)
    if len(parts) == 1:
        return run(parts[0], options)
    workers = options.workers or core_count()
    side_by_side = min(workers, len(parts)) if options.on_cpu else 1
    counted = Counted(options.progress)
    many_ends = lane_set.durations is not None and options.on_cpu and not lane_set.lanes.spatial
    each = dataclasses.replace(options, workers=workers // side_by_side)

    import concurrent.futures

    def run_part(number: int) -> Response:
        part = parts[number]
        few = many_ends and part.lanes.lane_count < FEW_LANES
        own = dataclasses.replace(
            each, progress=counted.of(number), form=Form.PLAIN if few else options.form
        )
        return run(part, own)

    pool = concurrent.futures.ThreadPoolExecutor(side_by_side)
    try:
        found = list(pool.map(run_part, range(len(parts))))
    finally:
        # Whoever stops a run does not wait for the parts that are left.
        pool.shutdown(wait=False, cancel_futures=True)
    order = np.concatenate([part.numbers for part in parts])
    return take_lanes(join_responses(found), np.argsort(order))


def _parts(
    lane_set: LaneSet, chosen: npt.NDArray[np.intp] | None, times: SampleTimes, settings: Any
) -> list[Part]:
    """The lanes wanted, by time step and duration; arguments as of `run_parts`."""
    numbers = np.arange(lane_set.lanes.lane_count) if chosen is None else chosen
    alike = np.ones((2, len(numbers)))
    if lane_set.step_factors is not None and has_time_step(settings):
        alike[0] = lane_set.step_factors[numbers]
    alike[1] = np.broadcast_to(lane_set.ends, lane_set.lanes.lane_count)[numbers]
    kinds, kind = alike[:, :1], np.zeros(len(numbers), dtype=np.intp)
    if (alike != kinds).any():
        kinds, kind = np.unique(alike, axis=1, return_inverse=True)
    by_kind = np.argsort(kind.reshape(-1), kind="stable")
    ends = np.cumsum(np.bincount(kind.reshape(-1)))
    parts = []
    for (factor, duration), places in zip(kinds.T, np.split(by_kind, ends[:-1]), strict=True):
        which = slice(None) if chosen is None and len(kinds.T) == 1 else numbers[places]
        parts.append(
            Part(
                places,
                lane_set.lanes.take(which),
                lane_set.motions.take(which).compact(),
                dataclasses.replace(times, duration=float(duration)),
                settings if factor == 1.0 else settings.with_step_scaled(float(factor)),
            )
        )
    return parts
