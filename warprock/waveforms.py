"""Ground motions of analytic waveforms: from what a user writes to what engines follow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warprock.motion import (
    RICKER_HALF_LENGTH,
    Array,
    Control,
    HarmonicMotions,
    RickerMotions,
    Waveform,
)


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
