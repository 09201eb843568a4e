"""Which intensity measures tell best whether a limit state is reached: one, or two together.

The probability that a lane with the measures x and z reaches a limit state is

    P = Phi(a + b ln x + c ln z),

a probit model; with c = 0 it is the lognormal function of `warprock.analysis.lognormal`. The second
measure is tested twice: by twice the gain of the logarithm of the likelihood, chi-square with one
degree of freedom where lanes are independent (Wilks 1938), and, since lanes of one record are
alike, by c over its standard error with one record left out after the other, Student's with G - 1
degrees of freedom. A measure is sufficient beside another where this one adds nothing to it (Luco
and Cornell 2007).

How well measures predict is told of records that a fit has not seen: each record (of more than 100
each of 100 parts of them) is predicted by the fit to all others. The loss is minus the logarithm of
the probability of what became of a lane, in the mean over lanes (of weighted records by their
weights); chances closer to 0 and 1 than half a lane of the fit are not claimed. A measure is more
efficient where its loss is lower (Giovenale, Cornell and Esteva 2004, ask the same of the
dispersion of a demand). Differences of losses have standard errors over records.

References:
    Giovenale, Cornell and Esteva (2004), Comparing the adequacy of alternative ground motion
    intensity measures for the estimation of structural responses, *Earthquake Engineering and
    Structural Dynamics* 33. Luco and Cornell (2007), Structure-specific scalar intensity measures
    for near-source and ordinary earthquake ground motions, *Earthquake Spectra* 23(2). Wilks
    (1938), The large-sample distribution of the likelihood ratio for testing composite hypotheses,
    *Annals of Mathematical Statistics* 9.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.analysis.bands import without_one
from warprock.analysis.fragility import INTENSITY, Curve, fragility_curves
from warprock.analysis.groups import Weights, record_numbers, record_weights
from warprock.analysis.limits import Limit, find_reached
from warprock.analysis.lognormal import Fit, Verdict
from warprock.errors import InputError, Said
from warprock.model.response import USABLE_NAMES

Array = npt.NDArray[np.float64]

RATIO = "velocity_acceleration_ratio_s"
"""Peak velocity over peak acceleration of a motion [s]: how long its pulses are."""
PGV = "peak_velocity_m_s"
USUAL = (
    *(INTENSITY, PGV, "normalised_acceleration", "normalised_velocity"),
    "spectral_acceleration_m_s2",
)
"""Measures that are compared where none are asked for and the table has them."""
MOST_MEASURES = 12
LEAST_RECORDS = 3
"""Records below which none can be predicted from others."""
SUFFICIENT = 0.05
"""Chance of a coefficient as far from 0 by mere draw of records, above which a measure counts as
sufficient."""
SLICES = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Quantiles of the second measure at which slices of a function of two are taken."""
_STEPS = 50
_PARTED = -1e-6
"""Logarithm of a likelihood above which every lane is predicted correctly: there is no maximum."""
_SAME = 1e-6
"""Spread of ln x - s ln z below which two measures are the same but for a factor and a power."""


@dataclasses.dataclass(frozen=True)
class Predictor:
    """One measure, or two together.

    Attributes:
        measures: Their columns.
        coefficients: a, b and, of two, c; where they part the lanes steep ones that do.
        log_likelihood: Logarithm of the likelihood of the lanes.
        loss: Loss of records that the fit has not seen, in the mean over lanes.
        losses: The same by record, in the mean over its lanes, shape [record].
    """

    measures: tuple[str, ...]
    coefficients: Array
    log_likelihood: float
    loss: float
    losses: Array

    @property
    def parted(self) -> bool:
        """Whether it parts lanes that reached the limit state from those that did not."""
        return self.log_likelihood > _PARTED

    def probability(self, *intensities: Array) -> Array:
        """Probability that the limit state is reached, shape of the intensities."""
        from scipy.special import ndtr

        score = self.coefficients[0] + sum(
            slope * np.log(each)
            for slope, each in zip(self.coefficients[1:], intensities, strict=True)
        )
        return np.asarray(ndtr(score))

    def slice(self, second: float) -> Fit:
        """The lognormal function of the first measure where the second has a value."""
        a, b, c = self.coefficients
        if not b > 0.0:
            return Fit(Verdict.FALLING)
        median = float(np.exp(-(a + c * np.log(second)) / b))
        if self.parted:
            return Fit(Verdict.SEPARATED, median, 0.0, median, median)
        return Fit(Verdict.FITTED, median, float(1.0 / b))


