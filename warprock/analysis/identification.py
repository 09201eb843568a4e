"""What a test of free rocking tells of a block: what it keeps at an impact, and its slenderness.

Between two impacts the energy of a block is that of its peak, cos(a - peak) - cos(a) in m g R, so
that two peaks in succession give the share that the impact between them leaves:

    eta^2 = [cos(a - peak_2) - cos(a)] / [cos(a - peak_1) - cos(a)].

Their logarithms have a common mean, log eta^2, and errors of two kinds: those of the peaks, known
from the noise of the history, each in two neighbours with opposite signs; and a spread from impact
to impact, of which each has its own. For a spread, the mean is that of least squares with both.
It is averaged over all spreads by their restricted likelihood, evenly in their cube root, so that
the error counts that few impacts hardly tell the spread: where there is none, errors are 1.7 times
too large, and nowhere too small by more than a third. The spread that is shown is the likeliest.

A swing to a peak lasts twice the quarter period of Housner's equation, F(peak, a) / p. Slenderness
angle a and frequency parameter p are those of least squares over the swings, each by the error of
its duration and its peak; where the swings scatter more than that, errors grow with them.

References:
    G. W. Housner (1963), The behavior of inverted pendulum structures during earthquakes, Bulletin
    of the Seismological Society of America 53(2), for energy and period of free rocking.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warprock.analysis.swings import Swings, find_swings
from warprock.errors import InputError, Said
from warprock.model import rocking
from warprock.model.hold import three_impacts

Array = npt.NDArray[np.float64]

SLENDERNESS, FREQUENCY = "slenderness", "frequency-parameter"
FITS = (SLENDERNESS, FREQUENCY)
"""What the durations of swings may be asked for."""

FEWEST = 3
"""Swings between impacts: two impacts, whose difference says what they are worth."""
SPREADS, MOST_SPREADS = 300, 4.0
"""Spreads of log eta^2 that are weighed, up to so many times its standard deviation."""
ROUND_OFF = 1e-14
"""Of log eta^2."""
STEP = 1e-5
"""Part of a value by which it is changed for a difference quotient."""
ROUNDS = 3
"""Fits of durations: their errors follow from what the fit before has found."""
TIGHT = 1e-13
"""Tolerance of the fit: next to round-off."""


@dataclasses.dataclass(frozen=True)
class Estimate:
    """A value and its standard error; the error of what is taken as known is 0."""

    value: float
    error: float = 0.0


@dataclasses.dataclass(frozen=True)
class Identified:
    """What a history of free rocking tells.

    Attributes:
        swings: Its swings, from the first impact on.
        slenderness_angle: [rad].
        frequency_parameter: [rad/s]; None where it is not known.
        restitution: Angular velocity after an impact over that before it, size for size.
        spread: Standard deviation of that from impact to impact.
        one_sided: Whether the block rocks to one side alone, off a wall.
        fits: What was found from the durations, names of `FITS`.
        given_slenderness: The slenderness angle that was given [rad]; None without one.
        given_frequency: The frequency parameter that was given [rad/s]; None without one.
        scatter: Root mean square of the differences of durations over their errors; None without
            fits.
    """

    swings: Swings
    slenderness_angle: Estimate
    frequency_parameter: Estimate | None
    restitution: Estimate
    spread: float
    one_sided: bool
    fits: tuple[str, ...] = ()
    given_slenderness: float | None = None
    given_frequency: float | None = None
    scatter: float | None = None

    @property
    def ratios(self) -> Array:
        """What each impact between two swings left of the angular velocity, shape [swing - 1]."""
        return np.exp(0.5 * np.diff(_log_energy(self.swings.peak, self.slenderness_angle.value)))

    @property
    def ratio_errors(self) -> Array:
        """Standard errors of these by the noise of their peaks, shape [swing - 1]."""
        variance = _log_variance(self.swings, self.slenderness_angle.value)
        return np.asarray(0.5 * self.ratios * np.sqrt(variance[1:] + variance[:-1]))

    @property
    def formula(self) -> float:
        """What the closed form gives: Housner's; beside a wall that of three impacts."""
        angle = np.asarray(self.slenderness_angle.value)
        found = three_impacts if self.one_sided else rocking.angular_restitution
        return float(found(angle))

    @property
    def misfit(self) -> float | None:
        """Root mean square of relative differences of durations from these [-]; None without."""
        durations = self.durations
        if durations is None:
            return None
        return float(np.sqrt(np.mean((self.swings.duration / durations - 1.0) ** 2)))

    @property
    def durations(self) -> Array | None:
        """How long Housner's equation has the swings last [s], shape [swing]."""
        if self.frequency_parameter is None:
            return None
        return durations_of(
            self.swings.peak, self.slenderness_angle.value, self.frequency_parameter.value
        )


