"""A sampled motion of the base, and what lies between its samples.

The record says which quantity of the base follows its samples. Between two samples

- an acceleration record is piecewise linear in acceleration,
- a velocity record is piecewise linear in velocity,
- a displacement record is a cubic spline of the displacement, twice continuously differentiable
  (not-a-knot ends).

The base rests before the first sample. After the last one it keeps its velocity under
acceleration control and stops otherwise; what the base velocity jumps by at the two ends are
velocity steps.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import numpy.typing as npt

from warprock.model.motion import Control
from warprock.units import Dimension

Array = npt.NDArray[np.float64]

CONTROL_OF = {
    Dimension.ACCELERATION: Control.ACCELERATION,
    Dimension.VELOCITY: Control.VELOCITY,
    Dimension.LENGTH: Control.DISPLACEMENT,
}
"""What samples with a unit of some dimension are."""

ROUND_OFF = 1e-12
"""Part of the largest velocity below which one at an end of a record counts as none."""


@dataclasses.dataclass(frozen=True)
class Pieces:
    """A record as pieces of linear acceleration, the layout of `RecordMotions`.

    Attributes:
        acceleration: Just after each sample [m/s^2], shape [sample]; zero at the last one.
        slope: Just after each sample [m/s^3], shape [sample]; zero at the last one.
        velocity: Just after each sample [m/s], shape [sample].
        step_start: Velocity step at the first sample [m/s].
        step_stop: Velocity step at the last sample [m/s].
    """

    acceleration: Array
    slope: Array
    velocity: Array
    step_start: float
    step_stop: float


@dataclasses.dataclass(frozen=True, eq=False)
class Record:
    """A sampled motion of the base in one direction.

    Attributes:
        name: Name of a shipped record, or of the file and its channel.
        file: File that it was read from.
        quantity: What the samples are.
        interval: Time between samples [s].
        samples: [m/s^2, m/s or m], shape [sample].
        sha256: Hash of the file's bytes.
        source: Where the record is from, as its file says.
        licence: As its file says; empty where it says nothing.
        processing: What was done to the motion, as its file says.
        original_sha256: Hash of the file that this one was made from; empty where it says nothing.
        direction: What the file calls the direction; empty where it says nothing.
    """

    name: str
    file: str
    quantity: Control
    interval: float
    samples: Array
    sha256: str
    source: str = ""
    licence: str = ""
    processing: str = ""
    original_sha256: str = ""
    direction: str = ""

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return self.interval * (len(self.samples) - 1)

    @property
    def acceleration(self) -> Array:
        """Acceleration of the base at the samples [m/s^2], shape [sample].

        Of a velocity or displacement record it is the one just after each sample, zero at the
        last sample, and leaves out the velocity steps at the ends.
        """
        if self.quantity is Control.ACCELERATION:
            return self.samples
        return self.pieces.acceleration

    @property
    def peak_acceleration(self) -> float:
        """Largest |acceleration| [m/s^2], velocity steps left out.

        The acceleration is linear between samples, so it is found at one end of a piece.
        """
        pieces = self.pieces
        ends = pieces.acceleration + pieces.slope * self.interval
        return float(max(np.max(np.abs(pieces.acceleration)), np.max(np.abs(ends))))

    @functools.cached_property
    def peak_velocity(self) -> float:
        """Largest |velocity| of the base [m/s]: at an end of a piece, or where a = 0 inside it."""
        start, slope = self.pieces.acceleration[:-1], self.pieces.slope[:-1]
        with np.errstate(divide="ignore", invalid="ignore"):
            zero = -start / slope
        zero = np.where((zero > 0.0) & (zero < self.interval), zero, 0.0)
        found = 0.0
        for time in (np.zeros_like(start), np.full_like(start, self.interval), zero):
            velocity = self.pieces.velocity[:-1] + time * (start + 0.5 * slope * time)
            found = max(found, float(np.max(np.abs(velocity))))
        return found

    @functools.cached_property
    def pieces(self) -> Pieces:
        """The record as pieces of linear acceleration."""
        split = {
            Control.ACCELERATION: _acceleration_pieces,
            Control.VELOCITY: _velocity_pieces,
            Control.DISPLACEMENT: _displacement_pieces,
        }
        return split[self.quantity](self.samples, self.interval)


def _acceleration_pieces(samples: Array, interval: float) -> Pieces:
    gained = 0.5 * interval * (samples[1:] + samples[:-1])
    return Pieces(
        acceleration=np.append(samples[:-1], 0.0),
        slope=np.append(np.diff(samples) / interval, 0.0),
        velocity=np.append(0.0, np.cumsum(gained)),
        step_start=0.0,
        step_stop=0.0,
    )


def _step(velocity: float, velocities: Array) -> float:
    """A velocity at an end [m/s], or zero where it is round-off beside the others [m/s].

    A step of 1e-17 m/s would count as an impact, whose impulses may pull.
    """
    return 0.0 if abs(velocity) < ROUND_OFF * np.max(np.abs(velocities)) else float(velocity)


def _velocity_pieces(samples: Array, interval: float) -> Pieces:
    return Pieces(
        acceleration=np.append(np.diff(samples) / interval, 0.0),
        slope=np.zeros_like(samples),
        velocity=np.append(samples[:-1], 0.0),
        step_start=_step(samples[0], samples),
        step_stop=-_step(samples[-1], samples),
    )


def _displacement_pieces(samples: Array, interval: float) -> Pieces:
    from scipy.interpolate import CubicSpline

    times = interval * np.arange(len(samples))
    spline = CubicSpline(times, samples)
    velocity = np.asarray(spline(times, 1))
    return Pieces(
        acceleration=np.append(2.0 * spline.c[1], 0.0),
        slope=np.append(6.0 * spline.c[0], 0.0),
        velocity=np.append(velocity[:-1], 0.0),
        step_start=_step(velocity[0], velocity),
        step_stop=-_step(velocity[-1], velocity),
    )
