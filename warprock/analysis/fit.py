"""Lognormal fragility functions by maximum likelihood, and their bands over records.

A fragility function is the probability that a demand reaches a limit state, given an intensity
measure: P = Phi(ln(intensity / median) / dispersion). With z of n lanes at an intensity the
likelihood is binomial (Baker 2015, Efficient analytical fragility function fitting using dynamic
structural analysis, *Earthquake Spectra* 31(1)): with x = ln(intensity) it is that of a probit
model Phi(a + b x), concave in (a, b), b = 1/dispersion and a = -ln(median)/dispersion.

Where no maximum exists the data say so (Albert and Anderson 1984, *Biometrika* 71): nothing or
everything reaches the limit state, or one intensity parts what does from what does not.
"""

from __future__ import annotations

import dataclasses
import enum

import numpy as np
import numpy.typing as npt

from warprock.analysis.bands import Band, band_of, without_one

Array = npt.NDArray[np.float64]

_SWEEPS = 60
"""Newton steps at most; six are the rule."""
_CONVERGED = 1e-13
"""Largest change of (a, b) in the last step, relative to their size."""
_AT_ONCE = 4_000_000
"""Numbers in the arrays of several fits, at most."""


class Verdict(enum.StrEnum):
    """Whether the data have a fragility function."""

    FITTED = "fitted"
    NONE_REACHED = "none reached"
    ALL_REACHED = "all reached"
    SEPARATED = "separated"
    FALLING = "falling"


@dataclasses.dataclass(frozen=True)
class Observations:
    """Lanes as a fragility function sees them.

    Attributes:
        intensity: Intensity measure, > 0, shape [row].
        reached: Lanes of the row that reached the limit state, shape [row].
        count: Lanes of the row, shape [row].
        cluster: Number of the record that the row belongs to, shape [row].
    """

    intensity: Array
    reached: Array
    count: Array
    cluster: npt.NDArray[np.intp]

    @property
    def cluster_count(self) -> int:
        """Records among the rows."""
        return int(self.cluster.max()) + 1


@dataclasses.dataclass(frozen=True)
class Fit:
    """A fragility function, or why there is none.

    Attributes:
        verdict: Whether there is one.
        median: Intensity at which half of the lanes reach the limit state; NaN without a fit.
        dispersion: Standard deviation of its logarithm; NaN without a fit, 0 where separated.
        low: Where nothing was fitted: the largest intensity up to which nothing reached the limit
            state, else NaN.
        high: The smallest intensity from which on everything did, else NaN.
    """

    verdict: Verdict
    median: float = np.nan
    dispersion: float = np.nan
    low: float = np.nan
    high: float = np.nan

    def probability(self, intensity: Array) -> Array:
        """Probability that the limit state is reached, shape of `intensity`."""
        from scipy.special import ndtr

        return np.asarray(ndtr(np.log(intensity / self.median) / self.dispersion))


def observe(
    intensity: Array, reached: npt.NDArray[np.bool_] | Array, record: npt.NDArray[np.intp]
) -> Observations:
    """Lanes gathered by record and intensity.

    Args:
        intensity: Of every lane, > 0, shape [lane].
        reached: Whether the limit state was reached, or the part of a lane that counts as one that
            did, shape [lane].
        record: Number of each lane's record, shape [lane].

    Raises:
        ValueError: No lanes, or an intensity that is not above 0.
    """
    if len(intensity) == 0:
        raise ValueError("lanes: got 0, must be at least 1")
    if not np.all(np.isfinite(intensity) & (intensity > 0.0)):
        raise ValueError("intensity: must be finite and > 0 in every lane")
    clusters = np.unique(record, return_inverse=True)[1]
    order = np.lexsort((intensity, clusters))
    x, c = intensity[order], clusters[order]
    first = np.flatnonzero(np.append(True, (x[1:] != x[:-1]) | (c[1:] != c[:-1])))
    return Observations(
        intensity=x[first],
        reached=np.add.reduceat(reached[order].astype(np.float64), first),
        count=np.diff(np.append(first, len(x))).astype(np.float64),
        cluster=c[first],
    )


def fit_lognormal(seen: Observations) -> Fit:
    """The fragility function of greatest likelihood, or why there is none."""
    verdict = _verdicts(seen, np.ones((1, seen.cluster_count)))[0]
    if verdict in (Verdict.FITTED, Verdict.FALLING):
        median, dispersion = _maximise(seen, np.ones((1, seen.cluster_count)))
        if dispersion[0] > 0.0:
            return Fit(Verdict.FITTED, float(median[0]), float(dispersion[0]))
        return Fit(Verdict.FALLING)
    never, always = seen.reached < seen.count, seen.reached > 0.0
    low = float(seen.intensity[never].max()) if never.any() else np.nan
    high = float(seen.intensity[always].min()) if always.any() else np.nan
    if verdict is Verdict.SEPARATED:
        return Fit(verdict, np.sqrt(low * high), 0.0, low, high)
    return Fit(verdict, low=low, high=high)


