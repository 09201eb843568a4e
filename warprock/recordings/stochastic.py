"""Seeded stochastic ground motions: white noise through the ground, shaped by an envelope.

A stationary motion with the power spectrum of Clough and Penzien,

    S(w) = |1 + 2i z r|^2 / |1 - r^2 + 2i z r|^2  x  q^4 / |1 - q^2 + 2i z q|^2,
    r = w / w_g,  q = w / (w_g / 10),

is a sum of harmonics with independent Gaussian coefficients. The first factor is that of Kanai
and Tajimi, a layer of ground with frequency w_g and damping z; the second takes off what would
make the displacement drift. The motion is multiplied by the envelope of Jennings, Housner and Tsai:
(t / t1)^2 up to t1, one up to t2, then an exponential decay to 5 % at the end. Last the envelope
times a straight line is added, so small that only the displacement shows it, which brings the base
to rest where it started, and the motion is scaled to the peak acceleration asked for.

The same seed and values give the same samples.

References:
    K. Kanai (1957), Semi-empirical formula for the seismic characteristics of the ground, Bulletin
    of the Earthquake Research Institute 35.
    H. Tajimi (1960), A statistical method of determining the maximum response of a building
    structure during an earthquake, 2nd World Conference on Earthquake Engineering.
    R. W. Clough and J. Penzien (1975), Dynamics of Structures, McGraw-Hill.
    P. C. Jennings, G. W. Housner and N. C. Tsai (1968), Simulated earthquake motions, California
    Institute of Technology (envelope).
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from warprock.errors import InputError
from warprock.recordings.sampled import Sampled

Array = npt.NDArray[np.float64]

HIGH_PASS = 0.1
"""Frequency of the second filter / that of the ground."""

RISE, STRONG = 0.15, 0.5
"""Ends of the rise and of the strong part / duration."""

LEFT = 0.05
"""Envelope at the end."""


@dataclasses.dataclass(frozen=True)
class GroundNoise:
    """What makes a motion.

    Attributes:
        seed: Of the random numbers, >= 0.
        peak: Peak acceleration [m/s^2].
        duration: From the first to the last sample [s].
        frequency: Of the ground, w_g / (2 pi) [Hz].
        damping: Of the ground [-].
        interval: Time between samples [s].
    """

    seed: int
    peak: float
    duration: float = 20.0
    frequency: float = 2.5
    damping: float = 0.6
    interval: float = 0.01

    def __post_init__(self) -> None:
        bounds = (
            ("seed", self.seed, self.seed >= 0, ">= 0"),
            ("peak", self.peak, 0.0 < self.peak <= 1000.0, "above 0 and up to 1000 m/s^2"),
            ("damping", self.damping, 0.0 < self.damping <= 10.0, "above 0 and up to 10"),
            ("interval", self.interval, self.interval > 0.0, "above 0 s"),
            (
                "duration",
                self.duration,
                100 * self.interval <= self.duration <= 1e7 * self.interval,
                "from 100 to 1e7 times the interval",
            ),
            (
                "frequency",
                self.frequency,
                1.0 / self.duration <= self.frequency <= 0.25 / self.interval,
                "from 1 / duration to 0.25 / interval",
            ),
        )
        for name, value, fits, allowed in bounds:
            if not fits:
                raise InputError(f"--{name}", "", value, f"must be {allowed}")

    @property
    def text(self) -> str:
        """How the motion was made, for its provenance."""
        return (
            f"stochastic motion, seed {self.seed}: spectrum of Kanai, Tajimi, Clough and Penzien "
            f"({self.frequency:g} Hz, damping {self.damping:g}), envelope of Jennings, Housner and "
            f"Tsai over {self.duration:g} s, brought to rest, scaled to {self.peak:g} m/s^2"
        )


def spectrum(noise: GroundNoise, frequency: npt.ArrayLike) -> Array:
    """Power spectrum of the stationary motion, one on the rock below [-].

    Args:
        noise: What makes the motion.
        frequency: [Hz], shape [any].
    """
    f = np.asarray(frequency, dtype=np.float64)
    r, q, z = f / noise.frequency, f / (HIGH_PASS * noise.frequency), noise.damping
    ground = (1.0 + (2.0 * z * r) ** 2) / ((1.0 - r**2) ** 2 + (2.0 * z * r) ** 2)
    return np.asarray(ground * q**4 / ((1.0 - q**2) ** 2 + (2.0 * z * q) ** 2))


def stationary(noise: GroundNoise, count: int) -> Array:
    """The motion before its envelope, of no certain size, shape [sample].

    Args:
        noise: What makes the motion.
        count: Number of samples.
    """
    random = np.random.Generator(np.random.PCG64(noise.seed))
    coefficients = random.standard_normal((2, count // 2 + 1))
    frequency = np.fft.rfftfreq(count, noise.interval)
    size = np.sqrt(spectrum(noise, frequency))
    size[0] = 0.0
    return np.fft.irfft(size * (coefficients[0] + 1j * coefficients[1]), count)


def stochastic_motion(noise: GroundNoise) -> Sampled:
    """A motion that starts and ends at rest.

    Args:
        noise: What makes it.
    """
    count = round(noise.duration / noise.interval) + 1
    part = np.arange(count) / (count - 1)
    shape = envelope(part)
    noisy, constant, straight = (
        Sampled(shape * values, noise.interval)
        for values in (stationary(noise, count), np.ones(count), part)
    )
    ends = [[integral[-1] for integral in each.integrals()] for each in (constant, straight)]
    wanted = [-integral[-1] for integral in noisy.integrals()]
    sizes = np.linalg.solve(np.transpose(ends), wanted)
    samples = noisy.samples + sizes[0] * constant.samples + sizes[1] * straight.samples
    return Sampled(noise.peak / np.max(np.abs(samples)) * samples, noise.interval)


def envelope(part: Array) -> Array:
    """Envelope at times / duration, shape [sample]."""
    decay = math.log(1.0 / LEFT) / (1.0 - STRONG)
    return np.where(
        part < RISE,
        (part / RISE) ** 2,
        np.where(part < STRONG, 1.0, np.exp(-decay * (part - STRONG))),
    )
