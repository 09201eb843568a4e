"""Runs a case with one engine: case -> lanes -> engine -> response.

Everything that can be refused is refused here, before a kernel is built.
"""

from __future__ import annotations

import dataclasses
import functools
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from warprock.arguments import at_the_door
from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.engines import ENGINES, engine_class
from warprock.engines.workload import require_workload
from warprock.errors import NOTHING, InputError, list_allowed
from warprock.model.response import Response, SampleTimes, join_responses, take_lanes
from warprock.model.words import lane_count_text
from warprock.running.batch import require_room, run_batch
from warprock.running.devices import require_device
from warprock.running.lane_parts import Part, run_parts
from warprock.running.machine import require_workers
from warprock.running.options import DEFAULT_OPTIONS, RunOptions
from warprock.running.tolerance import run_at_step, run_to_tolerance
from warprock.running.waiting import Forecast

PRECISIONS = ("float64", "float32")


@dataclasses.dataclass(frozen=True, repr=False)
class CaseRun:
    """One case, run by one engine, with what is needed to run it again.

    Attributes:
        case: The case.
        lane_set: Its lanes, motions and inputs.
        response: The engine's answer.
        options: How it was run.
        settings: Settings dataclass of the engine, with the step asked for.
        wall_time: Time that the batch took [s], kernel build included.

    Example:
        >>> import warprock as wr
        >>> run = wr.run_case(wr.load_case("free-b0"), "housner")
        >>> run.settings.__class__.__name__, run.options.precision
        ('HousnerSettings', 'float64')
    """

    case: Case
    lane_set: LaneSet
    response: Response
    options: RunOptions
    settings: Any
    wall_time: float

    def __repr__(self) -> str:
        lanes = self.response.lane_count
        return f"<run of {self.case.name}: {self.response.engine}, {lane_count_text(lanes)}>"


@at_the_door
def run_case(
    case: Case,
    engine: str,
    options: RunOptions = DEFAULT_OPTIONS,
    *,
    histories: bool | None = None,
) -> CaseRun:
    """Runs every lane of a case with one engine.

    Args:
        case: The case.
        engine: Name of the engine.
        options: How its lanes are run. With a tolerance every lane has an estimated error, and runs
            again at finer steps until that is within the tolerance. Without one every lane runs
            once, at the step of the case.
        histories: Whether to keep sampled histories; None does as the case says.

    Returns:
        The case, its lanes and the response.

    Raises:
        InputError: An option is not one of those allowed, or the engine cannot do the scene.

    Example:
        >>> import warprock as wr
        >>> wr.run_case(wr.load_case("free-b0"), "housner")
        <run of free-b0: housner, 2 lanes>
    """
    require_options(engine, options)
    lane_set = expand_lanes(case)
    require_support(case, lane_set, engine)
    times = _sample_times(case, histories)
    blocks = lane_set.lanes.lane_count * lane_set.lanes.block_count
    require_room(blocks, times, case.source_of("run.sample_interval"))
    started = time.perf_counter()
    settings = case.engine_settings(engine)
    response = run_lane_set(engine, lane_set, times, options, settings=settings)
    return CaseRun(
        case=case,
        lane_set=lane_set,
        response=response,
        options=options.without_progress(),
        settings=settings,
        wall_time=time.perf_counter() - started,
    )


def run_lane_set(
    engine: str,
    lane_set: LaneSet,
    times: SampleTimes,
    options: RunOptions = DEFAULT_OPTIONS,
    *,
    settings: Any,
) -> Response:
    """Runs lanes of a case with one engine.

    Args:
        engine: Name of the engine.
        lane_set: The lanes, all of a case or some.
        times: Sampling of the histories; how long lanes run is said by the lanes.
        options: How they are run.
        settings: Settings of the engine.
    """

    def run(part: Part, options: RunOptions) -> Response:
        batch = (engine, part.lanes, part.motions, part.times)
        if options.tolerance is None:
            watched = options.watched_by(Forecast(part.lanes.lane_count))
            return run_batch(*batch, settings=part.settings, **watched.of_batch)
        return run_to_tolerance(*batch, options, settings=part.settings)

    return run_parts(run, lane_set, None, times, settings, options)


def run_lane(run: CaseRun, lane: int) -> Response:
    """Runs one lane of a finished run again, alone, with histories, as `run_lanes` does."""
    return run_lanes(run, [lane])


