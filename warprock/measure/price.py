"""What an error costs: block B0 in free rocking, from nine starts, in everything that can run it.

A run from one start may be right by luck, as errors of an impact and of the next one cancel: the
error of a setting is the median over the starts of the largest error over 5 s. Of each engine,
program and plain loop several settings are tried, and the price of an error is the cost of the
cheapest one that meets it. There are two costs of a simulated second of one block, both CPU time
on one core: that of one block of many, and that of a block alone, which pays for the call.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines import preferred_engines, reference_engine
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import StillBase
from warprock.model.response import SampleTimes
from warprock.running.batch import LANE_QUANTUM, run_batch
from warprock.settings.engines import SETTINGS, EventSettings

Array = npt.NDArray[np.float64]

LEVELS = (1e-2, 1e-3, 1e-4, 1e-5)
"""Errors whose price is told, over the slenderness angle."""

STARTS = np.arange(1, 10) / 10.0
"""Rotations from which the block is let go, over the slenderness angle."""

TIMES = SampleTimes(5.0, 0.01)
"""The time of the paper's Fig. 5; programs of others have frames at the samples."""

B0_WIDTH, B0_HEIGHT, B0_DEPTH, B0_DENSITY, B0_FRICTION = 1.0, 5.0, 0.2, 2670.0, 1.0
"""Block B0 [m, kg/m^3] of the paper's Section 4."""

SUBSTEPS = (1, 3, 9, 19, 39, 79, 199, 399, 799, 1599)
"""Sub-steps of a frame that the engines with frames are tried with."""

OWN_SETTINGS: dict[str, tuple[Any, ...]] = {
    "event": tuple(EventSettings(time_step=step) for step in (0.1, 5e-2, 2e-2, 1e-2, 5e-3)),
    **{
        name: tuple(SETTINGS[name](substeps=count) for count in SUBSTEPS)
        for name in ("impulse", "direct", "xpbd")
    },
}
"""Settings tried of an engine, from coarse to fine; its defaults where it has none here."""

AGAINST = preferred_engines()[0]
"""Engine whose costs the others' are held against."""

LANES_MOST = 2**18
"""Lanes up to which a measurement that would be too short takes more of them."""

REPEATS = 3
"""Runs of each measurement; the fastest counts, the others met other work on the machine."""

REPEATS_ALONE = 30
"""The same of a block alone, which takes a millisecond."""


@dataclasses.dataclass(frozen=True)
class Trial:
    """What one setting gave.

    Attributes:
        name: Engine, program or loop.
        settings: In words.
        error: Median over the starts of the largest |rotation - housner| / slenderness angle.
        error_most: The largest over the starts.
        cost: CPU time of a simulated second of one block of many [s].
        cost_alone: The same of a block alone [s].
        steps_per_s: Steps of a block in a simulated second; None without a fixed step.
    """

    name: str
    settings: str
    error: float
    error_most: float
    cost: float
    cost_alone: float
    steps_per_s: float | None = None


def b0_lanes(ratios: Array) -> Lanes:
    """Blocks B0, let go from some ratios of the slenderness angle, shape [lane]."""
    count = len(ratios)
    width, height = np.full(count, B0_WIDTH), np.full(count, B0_HEIGHT)
    angle = rocking.slenderness_angle(width, height)
    return Lanes(
        width=width,
        height=height,
        depth=np.full(count, B0_DEPTH),
        density=np.full(count, B0_DENSITY),
        friction=np.full(count, B0_FRICTION),
        chamfer=np.zeros(count),
        offset=np.zeros(count),
        rotation_start=angle * ratios,
        angular_restitution=rocking.angular_restitution(angle),
    )


def start_errors(rotation: Array) -> Array:
    """Largest |rotation - housner| / slenderness angle over the samples, shape [start].

    Args:
        rotation: Rotations from `STARTS` at `TIMES` [rad], shape [start, sample].

    Raises:
        ValueError: Another shape.
    """
    lanes = b0_lanes(STARTS)
    right = run_batch(reference_engine(), lanes, StillBase(len(STARTS)), TIMES)["rotation"]
    if rotation.shape != right.shape:
        raise ValueError(f"rotation: got shape {rotation.shape}, must be {right.shape}")
    return np.asarray(np.abs(rotation - right).max(axis=1) / lanes.slenderness_angle)


