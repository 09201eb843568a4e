"""A table that tilts slowly, as a base that accelerates.

On a table that is tilted by an angle tau, seen from it, weight has the components g sin(tau) along
it and g cos(tau) across: cos(tau) times those of a level base that accelerates at g tan(tau). What
holds or collapses by statics is the same on either. What moves is the same, too, but for the
square root of cos(tau), by which times are longer on the tilted table. So lanes follow the
acceleration g tan(tau) on a level base; the rotation of the table itself moves nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warprock.model.lane_motion import Array
from warprock.model.loads import LoadMotions
from warprock.units import GRAVITY

STEEPEST = np.radians(75.0)
"""Largest tilt; from there on a sideways load of a few times the weight says nothing any more."""

STEP = np.radians(0.05)
"""Tilt between two samples: between them the tangent is straight to 4e-6 of g at 60 degrees. A
pause begins and ends within one of them."""


class Tilting(NamedTuple):
    """How tables tilt, one value a lane each.

    Attributes:
        rate: Angular velocity [rad/s], positive where the side at +x sinks.
        start: When the table begins to tilt [s].
        step: Tilt after which it pauses, and again [rad].
        pause: How long it pauses [s]; 0 without pauses.
        most: Tilt at which it stays [rad]; infinite where it tilts until the run ends.
    """

    rate: Array
    start: Array
    step: Array
    pause: Array
    most: Array

    def angle(self, times: Array) -> Array:
        """|Tilt| at some times, one a lane [s], shape [lane] or [sample, lane]."""
        speed, tau = np.abs(self.rate), np.maximum(times - self.start, 0.0)
        cycle = self.step / speed + self.pause
        turns = np.floor(tau / cycle)
        since = np.minimum(speed * (tau - turns * cycle), self.step)
        return np.asarray(np.minimum(turns * self.step + since, self.most))


def steady(rate: Array, start: Array) -> Tilting:
    """Tables that tilt at an even rate until the run ends, shape [lane] each; see `Tilting`."""
    never, step = np.full(len(rate), np.inf), np.full(len(rate), STEEPEST)
    return Tilting(rate, start, step, np.zeros(len(rate)), never)


def tilt_motions(tilting: Tilting, end: Array) -> LoadMotions:
    """Tables that tilt.

    Args:
        tilting: How.
        end: When the run ends [s], shape [lane]; the table tilts on until then.
    """
    rate, start = tilting.rate, tilting.start
    columns = [np.abs(rate), end - start, *tilting[2:]]
    kinds, of_lane = np.unique(np.stack(columns), axis=1, return_inverse=True)
    pools, counts = [], []
    for speed, last, step, pause, most in kinds.T:
        interval = STEP / speed
        count = max(int(np.ceil(last / interval)), 1) + 1
        own = Tilting(speed, np.zeros(1), step, pause, most)
        angle = own.angle(interval * np.arange(count + 1))
        acceleration = GRAVITY * np.tan(np.minimum(angle, STEEPEST))
        slope = np.append(np.diff(acceleration) / interval, 0.0)
        means = 0.5 * (acceleration[1:] + acceleration[:-1])
        velocity = np.concatenate([[0.0], interval * np.cumsum(means)])
        pools.append(np.stack([acceleration, slope, velocity]))
        counts.append(count + 1)
    offset = np.concatenate([[0], np.cumsum(counts)[:-1]])
    lanes, pool = of_lane.reshape(-1), np.concatenate(pools, axis=1)
    nothing = np.zeros(len(rate))
    return LoadMotions(
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
