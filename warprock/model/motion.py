"""Ground motions of a batch of lanes: analytic waveforms and sampled records.

A waveform follows one controlled quantity (displacement, velocity or acceleration of the base).
What the control implies is folded in here, once, on the host: the acceleration between two
knots is smooth, and at a knot the base velocity may step. A displacement-controlled sine, for
example, starts with a velocity step of amplitude x 2 pi f. The velocity steps are explicit data
(`velocity_step_start`, `velocity_step_stop`), so that every engine can carry them exactly.

Before `start` the base is at rest; after `stop` it keeps `velocity_final`. Base motion is
positive towards +x. SI units; arrays have shape [lane].
"""

from __future__ import annotations

import abc
import dataclasses
import enum
from collections.abc import Callable
from typing import ClassVar, Self

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

RICKER_HALF_LENGTH = 2.0
"""Half length of a Ricker pulse in periods: exp(-(2 pi)^2) = 7e-18, below round-off."""


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


def _no_acceleration(_time: float) -> float:
    return 0.0


@dataclasses.dataclass(frozen=True)
class StillBase:
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

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """The motions of some lanes."""
        return dataclasses.replace(self, count=len(np.arange(self.count)[lanes]))

    def segments(self, _lane: int) -> list[Segment]:
        """The motion of one lane, segment by segment."""
        return [Segment(0.0, np.inf, 0.0, _no_acceleration)]

    def acceleration(self, times: Array, _lane: int) -> Array:
        """Acceleration of one lane's base [m/s^2] at times [s]."""
        return np.zeros_like(times)


@dataclasses.dataclass(frozen=True)
class _Pulse(abc.ABC):
    """What every analytic waveform has: a start, a stop and the velocity steps at both."""

    start: Array
    stop: Array
    velocity_step_start: Array
    velocity_step_stop: Array
    velocity_final: Array

    @property
    def lane_count(self) -> int:
        """Number of lanes."""
        return len(self.start)

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """The motions of some lanes."""
        parts = {f.name: getattr(self, f.name)[lanes] for f in dataclasses.fields(self)}
        return dataclasses.replace(self, **parts)

    @abc.abstractmethod
    def acceleration_inside(self, times: Array, lane: int) -> Array:
        """Acceleration of the waveform itself [m/s^2], as if it had no start and no stop."""

    def acceleration(self, times: Array, lane: int) -> Array:
        """Acceleration of one lane's base [m/s^2] at times [s], without the velocity steps."""
        inside = (times >= self.start[lane]) & (times < self.stop[lane])
        return np.where(inside, self.acceleration_inside(times, lane), 0.0)

    def segments(self, lane: int) -> list[Segment]:
        """The motion of one lane, segment by segment."""
        start, stop = float(self.start[lane]), float(self.stop[lane])

        def moving(time: float) -> float:
            return float(self.acceleration_inside(np.asarray(time), lane))

        step_start = float(self.velocity_step_start[lane])
        step_stop = float(self.velocity_step_stop[lane])
        parts = [
            Segment(start, stop, step_start, moving),
            Segment(stop, np.inf, step_stop, _no_acceleration),
        ]
        if start > 0.0:
            parts.insert(0, Segment(0.0, start, 0.0, _no_acceleration))
        return parts


@dataclasses.dataclass(frozen=True)
class HarmonicMotions(_Pulse):
    """Sines and cosines between a start and a stop.

    With tau = t - start and w = 2 pi frequency, between start and stop:
    acceleration = acceleration_amplitude sin(w tau + phase),
    velocity = velocity_offset - acceleration_amplitude / w cos(w tau + phase).
    """

    frequency: Array
    acceleration_amplitude: Array
    phase: Array
    velocity_offset: Array
    kind: ClassVar[MotionKind] = MotionKind.HARMONIC

    def acceleration_inside(self, times: Array, lane: int) -> Array:
        """Acceleration of the waveform itself [m/s^2]."""
        angle = 2.0 * np.pi * self.frequency[lane] * (times - self.start[lane])
        return np.asarray(self.acceleration_amplitude[lane] * np.sin(angle + self.phase[lane]))


