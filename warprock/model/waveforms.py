"""Ground motions of analytic waveforms: from what a user writes to what engines follow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warprock.model.motion import (
    RICKER_HALF_LENGTH,
    Array,
    Control,
    HarmonicMotions,
    ModulatedMotions,
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


def mavroeidis_papageorgiou_motions(
    control: npt.NDArray[np.str_] | Sequence[Control],
    amplitude: Array,
    frequency: Array,
    start: Array,
    *,
    cycles: Array,
    phase: Array,
) -> ModulatedMotions:
    """Near-fault pulses of Mavroeidis and Papageorgiou, each `cycles` periods long.

    Controlled quantity = amplitude / 2 (1 + cos(2 pi f tau / cycles)) cos(2 pi f tau + phase), tau
    the time from the middle. They have the velocity follow it; its square brackets times a cosine
    are half a cosine at f and quarters at f (1 + 1 / cycles) and f (1 - 1 / cycles).

    Args:
        control: Controlled quantity, shape [lane].
        amplitude: Amplitude of the controlled quantity [m, m/s or m/s^2], shape [lane].
        frequency: Prevailing frequency f [Hz], shape [lane], > 0.
        start: [s], shape [lane], >= 0.
        cycles: Periods of f in the pulse, their gamma [-], shape [lane], > 1.
        phase: Their nu [rad], shape [lane].

    References:
        G. P. Mavroeidis and A. S. Papageorgiou (2003), A mathematical representation of near-fault
        ground motions, Bulletin of the Seismological Society of America 93.
    """
    controls = np.asarray(control, dtype=np.str_)
    by_acceleration = controls == Control.ACCELERATION
    parts = np.stack([np.ones_like(cycles), 1.0 + 1.0 / cycles, 1.0 - 1.0 / cycles])
    w = 2.0 * np.pi * frequency * parts
    # The velocity of a displacement cos x is w cos(x + pi/2); of an acceleration, cos(x - pi/2)/w.
    lead = np.select([controls == Control.DISPLACEMENT, by_acceleration], [1.0, -1.0], 0.0)
    swings = amplitude * np.array([0.5, 0.25, 0.25])[:, None] * w**lead
    moved = phase + 0.5 * np.pi * lead
    half = 0.5 * cycles / frequency
    velocities = [np.sum(swings * np.cos(side * w * half + moved), axis=0) for side in (-1.0, 1.0)]
    # At both ends the pulse and its slope are zero, so only an acceleration leaves a velocity.
    offset = np.where(by_acceleration, -velocities[0], 0.0)
    zero = np.zeros_like(amplitude)
    return ModulatedMotions(
        start=start,
        stop=start + 2.0 * half,
        velocity_step_start=zero,
        velocity_step_stop=zero,
        velocity_final=np.where(by_acceleration, velocities[1] + offset, 0.0),
        frequency=frequency,
        modulation=1.0 / cycles,
        phase=moved,
        swing_1=swings[0],
        swing_2=swings[1],
        swing_3=swings[2],
        velocity_offset=offset,
    )


PEAK_LOOKS = 64
"""Looks at a period about the middle of a pulse, in search of its peak acceleration."""


def modulated_peak_acceleration(motions: ModulatedMotions) -> Array:
    """Largest |acceleration| of every pulse [m/s^2], shape [lane].

    The envelope is largest in the middle, so that the peak lies within half a period of it. After
    `PEAK_LOOKS` looks two steps of Newton's method on the slope leave no error above round-off.
    """
    m = motions.modulation
    swings = np.stack([motions.swing_1, motions.swing_2, motions.swing_3])
    w = 2.0 * np.pi * motions.frequency * np.stack([np.ones_like(m), 1.0 + m, 1.0 - m])

    def derivative(tau: Array, order: int) -> Array:
        angle = w * tau + motions.phase + 0.5 * np.pi * order
        return np.asarray(np.sum(swings * w**order * np.cos(angle), axis=0))

    step = 1.0 / (PEAK_LOOKS * motions.frequency)
    best, peak = np.zeros_like(m), np.zeros_like(m)
    for look in range(-PEAK_LOOKS // 2, PEAK_LOOKS // 2 + 1):
        size = np.abs(derivative(look * step, 1))
        best, peak = np.where(size > peak, look * step, best), np.maximum(size, peak)
    for _ in range(2):
        bend = derivative(best, 3)
        move = derivative(best, 2) / np.where(bend == 0.0, 1.0, bend)
        best = best - np.clip(move, -step, step)
    return np.maximum(peak, np.abs(derivative(best, 1)))
