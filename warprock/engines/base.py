"""The contract that every engine keeps."""

from __future__ import annotations

import abc
from typing import Any, ClassVar

from warprock.lanes import Lanes
from warprock.motion import GroundMotions
from warprock.response import Response, SampleTimes


class AbstractEngine(abc.ABC):
    """A scheme that turns lanes and their ground motions into a response.

    An engine is built from a frozen settings dataclass (`settings_type`), a precision and a
    device. Trouble in one lane is a value of that lane's status and never disturbs another.
    """

    name: ClassVar[str]
    """Key in `ENGINES`."""
    order: ClassVar[int | None]
    """Order in the time step of the error after impacts; None if the step is not the knob."""
    settings_type: ClassVar[type[Any]]
    """Frozen dataclass of the engine's settings."""

    @abc.abstractmethod
    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread.

        Args:
            lanes: Blocks and starts, shape [lane].
            motions: Ground motions of the same lanes.
            times: Duration and sampling.

        Returns:
            One value of every lane field a lane; `rotation` if histories were asked for.
        """
