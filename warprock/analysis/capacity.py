"""Lognormal distributions of capacities that are known to lie between two intensities.

Incremental dynamic analysis gives every lane a bracket: it stood at one intensity and overturned at
the next. A lane that never overturned is censored: its capacity lies above the strongest motion it
saw; one that overturned at once has its capacity below the weakest. With x = ln(intensity) the
likelihood of a bracket is Phi(a + b x_high) - Phi(a + b x_low), b = 1/dispersion, a =
-ln(median)/dispersion, with one of the terms gone where it is open: log-concave in (a, b) (Burridge
1981, A note on maximum likelihood estimation for regression models using grouped data, *Journal of
the Royal Statistical Society B* 43). It is the likelihood of `scipy.stats.CensoredData`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.analysis.bands import Band, band_of, without_one
from warprock.analysis.fit import Fit, Verdict

Array = npt.NDArray[np.float64]

_STEPS = 100
"""Newton steps at most; ten are the rule."""
_CONVERGED = 1e-12
"""Largest change of (a, b) in the last step, relative to their size."""
_MOST_DISPERSION = 1e3
"""Dispersions above this are none: 68 % of all capacities would lie within 870 decades."""
_AT_ONCE = 4_000_000
"""Numbers in the arrays of several fits, at most."""


def fit_capacities(low: Array, high: Array) -> Fit:
    """The lognormal distribution of greatest likelihood of bracketed capacities.

    Args:
        low: Intensity at which a lane still stood, 0 where there is none, shape [lane].
        high: Intensity at which it had overturned, infinite where it never did, shape [lane].

    Returns:
        The fit; none reached where no lane overturned, all reached where no lane stood, separated
        where one intensity lies in all of the brackets.

    Raises:
        ValueError: No lanes, or a bracket whose ends are not 0 <= low < high.
    """
    if len(low) == 0 or not np.all((low >= 0.0) & (low < high)):
        raise ValueError("capacities: must be at least 1, each with 0 <= low < high")
    if np.all(np.isinf(high)):
        return Fit(Verdict.NONE_REACHED, low=float(low.min()))
    if np.all(low == 0.0):
        return Fit(Verdict.ALL_REACHED, high=float(high.max()))
    if low.max() < high.min():
        ends = float(low.max()), float(high.min())
        return Fit(Verdict.SEPARATED, np.sqrt(ends[0] * ends[1]), 0.0, *ends)
    median, dispersion = _maximise(low, high, np.ones((1, len(low))))
    if not _sound(median, dispersion)[0]:
        return Fit(Verdict.FALLING)
    return Fit(Verdict.FITTED, float(median[0]), float(dispersion[0]))


def capacity_band(low: Array, high: Array, record: npt.NDArray[np.intp], fit: Fit) -> Band:
    """The band over records of a fit, all lanes of a record together.

    Args:
        low: As in `fit_capacities`.
        high: As in `fit_capacities`.
        record: Number of each lane's record, from 0, shape [lane].
        fit: The fit to all of them, which has a dispersion above 0.
    """
    records = int(record.max()) + 1
    weights = without_one(records)[:, record]
    drawn = weights > 0.0
    parted = np.where(drawn, low, 0.0).max(axis=1) < np.where(drawn, high, np.inf).min(axis=1)
    medians, dispersions, da, db = np.full((4, len(weights)), np.nan)
    with np.errstate(divide="ignore"):
        ends = np.log(low), np.log(high)
    b = np.full(len(weights), 1.0 / fit.dispersion)
    a = -np.log(fit.median) * b
    size = max(1, _AT_ONCE // len(low))
    for at in range(0, len(weights), size):
        part = np.arange(at, min(at + size, len(weights)))
        da[part], db[part] = _newton_step(a[part], b[part], *ends, weights[part])
        some = part[~parted[part]]
        if len(some):
            medians[some], dispersions[some] = _maximise(low, high, weights[some])
    dispersions = np.where(_sound(medians, dispersions), dispersions, np.nan)
    return band_of(fit.median, fit.dispersion, records, (medians, dispersions), (da, db))


def _sound(median: Array, dispersion: Array) -> npt.NDArray[np.bool_]:
    """Whether a maximum was found; where capacities fall with the intensity b runs off to 0."""
    there = np.isfinite(median) & np.isfinite(dispersion)
    return there & (dispersion > 0.0) & (dispersion < _MOST_DISPERSION)


def _maximise(low: Array, high: Array, weights: Array) -> tuple[Array, Array]:
    """Medians and dispersions of greatest likelihood of some samples.

    Newton's method on (a, b) with halved steps where the likelihood would fall.

    Args:
        low: Lower ends of the brackets, shape [lane].
        high: Upper ends, shape [lane].
        weights: How often each lane was drawn, shape [sample, lane].

    Returns:
        Medians and dispersions, shape [sample]; not finite or not above 0 where there are none.
    """
    with np.errstate(divide="ignore"):
        ends = np.log(np.stack([low, high]))
    known = np.where(np.isfinite(ends), ends, np.nan)
    middle = np.nanmean(known, axis=0)
    # Centred and scaled, so that the two parameters are of one size.
    shift, spread = float(middle.mean()), float(max(middle.std(), 1e-9))
    x_low, x_high = (ends - shift) / spread
    a, b = np.zeros(len(weights)), np.ones(len(weights))
    likelihood = np.einsum("sl,sl->s", weights, _log_share(a, b, x_low, x_high))
    for _ in range(_STEPS):
        da, db = _newton_step(a, b, x_low, x_high, weights)
        factor = np.ones_like(a)
        for _ in range(40):
            share = _log_share(a + factor * da, b + factor * db, x_low, x_high)
            new = np.einsum("sl,sl->s", weights, share)
            worse = ~(new >= likelihood - 1e-12 * np.abs(likelihood))
            if not worse.any():
                break
            factor = np.where(worse, 0.5 * factor, factor)
        factor = np.where(worse, 0.0, factor)
        a, b = a + factor * da, b + factor * db
        likelihood = np.where(worse, likelihood, new)
        if np.all(factor * np.hypot(da, db) <= _CONVERGED * (1.0 + np.hypot(a, b))):
            break
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        return np.exp(shift - spread * a / b), spread / b


def _scores(a: Array, b: Array, x: Array) -> Array:
    """Standard scores a + b x, shape [sample, lane]; x may be infinite, b is above 0 then."""
    return np.asarray(a[:, None] + b[:, None] * x)


def _log_share(a: Array, b: Array, x_low: Array, x_high: Array) -> Array:
    """ln(Phi(a + b x_high) - Phi(a + b x_low)), shape [sample, lane]; -inf where b is not > 0."""
    from scipy.special import log_ndtr

    with np.errstate(invalid="ignore", divide="ignore"):
        u, v = _scores(a, b, x_high), _scores(a, b, x_low)
        # In the upper tail the difference is that of the mirrored scores.
        flipped = u + v > 0.0
        u, v = np.where(flipped, -v, u), np.where(flipped, -u, v)
        upper, lower = log_ndtr(u), log_ndtr(v)
        share = upper + np.log(-np.expm1(lower - upper))
    return np.where((b > 0.0)[:, None] & ~np.isnan(share), share, -np.inf)


def _newton_step(
    a: Array, b: Array, x_low: Array, x_high: Array, weights: Array
) -> tuple[Array, Array]:
    """Newton's step of (a, b) towards the greatest likelihood."""
    log_share = _log_share(a, b, x_low, x_high)

    def end(x: Array) -> tuple[Array, Array, Array]:
        """x, its score, and its density over the share; zeros where it is open."""
        closed = np.isfinite(x)
        plain = np.where(closed, x, 0.0)
        t = _scores(a, b, plain)
        density = np.exp(-0.5 * t * t - 0.5 * np.log(2.0 * np.pi) - log_share)
        return plain, t, np.where(closed, density, 0.0)

    (xu, u, ru), (xv, v, rv) = end(x_high), end(x_low)
    slope, tilt = ru - rv, ru * xu - rv * xv
    # Minus the second derivatives; as a matrix positive, as the likelihood is log-concave.
    h00 = np.sum(weights * (u * ru - v * rv + slope**2), axis=1)
    h01 = np.sum(weights * (u * ru * xu - v * rv * xv + slope * tilt), axis=1)
    h11 = np.sum(weights * (u * ru * xu**2 - v * rv * xv**2 + tilt**2), axis=1)
    g0, g1 = np.sum(weights * slope, axis=1), np.sum(weights * tilt, axis=1)
    determinant = h00 * h11 - h01 * h01
    with np.errstate(divide="ignore", invalid="ignore"):
        da = (h11 * g0 - h01 * g1) / determinant
        db = (h00 * g1 - h01 * g0) / determinant
    fine = np.isfinite(da) & np.isfinite(db)
    return np.where(fine, da, 0.0), np.where(fine, db, 0.0)