@dataclasses.dataclass(frozen=True)
class Test:
    """What a second measure adds to a first.

    Attributes:
        pair: The two together; the first measure is that which is tested.
        statistic: Twice the gain of the logarithm of the likelihood.
        chance: Chance of as much by mere draw of lanes that are independent.
        t: c over its standard error over records.
        chance_over_records: Chance of as much by mere draw of records; NaN where both together part
            the lanes.
    """

    pair: Predictor
    statistic: float
    chance: float
    t: float
    chance_over_records: float

    @property
    def sufficient(self) -> bool:
        """Whether the second adds nothing that records would not bring about by their draw."""
        return self.chance_over_records >= SUFFICIENT


@dataclasses.dataclass(frozen=True)
class Predictors:
    """Measures, the one that predicts best first.

    Attributes:
        limit: The limit state.
        table: The lanes that count, with `RATIO`.
        reached: Whether each reached the limit state, shape [lane].
        weight: Weight of every record, their mean 1, shape [record].
        curves: Fragility functions of one measure, in the order of `singles`.
        singles: Measures alone.
        tests: Measures two by two: each first one with each second.
        same: Measures left out, and the one that each is a power of.
    """

    limit: Limit
    table: pd.DataFrame
    reached: npt.NDArray[np.bool_]
    weight: Array
    curves: Sequence[Curve]
    singles: Sequence[Predictor]
    tests: Sequence[Test]
    same: dict[str, str]

    @property
    def records(self) -> int:
        """Records among the lanes."""
        return len(self.weight)

    @property
    def pair(self) -> Predictor | None:
        """The two that predict best, led by that of the two that predicts better alone."""
        known = [test.pair for test in self.tests]
        if not known:
            return None
        # The same two in other words have the same loss: the better single leads.
        order = {each.measures[0]: number for number, each in enumerate(self.singles)}
        best = min(each.loss for each in known)
        close = [each for each in known if each.loss <= best + 1e-9]
        return min(close, key=lambda each: order.get(each.measures[0], len(order)))

    def gain(self, one: Predictor, other: Predictor) -> tuple[float, float]:
        """How much lower the loss of one is than that of another, and its standard error."""
        apart = other.losses - one.losses
        shares = self.weight / self.weight.sum()
        mean = float((shares * apart).sum())
        count = len(apart)
        spread = float((shares**2 * (apart - mean) ** 2).sum()) * count / max(count - 1, 1)
        return mean, float(np.sqrt(spread))


def compare_measures(
    table: pd.DataFrame,
    *,
    source: str,
    measures: Sequence[str],
    limit: Limit,
    most_doubt: float,
    weights: Weights | None = None,
) -> Predictors:
    """Compares measures over a table of lanes.

    Args:
        table: A lane table.
        source: What errors name as its source.
        measures: Columns; empty takes the usual ones that the table has.
        limit: The limit state.
        most_doubt: Share of the lanes that may be left out or in doubt.
        weights: Weights by record, or the column that has them; None where all weigh the same.

    Raises:
        InputError: A column that the table does not have, too many lanes in doubt, too few records,
            or a limit state that all lanes reach or none.
    """
    if len(measures) > MOST_MEASURES:
        raise InputError(
            "--im", "", Said(f"{len(measures)} measures"), f"must be {MOST_MEASURES} at most"
        )
    table = _with_ratio(table)
    chosen = list(dict.fromkeys(measures)) or [name for name in USUAL if name in table]
    curves = {}
    for name in chosen:
        (curves[name],) = fragility_curves(
            table,
            source=source,
            intensity=name,
            limits=[limit],
            most_doubt=most_doubt,
            weights=weights,
        )
    usable = table[table["status"].isin(USABLE_NAMES)].reset_index(drop=True)
    hit = find_reached(usable, limit)
    if hit.all() or not hit.any():
        text = "all lanes" if hit.all() else "no lane"
        allowed = "must be reached by some lanes and not by others"
        raise InputError(source, limit.name, text, allowed)
    record = record_numbers(usable)
    weight = record_weights(usable, weights, source)
    count = int(record.max()) + 1
    if count < LEAST_RECORDS:
        allowed = f"must be at least {LEAST_RECORDS}: each is predicted from the others"
        got = Said(f"{count} record{'s' * (count != 1)}")
        raise InputError(source, "record", got, allowed)
    weight = np.ones(count) if weight is None else weight / weight.mean()
    columns, same = _independent(usable, chosen)
    lanes = _Lanes(hit, record, weight)
    singles = [lanes.predictor((name,), columns) for name in chosen if name not in same]
    singles.sort(key=lambda each: each.loss)
    seconds = [*(each.measures[0] for each in singles)]
    if RATIO in columns and RATIO not in seconds:
        seconds.append(RATIO)
    tests = [
        lanes.test(first, second, columns)
        for first, second in itertools.product(singles, seconds)
        if second != first.measures[0]
    ]
    ordered = [curves[each.measures[0]] for each in singles]
    return Predictors(limit, usable, hit, weight, ordered, singles, tests, same)


