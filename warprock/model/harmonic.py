"""Sines and cosines: from what a user writes to what engines follow."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from warprock.model.lane_motion import Array, Control, MotionKind, Waveform
from warprock.model.pulse import PulseMotions, variation_of_swings


@dataclasses.dataclass(frozen=True)
class HarmonicMotions(PulseMotions):
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
    linear: ClassVar[tuple[str, ...]] = ("acceleration_amplitude", "velocity_offset")

    def acceleration_inside(self, times: Array, lane: int) -> Array:
        """Acceleration of the waveform itself [m/s^2]."""
        angle = 2.0 * np.pi * self.frequency[lane] * (times - self.start[lane])
        return np.asarray(self.acceleration_amplitude[lane] * np.sin(angle + self.phase[lane]))

    @property
    def fastest_rate(self) -> Array:
        """Rate at which the acceleration changes [rad/s]."""
        return 2.0 * np.pi * self.frequency

    @property
    def shortest_period(self) -> Array:
        """Period [s]."""
        return np.asarray(1.0 / self.frequency)

    def variation_inside(self, moving: Array) -> Array:
        """Upper bound of the total variation of the velocity of the waveform itself [m/s]."""
        swing = self.acceleration_amplitude / (2.0 * np.pi * self.frequency)
        return variation_of_swings(swing[None], self.frequency[None], moving)

    def acceleration_bound(self) -> Array:
        """The largest |acceleration| [m/s^2]."""
        return np.abs(self.acceleration_amplitude)


def harmonic_motions(
    waveform: Sequence[Waveform] | Waveform,
    control: npt.NDArray[np.str_] | Sequence[Control],
    amplitude: Array,
    frequency: Array,
    start: Array,
    duration: Array,
) -> HarmonicMotions:
    """Sine or cosine motions under a control.

    Args:
        waveform: `Waveform.SINE` or `Waveform.COSINE`, one for all lanes or one a lane.
        control: Controlled quantity, shape [lane].
        amplitude: Amplitude of the controlled quantity [m, m/s or m/s^2], shape [lane].
        frequency: [Hz], shape [lane], > 0.
        start: [s], shape [lane], >= 0.
        duration: Time from start to stop [s], shape [lane], > 0.

    Raises:
        ValueError: A displacement-controlled cosine, whose displacement would jump.
    """
    count = len(frequency)
    waveforms = np.broadcast_to(np.asarray(waveform, dtype=np.str_), (count,))
    controls = np.asarray(control, dtype=np.str_)
    cosine = waveforms == Waveform.COSINE
    by_displacement = controls == Control.DISPLACEMENT
    by_velocity = controls == Control.VELOCITY
    by_acceleration = controls == Control.ACCELERATION
    if np.any(cosine & by_displacement):
        raise ValueError(
            "control: got displacement with waveform cosine, whose displacement would jump; "
            "allowed: velocity, acceleration"
        )
    w = 2.0 * np.pi * frequency
    # The controlled quantity is amplitude sin(w tau + lead); each derivative adds pi/2.
    derivatives = np.select([by_displacement, by_velocity], [2, 1], 0)
    lead = np.where(cosine, 0.5 * np.pi, 0.0)
    phase = lead + 0.5 * np.pi * derivatives
    acceleration_amplitude = amplitude * w**derivatives
    swing = acceleration_amplitude / w
    # Under acceleration control the base starts without a velocity step.
    velocity_offset = np.where(by_acceleration, swing * _cos_exact(phase), 0.0)
    velocity_start = velocity_offset - swing * _cos_exact(phase)
    cycles = frequency * duration
    angle = phase + 2.0 * np.pi * (cycles - np.round(cycles))
    velocity_stop = velocity_offset - swing * _cos_exact(angle)
    velocity_final = np.where(by_acceleration, velocity_stop, 0.0)
    return HarmonicMotions(
        start=start,
        stop=start + duration,
        velocity_step_start=np.where(by_acceleration, 0.0, velocity_start),
        velocity_step_stop=velocity_final - velocity_stop,
        velocity_final=velocity_final,
        frequency=frequency,
        acceleration_amplitude=acceleration_amplitude,
        phase=phase,
        velocity_offset=velocity_offset,
    )


def _cos_exact(angle: Array) -> Array:
    """Cosine, with zero where it is zero but for round-off, so that no false step remains."""
    value = np.cos(angle)
    return np.where(np.abs(value) < 1e-12, 0.0, value)
