"""Runs a case with one engine: case -> lanes -> engine -> response.

Everything that can be refused is refused here, before a kernel is built.
"""

from __future__ import annotations

import concurrent.futures
import dataclasses
import functools
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.engines import ENGINES, engine_class
from warprock.engines.workload import require_workload
from warprock.errors import InputError, listed
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Response, SampleTimes, join_responses, take_lanes
from warprock.quantity import NOTHING
from warprock.run.batch import require_room, run_batch
from warprock.run.devices import require_device
from warprock.run.machine import core_count, require_workers
from warprock.run.options import DEFAULT_OPTIONS, Counted, RunOptions
from warprock.run.tolerance import run_at_step, run_to_tolerance

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
        return f"<run of {self.case.name}: {self.response.engine}, {lanes:,} lanes>"


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
        options: How its lanes are run; with a tolerance the error of every lane is estimated, and
            it runs at finer steps until it is within the tolerance, without it once, at the step
            of the case.
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
        times: Length of the longest run and sampling of its histories.
        options: How they are run.
        settings: Settings of the engine.
    """

    def run(part: _Part, options: RunOptions) -> Response:
        batch = (engine, part.lanes, part.motions, part.times)
        if options.tolerance is None:
            return run_batch(*batch, settings=part.settings, **options.of_batch)
        return run_to_tolerance(*batch, options, settings=part.settings)

    return _run_parts(run, lane_set, None, times, settings, options)


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
        parts.append(_run_parts(run_again, run.lane_set, part, times, run.settings, run.options))
    return take_lanes(join_responses(parts), np.argsort(np.concatenate(places)))


@dataclasses.dataclass(frozen=True)
class _Part:
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


def _run_again(run: CaseRun, step: float, part: _Part, options: RunOptions) -> Response:
    """Runs lanes of a finished run once, with histories, at a step; 0 is that of the settings."""
    batch = (run.response.engine, part.lanes, part.motions, part.times)
    if step > 0.0:
        return run_at_step(*batch, options, step=step, settings=part.settings)
    return run_batch(*batch, settings=part.settings, **options.of_batch)


def _run_parts(
    run: Callable[[_Part, RunOptions], Response],
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
        times: Length of the longest run and sampling of its histories.
        settings: Settings of the engine, with the time step that the factors change.
        options: How they are run.
    """
    parts = _parts(lane_set, chosen, times, settings)
    if len(parts) == 1:
        return run(parts[0], options)
    workers = options.workers or core_count()
    side_by_side = min(workers, len(parts)) if options.device.startswith("cpu") else 1
    counted = Counted(options.progress)
    each = dataclasses.replace(options, workers=workers // side_by_side)

    def run_part(number: int) -> Response:
        return run(parts[number], dataclasses.replace(each, progress=counted.of(number)))

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
) -> list[_Part]:
    """The lanes wanted, by time step and duration; arguments as of `_run_parts`."""
    numbers = np.arange(lane_set.lanes.lane_count) if chosen is None else chosen
    alike = np.ones((2, len(numbers)))
    if lane_set.step_factors is not None and has_time_step(settings):
        alike[0] = lane_set.step_factors[numbers]
    alike[1] = times.duration
    if lane_set.durations is not None:
        alike[1] = lane_set.durations[numbers]
    kinds, kind = np.unique(alike, axis=1, return_inverse=True)
    by_kind = np.argsort(kind.reshape(-1), kind="stable")
    ends = np.cumsum(np.bincount(kind.reshape(-1)))
    parts = []
    for (factor, duration), places in zip(kinds.T, np.split(by_kind, ends[:-1]), strict=True):
        which = slice(None) if chosen is None and len(kinds.T) == 1 else numbers[places]
        parts.append(
            _Part(
                places,
                lane_set.lanes.take(which),
                lane_set.motions.take(which).compact(),
                dataclasses.replace(times, duration=float(duration)),
                settings if factor == 1.0 else settings.with_step_scaled(float(factor)),
            )
        )
    return parts


def has_time_step(settings: Any) -> bool:
    """Whether an engine with these settings has a time step that an ensemble can spread."""
    return hasattr(settings, "with_step_scaled")


def require_options(engine: str, options: RunOptions = DEFAULT_OPTIONS) -> None:
    """Refuses options of a run that are not among those allowed.

    Raises:
        InputError: Unknown engine, precision or device, or a number of workers or a tolerance out
            of bounds.
    """
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
        raise InputError(source, "", got, f"allowed: {listed(got, allowed)}")


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
    reason = engine_class(engine).supports(lane_set.scene)
    if reason is not None:
        raise InputError(case.file, "--engine", engine, f"cannot do this scene: {reason}")
    require_workload(
        engine_class(engine)(case.engine_settings(engine)),
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