def fragility_band(seen: Observations, fit: Fit) -> Band:
    """The band over records of a fit, all lanes of a record together.

    Args:
        seen: The lanes, under two records or more.
        fit: The fit to all of them, which has a dispersion above 0.
    """
    weights = without_one(seen.cluster_count)
    medians, dispersions, da, db = np.full((4, len(weights)), np.nan)
    fitted = np.array([v is Verdict.FITTED for v in _verdicts(seen, weights)])
    x = np.log(seen.intensity)
    a, b = np.full((2, len(weights)), 1.0 / fit.dispersion)
    a = -np.log(fit.median) * b
    size = max(1, _AT_ONCE // len(x))
    for chosen, found in ((fitted, True), (~fitted, False)):
        rows = np.flatnonzero(chosen)
        for part in (rows[at : at + size] for at in range(0, len(rows), size)):
            if found:
                medians[part], dispersions[part] = _maximise(seen, weights[part])
                continue
            w = weights[part][:, seen.cluster]
            hits, misses = w * seen.reached, w * (seen.count - seen.reached)
            da[part], db[part] = _newton_step(a[part], b[part], x, hits, misses)
    found_fits = (medians, dispersions)
    return band_of(fit.median, fit.dispersion, seen.cluster_count, found_fits, (da, db))


def _verdicts(seen: Observations, weights: Array) -> list[Verdict]:
    """Whether each sample of records has a maximum of the likelihood.

    Args:
        seen: The lanes.
        weights: How often each record was drawn, shape [sample, record].
    """
    clusters = seen.cluster_count
    edges = {}
    for name, has in (("hit", seen.reached > 0.0), ("miss", seen.reached < seen.count)):
        low, high = np.full(clusters, np.inf), np.full(clusters, -np.inf)
        np.minimum.at(low, seen.cluster[has], seen.intensity[has])
        np.maximum.at(high, seen.cluster[has], seen.intensity[has])
        drawn = weights > 0.0
        edges[name] = (
            np.where(drawn, low, np.inf).min(axis=1),
            np.where(drawn, high, -np.inf).max(axis=1),
        )
    (first_hit, last_hit), (first_miss, last_miss) = edges["hit"], edges["miss"]
    found = []
    for k in range(len(weights)):
        if np.isinf(first_hit[k]):
            found.append(Verdict.NONE_REACHED)
        elif np.isinf(first_miss[k]):
            found.append(Verdict.ALL_REACHED)
        elif last_miss[k] <= first_hit[k]:
            found.append(Verdict.SEPARATED)
        elif last_hit[k] <= first_miss[k]:
            found.append(Verdict.FALLING)
        else:
            found.append(Verdict.FITTED)
    return found


def _maximise(seen: Observations, weights: Array) -> tuple[Array, Array]:
    """Medians and dispersions of greatest likelihood of samples that have them.

    Newton's method on (a, b) with halved steps where the likelihood would fall.

    Args:
        seen: The lanes.
        weights: How often each record was drawn, shape [sample, record].

    Returns:
        Medians and dispersions, shape [sample]; a negative dispersion is a falling function.
    """
    # Centred and scaled, so that the two parameters are of one size.
    logs = np.log(seen.intensity)
    shift, spread = float(logs.mean()), float(max(logs.std(), 1e-9))
    x = (logs - shift) / spread
    w = weights[:, seen.cluster]
    hits, misses = w * seen.reached, w * (seen.count - seen.reached)
    a, b = _start(x, hits, misses)
    likelihood = _likelihood(a, b, x, hits, misses)
    for _ in range(_SWEEPS):
        da, db = _newton_step(a, b, x, hits, misses)
        factor = np.ones_like(a)
        for _ in range(30):
            new = _likelihood(a + factor * da, b + factor * db, x, hits, misses)
            worse = ~(new >= likelihood - 1e-12 * np.abs(likelihood))
            if not worse.any():
                break
            factor = np.where(worse, 0.5 * factor, factor)
        a, b, likelihood = a + factor * da, b + factor * db, new
        if np.all(np.hypot(da, db) <= _CONVERGED * (1.0 + np.hypot(a, b))):
            break
    with np.errstate(divide="ignore", over="ignore"):
        return np.exp(shift - spread * a / b), spread / b


def _start(x: Array, hits: Array, misses: Array) -> tuple[Array, Array]:
    """Parameters to start from: the share of hits, a slope of one."""
    from scipy.special import ndtri

    share = hits.sum(axis=1) / (hits + misses).sum(axis=1)
    mean = ((hits + misses) * x).sum(axis=1) / (hits + misses).sum(axis=1)
    b = np.ones(len(hits))
    return ndtri(share) * np.sqrt(2.0) - b * mean, b


def _likelihood(a: Array, b: Array, x: Array, hits: Array, misses: Array) -> Array:
    """Logarithm of the likelihood, shape [sample]."""
    from scipy.special import log_ndtr

    t = a[:, None] + b[:, None] * x
    return np.asarray((hits * log_ndtr(t) + misses * log_ndtr(-t)).sum(axis=1))


def _newton_step(a: Array, b: Array, x: Array, hits: Array, misses: Array) -> tuple[Array, Array]:
    """Newton's step of (a, b) towards the greatest likelihood."""
    from scipy.special import log_ndtr

    t = a[:, None] + b[:, None] * x
    log_density = -0.5 * t * t - 0.5 * np.log(2.0 * np.pi)
    up = np.exp(log_density - log_ndtr(t))
    down = np.exp(log_density - log_ndtr(-t))
    slope = hits * up - misses * down
    # Minus the second derivative; positive, as the likelihood is concave.
    bend = hits * up * (up + t) + misses * down * (down - t)
    g0, g1 = slope.sum(axis=1), (slope * x).sum(axis=1)
    h00, h01, h11 = bend.sum(axis=1), (bend * x).sum(axis=1), (bend * x * x).sum(axis=1)
    determinant = h00 * h11 - h01 * h01
    with np.errstate(divide="ignore", invalid="ignore"):
        return (h11 * g0 - h01 * g1) / determinant, (h00 * g1 - h01 * g0) / determinant
