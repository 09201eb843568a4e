"""A batch: lanes and what they run under."""

from __future__ import annotations

from typing import NamedTuple

from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import SampleTimes


class Batch(NamedTuple):
    """What an engine runs at once.

    Attributes:
        lanes: The lanes.
        motions: Ground motions of the same lanes.
        times: Duration and sampling.
    """

    lanes: Lanes
    motions: GroundMotions
    times: SampleTimes
