"""Yearly rates: how often a limit state is reached, of a fragility function and a hazard curve.

    rate = integral of P(x) |d lambda(x)|,   P(x) = Phi(ln(x / median) / dispersion)

(Cornell and Krawinkler 2000). On a piece of the hazard, lambda = c x^-k from x = a to b, that is
by parts

    lambda(a) P(a) - lambda(b) P(b)
      + c median^-k exp(k^2 s^2 / 2) (Phi(u + k s) - Phi(v + k s)),

s the dispersion, u and v the scores ln(b / median) / s and ln(a / median) / s. A power law alone
gives c median^-k exp(k^2 s^2 / 2) (Jalayer and Cornell 2003). Nothing is integrated by steps.

The band over records of the function goes through to the rate, and so does the band of the fit
alone (see the head of `warprock.analysis.bands`). `python -m tests.shared.fragility_studies` prints
how often they hold known rates.

Reaching a limit state is taken as a Poisson process: the chance within N years is
1 - exp(-rate N), and exp(-rate T) that of an object to have stood for its age T. The other way
round, a rock that has stood for T tells against a hazard (Brune 1996; Baker and others 2013): with
every motion above x at least as dangerous as x, rate >= lambda(x) P(x), so that where a chance of
standing of less than p is ruled out,

    lambda(x) <= -ln(p) / (T P(x)).

References:
    Baker, Abrahamson, Whitney, Board and Hanks (2013), Use of fragile geologic structures as
    indicators of unexceeded ground motions and direct constraints on probabilistic seismic hazard
    analysis, *Bulletin of the Seismological Society of America* 103(3). Brune (1996), Precariously
    balanced rocks and ground-motion maps for Southern California, *Bulletin of the Seismological
    Society of America* 86(1A). Cornell and Krawinkler (2000), Progress and challenges in seismic
    performance assessment, *PEER Center News* 3(2). Jalayer and Cornell (2003), A technical
    framework for probability-based demand and capacity factor design (DCFD) seismic formats, PEER
    Report 2003/08.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warprock.analysis.bands import Band, Estimate
from warprock.analysis.hazard import Hazard
from warprock.analysis.likelihood import log_between
from warprock.analysis.lognormal import Fit, Verdict
from warprock.errors import InputError
from warprock.units import split_unit

Array = npt.NDArray[np.float64]

MOST_OUTSIDE = 0.1
"""Share of a rate from beyond an end of the hazard above which it is refused, unless asked for."""
UNLIKELY = 0.05
"""Chance of having stood below which a hazard is ruled out, unless another is asked for."""
_NONE = (np.nan, np.nan)
"""A band that is not known."""


@dataclasses.dataclass(frozen=True)
class Function:
    """A fragility function.

    Attributes:
        name: Values of the columns that tell it from others.
        limit: Its limit state, in a word.
        fit: The lognormal function, or why there is none.
        band: Its band over records; None without.
        errors: Errors of the fit alone; None without.
        extremes: The fits in which all lanes in doubt reached the limit state, and in which none
            did; empty where that is not known.
    """

    name: dict[str, object]
    limit: str
    fit: Fit
    band: Band | None = None
    errors: Estimate | None = None
    extremes: tuple[Fit, ...] = ()


@dataclasses.dataclass(frozen=True)
class Risk:
    """How often in a year a limit state is reached.

    Attributes:
        function: The fragility function.
        hazard: The hazard.
        rate: Times in a year; NaN where there is no function.
        band: Its 5th and 95th percentile over records; of data that one intensity parts, the rates
            of the two intensities between which it lies. NaN without.
        fit_band: The same of the fit alone, as if every lane had a record of its own.
        extremes: Rates of the fits in which all lanes in doubt reached the limit state, and in
            which none did; NaN where that is not known.
        below: Share of the rate from motions weaker than the hazard tells of.
        beyond: Share of the rate from motions stronger than it tells of.
    """

    function: Function
    hazard: Hazard
    rate: float
    band: tuple[float, float]
    fit_band: tuple[float, float]
    extremes: tuple[float, float]
    below: float
    beyond: float

    def between(self, edges: Array) -> Array:
        """Rates that motions between some intensities add, of a fitted function.

        Args:
            edges: Intensities, rising, shape [edge].

        Returns:
            Shape [edge - 1].
        """
        hazard = self.hazard.cut(edges)
        total = np.cumsum(contributions(hazard, self.function.fit))
        return np.asarray(np.diff(total[np.searchsorted(hazard.edges, edges)]))

    def intensity_at(self, share: float) -> float:
        """The intensity up to which motions make a share of the rate."""
        from scipy.optimize import brentq

        fit = self.function.fit
        if not fit.dispersion > 0.0:
            return fit.median

        def missing(log_intensity: float) -> float:
            at = np.exp([log_intensity])
            hazard = self.hazard.cut(at)
            upto = np.append(hazard.edges, np.inf) <= at[0]
            return float(contributions(hazard, fit)[upto].sum()) / self.rate - share

        low = high = np.log(fit.median)
        while missing(low) > 0.0:
            low -= 1.0
        while missing(high) < 0.0:
            high += 1.0
        return float(np.exp(brentq(missing, low, high, xtol=1e-9)))


def contributions(hazard: Hazard, fit: Fit) -> Array:
    """Rates that each piece of a hazard adds, shape [piece]; see the head of this file."""
    return np.asarray(_parts(hazard, np.array([fit.median]), np.array([fit.dispersion]))[0])


def rates_of(hazard: Hazard, median: Array, dispersion: Array) -> Array:
    """Yearly rates of some lognormal functions, shape [fit].

    Args:
        hazard: The hazard.
        median: Their medians, in the unit of the hazard's measure, shape [fit].
        dispersion: Their dispersions, > 0, shape [fit].
    """
    return np.asarray(_parts(hazard, median, dispersion).sum(axis=1))


def _parts(hazard: Hazard, median: Array, dispersion: Array) -> Array:
    """Rates that each piece of a hazard adds to those of some functions, shape [fit, piece]."""
    from scipy.special import ndtr

    middle, spread = np.log(median)[:, None], dispersion[:, None]
    log_edge, slope = np.log(hazard.edges), hazard.slope
    score = (log_edge - middle) / spread
    ends = np.full((len(median), 1), np.inf)
    low, high = np.append(-ends, score, axis=1), np.append(score, ends, axis=1)
    log_mean = hazard.log_size - slope * middle + 0.5 * (slope * spread) ** 2
    swept = np.exp(log_mean + log_between(high + slope * spread, low + slope * spread))
    # Nothing falls at no motion, and no motion is stronger than all.
    nothing = np.zeros((len(median), 1))
    at_edge = np.exp(hazard.log_size[:-1] - slope[:-1] * log_edge) * ndtr(score)
    parts = np.append(nothing, at_edge, axis=1) - np.append(at_edge, nothing, axis=1) + swept
    return np.asarray(np.maximum(parts, 0.0))


def assess(function: Function, hazard: Hazard, most_outside: float = MOST_OUTSIDE) -> Risk:
    """How often in a year a limit state is reached.

    Args:
        function: The fragility function, over the measure of the hazard.
        hazard: The hazard.
        most_outside: Share of the rate that may come from beyond an end of the hazard.

    Raises:
        InputError: More of it comes from there.
    """
    fit = function.fit
    if fit.verdict is Verdict.SEPARATED:
        found = _of_parted(function, hazard)
    elif fit.verdict is not Verdict.FITTED:
        found = Risk(function, hazard, np.nan, _NONE, _NONE, _NONE, 0.0, 0.0)
    else:
        found = _of_fitted(function, hazard)
    ends = {"below": (found.below, hazard.start), "beyond": (found.beyond, hazard.end)}
    for side, (share, end) in ends.items():
        if share > most_outside:
            text = f"{end:.4g} {split_unit(hazard.measure)[1]}".rstrip()
            got = f"{100.0 * share:.3g} % of the rate of {function.limit} from {side} {text}"
            allowed = (
                f"must tell of motions so {'weak' if side == 'below' else 'strong'} that at most "
                f"{100.0 * most_outside:g} % come from {side} its end; --max-outside 1 takes all"
            )
            raise InputError(hazard.source, hazard.measure, got, allowed)
    return found


def _of_fitted(function: Function, hazard: Hazard) -> Risk:
    """The rate of a lognormal function, its bands, and what comes from beyond the hazard."""
    fit, band = function.fit, function.band
    parts = contributions(hazard, fit)
    rate = float(parts.sum())
    below = float(parts[0]) if hazard.start > 0.0 else 0.0
    beyond = float(parts[-1]) if np.isfinite(hazard.end) else 0.0
    ends = alone = _NONE

    def number(median: Array, spread: Array) -> Array:
        return rates_of(hazard, median, spread)

    if band is not None:
        ends = band.following(number)
    if function.errors is not None:
        alone = function.errors.following(number)
    others = [
        float(contributions(hazard, each).sum()) if each.verdict is Verdict.FITTED else np.nan
        for each in function.extremes
    ]
    extremes = (others[0], others[1]) if others else _NONE
    return Risk(function, hazard, rate, ends, alone, extremes, below / rate, beyond / rate)


def _of_parted(function: Function, hazard: Hazard) -> Risk:
    """The rate where one intensity parts what reaches the limit state from what does not."""
    fit = function.fit
    least, rate, most = (
        float(hazard.rate(np.array([at]))[0]) for at in (fit.high, fit.median, fit.low)
    )
    below = float(fit.median < hazard.start)
    beyond = float(fit.median > hazard.end)
    return Risk(function, hazard, rate, (least, most), _NONE, _NONE, below, beyond)


def chance_within(rate: float, years: float) -> float:
    """Chance that a limit state is reached within some years, of its yearly rate."""
    return float(-np.expm1(-rate * years))


def allowed_rate(age: float, unlikely: float = UNLIKELY) -> float:
    """The yearly rate that an object which has stood for its age allows.

    Args:
        age: Its age in years, > 0.
        unlikely: Chance of having stood below which a rate is ruled out.
    """
    return float(-np.log(unlikely) / age)


def allowed_hazard(fit: Fit, intensity: Array, age: float, unlikely: float = UNLIKELY) -> Array:
    """Rates of exceedance that an object which has stood for its age allows, shape of `intensity`.

    Args:
        fit: Its lognormal function.
        intensity: Intensities, > 0.
        age: Its age in years, > 0.
        unlikely: Chance of having stood below which a hazard is ruled out.
    """
    with np.errstate(divide="ignore"):
        return np.asarray(allowed_rate(age, unlikely) / fit.probability(intensity))


CONTRIBUTIONS = 40
"""Intervals of intensity by which rates are told apart."""


def contribution_edges(risks: Sequence[Risk]) -> Array:
    """Intensities between which the rates of some functions are told apart, evenly over the log."""
    known = [risk for risk in risks if risk.rate > 0.0]
    low = min(risk.intensity_at(0.005) for risk in known)
    high = max(risk.intensity_at(0.995) for risk in known)
    if not high > low:
        low, high = low / 1.5, high * 1.5
    return np.geomspace(low, high, CONTRIBUTIONS + 1)
