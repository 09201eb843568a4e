"""Which lanes a run leaves undecided: it ended before their blocks had fallen or come to stand.

A block that has not fallen may still do so while its base moves, and while it rocks: it is known to
stand once it has come to rest on a base whose motion is over. A single block in the plane is known
to stand earlier. At rest it stays where what is left of its record is too weak to lift a rigid
block, below g tan(slenderness angle), with less than g on a base that falls (Housner 1963; not on
springs, which can lift it, and not where a tie may pull it). On a base that is still it loses
energy in every impact, so that one which has swung back stays up; it falls within its first two
swings or not at all. A swing takes long only where it comes close to the point of balance, about
2 ln(2 / e) / p where it misses that by a part e: `SWUNG` / p leaves a part of 1e-6.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, UprightMotions
from warprock.model.response import USABLE, Outcome, Response
from warprock.model.rocking import uplift_acceleration
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

SWUNG = 30.0
"""Time on a base that is still, times the frequency parameter p, after which a single block in the
plane that rocks stays up."""

UNDECIDED = "undecided"
"""Column of the lane table that says so."""
UNDECIDED_TEXT = (
    "Whether the run ended before it was known if the blocks stand: they still moved, or their "
    "ground motion was not over and strong enough to lift them"
)

_ROUND_OFF = 1e-9
"""Part of its length by which a run may be shorter than its motion and still be as long."""


def cut_short(motions: GroundMotions, duration: Array | float) -> Mask:
    """Whether a lane's run, of a duration [s], ends before its ground motion does, shape [lane]."""
    return np.asarray(motions.end > duration * (1.0 + _ROUND_OFF))


def undecided(
    response: Response,
    lanes: Lanes,
    motions: GroundMotions,
    duration: Array | float,
    *,
    springs: bool,
) -> Mask:
    """Which lanes have neither fallen nor come to stand, shape [lane].

    Args:
        response: What became of the lanes.
        lanes: Their blocks.
        motions: Their ground motions.
        duration: Of the run [s], shape [lane] or one for all.
        springs: Whether blocks stand on springs, on which they lift below g tan(slenderness angle).
    """
    outcome = response["outcome"]
    upright = np.isin(outcome, [Outcome.AT_REST, Outcome.ROCKING])
    rocks, cut = outcome == Outcome.ROCKING, cut_short(motions, duration)
    may_fall = rocks | cut
    if not (lanes.stacked or lanes.spatial or lanes.assembly is not None):
        free = (duration - motions.end) * lanes.frequency_parameter
        may_fall = cut | (rocks & (free < SWUNG))
        if cut.any() and not springs and lanes.hold is None:
            lifts = uplift_acceleration(lanes.width, lanes.height)
            if lanes.body is not None:
                lifts = GRAVITY * lanes.uplift_ratios.min(axis=1)
            if isinstance(motions, UprightMotions):
                # A base that falls takes weight off a block.
                lifts = lifts * (1.0 - motions.z.later_acceleration(duration) / GRAVITY)
            may_fall &= rocks | (motions.components[0].later_acceleration(duration) >= lifts)
    usable = np.isin(response["status"], USABLE)
    return np.asarray(usable & upright & may_fall)


def decided_after(lanes: Lanes, motions: GroundMotions) -> Array:
    """Duration from which on no run of a lane is undecided [s], shape [lane].

    Args:
        lanes: Single blocks in the plane.
        motions: Their ground motions.
    """
    return np.asarray(motions.end + SWUNG / lanes.frequency_parameter)


def cut_text(motions: GroundMotions, duration: Array | float) -> str:
    """That a run ends before its ground motions do, in words; empty where it does not."""
    cut = cut_short(motions, duration)
    if not cut.any():
        return ""
    when = _span(motions.end[cut])
    runs = np.broadcast_to(duration, cut.shape)[cut]
    return (
        f"the run ends at {_span(runs)}, before the ground motion of {int(cut.sum()):,} of "
        f"{len(cut):,} lane{'s' * (len(cut) != 1)} ({when}): "
        "blocks that have not fallen by then are undecided"
    )


def _span(times: Array) -> str:
    """Times in words, from the least to the greatest."""
    least, most = times.min(), times.max()
    return f"{most:.6g} s" if least == most else f"{least:.6g} to {most:.6g} s"
