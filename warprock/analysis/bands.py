"""Bands of lognormal fits: over records, by leaving out one after the other, and of the fit alone.

Lanes of one record are alike, so that records and not lanes are the sample. With y the logarithm of
the median or of the dispersion, y_(i) its value without record i, and G records,

    centre           c = y - bias,   bias = (G - 1) (mean of y_(i) - y), at most the error
    standard error   s,              s^2 = (G - 1) / G sum of (y_(i) - y)^2

(Quenouille 1956, Tukey 1958), and r the correlation of both among the y_(i). The bias matters: with
few records, each with a capacity of its own, greatest likelihood finds a dispersion that is too
small. The band of the fit alone takes every lane for a record of its own: s and r are those of the
curvature of the likelihood, without a bias.

With t the quantile of Student's distribution of G - 1 degrees of freedom, of weighted records of
their effective number less one, of the fit alone that of a normal one, the bands are

    ln(median)       c -+ t s
    ln(dispersion)   c - (3/2) ln(1 +- t (2/3) s)

The second says that the cube root of a variance, not its logarithm, is spread evenly (Wilson and
Hilferty 1931): where a sample has a small dispersion by chance, its error is small by chance, too,
and the truth lies above the band more often than below.

A number f of both, such as a probability or a yearly rate, has the band

    f(c) -+ (u^2 + v^2 +- 2 r u v)^1/2,

u and v how far it goes with the end of one band and the centre of the other: each side from the
ends of its own side (Zou, Huo and Taleban 2009, for the mean of a lognormal sample; Zou and Donner
2008, with a correlation). Of a rate in place of f itself its logarithm, of a probability its score.

In studies of known truth with 5 to 44 records, 1000 of each kind, these bands held the median in 88
to 94 of 100, the dispersion in 86 to 97 (96 to 97 where records are five), the probability at the
median in 89 to 94 and a yearly rate in 86 to 94 (`python -m tests.shared.fragility_studies`; the
standard error is 1). Without the last two steps, with f -+ t s of the numbers without one record
each, 6 to 8 records held the rate in 85 to 87, and 10 to 13 of the others lay above the band; the
dispersion of 6 in 82. Bands of resampled records (the bootstrap) held
the dispersions of six in 48 to 66 (percentiles), 60 to 66 (bias-corrected and accelerated) and 71
to 80 (studentised).

References:
    Cameron and Miller (2015), A practitioner's guide to cluster-robust inference, *Journal of Human
    Resources* 50, section VI, for few clusters. Quenouille (1956), Notes on bias in estimation,
    *Biometrika* 43. Tukey (1958), Bias and confidence in not quite large samples, *Annals of
    Mathematical Statistics* 29. Wilson and Hilferty (1931), The distribution of chi-square,
    *Proceedings of the National Academy of Sciences* 17. Zou and Donner (2008), Construction of
    confidence limits about effect measures: a general approach, *Statistics in Medicine* 27. Zou,
    Huo and Taleban (2009), Simple confidence intervals for lognormal means and their differences
    with environmental applications, *Environmetrics* 20.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

BAND = (5.0, 95.0)
"""Percentiles that bound the bands."""
LEAST_RECORDS = 5
"""Records below which a band over them would say nothing."""
FEW_RECORDS = 10
"""Records below which a band is there, with a warning."""
MOST_PARTS = 100
"""Parts into which records are shared out at most: Student's quantile is within 1 % by then."""
FARTHEST = 3.0
"""Change of a logarithm, at most, that one step towards a fit that is not there may make."""
WIDEST = 0.8
"""t (2/3) s of a dispersion, at most: its band then ends at 11 times the dispersion, which says
that records do not tell it."""


