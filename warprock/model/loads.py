"""Sideways loads on a base that stays where it is: a slow push.

A load that is the same part of the weight of every block acts on blocks as a level base does that
accelerates the other way. Lanes follow that acceleration, and pictures show a base that stays.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from warprock.model.lane_motion import Array
from warprock.model.record_motion import RecordMotions


@dataclasses.dataclass(frozen=True)
class LoadMotions(RecordMotions):
    """Loads as accelerations of a base that stays where it is.

    Attributes:
        until: When the run ends, until which they act [s], shape [lane].
    """

    until: Array

    @property
    def end(self) -> Array:
        """Time from which on they change no further [s]."""
        return self.until


def push_motions(load: Array, rise: Array, start: Array, end: Array) -> LoadMotions:
    """Pushes: loads that rise evenly from nothing and stay.

    Args:
        load: What they rise to [m/s^2], positive towards +x, shape [lane].
        rise: Time in which they rise [s], shape [lane].
        start: When they begin [s], shape [lane].
        end: When the run ends [s], shape [lane].
    """
    kinds, of_lane = np.unique(np.stack([rise, end - start]), axis=1, return_inverse=True)
    pools, counts = [], []
    for length, last in kinds.T:
        acceleration = np.minimum(np.arange(int(np.ceil(last / length)) + 2, dtype=float), 1.0)
        slope = np.append(np.diff(acceleration) / length, 0.0)
        mean = 0.5 * length * (acceleration[1:] + acceleration[:-1])
        pools.append(np.stack([acceleration, slope, np.concatenate([[0.0], np.cumsum(mean)])]))
        counts.append(len(acceleration))
    offset = np.concatenate([[0], np.cumsum(counts)[:-1]])
    lanes, pool = of_lane.reshape(-1), np.concatenate(pools, axis=1)
    nothing = np.zeros(len(load))
    return LoadMotions(
        start=start,
        # A load towards +x is a base that accelerates towards -x.
        scale=-load,
        offset=offset[lanes].astype(np.int32),
        count=np.array(counts)[lanes].astype(np.int32),
        interval=rise,
        velocity_step_start=nothing,
        velocity_step_stop=nothing,
        pool_acceleration=pool[0],
        pool_slope=pool[1],
        pool_velocity=pool[2],
        until=end,
    )
