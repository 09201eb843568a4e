"""A table that tilts slowly, as a base that accelerates.

On a table that is tilted by an angle tau, seen from it, weight has the components g sin(tau) along
it and g cos(tau) across: cos(tau) times those of a level base that accelerates at g tan(tau). What
holds or collapses by statics is the same on either. What moves is the same, too, but for the
square root of cos(tau), by which times are longer on the tilted table. So lanes follow the
acceleration g tan(tau) on a level base; the rotation of the table itself moves nothing.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from warprock.model.lane_motion import Array
from warprock.model.record_motion import RecordMotions
from warprock.units import GRAVITY

STEEPEST = np.radians(75.0)
"""Largest tilt; from there on a sideways load of a few times the weight says nothing any more."""

STEP = np.radians(0.05)
"""Tilt between two samples: between them the tangent is straight to 4e-6 of g at 60 degrees."""


@dataclasses.dataclass(frozen=True)
class TiltMotions(RecordMotions):
    """Tilting tables; their samples are accelerations, and they stay where they are.

    Attributes:
        until: When the run ends, until which they tilt [s], shape [lane].
    """

    until: Array

    @property
    def end(self) -> Array:
        """Time from which on they tilt no further [s]."""
        return self.until


def tilt_motions(rate: Array, start: Array, end: Array) -> TiltMotions:
    """Tables that tilt at an even rate.

    Args:
        rate: Angular velocity [rad/s], positive where the side at +x sinks, shape [lane].
        start: When the table begins to tilt [s], shape [lane].
        end: When the run ends [s], shape [lane]; the table tilts on until then.
    """
    tilt = np.abs(rate) * (end - start)
    kinds, of_lane = np.unique(np.stack([np.abs(rate), tilt]), axis=1, return_inverse=True)
    pools, counts = [], []
    for speed, most in kinds.T:
        count = max(int(np.ceil(most / STEP)), 1) + 1
        angle = STEP * np.arange(count + 1)
        interval = STEP / speed
        acceleration = GRAVITY * np.tan(np.minimum(angle, STEEPEST))
        slope = np.append(np.diff(acceleration) / interval, 0.0)
        means = 0.5 * (acceleration[1:] + acceleration[:-1])
        velocity = np.concatenate([[0.0], interval * np.cumsum(means)])
        pools.append(np.stack([acceleration, slope, velocity]))
        counts.append(count + 1)
    offset = np.concatenate([[0], np.cumsum(counts)[:-1]])
    lanes, pool = of_lane.reshape(-1), np.concatenate(pools, axis=1)
    nothing = np.zeros(len(rate))
    return TiltMotions(
        start=start,
        # What slides down a table whose side at +x sinks goes to +x: its base pulls to -x.
        scale=-np.sign(rate),
        offset=offset[lanes].astype(np.int32),
        count=np.array(counts)[lanes].astype(np.int32),
        interval=STEP / np.abs(rate),
        velocity_step_start=nothing,
        velocity_step_stop=nothing,
        pool_acceleration=pool[0],
        pool_slope=pool[1],
        pool_velocity=pool[2],
        until=end,
    )