def identify_block(
    times: Array,
    rotations: Array,
    slenderness_angle: float | None,
    frequency_parameter: float | None,
    fits: Sequence[str] = (),
    source: str = "history",
) -> Identified:
    """What a history of free rocking tells of its block.

    Args:
        times: [s], growing, shape [sample].
        rotations: [rad], 0 at rest, shape [sample].
        slenderness_angle: [rad]; may be None where it is a fit.
        frequency_parameter: [rad/s]; may be None where it is a fit, or where there is none.
        fits: What to find from the durations of swings, names of `FITS`.
        source: What errors name.

    Raises:
        InputError: It has too few swings, a peak beyond the slenderness angle, or durations that no
            block has.
    """
    swings = find_swings(times, rotations)
    if swings.count < FEWEST:
        got = Said(f"{swings.count} whole swings between impacts")
        allowed = f"must have at least {FEWEST} that stand out of the noise, of 7 samples each"
        raise InputError(source, "rotation", got, allowed)
    given, highest = slenderness_angle, float(swings.peak.max())
    if given is not None and highest >= given and SLENDERNESS not in fits:
        got = Said(f"a swing to {highest:.4g} rad")
        allowed = f"must stay below the slenderness angle, {given:.4g} rad: see --fit slenderness"
        raise InputError(source, "rotation", got, allowed)
    angle = None if given is None else Estimate(given)
    rate = None if frequency_parameter is None else Estimate(frequency_parameter)
    scatter = None
    if fits:
        angle, rate, scatter = _fit_durations(swings, slenderness_angle, frequency_parameter, fits)
    assert angle is not None
    restitution, spread = restitution_of(swings, angle)
    sides = set(swings.side.tolist())
    return Identified(
        swings=swings,
        slenderness_angle=angle,
        frequency_parameter=rate,
        restitution=restitution,
        spread=spread,
        one_sided=len(sides) == 1,
        fits=tuple(fits),
        given_slenderness=given,
        given_frequency=frequency_parameter,
        scatter=scatter,
    )


def _log_energy(peak: Array, angle: float) -> Array:
    """log[cos(a - peak) - cos(a)], shape [swing]."""
    return np.log(2.0 * np.sin(angle - 0.5 * peak) * np.sin(0.5 * peak))


def _log_variance(swings: Swings, angle: float) -> Array:
    """Variance of these logarithms by the errors of the peaks, shape [swing]."""
    per_peak = np.sin(angle - swings.peak) / np.exp(_log_energy(swings.peak, angle))
    return np.asarray((per_peak * swings.peak_error) ** 2)


def restitution_of(swings: Swings, angle: Estimate) -> tuple[Estimate, float]:
    """Restitution, and its spread from impact to impact."""
    found, error, spread = _mean_log(swings, angle.value)
    eta = np.exp(0.5 * found)
    step = STEP * angle.value
    ends = [_mean_log(swings, angle.value + sign * step)[0] for sign in (1.0, -1.0)]
    by_angle = (ends[0] - ends[1]) / (2.0 * step) * angle.error
    error_of_eta = float(0.5 * eta * np.hypot(error, by_angle))
    return Estimate(float(eta), error_of_eta), float(0.5 * eta * spread)


