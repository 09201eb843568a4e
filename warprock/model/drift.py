"""Bases that a record carries away: an acceleration that was not corrected for its baseline."""

from __future__ import annotations

import numpy as np

from warprock.model.base_path import base_places
from warprock.model.motion import GroundMotions
from warprock.model.record_motion import RecordMotions

MOST_LEFT = 1.0
"""Displacement that a record may leave behind before it is said to drift [m]: the ground keeps less
in all but the largest earthquakes, and there within some kilometres of the fault."""
MOST_RECORDS = 200
"""Records that are looked at."""


def drift_text(motions: GroundMotions) -> str:
    """That a record carries the base away, and what to do, in words; empty where none does."""
    along_x = motions.components[0]
    if not isinstance(along_x, RecordMotions):
        return ""
    first = np.unique(along_x.offset, return_index=True)[1][:MOST_RECORDS]
    widest = [
        int(same[np.argmax(np.abs(along_x.scale[same]))])
        for same in (np.flatnonzero(along_x.offset == along_x.offset[k]) for k in first)
    ]
    left = [abs(float(base_places(motions, k, motions.end[[k]])[0, 0])) for k in widest]
    if max(left) <= MOST_LEFT:
        return ""
    which = "its record" if len(left) == 1 else f"lane {widest[int(np.argmax(left))]}'s record"
    return (
        f"the base ends {max(left):.3g} m from where it began, by {which}; more than "
        f"{MOST_LEFT:g} m is mostly a drift: warprock records import --step 'baseline 2', or "
        "--step 'bandpass 0.1 Hz, 25 Hz', takes it off"
    )
