"""Lognormal functions by maximum likelihood, and their bands over records.

A fragility function is the probability that a lane has reached a limit state at an intensity:
P = Phi(ln(intensity / median) / dispersion). What is known of a lane is a bracket of its capacity,
the intensity at which it reaches the limit state: a lane that ran at x and reached it has its
capacity in (0, x], one that did not in (x, inf), and one that an incremental analysis saw stand at
one intensity and fall at the next lies between the two. See `warprock.analysis.likelihood`.

Where no maximum exists the data say so (Albert and Anderson 1984, On the existence of maximum
likelihood estimates in logistic regression models, *Biometrika* 71): nothing or everything reaches
the limit state, or one intensity parts what does from what does not.
"""

from __future__ import annotations

import dataclasses
import enum

import numpy as np
import numpy.typing as npt

from warprock.analysis.bands import LEAST_RECORDS, Band, Estimate, band_of, without_one
from warprock.analysis.likelihood import Brackets, Likelihood, maximise

Array = npt.NDArray[np.float64]

_MOST_DISPERSION = 1e3
"""Dispersions above this are none: 68 % of all capacities would lie within 870 decades."""
_AT_ONCE = 4_000_000
"""Numbers in the arrays of several fits, at most."""


class Verdict(enum.StrEnum):
    """Whether the data have a lognormal function."""

    FITTED = "fitted"
    NONE_REACHED = "none reached"
    ALL_REACHED = "all reached"
    SEPARATED = "separated"
    FALLING = "falling"


@dataclasses.dataclass(frozen=True)
class Observations:
    """Lanes that ran at one intensity each, gathered by record and intensity.

    Attributes:
        intensity: Intensity measure, > 0, shape [row].
        reached: Lanes of the row that reached the limit state, shape [row].
        count: Lanes of the row, shape [row].
        record: Number of the record that the row belongs to, shape [row].
    """

    intensity: Array
    reached: Array
    count: Array
    record: npt.NDArray[np.intp]

    @property
    def record_count(self) -> int:
        """Records among the rows."""
        return int(self.record.max()) + 1

    @property
    def brackets(self) -> Brackets:
        """What hits and misses say of capacities: a hit at x is (0, x], a miss (x, inf)."""
        missed = self.count - self.reached
        hit, miss = np.flatnonzero(self.reached > 0.0), np.flatnonzero(missed > 0.0)
        return Brackets(
            low=np.append(np.zeros(len(hit)), self.intensity[miss]),
            high=np.append(self.intensity[hit], np.full(len(miss), np.inf)),
            count=np.append(self.reached[hit], missed[miss]),
            record=np.append(self.record[hit], self.record[miss]),
        )


