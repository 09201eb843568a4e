"""What every motion of a base along one direction has, whatever its waveform.

A waveform follows one controlled quantity (displacement, velocity or acceleration of the base).
What the control implies is folded in once, on the host: the acceleration between two knots is
smooth, and at a knot the base velocity may step. A displacement-controlled sine, for example,
starts with a velocity step of amplitude x 2 pi f. The velocity steps are explicit data, so that
every engine can carry them exactly.

Before `start` the base is at rest; after `stop` it keeps `velocity_final`. Base motion is positive
towards +x. SI units; arrays have shape [lane].
"""

from __future__ import annotations

import abc
import dataclasses
import enum
from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Lanes = slice | npt.NDArray[np.intp]
"""Which lanes to take: a slice, or their indices."""


class Control(enum.StrEnum):
    """The quantity of the base that follows the waveform."""

    DISPLACEMENT = "displacement"
    VELOCITY = "velocity"
    ACCELERATION = "acceleration"


class Waveform(enum.StrEnum):
    """Shape of the controlled quantity in time."""

    SINE = "sine"
    COSINE = "cosine"
    RICKER = "ricker"
    MAVROEIDIS_PAPAGEORGIOU = "mavroeidis-papageorgiou"
    TILT = "tilt"
    PUSH = "push"
    RECORD = "record"


class MotionKind(enum.StrEnum):
    """Family of motions that one compiled kernel can follow."""

    STILL = "still"
    HARMONIC = "harmonic"
    RICKER = "ricker"
    MODULATED = "modulated"
    RECORD = "record"


@dataclasses.dataclass(frozen=True)
class Segment:
    """A stretch of one lane's motion between two knots.

    Attributes:
        start: Time at which the segment starts [s].
        stop: Time at which it stops [s]; may be infinite.
        velocity_step: Step of the base velocity at its start [m/s].
        acceleration: Acceleration of the base at a time inside it [m/s^2].
    """

    start: float
    stop: float
    velocity_step: float
    acceleration: Callable[[float], float]


def no_acceleration(_time: float) -> float:
    """Acceleration of a base that keeps its velocity [m/s^2]."""
    return 0.0


class LaneMotions(abc.ABC):
    """Motions of a base along one direction, one a lane.

    Attributes:
        kind: Family of motions, which a kernel is compiled for.
    """

    kind: ClassVar[MotionKind]

    if TYPE_CHECKING:

        @property
        def start(self) -> Array:
            """Time at which the motion starts [s], shape [lane]; most have it as a field."""

    @property
    @abc.abstractmethod
    def lane_count(self) -> int:
        """Number of lanes."""

    @property
    @abc.abstractmethod
    def velocity_steps(self) -> tuple[Array, Array]:
        """Steps of the base velocity at its start and at its stop [m/s]."""

    @property
    @abc.abstractmethod
    def moves(self) -> Mask:
        """Whether the base moves at all."""

    @property
    @abc.abstractmethod
    def end(self) -> Array:
        """Time from which on the base keeps its velocity [s]; 0 where it does not move."""

    @property
    @abc.abstractmethod
    def fastest_rate(self) -> Array | float:
        """Rate at which the acceleration changes [rad/s]; 0 where it is linear between knots."""

    @property
    @abc.abstractmethod
    def shortest_period(self) -> Array:
        """Period of the fastest part of the waveform [s]; infinite where there is no period."""

    @property
    def knot_count(self) -> npt.NDArray[np.int32] | int:
        """Samples of a record, at which its formula changes; 0 for other motions."""
        return 0

    @property
    def knot_interval(self) -> Array | float:
        """Time between two samples of a record [s]; infinite for other motions."""
        return np.inf

    @property
    def pool(self) -> Array:
        """Samples of records, shape [3, sample]: acceleration, slope, velocity; else zeros."""
        return np.zeros((3, 1))

    @property
    def axes(self) -> str:
        """The axes that the base moves along."""
        return "x"

    @property
    def components(self) -> tuple[Self]:
        """The directions that the base moves along: this one."""
        return (self,)

    @abc.abstractmethod
    def take(self, lanes: Lanes) -> Self:
        """The motions of some lanes."""

    def compact(self) -> Self:
        """The same motions, without what they do not use."""
        return self

    @abc.abstractmethod
    def scaled(self, factors: Array) -> Self:
        """The motions times a factor, with the knots that they had.

        Args:
            factors: Factor on the motion of every lane, shape [lane].
        """

    @abc.abstractmethod
    def segments(self, lane: int) -> list[Segment]:
        """The motion of one lane, segment by segment."""

    @abc.abstractmethod
    def acceleration(self, times: Array, lane: int) -> Array:
        """Acceleration of one lane's base [m/s^2] at times [s], without the velocity steps."""

    @abc.abstractmethod
    def velocity_variation(self, duration: float) -> Array:
        """Upper bound of the total variation of the base velocity until a time [m/s], [lane]."""

    @abc.abstractmethod
    def acceleration_bound(self) -> Array:
        """Upper bound of the |acceleration| of the base [m/s^2], without its velocity steps."""

    def largest_acceleration(self) -> Array:
        """Upper bound of the |acceleration| of the base [m/s^2], shape [lane].

        Infinite where the base velocity steps.
        """
        start, stop = self.velocity_steps
        return np.where((start != 0.0) | (stop != 0.0), np.inf, self.acceleration_bound())

    def later_acceleration(self, duration: Array | float) -> Array:
        """Upper bound of the |acceleration| of the base after a time [m/s^2], shape [lane].

        Infinite where a velocity step is left.
        """
        return np.where(self.end > duration, self.largest_acceleration(), 0.0)


@dataclasses.dataclass(frozen=True)
class StillBase(LaneMotions):
    """A base that does not move."""

    count: int
    kind: ClassVar[MotionKind] = MotionKind.STILL

    @property
    def lane_count(self) -> int:
        """Number of lanes."""
        return self.count

    @property
    def start(self) -> Array:
        """Time at which the motion starts [s]: never."""
        return np.full(self.count, np.inf)

    @property
    def velocity_steps(self) -> tuple[Array, Array]:
        """Steps of the base velocity [m/s]: none."""
        return np.zeros(self.count), np.zeros(self.count)

    @property
    def moves(self) -> Mask:
        """Whether the base moves at all: no."""
        return np.zeros(self.count, dtype=bool)

    @property
    def end(self) -> Array:
        """Time from which on the base keeps its velocity [s]: 0."""
        return np.zeros(self.count)

    @property
    def fastest_rate(self) -> float:
        """Rate at which the acceleration changes [rad/s]: none."""
        return 0.0

    @property
    def shortest_period(self) -> Array:
        """Period of the fastest part of the waveform [s]: there is none."""
        return np.full(self.count, np.inf)

    def take(self, lanes: Lanes) -> Self:
        """The motions of some lanes."""
        return dataclasses.replace(self, count=len(np.arange(self.count)[lanes]))

    def scaled(self, factors: Array) -> Self:
        """The motions times a factor: the same."""
        return self

    def segments(self, _lane: int) -> list[Segment]:
        """The motion of one lane, segment by segment."""
        return [Segment(0.0, np.inf, 0.0, no_acceleration)]

    def acceleration(self, times: Array, _lane: int) -> Array:
        """Acceleration of one lane's base [m/s^2] at times [s]."""
        return np.zeros_like(times)

    def velocity_variation(self, duration: float) -> Array:
        """The total variation of the base velocity [m/s]: none."""
        return np.zeros(self.count)

    def acceleration_bound(self) -> Array:
        """The largest |acceleration| of the base [m/s^2]: none."""
        return np.zeros(self.count)