def own_trials(engine: str, seconds: float, levels: Sequence[float] = LEVELS) -> list[Trial]:
    """Settings of one of our engines: of each level the coarsest that meets it.

    The error of the reference, against which the others are held, is NaN.

    Args:
        engine: Name in `ENGINES`.
        seconds: Time of each measurement of a cost, about [s].
        levels: Errors to meet.
    """
    lanes, reference = b0_lanes(STARTS), reference_engine()
    trials: list[Trial] = []
    left = sorted(levels, reverse=True)
    for settings in OWN_SETTINGS.get(engine, (None,)):
        found = run_batch(engine, lanes, StillBase(len(STARTS)), TIMES, settings=settings)
        errors = start_errors(found["rotation"])
        error = float(np.median(errors))
        met = engine == reference or error <= left[0]
        if not met:
            continue
        cost, alone = _costs(engine, settings, seconds)
        step = getattr(settings, "time_step", None)
        said = (math.nan, math.nan) if engine == reference else (error, float(errors.max()))
        rate = None if step is None else 1.0 / step
        trials.append(Trial(engine, _text(settings), *said, cost, alone, rate))
        left = [level for level in left if error > level]
        if not left:
            break
    return trials


def _text(settings: Any) -> str:
    """Settings of ours in words."""
    if settings is None:
        return "defaults"
    if isinstance(settings, EventSettings):
        return f"steps of {settings.time_step:g} s"
    return f"{settings.frames_per_second:g} x {settings.substeps + 1} steps/s"


def _costs(engine: str, settings: Any, seconds: float) -> tuple[float, float]:
    """CPU time of one simulated second of one block B0 [s]: one of many, and alone.

    The many start from all over the range of `STARTS`, so that those of a pack do not meet their
    impacts together.
    """

    def run(count: int) -> float:
        ratios = np.linspace(STARTS[0], STARTS[-1], count) if count > 1 else np.array([0.5])
        lanes, motions, times = b0_lanes(ratios), StillBase(count), SampleTimes(TIMES.duration)
        begin = time.process_time()
        run_batch(engine, lanes, motions, times, settings=settings, workers=1, chunk_size=count)
        return time.process_time() - begin

    def fastest(count: int, took: float, repeats: int) -> float:
        spent = took
        for _ in range(repeats - 1):
            if spent > 0.5 * seconds:
                break
            again = run(count)
            spent, took = spent + again, min(took, again)
        return took / (count * TIMES.duration)

    count = LANE_QUANTUM
    while (took := run(count)) < 0.25 * seconds / REPEATS and count < LANES_MOST:
        count *= 4
    return fastest(count, took, REPEATS), fastest(1, run(1), REPEATS_ALONE)


def price_rows(trials: Iterable[Trial], levels: Sequence[float] = LEVELS) -> list[dict[str, Any]]:
    """The cheapest setting of each that meets each error, beside that of `AGAINST`.

    Args:
        trials: Of everything that ran.
        levels: Errors to meet.

    Returns:
        error_met, name, settings, error, error_most, cpu_s_per_simulated_s (one block of many),
        cpu_s_per_simulated_s_alone, and both over those of `AGAINST` at that error; a row a level
        and name, without a cost where no setting met it.
    """
    by_name: dict[str, list[Trial]] = {}
    for trial in trials:
        by_name.setdefault(trial.name, []).append(trial)
    rows = []
    for level in levels:
        base = _best(by_name.get(AGAINST, []), level, "cost")
        base_alone = _best(by_name.get(AGAINST, []), level, "cost_alone")
        for name, mine in by_name.items():
            best = _best(mine, level, "cost")
            alone = _best(mine, level, "cost_alone")
            row: dict[str, Any] = {"error_met": level, "name": name}
            if best is not None and alone is not None:
                row |= {
                    "settings": best.settings,
                    "error": best.error,
                    "error_most": best.error_most,
                    "cpu_s_per_simulated_s": best.cost,
                    "cpu_s_per_simulated_s_alone": alone.cost_alone,
                }
                if base is not None and base_alone is not None:
                    row[f"cost / {AGAINST}"] = best.cost / base.cost
                    row[f"cost / {AGAINST}_alone"] = alone.cost_alone / base_alone.cost_alone
            rows.append(row)
    return rows


def _best(trials: Iterable[Trial], level: float, cost: str) -> Trial | None:
    """The trial of the least cost that meets an error; NaN is the error of the reference."""
    met = [trial for trial in trials if not trial.error > level]
    return min(met, key=lambda trial: float(getattr(trial, cost)), default=None)
