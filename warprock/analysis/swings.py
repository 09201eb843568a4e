"""The swings of a history of free rocking: their peaks and how long they last, with their errors.

Impacts are kinks of the rotation, where its size is least between two peaks. What a block does
between two of them is the same forwards and backwards from its peak: a polynomial that is even
about its peak is fitted, whose zeros are the impacts. So samples need to meet neither, and noise is
averaged. Its residuals are the noise.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

Array = npt.NDArray[np.float64]

MOST_DEGREE = 12
"""Of the polynomials: what it leaves of a swing to 0.97 of the slenderness angle is 1e-10 of the
angle, less than any sensor tells."""
GAIN = 2.0
"""Squares of residuals, over the variance of the noise, that a degree takes which is needed."""
FEWEST_SPARE = 2
"""Samples of a swing beyond the coefficients of its polynomial."""
ROUNDS = 20
"""Steps of Gauss's and Newton's method."""
FEWEST_SAMPLES = 7
"""Samples of a swing."""
CLEAR = 10.0
"""A peak counts that is this many times the noise."""


@dataclasses.dataclass(frozen=True)
class Swings:
    """Whole swings in their order, each from one impact to the next, shape [swing] each.

    Attributes:
        side: Side to which the block leans, -1 or 1.
        peak_time: When its lean is largest [s].
        peak: Its largest |rotation| [rad].
        duration: From impact to impact [s].
        peak_variance: Variance of the peak over that of a sample [-].
        duration_variance: Variance of the duration over that of a sample [s^2/rad^2].
        covariance: Of peak and duration, likewise [s/rad].
        noise: Standard deviation of a sample [rad].
    """

    side: Array
    peak_time: Array
    peak: Array
    duration: Array
    peak_variance: Array
    duration_variance: Array
    covariance: Array
    noise: float

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.peak)

    @property
    def peak_error(self) -> Array:
        """Standard error of the peaks [rad]."""
        return np.asarray(self.noise * np.sqrt(self.peak_variance))

    @property
    def duration_error(self) -> Array:
        """Standard error of the durations [s]."""
        return np.asarray(self.noise * np.sqrt(self.duration_variance))


def find_swings(times: Array, rotations: Array) -> Swings:
    """The swings of a history.

    The first one counts from its first impact on: how the block was let go is not asked. The last
    one is that before the first swing that noise hides, or that has too few samples.

    Args:
        times: [s], growing.
        rotations: [rad], 0 at rest.
    """
    fits = []
    for part in _parts(rotations):
        fit = _Fit.of(times[part], rotations[part])
        if fit is None:
            break
        fits.append(fit)
    spare = sum(fit.spare for fit in fits)
    noise = np.sqrt(sum(fit.squares for fit in fits) / spare) if fits else 0.0
    rows = np.array([fit.row for fit in fits]).reshape(-1, 7)
    clear = rows[:, 2] > CLEAR * noise * np.sqrt(rows[:, 4])
    last = int(np.argmin(clear)) if not clear.all() else len(rows)
    names = [field.name for field in dataclasses.fields(Swings)][:-1]
    return Swings(**dict(zip(names, rows[:last].T, strict=True)), noise=float(noise))


def _parts(rotations: Array) -> Iterator[slice]:
    """The samples between impacts that follow one another."""
    from scipy.signal import find_peaks

    size = np.abs(rotations)
    # A third difference of white noise has 20 times its variance; of a swing next to nothing.
    steps = np.abs(np.diff(rotations, 3))
    noise = 1.4826 * float(np.median(steps)) / np.sqrt(20.0) if len(steps) else 0.0
    least = max(CLEAR * noise, 1e-9 * float(size.max(initial=0.0)), np.finfo(float).tiny)
    # A history may begin and end with a block that leans: the zeros make a peak of that.
    peaks = find_peaks(np.concatenate([[0.0], size, [0.0]]), prominence=least)[0] - 1
    impacts = [a + int(np.argmin(size[a:b])) for a, b in itertools.pairwise(peaks)]
    # The sample next to an impact may lie on either side of it.
    for first, end in itertools.pairwise(impacts):
        yield slice(first + 1, end)


@dataclasses.dataclass(frozen=True)
class _Fit:
    """The polynomial of a swing, even about its peak.

    Attributes:
        row: Fields of `Swings` but for the noise.
        squares: Sum of the squares of its residuals [rad^2].
        spare: Samples beyond its coefficients.
    """

    row: tuple[float, ...]
    squares: float
    spare: int

    @classmethod
    def of(cls, times: Array, rotations: Array) -> _Fit | None:
        """That of the samples of a swing; None of too few, or of no swing.

        Its degree grows until one more takes from the residuals no more than from noise: what that
        one takes, too, may hide in the noise, but would move all swings to the same side.
        """
        if len(times) < FEWEST_SAMPLES:
            return None
        found, middle = None, 0.5 * float(times[0] + times[-1])
        for degree in range(2, min(MOST_DEGREE, len(times) - FEWEST_SPARE - 1) + 1, 2):
            more = _Even.of(times, rotations, middle, degree)
            if more is None:
                break
            enough = found and found.squares < more.squares * (1.0 + GAIN / more.spare)
            found, middle = more, more.middle
            if enough:
                break
        return None if found is None else found.fit()


@dataclasses.dataclass(frozen=True)
class _Even:
    """An even polynomial, sum of c_j P_2j(u) with u = (time - middle) / half.

    Attributes:
        middle: Time of the peak [s].
        half: Unit of u [s]: half the time from the first to the last sample.
        coefficients: c_j [rad], shape [j].
        inverse: Changes of the coefficients by those of samples, shape [j, sample].
        squares: Sum of the squares of the residuals [rad^2].
        spare: Samples beyond the coefficients and the middle.
    """

    middle: float
    half: float
    coefficients: Array
    inverse: Array
    squares: float
    spare: int

    @classmethod
    def of(cls, times: Array, rotations: Array, middle: float, degree: int) -> _Even | None:
        """That of least squares, by Gauss's and Newton's method from a guess of the middle."""
        half = 0.5 * float(times[-1] - times[0])
        for _ in range(ROUNDS):
            u = (times - middle) / half
            even = legendre.legvander(u, degree)[:, ::2]
            found = np.asarray(np.linalg.lstsq(even, rotations, rcond=None)[0], np.float64)
            slope = legendre.legval(u, legendre.legder(_spread_out(found)))
            inverse = np.linalg.pinv(np.column_stack([even, -slope / half]))
            residual = rotations - even @ found
            shift = float(inverse[-1] @ residual)
            middle += shift
            if not times[0] < middle < times[-1]:
                return None
            if abs(shift) < np.finfo(float).eps * times[-1]:
                break
        spare = len(times) - len(found) - 1
        return cls(middle, half, found, inverse[:-1], float(residual @ residual), spare)

    def fit(self) -> _Fit | None:
        """The swing; None where it comes back to no rotation 0."""
        whole = _spread_out(self.coefficients)
        roots = legendre.legroots(whole)
        real = roots[np.abs(np.imag(roots)) < 1e-9].real
        # The impacts lie at most a sample or two beyond the samples.
        ends = real[(real > 0.5) & (real < 1.0 + 6.0 / self.inverse.shape[1])]
        if not len(ends):
            return None
        end = float(ends.min())
        at_peak, at_end = legendre.legvander(np.array([0.0, end]), len(whole) - 1)[:, ::2]
        peak = float(at_peak @ self.coefficients)
        side = float(np.sign(peak))
        of_peak = side * at_peak @ self.inverse
        # A zero moves by -(change of the polynomial) / slope.
        steep = float(legendre.legval(end, legendre.legder(whole)))
        of_duration = -2.0 * self.half / steep * at_end @ self.inverse
        row = (
            side,
            self.middle,
            side * peak,
            2.0 * self.half * end,
            float(of_peak @ of_peak),
            float(of_duration @ of_duration),
            float(of_peak @ of_duration),
        )
        return _Fit(row, self.squares, self.spare)


def _spread_out(even: Array) -> Array:
    """Coefficients of all Legendre polynomials from those of the even ones."""
    whole = np.zeros(2 * len(even) - 1)
    whole[::2] = even
    return whole
