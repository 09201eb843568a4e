"""The likelihood of lognormal capacities that are known to lie in brackets, and its maximum.

With x = ln(intensity), b = 1/dispersion and a = -ln(median)/dispersion the likelihood of a bracket
is

    Phi(a + b x_high) - Phi(a + b x_low),

1 in place of the first term, 0 in place of the second where that end is open. It is log-concave in
(a, b) (Burridge 1981). Of lanes that ran once each it is the binomial likelihood of Baker (2015), a
probit model; of brackets it is that of `scipy.stats.CensoredData`.

References:
    Baker (2015), Efficient analytical fragility function fitting using dynamic structural analysis,
    *Earthquake Spectra* 31(1). Burridge (1981), A note on maximum likelihood estimation for
    regression models using grouped data, *Journal of the Royal Statistical Society B* 43. Kish
    (1965), *Survey Sampling*, section 11.7.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

_STEPS = 100
"""Newton steps at most; six to ten are the rule."""
_HALVINGS = 40
"""Times that a step is halved at most, where the likelihood would fall."""
_CONVERGED = 1e-12
"""Largest change of (a, b) in the last step, relative to their size."""


@dataclasses.dataclass(frozen=True)
class Brackets:
    """Between which intensities capacities lie.

    Attributes:
        low: Largest intensity that the capacity is known to lie above; 0 without, shape [row].
        high: Smallest that it is known not to exceed; infinite without, shape [row].
        count: Lanes of the row, shape [row].
        record: Number of the record that the row belongs to, from 0, shape [row].
        weight: Weight of each record, > 0, shape [record]; None where all weigh the same.
    """

    low: Array
    high: Array
    count: Array
    record: npt.NDArray[np.intp]
    weight: Array | None = None

    @property
    def record_count(self) -> int:
        """Records among the rows."""
        return int(self.record.max()) + 1

    @property
    def effective_records(self) -> float:
        """Records of one weight that would tell as much: (sum w)^2 / sum w^2 (Kish 1965)."""
        if self.weight is None:
            return float(self.record_count)
        return float(self.weight.sum() ** 2 / (self.weight**2).sum())

    @property
    def row_weight(self) -> Array:
        """Lanes that each row counts for; of weighted records as many as tell as much."""
        if self.weight is None:
            return self.count
        size = self.weight.sum() / (self.weight**2).sum()
        return np.asarray(self.count * (size * self.weight)[self.record])


def maximise(known: Brackets, weights: Array) -> tuple[Array, Array]:
    """Medians and dispersions of greatest likelihood of samples of records.

    Newton's method on (a, b), with halved steps where the likelihood would fall.

    Args:
        known: The lanes.
        weights: How often each record was drawn, shape [sample, record].

    Returns:
        Medians and dispersions, shape [sample]. Where there is no maximum, a median is not finite,
        or a dispersion is not above 0 or huge.
    """
    # Centred and scaled, so that the two parameters are of one size.
    with np.errstate(divide="ignore"):
        ends = np.log(np.stack([known.low, known.high]))
    middle = np.nanmean(np.where(np.isfinite(ends), ends, np.nan), axis=0)
    shift, spread = float(middle.mean()), float(max(middle.std(), 1e-9))
    likelihood = Likelihood(known, shift, spread)
    a, b = likelihood.start(weights)
    found = likelihood.logarithm(a, b, weights)
    for _ in range(_STEPS):
        da, db = likelihood.newton_step(a, b, weights)
        factor = np.ones_like(a)
        for _ in range(_HALVINGS):
            new = likelihood.logarithm(a + factor * da, b + factor * db, weights)
            worse = ~(new >= found - 1e-12 * np.abs(found))
            if not worse.any():
                break
            factor = np.where(worse, 0.5 * factor, factor)
        factor = np.where(worse, 0.0, factor)
        a, b = a + factor * da, b + factor * db
        found = np.where(worse, found, new)
        if np.all(factor * np.hypot(da, db) <= _CONVERGED * (1.0 + np.hypot(a, b))):
            break
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        return np.exp(shift - spread * a / b), spread / b


class Likelihood:
    """The likelihood of some brackets: rows with one end, hits and misses, and rows with both.

    A row with one end has the likelihood Phi(s (a + b x)), s = 1 for a hit and -1 for a miss; b may
    have any sign. Where rows have both ends it must be above 0.
    """

    def __init__(self, known: Brackets, shift: float = 0.0, spread: float = 1.0) -> None:
        """Takes the logarithms of the intensities, centred and scaled."""
        hit, miss = known.low == 0.0, np.isinf(known.high)
        one, both = np.flatnonzero(hit | miss), np.flatnonzero(~(hit | miss))
        end = np.where(hit, known.high, known.low)[one]
        self.x = (np.log(end) - shift) / spread
        self.side = np.where(hit[one], 1.0, -1.0)
        self.x_low, self.x_high = (
            (np.log(each[both]) - shift) / spread for each in (known.low, known.high)
        )
        self.rows = (known.record[one], known.record[both])
        count = known.row_weight
        self.counts = (count[one], count[both])

    def _weights(self, weights: Array) -> tuple[Array, Array]:
        """Lanes of every row in every sample, of rows with one end and with both."""
        one, both = (
            weights[:, rows] * count for rows, count in zip(self.rows, self.counts, strict=True)
        )
        return one, both

    def start(self, weights: Array) -> tuple[Array, Array]:
        """Parameters to start from: the share of hits, a slope of one."""
        from scipy.special import ndtri

        one, both = self._weights(weights)
        total = one.sum(axis=1) + both.sum(axis=1)
        hits = (one * (self.side > 0.0)).sum(axis=1) + 0.5 * both.sum(axis=1)
        middle = 0.5 * (self.x_low + self.x_high)
        mean = ((one * self.x).sum(axis=1) + (both * middle).sum(axis=1)) / total
        b = np.ones(len(weights))
        return ndtri(hits / total) * np.sqrt(2.0) - b * mean, b

    def logarithm(self, a: Array, b: Array, weights: Array) -> Array:
        """Logarithm of the likelihood, shape [sample]; -inf where b must be above 0 and is not."""
        from scipy.special import log_ndtr

        one, both = self._weights(weights)
        found = (one * log_ndtr(self.side * _scores(a, b, self.x))).sum(axis=1)
        if len(self.x_low):
            found = found + np.einsum("sl,sl->s", both, self._log_share(a, b))
        return np.asarray(found)

    def _log_share(self, a: Array, b: Array) -> Array:
        """ln(Phi(a + b x_high) - Phi(a + b x_low)), shape [sample, row]; -inf unless b > 0."""
        share = log_between(_scores(a, b, self.x_high), _scores(a, b, self.x_low))
        return np.where((b > 0.0)[:, None], share, -np.inf)

    def newton_step(self, a: Array, b: Array, weights: Array) -> tuple[Array, Array]:
        """Newton's step of (a, b) towards the greatest likelihood."""
        (g0, g1), (h00, h01, h11) = self.slopes(a, b, weights)
        determinant = h00 * h11 - h01 * h01
        with np.errstate(divide="ignore", invalid="ignore"):
            da = (h11 * g0 - h01 * g1) / determinant
            db = (h00 * g1 - h01 * g0) / determinant
        fine = np.isfinite(da) & np.isfinite(db)
        return np.where(fine, da, 0.0), np.where(fine, db, 0.0)

    def slopes(
        self, a: Array, b: Array, weights: Array
    ) -> tuple[tuple[Array, Array], tuple[Array, Array, Array]]:
        """Derivatives of the logarithm of the likelihood by (a, b), and minus the second ones."""
        from scipy.special import log_ndtr

        one, both = self._weights(weights)
        # s phi / Phi of a row, the slope of its logarithm; minus its second derivative is positive.
        t = _scores(a, b, self.x)
        ratio = np.exp(_log_density(t) - log_ndtr(self.side * t))
        slope = one * self.side * ratio
        bend = one * ratio * (ratio + self.side * t)
        x = self.x
        g0, g1 = slope.sum(axis=1), (slope * x).sum(axis=1)
        h00, h01, h11 = bend.sum(axis=1), (bend * x).sum(axis=1), (bend * x * x).sum(axis=1)
        if len(self.x_low):
            log_share = self._log_share(a, b)
            xu, xv = self.x_high, self.x_low
            u, v = _scores(a, b, xu), _scores(a, b, xv)
            ru, rv = (np.exp(_log_density(score) - log_share) for score in (u, v))
            slope, tilt = ru - rv, ru * xu - rv * xv
            g0 = g0 + (both * slope).sum(axis=1)
            g1 = g1 + (both * tilt).sum(axis=1)
            h00 = h00 + (both * (u * ru - v * rv + slope**2)).sum(axis=1)
            h01 = h01 + (both * (u * ru * xu - v * rv * xv + slope * tilt)).sum(axis=1)
            h11 = h11 + (both * (u * ru * xu**2 - v * rv * xv**2 + tilt**2)).sum(axis=1)
        return (g0, g1), (h00, h01, h11)


def log_between(upper: Array, lower: Array) -> Array:
    """ln(Phi(upper) - Phi(lower)) to full precision in both tails; -inf unless upper > lower."""
    from scipy.special import log_ndtr

    with np.errstate(invalid="ignore", divide="ignore"):
        # In the upper tail the difference is that of the mirrored scores.
        flipped = upper + lower > 0.0
        u, v = np.where(flipped, -lower, upper), np.where(flipped, -upper, lower)
        log_upper, log_lower = log_ndtr(u), log_ndtr(v)
        share = log_upper + np.log(-np.expm1(log_lower - log_upper))
    return np.where(np.isnan(share), -np.inf, share)


def _scores(a: Array, b: Array, x: Array) -> Array:
    """Standard scores a + b x, shape [sample, row]."""
    return np.asarray(a[:, None] + b[:, None] * x)


def _log_density(t: Array) -> Array:
    """Logarithm of the standard normal density."""
    return np.asarray(-0.5 * t * t - 0.5 * np.log(2.0 * np.pi))