@dataclasses.dataclass(frozen=True)
class Fit:
    """A lognormal function, or why there is none.

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
    numbers = np.unique(record, return_inverse=True)[1]
    order = np.lexsort((intensity, numbers))
    x, c = intensity[order], numbers[order]
    first = np.flatnonzero(np.append(True, (x[1:] != x[:-1]) | (c[1:] != c[:-1])))
    return Observations(
        intensity=x[first],
        reached=np.add.reduceat(reached[order].astype(np.float64), first),
        count=np.diff(np.append(first, len(x))).astype(np.float64),
        record=c[first],
    )


def bracket_lanes(low: Array, high: Array, record: npt.NDArray[np.intp]) -> Brackets:
    """Lanes of an incremental analysis, a row each.

    Args:
        low: Intensity at which a lane still stood, 0 where there is none, shape [lane].
        high: Intensity at which it had overturned, infinite where it never did, shape [lane].
        record: Number of each lane's record, from 0, shape [lane].

    Raises:
        ValueError: No lanes, or a bracket whose ends are not 0 <= low < high.
    """
    if len(low) == 0 or not np.all((low >= 0.0) & (low < high)):
        raise ValueError("capacities: must be at least 1, each with 0 <= low < high")
    return Brackets(low, high, np.ones(len(low)), record)


def fit_lognormal(known: Brackets) -> Fit:
    """The lognormal function of greatest likelihood, or why there is none."""
    sample = np.ones((1, known.record_count))
    verdict = _verdicts(known, sample)[0]
    if verdict in (Verdict.FITTED, Verdict.FALLING):
        median, dispersion = maximise(known, sample)
        if _sound(median, dispersion)[0]:
            return Fit(Verdict.FITTED, float(median[0]), float(dispersion[0]))
        return Fit(Verdict.FALLING)
    low, high = float(known.low.max()), float(known.high.min())
    if verdict is Verdict.SEPARATED:
        return Fit(verdict, np.sqrt(low * high), 0.0, low, high)
    return Fit(verdict, low=low) if verdict is Verdict.NONE_REACHED else Fit(verdict, high=high)


def record_band(known: Brackets, fit: Fit) -> Band:
    """The band over records of a fit, all lanes of a record together.

    Args:
        known: The lanes, under two records or more.
        fit: The fit to all of them, which has a dispersion above 0.
    """
    weights = without_one(known.record_count)
    medians, dispersions, da, db = np.full((4, len(weights)), np.nan)
    may_fit = np.array([verdict is Verdict.FITTED for verdict in _verdicts(known, weights)])
    b = np.full(len(weights), 1.0 / fit.dispersion)
    a = -np.log(fit.median) * b
    likelihood = Likelihood(known)
    size = max(1, _AT_ONCE // len(known.low))
    for at in range(0, len(weights), size):
        part = np.arange(at, min(at + size, len(weights)))
        da[part], db[part] = likelihood.newton_step(a[part], b[part], weights[part])
        some = part[may_fit[part]]
        if len(some):
            medians[some], dispersions[some] = maximise(known, weights[some])
    dispersions = np.where(_sound(medians, dispersions), dispersions, np.nan)
    fitted = (medians, dispersions)
    records = known.record_count, known.effective_records
    return band_of(fit.median, fit.dispersion, records, fitted, (da, db))


def bands_of(known: Brackets, fit: Fit) -> tuple[Band | None, Estimate | None]:
    """The band of a fit over records, None with too few of them, and the errors of the fit alone.

    Both are None without a fit.
    """
    if not fit.dispersion > 0.0:
        return None, None
    enough = known.record_count >= LEAST_RECORDS
    return record_band(known, fit) if enough else None, fit_errors(known, fit)


def fit_errors(known: Brackets, fit: Fit) -> Estimate:
    """Errors of a fit alone, as if every lane had a record of its own.

    Args:
        known: The lanes.
        fit: The fit to all of them, which has a dispersion above 0.
    """
    b = 1.0 / fit.dispersion
    middle = float(np.log(fit.median))
    everything = np.ones((1, known.record_count))
    at = np.array([-middle * b]), np.array([b])
    _, (h00, h01, h11) = Likelihood(known).slopes(*at, everything)
    inverse = np.linalg.inv(np.array([[h00[0], h01[0]], [h01[0], h11[0]]]))
    # ln(median) = -a / b and ln(dispersion) = -ln b.
    slope = np.array([[-1.0, -middle], [0.0, -1.0]]) / b
    spread = slope @ inverse @ slope.T
    errors = np.sqrt(np.diag(spread))
    return Estimate(
        (middle, float(np.log(fit.dispersion))),
        (float(errors[0]), float(errors[1])),
        float(spread[0, 1] / (errors[0] * errors[1])),
    )


def _sound(median: Array, dispersion: Array) -> npt.NDArray[np.bool_]:
    """Whether a maximum was found; where lanes fall less at a greater intensity b is not above 0.

    Brackets keep b above 0, so that it runs towards 0 then.
    """
    there = np.isfinite(median) & np.isfinite(dispersion)
    return there & (dispersion > 0.0) & (dispersion < _MOST_DISPERSION)


def _verdicts(known: Brackets, weights: Array) -> list[Verdict]:
    """Whether each sample of records has a maximum of the likelihood.

    Args:
        known: The lanes.
        weights: How often each record was drawn, shape [sample, record].
    """
    drawn = weights > 0.0
    hit, miss = known.low == 0.0, np.isinf(known.high)
    ends = {
        "low": (known.low, np.maximum, -np.inf, hit | ~hit),
        "high": (known.high, np.minimum, np.inf, hit | ~hit),
        "hit": (known.high, np.maximum, -np.inf, hit),
        "miss": (known.low, np.minimum, np.inf, miss),
        "inside": (np.ones(len(hit)), np.maximum, -np.inf, ~hit & ~miss),
    }
    found = {}
    for name, (values, farthest, none, rows) in ends.items():
        of_record = np.full(known.record_count, none)
        farthest.at(of_record, known.record[rows], values[rows])
        found[name] = farthest.reduce(np.where(drawn, of_record, none), axis=1)
    return [
        Verdict.NONE_REACHED
        if np.isinf(found["high"][k])
        else Verdict.ALL_REACHED
        if found["low"][k] == 0.0
        else Verdict.SEPARATED
        if found["low"][k] <= found["high"][k]
        else Verdict.FALLING
        if found["inside"][k] < 0.0 and found["hit"][k] <= found["miss"][k]
        else Verdict.FITTED
        for k in range(len(weights))
    ]