@dataclasses.dataclass(frozen=True)
class RickerMotions(_Pulse):
    """Ricker pulses, the second derivative of a Gaussian.

    With x = rate (t - start) - rate (stop - start)/2 and rate = pi frequency:
    velocity = (c0 + c1 x + c2 x^2 + c3 x^3) exp(-x^2), acceleration its time derivative.
    """

    rate: Array
    c0: Array
    c1: Array
    c2: Array
    c3: Array
    kind: ClassVar[MotionKind] = MotionKind.RICKER

    def acceleration_inside(self, times: Array, lane: int) -> Array:
        """Acceleration of the waveform itself [m/s^2]."""
        rate = self.rate[lane]
        x = rate * (times - 0.5 * (self.start[lane] + self.stop[lane]))
        c0, c1, c2, c3 = (c[lane] for c in (self.c0, self.c1, self.c2, self.c3))
        velocity = c0 + x * (c1 + x * (c2 + x * c3))
        slope = c1 + x * (2.0 * c2 + x * 3.0 * c3)
        return np.asarray(rate * (slope - 2.0 * x * velocity) * np.exp(-x * x))


@dataclasses.dataclass(frozen=True)
class ModulatedMotions(_Pulse):
    """Pulses of a few cycles under one swing of a cosine, which are sums of three harmonics.

    With tau = t - (start + stop) / 2 and f_k = frequency, frequency (1 + modulation) and
    frequency (1 - modulation): velocity = velocity_offset + the sum of swing_k cos(2 pi f_k tau +
    phase), acceleration its time derivative.
    """

    frequency: Array
    modulation: Array
    phase: Array
    swing_1: Array
    swing_2: Array
    swing_3: Array
    velocity_offset: Array
    kind: ClassVar[MotionKind] = MotionKind.MODULATED

    def acceleration_inside(self, times: Array, lane: int) -> Array:
        """Acceleration of the waveform itself [m/s^2]."""
        tau = times - 0.5 * (self.start[lane] + self.stop[lane])
        found = np.zeros_like(tau)
        m = self.modulation[lane]
        for swing, part in ((self.swing_1, 1.0), (self.swing_2, 1.0 + m), (self.swing_3, 1.0 - m)):
            w = 2.0 * np.pi * self.frequency[lane] * part
            found = found - w * swing[lane] * np.sin(w * tau + self.phase[lane])
        return np.asarray(found)


@dataclasses.dataclass(frozen=True)
class RecordMotions:
    """Sampled records, each lane following one of them, scaled.

    The samples of all records lie behind one another in a pool. Between two samples the
    acceleration is linear: acceleration[i] + slope[i] (t - t_i). The last sample of a record
    is an empty segment (zero acceleration and slope) that carries the final velocity.

    Attributes:
        start: Time at which the record starts [s], shape [lane].
        scale: Factor on the motion, shape [lane].
        offset: First sample of the lane's record in the pool, shape [lane].
        count: Samples of the lane's record, shape [lane].
        interval: Time between samples of the lane's record [s], shape [lane].
        velocity_step_start: Velocity step at the first sample [m/s], unscaled, shape [lane].
        velocity_step_stop: Velocity step at the last sample [m/s], unscaled, shape [lane].
        pool_acceleration: [m/s^2], shape [pool].
        pool_slope: [m/s^3], shape [pool].
        pool_velocity: Base velocity just after each sample [m/s], shape [pool].
    """

    start: Array
    scale: Array
    offset: npt.NDArray[np.int32]
    count: npt.NDArray[np.int32]
    interval: Array
    velocity_step_start: Array
    velocity_step_stop: Array
    pool_acceleration: Array
    pool_slope: Array
    pool_velocity: Array
    kind: ClassVar[MotionKind] = MotionKind.RECORD

    @property
    def lane_count(self) -> int:
        """Number of lanes."""
        return len(self.start)

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """The motions of some lanes; the pool is shared."""
        names = [f.name for f in dataclasses.fields(self) if not f.name.startswith("pool_")]
        return dataclasses.replace(self, **{name: getattr(self, name)[lanes] for name in names})

    def _index(self, times: Array, lane: int) -> npt.NDArray[np.intp]:
        position = (np.asarray(times) - self.start[lane]) / self.interval[lane]
        return np.asarray(np.clip(np.floor(position), 0, self.count[lane] - 1), dtype=np.intp)

    def acceleration(self, times: Array, lane: int) -> Array:
        """Acceleration of one lane's base [m/s^2] at times [s], without the velocity steps."""
        index = self._index(times, lane)
        tau = np.asarray(times) - self.start[lane] - index * self.interval[lane]
        at = self.offset[lane] + index
        value = self.pool_acceleration[at] + self.pool_slope[at] * tau
        return np.where(times < self.start[lane], 0.0, self.scale[lane] * value)

    def segments(self, lane: int) -> list[Segment]:
        """The motion of one lane, sample by sample."""
        offset, count = int(self.offset[lane]), int(self.count[lane])
        start, interval, scale = (float(a[lane]) for a in (self.start, self.interval, self.scale))
        parts = [] if start <= 0.0 else [Segment(0.0, start, 0.0, _no_acceleration)]
        for index in range(count):
            begin = start + index * interval
            end = start + (index + 1) * interval if index < count - 1 else np.inf
            value = scale * float(self.pool_acceleration[offset + index])
            slope = scale * float(self.pool_slope[offset + index])
            step = 0.0
            if index == 0:
                step = scale * float(self.velocity_step_start[lane])
            elif index == count - 1:
                step = scale * float(self.velocity_step_stop[lane])

            def linear(
                time: float, begin: float = begin, value: float = value, slope: float = slope
            ) -> float:
                return value + slope * (time - begin)

            parts.append(Segment(begin, end, step, linear))
        return parts


