"""What a run may ask of an engine: lanes that it can model, and steps that have an end."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.engines.base import AbstractEngine
from warprock.errors import InputError, Said
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import SampleTimes

MOST_STEPS = 100_000_000
"""Steps of a lane at the settings asked for: some ten seconds to a minute of work."""
FINEST_STEPS = 16 * MOST_STEPS
"""Steps of a lane at the finer settings that an estimate runs; kernels count to 2^31."""


def require_workload(
    engine: AbstractEngine,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
    *,
    source: str = "run_batch",
    first: int = 0,
    most_steps: float = MOST_STEPS,
) -> None:
    """Refuses lanes that an engine cannot model, or that would need too many steps.

    An engine without an order goes from event to event, and needs as many steps as there are.

    Args:
        engine: The engine, with its settings.
        lanes: The lanes.
        motions: Their ground motions.
        times: Duration of the run.
        source: What errors name as their source.
        first: Number of the first lane.
        most_steps: Steps of a lane, at most.

    Raises:
        InputError: There is such a lane: its number, the value, and the bound.
    """
    reserve = engine.reserve(lanes)
    if reserve is not None and (reserve[0] <= 1.0).any():
        lane = int(np.argmax(reserve[0] <= 1.0))
        allowed = f"must be above 1: {reserve[1]}"
        raise InputError(source, f"lane {first + lane}", float(reserve[0][lane]), allowed)
    if engine.order is None:
        return
    step = engine.longest_step(lanes, motions)
    # A lane whose sizes are not finite takes one step to find that out.
    long = times.duration > most_steps * step
    if not long.any():
        return
    lane = int(np.argmax(long))
    needed = times.duration / float(step[lane])
    allowed = (
        f"must be at most {most_steps:.0e} steps: {engine.name} would step by "
        f"{float(step[lane]):.2g} s for {times.duration:g} s; give it "
    )
    cure = "a longer time step, or a shorter run"
    if step[lane] < engine.settings.time_step:
        cure = "heavier or larger blocks, softer contacts, or a shorter run"
    raise InputError(source, f"lane {first + lane}", Said(f"{needed:.2g} steps"), allowed + cure)


def step_limit(
    motions: GroundMotions,
    duration: float,
    longest_step: npt.NDArray[np.float64],
    spare: float,
    extra: int = 0,
) -> npt.NDArray[np.int64]:
    """Steps after which a lane of an engine that goes from event to event counts as stalled.

    Args:
        motions: The ground motions.
        duration: Of the run [s].
        longest_step: Longest step of every lane [s], shape [lane].
        spare: Steps allowed for every step that a run without events would take.
        extra: Other times at which steps end.

    Returns:
        Shape [lane]; 0 where sizes are not finite.
    """
    steps = duration / longest_step + extra + motions.knot_count
    return np.where(np.isfinite(steps), spare * (steps + 100.0), 0.0).astype(np.int64)