@dataclasses.dataclass(frozen=True)
class Estimate:
    """A median and a dispersion with the errors of their logarithms, see the head of this file.

    Attributes:
        centre: ln(median) and ln(dispersion), without bias.
        errors: Their standard errors.
        correlation: Of the two errors.
        freedom: Degrees of freedom of the errors; infinite where they are known.
    """

    centre: tuple[float, float]
    errors: tuple[float, float]
    correlation: float
    freedom: float = np.inf

    def following(self, number: Callable[[Array, Array], Array]) -> tuple[float, float]:
        """Percentiles `BAND` of a number above 0 that follows from the fit.

        Args:
            number: The number, of medians and dispersions of shape [fit].
        """
        with np.errstate(over="ignore"):
            values = np.log(number(*self._ends))
        low, high = self._around(values[:, None])
        return float(np.exp(low[0])), float(np.exp(high[0]))

    def scores(self, intensity: Array) -> tuple[Array, Array]:
        """Percentiles `BAND` of the standard scores of intensities, shape of `intensity`."""
        median, dispersion = self._ends
        return self._around((np.log(intensity) - np.log(median)[:, None]) / dispersion[:, None])

    @property
    def _ends(self) -> tuple[Array, Array]:
        """Medians and dispersions: at the centre, and with one of either band's ends each."""
        from scipy.special import ndtri, stdtrit

        share = 0.01 * BAND[1]
        t = float(ndtri(share) if np.isinf(self.freedom) else stdtrit(self.freedom, share))
        (middle, spread), (median_error, spread_error) = self.centre, self.errors
        tilt = min(t * spread_error / 1.5, WIDEST)
        ends = np.array(
            [
                [middle, spread],
                [middle - t * median_error, spread],
                [middle + t * median_error, spread],
                [middle, spread - 1.5 * np.log1p(tilt)],
                [middle, spread - 1.5 * np.log1p(-tilt)],
            ]
        )
        return np.exp(ends[:, 0]), np.exp(ends[:, 1])

    def _around(self, values: Array) -> tuple[Array, Array]:
        """Ends of the band of numbers at the `_ends`, shape [end, number]."""
        centre = values[0]
        by_median, by_spread = values[1:3] - centre, values[3:5] - centre
        sense = np.sign(by_median[1] - by_median[0]) * np.sign(by_spread[1] - by_spread[0])
        found = []
        for side in (-1.0, 1.0):
            u, v = (np.max(np.maximum(side * each, 0.0), axis=0) for each in (by_median, by_spread))
            with np.errstate(over="ignore", invalid="ignore"):
                square = u * u + v * v + 2.0 * self.correlation * sense * u * v
            far = np.where(np.isinf(u) | np.isinf(v), np.inf, np.sqrt(np.maximum(square, 0.0)))
            found.append(centre + side * far)
        return found[0], found[1]


@dataclasses.dataclass(frozen=True)
class Band:
    """Fits without a part of the records each.

    Attributes:
        median: Median of the fit to all records.
        dispersion: Its dispersion.
        medians: Medians without one of the parts each, shape [part].
        dispersions: Dispersions likewise, shape [part].
        records: Number of records; each is a part where there are no more than `MOST_PARTS`.
        effective: Their effective number, less where they have weights that differ.
        stepped: Parts without which there is no fit, so that one step towards it stands for it.
        others: Bands that this one reaches around as well.
    """

    median: float
    dispersion: float
    medians: Array
    dispersions: Array
    records: int
    effective: float
    stepped: int = 0
    others: tuple[Band, ...] = ()

    @property
    def text(self) -> str:
        """What is to be said of the bands."""
        few = f"fewer than {FEW_RECORDS} records" if self.records < FEW_RECORDS else ""
        alone = f"no fit without one of {self.stepped} records" if self.stepped else ""
        return "; ".join(filter(None, (few, alone))) or "ok"

    @property
    def estimate(self) -> Estimate:
        """The fit with its errors over records."""
        parts = np.log(np.stack([self.medians, self.dispersions]))
        whole = np.log(np.array([self.median, self.dispersion]))
        count = parts.shape[1]
        errors = np.sqrt((count - 1) / count * ((parts - whole[:, None]) ** 2).sum(axis=1))
        bias = np.clip((count - 1) * (parts.mean(axis=1) - whole), -errors, errors)
        apart = parts - parts.mean(axis=1, keepdims=True)
        size = float(np.sqrt((apart[0] ** 2).sum() * (apart[1] ** 2).sum()))
        correlation = float((apart[0] * apart[1]).sum() / size) if size > 0.0 else 0.0
        centre = whole - bias
        return Estimate(
            (float(centre[0]), float(centre[1])),
            (float(errors[0]), float(errors[1])),
            correlation,
            min(float(count), self.effective) - 1.0,
        )

    def interval(self, name: str) -> tuple[float, float]:
        """Percentiles `BAND` of `median` or `dispersion`."""
        return self.following(
            lambda median, dispersion: {"median": median, "dispersion": dispersion}[name]
        )

    def following(self, number: Callable[[Array, Array], Array]) -> tuple[float, float]:
        """Percentiles `BAND` of a number above 0 that follows from the fit.

        Args:
            number: The number, of medians and dispersions of shape [fit].
        """
        ends = [each.estimate.following(number) for each in (self, *self.others)]
        low, high = zip(*ends, strict=True)
        return min(low), max(high)

    def probabilities(self, intensity: Array) -> tuple[Array, Array]:
        """Percentiles `BAND` of the probability at some intensities, shape of `intensity`."""
        from scipy.special import ndtr

        found = [each.estimate.scores(intensity) for each in (self, *self.others)]
        low, high = zip(*found, strict=True)
        return np.asarray(ndtr(np.min(low, axis=0))), np.asarray(ndtr(np.max(high, axis=0)))