PlanarMotions = StillBase | HarmonicMotions | RickerMotions | ModulatedMotions | RecordMotions
"""Motions of one direction."""


@dataclasses.dataclass(frozen=True)
class SpatialMotions:
    """Motions of a base that translates in space: one motion of each direction, all of one kind.

    Attributes:
        x: Along +x, in the plane of rocking.
        y: Along +y, across it.
        z: Upwards.
    """

    x: PlanarMotions
    y: PlanarMotions
    z: PlanarMotions

    @property
    def components(self) -> tuple[PlanarMotions, PlanarMotions, PlanarMotions]:
        """The motions along x, y and z."""
        return self.x, self.y, self.z

    @property
    def kind(self) -> MotionKind:
        """Family of the motions."""
        return self.x.kind

    @property
    def lane_count(self) -> int:
        """Number of lanes."""
        return self.x.lane_count

    @property
    def start(self) -> Array:
        """Time at which the first of the directions starts to move [s]."""
        return np.asarray(np.min([part.start for part in self.components], axis=0))

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """The motions of some lanes."""
        return dataclasses.replace(
            self, x=self.x.take(lanes), y=self.y.take(lanes), z=self.z.take(lanes)
        )


GroundMotions = PlanarMotions | SpatialMotions


def no_motion(like: PlanarMotions) -> PlanarMotions:
    """A base that stays where it is, in the family of other motions and with their knots."""
    return _scaled(like, np.zeros(like.lane_count))


def scaled(motions: GroundMotions, factors: Array) -> GroundMotions:
    """The motions times a factor, in all directions, with the knots that they had.

    Args:
        motions: The motions.
        factors: Factor on the motion of every lane, shape [lane].
    """
    if isinstance(motions, SpatialMotions):
        x, y, z = (_scaled(part, factors) for part in motions.components)
        return SpatialMotions(x, y, z)
    return _scaled(motions, factors)


_LINEAR: dict[MotionKind, tuple[str, ...]] = {
    MotionKind.HARMONIC: ("acceleration_amplitude", "velocity_offset"),
    MotionKind.RICKER: ("c0", "c1", "c2", "c3"),
    MotionKind.MODULATED: ("swing_1", "swing_2", "swing_3", "velocity_offset"),
}
_LINEAR_OF_PULSES = ("velocity_step_start", "velocity_step_stop", "velocity_final")
"""Fields that a factor on the motion multiplies: of each family, and of all analytic ones."""


def _scaled(motions: PlanarMotions, factors: Array) -> PlanarMotions:
    if isinstance(motions, StillBase):
        return motions
    if isinstance(motions, RecordMotions):
        return dataclasses.replace(motions, scale=motions.scale * factors)
    names = _LINEAR_OF_PULSES + _LINEAR[motions.kind]
    return dataclasses.replace(motions, **{n: getattr(motions, n) * factors for n in names})
