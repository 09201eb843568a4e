"""Which lanes a run leaves undecided: it ended before their blocks had fallen or come to stand.

A block that has not fallen may still do so while its base moves, and while it rocks: it is known to
stand once it has come to rest on a base whose motion is over. A single block in the plane is known
to stand earlier. At rest it stays where what is left of its record is too weak to lift a rigid
block, below g tan(slenderness angle) (Housner 1963; not in `dem`, whose springs can lift it). On a
base that is still it loses energy in every impact, so that one which has swung back stays up; it
falls within its first two swings or not at all. A swing takes long only where it comes close to the
point of balance, about 2 ln(2 / e) / p where it misses that by a part e: `SWUNG` / p leaves a part
of 1e-6.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes
from warprock.model.motion import (
    GroundMotions,
    PlanarMotions,
    RecordMotions,
    SpatialMotions,
    StillBase,
)
from warprock.model.response import USABLE, Outcome, Response
from warprock.model.rocking import frequency_parameter, uplift_acceleration

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

SWUNG = 30.0
"""Time on a base that is still, times the frequency parameter p, after which a single block in the
plane that rocks stays up."""

SPRINGS = "dem"
"""Engine whose blocks stand on springs, on which they lift below g tan(slenderness angle)."""

UNDECIDED = "undecided"
"""Column of the lane table that says so."""
UNDECIDED_TEXT = (
    "Whether the run ended before it was known if the blocks stand: they still moved, or their "
    "ground motion was not over and strong enough to lift them"
)

_MOVING = (
    "acceleration_amplitude", "velocity_step_start", "velocity_step_stop", "velocity_offset",
    "velocity_final", "c0", "c1", "c2", "c3", "swing_1", "swing_2", "swing_3",
)  # fmt: skip
"""Attributes of pulses of which one is not zero where the base moves, of one kind or another."""
_ROUND_OFF = 1e-9
"""Part of its length by which a run may be shorter than its motion and still be as long."""


def motion_end(motions: GroundMotions) -> Array:
    """Time at which the base of every lane has come to its last motion [s], shape [lane].

    That of a record is its last sample, that of a pulse its stop; 0 where the base does not move.
    """
    if isinstance(motions, SpatialMotions):
        return np.asarray(np.max([_end(part) for part in motions.components], axis=0))
    return _end(motions)


def _end(motions: PlanarMotions) -> Array:
    if isinstance(motions, StillBase):
        return np.zeros(motions.lane_count)
    if isinstance(motions, RecordMotions):
        last = motions.start + (motions.count - 1) * motions.interval
        return np.where(motions.scale != 0.0, last, 0.0)
    parts = [getattr(motions, name) != 0.0 for name in _MOVING if hasattr(motions, name)]
    return np.where(np.any(parts, axis=0), motions.stop, 0.0)


def cut_short(motions: GroundMotions, duration: float) -> Mask:
    """Whether a run ends before the ground motion of a lane does, shape [lane]."""
    return np.asarray(motion_end(motions) > duration * (1.0 + _ROUND_OFF))


def left_acceleration(motions: RecordMotions, duration: float) -> Array:
    """Largest acceleration of the base that a run leaves out [m/s^2], shape [lane].

    Infinite where a velocity step is left out.
    """
    passed = np.floor((duration - motions.start) / motions.interval).astype(np.intp)
    first = motions.offset + np.clip(passed, 0, motions.count - 1)
    ends, end = np.unique(
        np.stack([first, motions.offset + motions.count], axis=1), axis=0, return_inverse=True
    )
    largest = np.array([np.abs(motions.pool_acceleration[a:b]).max() for a, b in ends])
    left = np.abs(motions.scale) * largest[end.reshape(-1)]
    steps = (motions.velocity_step_stop != 0.0) | (
        (motions.velocity_step_start != 0.0) & (motions.start > duration)
    )
    return np.where(cut_short(motions, duration) & steps, np.inf, left)


def undecided(response: Response, lanes: Lanes, motions: GroundMotions, duration: float) -> Mask:
    """Which lanes have neither fallen nor come to stand, shape [lane].

    Args:
        response: What became of the lanes.
        lanes: Their blocks.
        motions: Their ground motions.
        duration: Of the run [s].
    """
    outcome = response["outcome"]
    upright = np.isin(outcome, [Outcome.AT_REST, Outcome.ROCKING])
    rocks, cut = outcome == Outcome.ROCKING, cut_short(motions, duration)
    may_fall = rocks | cut
    if not (lanes.stacked or lanes.spatial):
        free = (duration - motion_end(motions)) * frequency_parameter(lanes.width, lanes.height)
        may_fall = cut | (rocks & (free < SWUNG))
        if cut.any() and isinstance(motions, RecordMotions) and response.engine != SPRINGS:
            lifts = uplift_acceleration(lanes.width, lanes.height)
            may_fall &= rocks | (left_acceleration(motions, duration) >= lifts)
    usable = np.isin(response["status"], USABLE)
    return np.asarray(usable & upright & may_fall)


def cut_text(motions: GroundMotions, duration: float) -> str:
    """That a run ends before its ground motions do, in words; empty where it does not."""
    cut = cut_short(motions, duration)
    if not cut.any():
        return ""
    ends = motion_end(motions)[cut]
    when = f"{ends.min():.6g} s"
    if ends.max() > ends.min():
        when = f"{ends.min():.6g} to {ends.max():.6g} s"
    return (
        f"the run ends at {duration:.6g} s, before the ground motion of {int(cut.sum()):,} of "
        f"{len(cut):,} lanes ({when}): blocks that have not fallen by then are undecided"
    )
