"""Accelerations from displacements and velocities, and one motion from two instruments.

A displacement is differentiated twice, a velocity once, as the cubic spline through its samples
(not-a-knot ends): of a smooth motion the acceleration errs by h^2 / 12 times its second derivative,
h the time between samples, or h^4 / 180 times its fourth.

An accelerometer is weak at low frequencies, where it drifts, and a displacement at high ones, where
its noise grows with the square of the frequency. Two complementary filters take of each what it is
good at: L of the displacement's acceleration and 1 - L of the measured one, with

    L(f) = 1 / (1 + (f / f0)^8),

a Butterworth low-pass of order 4 forwards and backwards. Both have one half at the crossover f0 and
no phase, so that a motion on which the two instruments agree passes unchanged.

References:
    W. T. Higgins (1975), A comparison of complementary and Kalman filtering, IEEE Transactions on
    Aerospace and Electronic Systems AES-11(3).
"""

from __future__ import annotations

import dataclasses

import numpy as np

from warprock.model.motion import Control
from warprock.recordings.sampled import Sampled, pad_length, part, require_corners

ORDER = 4
"""Order of the low-pass in each of its two passes."""


DIFFERENTIATE = "differentiate"
"""Name of the step that makes a displacement or a velocity an acceleration."""

LEAST_SPLINE = 4
"""Samples that a cubic spline needs."""


def differentiate(motion: Sampled) -> Sampled:
    """The acceleration of a displacement or a velocity.

    Raises:
        ValueError: Too few samples for a spline.
    """
    from scipy.interpolate import CubicSpline

    if len(motion.samples) < LEAST_SPLINE:
        raise ValueError(f"must have at least {LEAST_SPLINE} samples")
    times = motion.interval * np.arange(len(motion.samples))
    spline = CubicSpline(times, motion.samples)
    if motion.quantity is Control.VELOCITY:
        velocity = float(motion.samples[0])
        return Sampled(np.asarray(spline(times, 1)), motion.interval, velocity)
    return Sampled(np.asarray(spline(times, 2)), motion.interval, float(spline(0.0, 1)))


def merge(motion: Sampled, crossover: float) -> Sampled:
    """An acceleration above a frequency, and the displacement beside it below.

    Args:
        motion: The acceleration, with the displacement.
        crossover: Frequency at which each is half of the motion [Hz].

    Raises:
        ValueError: No displacement, or a frequency that is out of bounds.
    """
    from scipy import signal

    if motion.beside is None:
        raise ValueError("must be the first step, with --displacement beside the acceleration")
    require_corners(motion, crossover)
    beside = Sampled(motion.beside, motion.interval, quantity=Control.DISPLACEMENT)
    sections = signal.butter(ORDER, crossover, "lowpass", fs=1.0 / motion.interval, output="sos")
    count = pad_length(motion, crossover)
    # The noise of a displacement has large derivatives, which at an end do not cancel: it is
    # smoothed before. Beyond its ends a motion goes on as it is there, an offset too.
    smooth, drift = (
        signal.sosfiltfilt(sections, np.pad(each, count, mode="edge"))
        for each in (motion.beside, motion.samples)
    )
    low = differentiate(dataclasses.replace(beside, samples=smooth)).samples
    whole = Sampled(np.pad(motion.samples, count, mode="edge") - drift + low, motion.interval)
    return part(whole, count, count + len(motion.samples))
