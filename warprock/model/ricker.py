"""Ricker pulses: from what a user writes to what engines follow."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from warprock.model.lane_motion import Array, Control, MotionKind
from warprock.model.pulse import PulseMotions

RICKER_HALF_LENGTH = 2.0
"""Half length of a Ricker pulse in periods: exp(-(2 pi)^2) = 7e-18, below round-off."""


@functools.cache
def _humps() -> tuple[Array, Array]:
    """Total variation and steepest slope of the humps x^k exp(-x^2), shape [k].

    They are the parts of the velocity of a Ricker pulse, see `RickerMotions`. The grid finds their
    peaks to 1e-6; outside it they are zero to round-off.
    """
    grid, powers = np.linspace(-6.0, 6.0, 12_001), np.arange(4)[:, None]
    bell = np.exp(-(grid**2))
    slopes = (powers * grid ** np.maximum(powers - 1, 0) - 2.0 * grid ** (powers + 1)) * bell
    variation = np.abs(np.diff(grid**powers * bell, axis=1)).sum(axis=1)
    return variation, np.abs(slopes).max(axis=1)


@dataclasses.dataclass(frozen=True)
class RickerMotions(PulseMotions):
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
    linear: ClassVar[tuple[str, ...]] = ("c0", "c1", "c2", "c3")

    def acceleration_inside(self, times: Array, lane: int) -> Array:
        """Acceleration of the waveform itself [m/s^2]."""
        rate = self.rate[lane]
        x = rate * (times - 0.5 * (self.start[lane] + self.stop[lane]))
        c0, c1, c2, c3 = (c[lane] for c in (self.c0, self.c1, self.c2, self.c3))
        velocity = c0 + x * (c1 + x * (c2 + x * c3))
        slope = c1 + x * (2.0 * c2 + x * 3.0 * c3)
        return np.asarray(rate * (slope - 2.0 * x * velocity) * np.exp(-x * x))

    @property
    def fastest_rate(self) -> Array:
        """Rate at which the acceleration changes [rad/s].

        A series of the motion is of derivatives of a Gaussian. The highest that it keeps oscillates
        fastest, at about this rate.
        """
        return 4.0 * self.rate

    @property
    def shortest_period(self) -> Array:
        """Period [s]."""
        return np.asarray(np.pi / self.rate)

    def variation_inside(self, moving: Array) -> Array:
        """Upper bound of the total variation of the velocity of the waveform itself [m/s]."""
        return np.asarray(_humps()[0] @ np.abs([self.c0, self.c1, self.c2, self.c3]))

    def acceleration_bound(self) -> Array:
        """Upper bound of the |acceleration| [m/s^2]."""
        return np.asarray(self.rate * (_humps()[1] @ np.abs([self.c0, self.c1, self.c2, self.c3])))


def ricker_motions(
    control: npt.NDArray[np.str_] | Sequence[Control],
    amplitude: Array,
    frequency: Array,
    start: Array,
) -> RickerMotions:
    """Ricker pulses under a control, each `2 RICKER_HALF_LENGTH` periods long.

    Controlled quantity = amplitude (1 - 2 x^2) exp(-x^2), x = pi frequency (t - centre).

    Args:
        control: Controlled quantity, shape [lane].
        amplitude: Amplitude of the controlled quantity [m, m/s or m/s^2], shape [lane].
        frequency: [Hz], shape [lane], > 0.
        start: [s], shape [lane], >= 0.
    """
    controls = np.asarray(control, dtype=np.str_)
    by_displacement = controls == Control.DISPLACEMENT
    by_velocity = controls == Control.VELOCITY
    by_acceleration = controls == Control.ACCELERATION
    rate = np.pi * frequency
    # Velocity polynomials: acceleration control integrates to a x exp(-x^2) / rate; velocity
    # control is v (1 - 2 x^2); displacement control differentiates to u rate (-6 x + 4 x^3).
    zero = np.zeros_like(amplitude)
    stop = start + 2.0 * RICKER_HALF_LENGTH / frequency
    return RickerMotions(
        start=start,
        stop=stop,
        velocity_step_start=zero,
        velocity_step_stop=zero,
        velocity_final=zero,
        rate=rate,
        c0=np.where(by_velocity, amplitude, 0.0),
        c1=np.select(
            [by_acceleration, by_displacement], [amplitude / rate, -6.0 * amplitude * rate], 0.0
        ),
        c2=np.where(by_velocity, -2.0 * amplitude, 0.0),
        c3=np.where(by_displacement, 4.0 * amplitude * rate, 0.0),
    )


_SQUARE = 0.5 * (3.0 - np.sqrt(6.0))
_PEAK = np.array([1.0, np.sqrt(_SQUARE) * (6.0 - 4.0 * _SQUARE) * np.exp(-_SQUARE), 6.0])
"""Largest |acceleration| of a pulse per unit of amplitude x rate^n, n = 0, 1, 2 derivatives between
the controlled quantity and acceleration. n = 1: the extremum of (4 x^3 - 6 x) exp(-x^2) at
x^2 = (3 - sqrt 6)/2; n = 2: |-6| at the centre."""


def ricker_peak_acceleration(
    amplitude: Array, frequency: Array, derivatives: npt.NDArray[np.intp]
) -> Array:
    """Largest |acceleration| of every pulse [m/s^2], shape [lane].

    Args:
        amplitude: Amplitude of the controlled quantity [m, m/s or m/s^2], shape [lane].
        frequency: [Hz], shape [lane].
        derivatives: How often the controlled quantity is differentiated to reach acceleration.
    """
    rate = np.pi * frequency
    return np.asarray(np.abs(amplitude) * rate**derivatives * _PEAK[derivatives])
