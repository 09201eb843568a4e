"""The contract that every engine keeps."""

from __future__ import annotations

import abc
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from warprock.engines.launching import Kernel, Target
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Response, SampleTimes
from warprock.model.scene import SceneKind


class AbstractEngine(abc.ABC):
    """A scheme that turns lanes and their ground motions into a response.

    An engine is built from a frozen settings dataclass (`settings_type`), a precision and a
    device. Trouble in one lane is a value of that lane's status and never disturbs another.
    """

    name: ClassVar[str]
    """Key in `ENGINES`."""
    order: ClassVar[int | None]
    """Order in the time step of the error after impacts; None if the step is not the knob."""
    slides: ClassVar[bool] = True
    """Whether its blocks can slide, so that its law of contact may have several solutions."""
    rests_exactly: ClassVar[bool] = False
    """Whether a block at rest does not move at all, until its base lifts it or makes it slide."""
    settings_type: ClassVar[type[Any]]
    """Frozen dataclass of the engine's settings."""
    settings: Any
    """Its settings."""
    target: Target
    """Precision, device and form of its kernel."""

    @abc.abstractmethod
    def __init__(self, settings: Any = None, target: Target | None = None) -> None:
        """Builds the engine with default settings on the CPU unless told otherwise."""

    @classmethod
    @abc.abstractmethod
    def supports(cls, scene: SceneKind) -> str | None:
        """Why the engine cannot run a scene; None if it can."""

    @abc.abstractmethod
    def kernel(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene, or the lanes of one, with these settings and this target.

        `warm_up` and `run` ask here, and so does `warprock explain`.
        """

    @abc.abstractmethod
    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads the kernels for lanes and motions, once, on the calling thread."""

    def longest_step(self, lanes: Lanes, motions: GroundMotions) -> npt.NDArray[np.float64]:
        """Longest step that every lane may take [s], shape [lane], of an engine with an order."""
        return np.full(lanes.lane_count, self.settings.time_step)

    def reserve(self, lanes: Lanes) -> tuple[npt.NDArray[np.float64], str] | None:
        """What lanes must have to be run, over what they need; None where there is no such bound.

        Args:
            lanes: The lanes.

        Returns:
            A number that must be above 1, shape [lane], and what it is.
        """
        return None

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
