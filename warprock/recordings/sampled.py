"""Sampled accelerations while they are processed."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import numpy.typing as npt

from warprock.model.motion import Control

Array = npt.NDArray[np.float64]

PAD_PERIODS = 3.0
"""Zeros at both ends of a record while it is filtered, in periods of the lower corner."""

LONGEST_PAD = 100
"""Longest pad in lengths of the record; lower corners are out of reach of so short a record."""


@dataclasses.dataclass(frozen=True, eq=False)
class Sampled:
    """Accelerations, and how the base moves at the first of them.

    Attributes:
        samples: [m/s^2], shape [sample]; [m/s] or [m] before they are differentiated.
        interval: Time between samples [s].
        velocity: At the first sample [m/s].
        displacement: At the first sample [m].
        quantity: What the samples are.
        beside: The displacement that another instrument measured [m], shape [sample]; None without
            one, and after the first step.
    """

    samples: Array
    interval: float
    velocity: float = 0.0
    displacement: float = 0.0
    quantity: Control = Control.ACCELERATION
    beside: Array | None = None

    def integrals(self) -> tuple[Array, Array]:
        """Velocity [m/s] and displacement [m] at the samples, by the trapezoidal rule."""
        velocity = self.velocity + _integral(self.samples, self.interval)
        return velocity, self.displacement + _integral(velocity, self.interval)


def _integral(values: Array, interval: float) -> Array:
    """Cumulative trapezoidal integral from zero."""
    steps = 0.5 * interval * (values[1:] + values[:-1])
    return np.concatenate([[0.0], np.cumsum(steps)])


def part(motion: Sampled, first: int, end: int) -> Sampled:
    """The samples from `first` to before `end`."""
    velocity, displacement = motion.integrals()
    return Sampled(
        motion.samples[first:end],
        motion.interval,
        float(velocity[first]),
        float(displacement[first]),
    )


def pad_length(motion: Sampled, low: float) -> int:
    """Zeros at either end of a motion while it is filtered."""
    return round(PAD_PERIODS / (low * motion.interval))


def require_corners(motion: Sampled, *corners: float) -> None:
    """Refuses corners of filters that rise not, or that the motion is too short or too coarse for.

    Raises:
        ValueError: They are out of bounds.
    """
    nyquist = 0.5 / motion.interval
    lowest = PAD_PERIODS / (LONGEST_PAD * len(motion.samples) * motion.interval)
    rising = all(low < high for low, high in itertools.pairwise((*corners, nyquist)))
    if not (lowest <= corners[0] and rising):
        allowed = f"must have its corners in order between {lowest:.3g} and {nyquist:g} Hz"
        raise ValueError(allowed)