def ratio_interval(
    one: Band, other: Band, number: Callable[[Array, Array], Array]
) -> tuple[float, float]:
    """Percentiles `BAND` of the ratio of a number of two fits to the same records.

    Both lack the same record in each part, so that what the records do to both alike cancels. With
    y the logarithm of the ratio, the band is c -+ t s.

    Args:
        one: The fit above the line.
        other: The fit below it.
        number: The number, above 0, of medians and dispersions of shape [fit].

    Returns:
        NaN where the fits are not to the same number of records.
    """
    if one.records != other.records:
        return np.nan, np.nan
    whole = np.log(_of_whole(one, number) / _of_whole(other, number))
    without = np.log(
        number(one.medians, one.dispersions) / number(other.medians, other.dispersions)
    )
    low, high = np.exp(_ends(whole, without[:, None], min(one.effective, other.effective)))
    return float(low[0]), float(high[0])


def _of_whole(band: Band, number: Callable[[Array, Array], Array]) -> Array:
    """A number of the fit to all records, shape [1]."""
    return number(np.array([band.median]), np.array([band.dispersion]))


def _ends(whole: Array, without: Array, effective: float) -> tuple[Array, Array]:
    """Ends of the band c -+ t s of numbers.

    Args:
        whole: Numbers of all records, shape [number].
        without: The same without one record each, shape [record, number].
        effective: Effective number of records.
    """
    from scipy.special import stdtrit

    records = len(without)
    spread = np.sqrt((records - 1) / records * ((without - whole) ** 2).sum(axis=0))
    bias = np.clip((records - 1) * (without.mean(axis=0) - whole), -spread, spread)
    freedom = min(float(records), effective) - 1.0
    low, high = (stdtrit(freedom, 0.01 * percent) for percent in BAND)
    return whole - bias + low * spread, whole - bias + high * spread


def without_one(records: int) -> Array:
    """Weights of records in the samples of a jackknife, shape [part, record].

    Each sample lacks one part of the records.

    A part is one record; of more than `MOST_PARTS` records several, shared out by a fixed draw.
    """
    parts = min(records, MOST_PARTS)
    part = np.random.default_rng(1).permutation(records) % parts
    return np.where(part == np.arange(parts)[:, None], 0.0, 1.0)


def band_of(
    median: float,
    dispersion: float,
    records: tuple[int, float],
    fitted: tuple[Array, Array],
    steps: tuple[Array, Array],
) -> Band:
    """The band from the fits without a part each.

    Where records are few, a sample without one of them may have no fit. One step of Newton's method
    from the fit to all records, in the logarithms, then stands for it.

    Args:
        median: Of the fit to all records.
        dispersion: Likewise.
        records: Number of records, and their effective number.
        fitted: Medians and dispersions without a part each, shape [part]; NaN without a fit.
        steps: The steps of a and b there, see the head of `warprock.analysis.lognormal`, from the
            fit to all, shape [part].
    """
    da, db = steps
    moved = -dispersion * (da + np.log(median) * db), -dispersion * db
    there = np.isfinite(fitted[0]) & (fitted[1] > 0.0)
    ends = []
    for value, found, step in zip((median, dispersion), fitted, moved, strict=True):
        near = value * np.exp(np.clip(np.nan_to_num(step), -FARTHEST, FARTHEST))
        ends.append(np.where(there, found, near))
    return Band(median, dispersion, ends[0], ends[1], *records, int((~there).sum()))
