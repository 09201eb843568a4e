"""Near-fault pulses of a few cycles: from what a user writes to what engines follow."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from warprock.model.lane_motion import Array, Control, MotionKind
from warprock.model.pulse import PulseMotions, variation_of_swings


@dataclasses.dataclass(frozen=True)
class ModulatedMotions(PulseMotions):
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
    linear: ClassVar[tuple[str, ...]] = ("swing_1", "swing_2", "swing_3", "velocity_offset")

    def acceleration_inside(self, times: Array, lane: int) -> Array:
        """Acceleration of the waveform itself [m/s^2]."""
        tau = times - 0.5 * (self.start[lane] + self.stop[lane])
        found = np.zeros_like(tau)
        m = self.modulation[lane]
        for swing, part in ((self.swing_1, 1.0), (self.swing_2, 1.0 + m), (self.swing_3, 1.0 - m)):
            w = 2.0 * np.pi * self.frequency[lane] * part
            found = found - w * swing[lane] * np.sin(w * tau + self.phase[lane])
        return np.asarray(found)

    @property
    def swings(self) -> Array:
        """Velocity amplitudes of the three harmonics [m/s], shape [3, lane]."""
        return np.stack([self.swing_1, self.swing_2, self.swing_3])

    @property
    def frequencies(self) -> Array:
        """Frequencies of the three harmonics [Hz], shape [3, lane]."""
        m = self.modulation
        return np.stack([self.frequency * part for part in (np.ones_like(m), 1.0 + m, 1.0 - m)])

    @property
    def fastest_rate(self) -> Array:
        """Rate at which the acceleration changes [rad/s]: that of the fastest harmonic."""
        return np.asarray(2.0 * np.pi * self.frequency * (1.0 + self.modulation))

    @property
    def shortest_period(self) -> Array:
        """Period of the fastest harmonic [s]."""
        return np.asarray(1.0 / (self.frequency * (1.0 + self.modulation)))

    def variation_inside(self, moving: Array) -> Array:
        """Upper bound of the total variation of the velocity of the waveform itself [m/s]."""
        return variation_of_swings(self.swings, self.frequencies, moving)

    def acceleration_bound(self) -> Array:
        """Upper bound of the |acceleration| [m/s^2]."""
        return np.asarray(2.0 * np.pi * np.sum(np.abs(self.swings) * self.frequencies, axis=0))


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
