"""Bases that move upwards, too: what tests of several engines share."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from tests.shared.blocks import make_lanes
from warprock.model.lanes import Lanes
from warprock.model.motion import (
    Control,
    HarmonicMotions,
    RecordMotions,
    UprightMotions,
    Waveform,
    harmonic_motions,
)

Array = npt.NDArray[np.float64]


def sampled(accelerations: Array, interval: float) -> RecordMotions:
    """Records of accelerations [m/s^2], linear between samples, shape [lane, sample]."""
    count, samples = accelerations.shape
    slope = np.zeros_like(accelerations)
    slope[:, :-1] = np.diff(accelerations, axis=1) / interval
    gained = 0.5 * interval * (accelerations[:, 1:] + accelerations[:, :-1])
    velocity = np.concatenate([np.zeros((count, 1)), np.cumsum(gained, axis=1)], axis=1)
    begins = accelerations.copy()
    # The last sample of a record is an empty segment.
    begins[:, -1] = 0.0
    zero = np.zeros(count)
    return RecordMotions(
        start=zero,
        scale=np.ones(count),
        offset=(samples * np.arange(count)).astype(np.int32),
        count=np.full(count, samples, np.int32),
        interval=np.full(count, interval),
        velocity_step_start=zero,
        velocity_step_stop=zero,
        pool_acceleration=begins.ravel(),
        pool_slope=slope.ravel(),
        pool_velocity=velocity.ravel(),
    )


def steady(upwards: Array, duration: float) -> UprightMotions:
    """A base that rises at a steady acceleration [m/s^2], shape [lane], and stays along x."""
    levels = np.repeat(upwards[:, None], 3, axis=1)
    interval = 0.5 * duration
    return UprightMotions(sampled(0.0 * levels, interval), sampled(levels, interval))


def shaken(
    count: int, upwards: float, duration: float, seed: int = 1, along: float = 4.0
) -> UprightMotions:
    """Records of some waves along x and upwards, of at most so many m/s^2, at unlike samples."""
    draw = np.random.default_rng(seed)

    def waves(size: float, interval: float, frequencies: tuple[float, float]) -> RecordMotions:
        time = interval * np.arange(round(duration / interval) + 1)
        f, phase = draw.uniform(*frequencies, (count, 3, 1)), draw.uniform(0.0, 6.0, (count, 3, 1))
        ramp = np.clip(np.minimum(time, duration - time) / 0.2, 0.0, 1.0)
        return sampled(size * ramp * np.sin(2.0 * np.pi * f * time + phase).mean(axis=1), interval)

    return UprightMotions(waves(along, 0.02, (0.7, 2.0)), waves(upwards, 0.01, (2.0, 6.0)))


def flights(count: int, seed: int) -> tuple[Lanes, HarmonicMotions, HarmonicMotions]:
    """Random blocks in the plane, and sines along x and upwards under which they fly and land."""
    draw = np.random.default_rng(seed)
    width = draw.uniform(0.2, 1.2, count)
    height = width * np.exp(draw.uniform(np.log(0.7), np.log(7.0), count))
    lanes = make_lanes(width, height, friction=draw.uniform(0.2, 1.0, count))
    lanes = dataclasses.replace(lanes, depth=draw.uniform(0.3, 1.2, count))

    def sine(
        size: tuple[float, float], frequency: tuple[float, float], cycles: float, late: float
    ) -> HarmonicMotions:
        f, sign = draw.uniform(*frequency, count), draw.choice([-1.0, 1.0], count)
        start = draw.uniform(0.0, late, count)
        amplitude, control = sign * draw.uniform(*size, count), [Control.ACCELERATION] * count
        return harmonic_motions(Waveform.SINE, control, amplitude, f, start, cycles / f)

    along = sine((2.0, 9.0), (1.0, 5.0), 1.0, 0.3)
    return lanes, along, sine((9.9, 16.0), (1.5, 5.0), 3.0, 0.0)
