"""The motion of a floor or an isolator under a block: a linear oscillator before the ground motion.

With the acceleration a of the ground, the natural frequency w, the damping ratio z and the height
factor c (participation factor times the mode at the floor; 1 for an isolator),

    q'' + 2 z w q' + w^2 q = -a,      floor: a + c q'' = (1 - c) a - c (2 z w q' + w^2 q).

q = Im(y) / w_d, where y' = (-z w + i w_d) y - a and w_d = w sqrt(1 - z^2). From sample to sample y
is known but for round-off: exactly for linear pieces (Nigam and Jennings 1969), by Gauss's rule
with eight nodes for others. Between samples the floor's acceleration is taken as linear.

References:
    N. C. Nigam and P. C. Jennings (1969), Calculation of response spectra from strong-motion
    earthquake records, Bulletin of the Seismological Society of America 59.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from warprock.model.lane_motion import Array, LaneMotions
from warprock.model.record_motion import RecordMotions

SAMPLES = 100
"""Samples in a period of the floor, or of the motion where that is shorter: between them a sine is
off by at most (2 pi / SAMPLES)^2 / 8 = 5e-4 of its amplitude."""

MOST_SAMPLES = 40_000_000
"""Samples of all floors of a case together: 1.3 GB."""

NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclasses.dataclass(frozen=True)
class Floors:
    """Oscillators of lanes, shape [lane] each.

    Attributes:
        frequency: Natural frequency [Hz].
        damping: Damping ratio [-], below 1.
        height_factor: c [-].
    """

    frequency: Array
    damping: Array
    height_factor: Array


def sample_intervals(motions: LaneMotions, floors: Floors) -> Array:
    """Time between samples of the floors' motions [s], shape [lane]: a part of the ground's."""
    wanted = np.minimum(1.0 / floors.frequency, motions.shortest_period) / SAMPLES
    whole = np.asarray(motions.knot_interval) + np.zeros(motions.lane_count)
    whole = np.where(np.isfinite(whole), whole, np.maximum(motions.end - motions.start, wanted))
    return np.asarray(whole / np.ceil(whole / wanted))


def floor_sample_counts(
    motions: LaneMotions, floors: Floors, duration: Array
) -> npt.NDArray[np.int64]:
    """Samples of the floor's motion of every lane until the end of its run, shape [lane]."""
    left = np.maximum(duration - motions.start, 0.0)
    return np.asarray(left / sample_intervals(motions, floors) * (1.0 + 1e-12), np.int64) + 1


def floor_motions(
    motions: LaneMotions, floors: Floors, duration: Array
) -> tuple[RecordMotions, Array]:
    """The motions of floors on a base that moves, and how far they move against it.

    Args:
        motions: Ground motions of lanes, without velocity steps at their stop where a height factor
            is not 1.
        floors: Their floors.
        duration: Of each run [s], shape [lane]; the motion ends there.

    Returns:
        The motions, and the largest displacement |c q| of each floor against the ground at its
        samples [m], shape [lane]: between them it is larger by at most 5e-4 of it.
    """
    intervals = sample_intervals(motions, floors)
    counts = floor_sample_counts(motions, floors, duration)
    parts, ways = [], np.zeros(motions.lane_count)
    for lane in range(motions.lane_count):
        part, ways[lane] = _floor(motions, floors, lane, float(intervals[lane]), int(counts[lane]))
        parts.append(part)
    first, _ = motions.velocity_steps
    offset = np.concatenate([[0], np.cumsum(counts)[:-1]])
    acceleration, slope, velocity = np.concatenate(parts, axis=1)
    floor = RecordMotions(
        start=motions.start,
        scale=np.ones(motions.lane_count),
        offset=offset.astype(np.int32),
        count=counts.astype(np.int32),
        interval=intervals,
        velocity_step_start=(1.0 - floors.height_factor) * first,
        velocity_step_stop=np.zeros(motions.lane_count),
        pool_acceleration=acceleration,
        pool_slope=slope,
        pool_velocity=velocity,
    )
    return floor, ways


def _floor(
    motions: LaneMotions, floors: Floors, lane: int, interval: float, count: int
) -> tuple[Array, float]:
    """One floor at its samples.

    Returns:
        Acceleration, slope and velocity, shape [3, sample], and the largest |c q| [m].
    """
    from scipy.signal import lfilter

    w, z = 2.0 * math.pi * float(floors.frequency[lane]), float(floors.damping[lane])
    c, start = float(floors.height_factor[lane]), float(motions.start[lane])
    damped = w * math.sqrt(1.0 - z * z)
    pole = complex(-z * w, damped)
    times: Array = start + interval * np.arange(count, dtype=np.float64)
    inside = 0.5 * interval * (1.0 + NODES)
    pull = motions.acceleration((times[:-1, None] + inside).ravel(), lane)
    driven = pull.reshape(count - 1, len(NODES)) @ (
        -0.5 * interval * WEIGHTS * np.exp(pole * (interval - inside))
    )
    first, last = (float(step[lane]) for step in motions.velocity_steps)
    kicks = np.zeros(count)
    kicks[0] = first
    stop = round((float(motions.end[lane]) - start) / interval)
    if last and 0 < stop < count:
        kicks[stop] += last
    # What a step of the velocity leaves is there just after its sample.
    y: npt.NDArray[np.complex128] = lfilter(
        [1.0], [1.0, -np.exp(pole * interval)], np.concatenate([[0.0], driven]) - kicks
    )
    before: npt.NDArray[np.complex128] = y + kicks

    def floor(state: npt.NDArray[np.complex128], ground: Array) -> Array:
        spring = 2.0 * z * w * (pole * state).imag + w * w * state.imag
        return np.asarray((1.0 - c) * ground - c * spring / damped)

    near = np.float64(1e-9 * interval)
    begin = floor(y[:-1], motions.acceleration(np.asarray(times[:-1] + near), lane))
    end = floor(before[1:], motions.acceleration(np.asarray(times[1:] - near), lane))
    moved = np.concatenate([[(1.0 - c) * first], 0.5 * interval * (begin + end)])
    velocity = np.cumsum(moved)
    # The last sample starts no segment.
    slope = np.append((end - begin) / interval, 0.0)
    way = c * float(np.abs(y.imag).max()) / damped
    return np.stack([np.append(begin, 0.0), slope, velocity]), way