def run_lanes(run: CaseRun, lanes: Sequence[int]) -> Response:
    """Runs some lanes of a finished run again, with histories, each at the step of its numbers.

    A lane's numbers do not depend on the batch around it, so these are the same lanes.

    Args:
        run: The finished run.
        lanes: Numbers of the lanes, from 0; their order is that of the response.

    Raises:
        InputError: There is no such lane, or the case does not say how to sample histories.
    """
    require_histories(run.case, lanes)
    chosen = np.asarray(lanes, dtype=np.intp)
    fields = run.response.fields
    # Without an estimate all lanes ran at the step of the settings.
    steps = fields["time_step"][chosen] if "time_step" in fields else np.zeros(len(chosen))
    parts, places = [], []
    for step in np.unique(steps):
        places.append(np.flatnonzero(steps == step))
        run_again = functools.partial(_run_again, run, float(step))
        part, times = chosen[places[-1]], dataclasses.replace(run.case.sample_times, places=True)
        parts.append(run_parts(run_again, run.lane_set, part, times, run.settings, run.options))
    return take_lanes(join_responses(parts), np.argsort(np.concatenate(places)))


def _run_again(run: CaseRun, step: float, part: Part, options: RunOptions) -> Response:
    """Runs lanes of a finished run once, with histories, at a step; 0 is that of the settings."""
    batch = (run.response.engine, part.lanes, part.motions, part.times)
    if step > 0.0:
        return run_at_step(*batch, options, step=step, settings=part.settings)
    return run_batch(*batch, settings=part.settings, **options.of_batch)


def require_options(engine: str | None, options: RunOptions = DEFAULT_OPTIONS) -> None:
    """Refuses options of a run that are not among those allowed; no engine is one, too.

    Raises:
        InputError: Unknown engine, precision or device, or a number of workers or a tolerance out
            of bounds.
    """
    if engine is not None:
        require_choice("--engine", engine, tuple(ENGINES))
    require_choice("--precision", options.precision, PRECISIONS)
    require_workers(options.workers)
    require_device(options.device)
    if options.tolerance is not None:
        require_tolerance(options.tolerance)


def require_tolerance(tolerance: float) -> None:
    """Refuses a tolerance that is out of bounds.

    Raises:
        InputError: It is not above 0 and below 1.
    """
    if not 0.0 < tolerance < 1.0:
        allowed = "must be > 0 and < 1, an error of the rotation over the slenderness angle"
        raise InputError("--tolerance", "", tolerance, allowed)


def require_choice(source: str, got: str, allowed: tuple[str, ...]) -> None:
    """Refuses a value that is not among those allowed.

    Raises:
        InputError: It is not.
    """
    if got not in allowed:
        raise InputError(source, "", got, f"allowed: {list_allowed(got, allowed)}")


def require_support(case: Case, lane_set: LaneSet, engine: str, first: int = 0) -> None:
    """Refuses a scene that the engine cannot do, and lanes that it cannot run to their end.

    Args:
        case: The case.
        lane_set: Its lanes, or some that follow one another.
        engine: Name of the engine, which runs with the settings of the case.
        first: Number of the first of the lanes.

    Raises:
        InputError: It cannot, with the engine's reason.
    """
    built = engine_class(engine)(case.engine_settings(engine))
    reason = built.supports(lane_set.scene) or built.refuses(lane_set.scene)
    if reason is not None:
        raise InputError(case.file, "--engine", engine, f"cannot do this scene: {reason}")
    require_workload(
        built,
        lane_set.lanes,
        lane_set.motions,
        case.sample_times,
        source=case.file,
        first=first,
    )


def require_histories(case: Case, lanes: Sequence[int]) -> None:
    """Refuses histories of lanes that the case does not have, or does not say how to sample.

    Raises:
        InputError: There is no such lane, or the case has no sample interval.
    """
    count = case.lane_count
    for lane in lanes:
        if not 0 <= lane < count:
            raise InputError("--history", "", lane, f"must be a lane from 0 to {count - 1}")
    if lanes:
        _sample_times(case, histories=True)


def _sample_times(case: Case, histories: bool | None) -> SampleTimes:
    times = case.sample_times
    if histories is False:
        return SampleTimes(times.duration)
    if histories and times.interval is None:
        raise InputError(
            case.file, "run.sample_interval", NOTHING, "must be given where histories are wanted"
        )
    return times