def _with_ratio(table: pd.DataFrame) -> pd.DataFrame:
    """The table with peak velocity over peak acceleration, where both are above 0."""
    if RATIO in table or INTENSITY not in table or PGV not in table:
        return table
    pga, pgv = (table[name].to_numpy(dtype=np.float64) for name in (INTENSITY, PGV))
    good = np.all((pga > 0.0) & (pgv > 0.0) & np.isfinite(pga) & np.isfinite(pgv))
    return table.assign(**{RATIO: pgv / pga}) if good else table


def _independent(
    table: pd.DataFrame, chosen: Sequence[str]
) -> tuple[dict[str, Array], dict[str, str]]:
    """Logarithms of measures, and those that are a power of one before them, or do not differ."""
    columns: dict[str, Array] = {}
    same: dict[str, str] = {}
    for name in [*chosen, *([RATIO] if RATIO in table and RATIO not in chosen else [])]:
        values = np.log(table[name].to_numpy(dtype=np.float64))
        centred = values - values.mean()
        if centred.std() < _SAME:
            same[name] = ""
            continue
        twin = next((other for other, each in columns.items() if _alike(centred, each)), None)
        if twin is None:
            columns[name] = values
        else:
            same[name] = twin
    return columns, {name: twin for name, twin in same.items() if name in chosen}


def _alike(centred: Array, other: Array) -> bool:
    """Whether one logarithm is a multiple of another but for a constant."""
    apart = other - other.mean()
    slope = float((centred * apart).sum() / (apart * apart).sum())
    return bool((centred - slope * apart).std() < _SAME * centred.std())


@dataclasses.dataclass(frozen=True)
class _Lanes:
    """Lanes and what became of them.

    Attributes:
        hit: Whether each reached the limit state, shape [lane].
        record: Number of the record of each, shape [lane].
        weight: Weight of each record, shape [record].
    """

    hit: npt.NDArray[np.bool_]
    record: npt.NDArray[np.intp]
    weight: Array

    @property
    def parts(self) -> Array:
        """Records that each part leaves out are 0, shape [part, record]."""
        return without_one(len(self.weight))

    def predictor(self, names: tuple[str, ...], columns: dict[str, Array]) -> Predictor:
        """One measure, or two together, and how well they predict records unseen."""
        return self._fit(names, columns)[0]

    def _fit(self, names: tuple[str, ...], columns: dict[str, Array]) -> tuple[Predictor, Array]:
        """A predictor, and its coefficients without each part, shape [part, coefficient]."""
        from scipy.special import ndtr

        x = np.column_stack([np.ones(len(self.hit)), *(columns[name] for name in names)])
        lane_weight = self.weight[self.record]
        whole, likelihood = fit_probit(x, self.hit, lane_weight)
        size = x.shape[1]
        chance = np.empty(len(self.hit))
        parts = self.parts
        without = np.empty((len(parts), size))
        for number, kept in enumerate(parts):
            out = kept[self.record] == 0.0
            without[number], _ = fit_probit(x, self.hit, lane_weight * ~out, whole)
            least = 0.5 / max(float((~out).sum()), 1.0)
            chance[out] = np.clip(ndtr(x[out] @ without[number]), least, 1.0 - least)
        each = -np.log(np.where(self.hit, chance, 1.0 - chance))
        lanes = np.bincount(self.record)
        # The mean over all lanes is that over records of what each adds.
        by_record = np.bincount(self.record, weights=each) / lanes.mean()
        loss = float((self.weight * by_record).sum() / self.weight.sum())
        return Predictor(names, whole, likelihood, loss, by_record), without

    def test(self, first: Predictor, second: str, columns: dict[str, Array]) -> Test:
        """What a second measure adds to a first."""
        from scipy.special import chdtrc, stdtr

        pair, without = self._fit((*first.measures, second), columns)
        if first.parted:
            return Test(pair, 0.0, 1.0, 0.0, 1.0)
        statistic = max(2.0 * (pair.log_likelihood - first.log_likelihood), 0.0)
        t = chance = np.nan
        if not pair.parted:
            count = len(without)
            spread = np.sqrt(
                (count - 1) / count * ((without[:, -1] - pair.coefficients[-1]) ** 2).sum()
            )
            if spread > 0.0:
                t = float(pair.coefficients[-1] / spread)
                effective = self.weight.sum() ** 2 / (self.weight**2).sum()
                freedom = min(float(count), float(effective)) - 1.0
                chance = float(2.0 * stdtr(freedom, -abs(t)))
        return Test(pair, statistic, float(chdtrc(1.0, statistic)), t, chance)