def _mean_log(swings: Swings, angle: float) -> tuple[float, float, float]:
    """Mean of log eta^2 over the impacts, its standard error, and the spread of single ones."""
    logs = np.diff(_log_energy(swings.peak, angle))
    variance = _log_variance(swings, angle)
    read = np.diag(variance[1:] + variance[:-1])
    read -= np.diag(variance[1:-1], 1) + np.diag(variance[1:-1], -1)
    own, axes = np.linalg.eigh(read)
    most = MOST_SPREADS * max(float(logs.std()), ROUND_OFF)
    part = np.linspace(0.0, 1.0, SPREADS + 1)[1:]
    spreads = most * part**3
    weights = 1.0 / (np.maximum(own, 0.0) + spreads[:, None] ** 2)
    ones, logs = axes.T @ np.ones_like(logs), axes.T @ logs
    information = weights @ ones**2
    means = weights @ (ones * logs) / information
    left = logs - means[:, None] * ones
    misfit = np.sum(weights * left**2 - np.log(weights), axis=1) + np.log(information)
    likelihood = np.exp(-0.5 * (misfit - misfit.min()))
    shares = likelihood / np.sum(likelihood)
    mean = float(shares @ means)
    squared = float(shares @ (1.0 / information + (means - mean) ** 2))
    return mean, float(np.sqrt(squared)), float(spreads[np.argmin(misfit)])


def durations_of(peak: Array, angle: float, rate: float) -> Array:
    """How long swings last [s], shape [swing]."""
    return np.asarray(2.0 * rocking.quarter_period_of(angle, rate, peak))


def _fit_durations(
    swings: Swings, angle: float | None, rate: float | None, fits: Sequence[str]
) -> tuple[Estimate, Estimate, float]:
    """Slenderness angle and frequency parameter by the durations of swings, and their scatter.

    Args:
        swings: The swings.
        angle: Slenderness angle [rad]; where it is asked for, a guess, or None.
        rate: Frequency parameter [rad/s]; where it is asked for, a guess, or None.
        fits: Which of them are asked for.
    """
    from scipy.optimize import least_squares

    highest = float(swings.peak.max())
    if SLENDERNESS in fits:
        angle = max(angle or 0.0, 1.5 * highest)
    assert angle is not None
    if FREQUENCY in fits:
        rate = float(np.median(durations_of(swings.peak, angle, 1.0) / swings.duration))
    assert rate is not None
    values = np.array([angle, rate])
    free = np.array([name in fits for name in FITS])
    low, high = np.array([highest, 0.0])[free], np.array([0.5 * np.pi, np.inf])[free]

    def with_free(found: Array) -> Array:
        whole = values.copy()
        whole[free] = found
        return whole

    for _ in range(ROUNDS):
        errors = _duration_errors(swings, *values)

        def misfit(found: Array, errors: Array = errors) -> Array:
            return (durations_of(swings.peak, *with_free(found)) - swings.duration) / errors

        fit = least_squares(
            misfit,
            values[free],
            bounds=(low, high),
            x_scale="jac",
            xtol=TIGHT,
            ftol=TIGHT,
            gtol=TIGHT,
        )
        values = with_free(fit.x)
    scatter = float(np.sqrt(2.0 * fit.cost / (swings.count - free.sum())))
    slopes = np.asarray(fit.jac)
    covariance = np.linalg.inv(slopes.T @ slopes) * max(1.0, scatter) ** 2
    spreads = np.zeros(2)
    spreads[free] = np.sqrt(np.diag(covariance))
    first, second = (Estimate(float(v), float(e)) for v, e in zip(values, spreads, strict=True))
    return first, second, scatter


def _duration_errors(swings: Swings, angle: float, rate: float) -> Array:
    """Standard errors of durations less those of Housner's equation to the measured peaks [s]."""
    step = STEP * np.minimum(swings.peak, angle - swings.peak)
    ends = [durations_of(swings.peak + sign * step, angle, rate) for sign in (1.0, -1.0)]
    slope = (ends[0] - ends[1]) / (2.0 * step)
    variance = swings.duration_variance - 2.0 * slope * swings.covariance
    variance = variance + slope**2 * swings.peak_variance
    round_off = 1e-12 * swings.duration
    return np.asarray(np.hypot(swings.noise * np.sqrt(np.maximum(variance, 0.0)), round_off))
