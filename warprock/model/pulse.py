"""What every analytic waveform has: a start, a stop, and velocity steps at both."""

from __future__ import annotations

import abc
import dataclasses
from typing import ClassVar, Self

import numpy as np

from warprock.model.lane_motion import Array, LaneMotions, Lanes, Mask, Segment, no_acceleration

_LINEAR = ("velocity_step_start", "velocity_step_stop", "velocity_final")
"""Fields of all waveforms that a factor on the motion multiplies."""


@dataclasses.dataclass(frozen=True)
class PulseMotions(LaneMotions):
    """What every analytic waveform has: a start, a stop and the velocity steps at both."""

    start: Array
    stop: Array
    velocity_step_start: Array
    velocity_step_stop: Array
    velocity_final: Array
    linear: ClassVar[tuple[str, ...]]
    """Fields of the waveform itself that a factor on the motion multiplies; without them, and
    without velocity steps, the base does not move."""

    @property
    def lane_count(self) -> int:
        """Number of lanes."""
        return len(self.start)

    @property
    def velocity_steps(self) -> tuple[Array, Array]:
        """Steps of the base velocity at its start and at its stop [m/s]."""
        return self.velocity_step_start, self.velocity_step_stop

    @property
    def moves(self) -> Mask:
        """Whether the base moves at all."""
        names = (*_LINEAR, *self.linear)
        return np.asarray(np.any([getattr(self, name) != 0.0 for name in names], axis=0))

    @property
    def end(self) -> Array:
        """Time from which on the base keeps its velocity [s]: its stop."""
        return np.where(self.moves, self.stop, 0.0)

    def take(self, lanes: Lanes) -> Self:
        """The motions of some lanes."""
        parts = {f.name: getattr(self, f.name)[lanes] for f in dataclasses.fields(self)}
        return dataclasses.replace(self, **parts)

    def scaled(self, factors: Array) -> Self:
        """The motions times a factor, with the knots that they had."""
        names = (*_LINEAR, *self.linear)
        return dataclasses.replace(self, **{n: getattr(self, n) * factors for n in names})

    @abc.abstractmethod
    def variation_inside(self, moving: Array) -> Array:
        """Upper bound of the total variation of the velocity of the waveform itself [m/s].

        Args:
            moving: Time for which it has been moving [s], shape [lane].
        """

    def velocity_variation(self, duration: float) -> Array:
        """Upper bound of the total variation of the base velocity until a time [m/s], [lane]."""
        moving = np.maximum(np.minimum(self.stop, duration) - self.start, 0.0)
        steps = np.abs(self.velocity_step_start) + np.abs(self.velocity_step_stop)
        return np.asarray(self.variation_inside(moving) + steps)

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
            Segment(stop, np.inf, step_stop, no_acceleration),
        ]
        if start > 0.0:
            parts.insert(0, Segment(0.0, start, 0.0, no_acceleration))
        return parts


def variation_of_swings(swings: Array, frequencies: Array, moving: Array) -> Array:
    """Upper bound of the total variation of a sum of harmonics [m/s], shape [lane].

    Args:
        swings: Amplitudes of the velocity [m/s], shape [harmonic, lane].
        frequencies: [Hz], shape [harmonic, lane].
        moving: Time for which they have been moving [s], shape [lane].
    """
    # A swing up or down for every half cycle, begun ones too; but for round-off of whole ones.
    parts = zip(swings, frequencies, strict=True)
    return np.asarray(sum(2.0 * np.abs(s) * np.ceil(2.0 * f * moving - 1e-9) for s, f in parts))