def fit_probit(
    x: Array, hit: npt.NDArray[np.bool_], weight: Array, start: Array | None = None
) -> tuple[Array, float]:
    """The probit model of greatest likelihood, by Newton's method with halved steps.

    Args:
        x: Rows of the design, shape [lane, coefficient].
        hit: What became of each lane, shape [lane].
        weight: Weight of each lane, shape [lane].
        start: Coefficients to start from; None starts from the share of hits.

    Returns:
        The coefficients, and the logarithm of the likelihood; near 0 where a plane parts the lanes,
        which have no maximum then.
    """
    from scipy.special import log_ndtr, ndtri

    side = np.where(hit, 1.0, -1.0)
    # Centred and scaled, so that coefficients are of one size.
    shift, size = x.mean(axis=0), x.std(axis=0)
    shift[0], size[0] = 0.0, 1.0
    scaled = (x - shift) / size
    beta = np.zeros(x.shape[1])
    share = float((weight * hit).sum() / weight.sum())
    beta[0] = ndtri(np.clip(share, 1e-6, 1.0 - 1e-6))
    if start is not None:
        beta = start * size
        beta[0] = float(start[0] + (start[1:] * shift[1:]).sum())

    def logarithm(at: Array) -> float:
        return float((weight * log_ndtr(side * (scaled @ at))).sum())

    found = logarithm(beta)
    for _ in range(_STEPS):
        t = scaled @ beta
        ratio = np.exp(-0.5 * t * t - 0.5 * np.log(2.0 * np.pi) - log_ndtr(side * t))
        slope = scaled.T @ (weight * side * ratio)
        bend = (scaled * (weight * ratio * (ratio + side * t))[:, None]).T @ scaled
        step = np.linalg.lstsq(bend, slope, rcond=None)[0]
        factor = 1.0
        while factor > 1e-9 and not logarithm(beta + factor * step) >= found - 1e-12 * abs(found):
            factor *= 0.5
        beta = beta + factor * step
        found = logarithm(beta)
        if np.abs(factor * step).max() <= 1e-10 * (1.0 + np.abs(beta).max()) or found > -1e-9:
            break
    coefficients = beta / size
    coefficients[0] -= float((coefficients[1:] * shift[1:]).sum())
    return coefficients, found


@dataclasses.dataclass(frozen=True)
class Slice:
    """A function of two measures where the second has a value.

    Attributes:
        group_text: That value in words.
        limit: The limit state.
        fit: The lognormal function of the first.
    """

    group_text: str
    limit: Limit
    fit: Fit


def slices(found: Predictors) -> tuple[str, list[Slice]]:
    """The column of the first measure, and slices of the best two at quantiles of the second."""
    pair = found.pair
    if pair is None:
        return "", []
    first, second = pair.measures
    values = np.quantile(found.table[second].to_numpy(dtype=np.float64), SLICES)
    return first, [
        Slice(f"{second} {value:.4g}", found.limit, pair.slice(float(value))) for value in values
    ]
