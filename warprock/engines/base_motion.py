"""What the motion of a base asks of an engine, and what it can give to blocks, before any run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from warprock.engines.launching import components
from warprock.model.motion import (
    GroundMotions,
    HarmonicMotions,
    ModulatedMotions,
    PlanarMotions,
    RecordMotions,
    RickerMotions,
    StillBase,
)

Array = npt.NDArray[np.float64]

GRID = np.linspace(-6.0, 6.0, 12_001)
"""Places x at which humps x^k exp(-x^2) are looked at: their peaks to 1e-6, nothing is beyond."""
BELL = np.exp(-(GRID**2))
POWERS = np.arange(4)[:, None]
HUMP_VARIATION = np.abs(np.diff(GRID**POWERS * BELL, axis=1)).sum(axis=1)
"""Total variation of the humps k of the velocity of a Ricker pulse, see `RickerMotions`."""
HUMP_SLOPE = np.abs(
    (POWERS * GRID ** np.maximum(POWERS - 1, 0) - 2.0 * GRID ** (POWERS + 1)) * BELL
).max(axis=1)
"""Their steepest slopes."""

MOVING = (
    "acceleration_amplitude", "velocity_offset", "velocity_final", "scale", "c0", "c1", "c2", "c3"
)  # fmt: skip
"""Attributes of motions of which one is not zero where the base moves, of one kind or another."""


def fastest_rate(motions: GroundMotions) -> npt.NDArray[np.float64] | float:
    """Rate at which a motion changes [rad/s]; a record is linear between its knots."""
    if isinstance(motions, HarmonicMotions):
        return 2.0 * np.pi * motions.frequency
    if isinstance(motions, RickerMotions):
        # The highest derivative of a Gaussian that a series keeps changes the fastest.
        return 4.0 * motions.rate
    if isinstance(motions, ModulatedMotions):
        return np.asarray(2.0 * np.pi * motions.frequency * (1.0 + motions.modulation))
    return 0.0


def step_limit(
    motions: GroundMotions, duration: float, longest_step: Array, spare: float, extra: int = 0
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
    steps = duration / longest_step + extra
    for part in components(motions):
        if isinstance(part, RecordMotions):
            steps = steps + part.count
    return np.where(np.isfinite(steps), spare * (steps + 100.0), 0.0).astype(np.int64)


def moves(motions: PlanarMotions) -> npt.NDArray[np.bool_]:
    """Whether the base moves along one direction, shape [lane]."""
    if isinstance(motions, StillBase):
        return np.zeros(motions.lane_count, dtype=bool)
    parts = [getattr(motions, name) != 0.0 for name in MOVING if hasattr(motions, name)]
    return np.asarray(np.any(parts, axis=0))


def velocity_variation(motions: PlanarMotions, duration: float) -> Array:
    """At most the total variation of the base velocity until a time [m/s], shape [lane]."""
    if isinstance(motions, StillBase):
        return np.zeros(motions.lane_count)
    steps = np.abs(motions.velocity_step_start) + np.abs(motions.velocity_step_stop)
    if isinstance(motions, RecordMotions):
        moved = np.zeros(motions.lane_count)
        for lanes, begin, end in _records(motions):
            interval = motions.interval[lanes]
            sizes = np.concatenate([[0.0], np.cumsum(0.5 * (np.abs(begin) + np.abs(end)))])
            passed = np.ceil((duration - motions.start[lanes]) / interval)
            moved[lanes] = interval * sizes[np.clip(passed, 0, len(begin)).astype(int)]
        return np.asarray(np.abs(motions.scale) * (moved + steps))
    moving = np.maximum(np.minimum(motions.stop, duration) - motions.start, 0.0)
    return np.asarray(_pulse_variation(motions, moving) + steps)


def _pulse_variation(
    motions: HarmonicMotions | RickerMotions | ModulatedMotions, moving: Array
) -> Array:
    """The same for the waveform itself, which has been moving for a time [s]."""
    if isinstance(motions, RickerMotions):
        parts = np.abs([motions.c0, motions.c1, motions.c2, motions.c3])
        return np.asarray(HUMP_VARIATION @ parts)
    if isinstance(motions, HarmonicMotions):
        swing = motions.acceleration_amplitude / (2.0 * np.pi * motions.frequency)
        waves = [(swing, motions.frequency)]
    else:
        waves = list(zip(*_harmonics(motions), strict=True))
    # A swing up or down for every half cycle, begun ones too; but for round-off of whole ones.
    return np.asarray(
        sum(2.0 * np.abs(swing) * np.ceil(2.0 * f * moving - 1e-9) for swing, f in waves)
    )


def _harmonics(motions: ModulatedMotions) -> tuple[list[Array], list[Array]]:
    """Swings [m/s] and frequencies [Hz] of the three harmonics of a pulse."""
    swings = [motions.swing_1, motions.swing_2, motions.swing_3]
    m = motions.modulation
    return swings, [motions.frequency * part for part in (np.ones_like(m), 1.0 + m, 1.0 - m)]


def strongest_pull(motions: PlanarMotions) -> Array:
    """At most the largest |acceleration| of the base [m/s^2], shape [lane].

    Infinite where the base velocity steps.
    """
    if isinstance(motions, StillBase):
        return np.zeros(motions.lane_count)
    if isinstance(motions, RecordMotions):
        pull = np.zeros(motions.lane_count)
        for lanes, begin, end in _records(motions):
            pull[lanes] = np.maximum(np.abs(begin), np.abs(end)).max()
        pull = pull * np.abs(motions.scale)
    elif isinstance(motions, HarmonicMotions):
        pull = np.abs(motions.acceleration_amplitude)
    elif isinstance(motions, RickerMotions):
        parts = np.abs([motions.c0, motions.c1, motions.c2, motions.c3])
        pull = motions.rate * (HUMP_SLOPE @ parts)
    else:
        swings, frequencies = _harmonics(motions)
        pull = 2.0 * np.pi * np.sum(np.abs(swings) * np.asarray(frequencies), axis=0)
    steps = (motions.velocity_step_start != 0.0) | (motions.velocity_step_stop != 0.0)
    return np.where(steps, np.inf, pull)


def _records(motions: RecordMotions) -> Iterator[tuple[npt.NDArray[np.intp], Array, Array]]:
    """The lanes of each record; accelerations at both ends of its segments, unscaled [m/s^2]."""
    keys = np.stack([motions.offset, motions.count])
    records, of_lane = np.unique(keys, axis=1, return_inverse=True)
    for number, (offset, count) in enumerate(records.T):
        lanes = np.flatnonzero(of_lane.reshape(-1) == number)
        begin = motions.pool_acceleration[offset : offset + count]
        slope = motions.pool_slope[offset : offset + count]
        yield lanes, begin, begin + slope * motions.interval[lanes[0]]
