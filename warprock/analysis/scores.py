"""How well predictions agree with observed outcomes: scores, bands over records, paired tests.

A test has an outcome y, 1 where the block overturned and 0 where it stood. A prediction gives it a
probability p, and says "overturned" or "stood". With hits and misses among tests that overturned,
false alarms and correct rejections among those that stood,

    accuracy           share of tests whose outcome was said
    balanced accuracy  mean of hits / overturned and correct rejections / stood
    Brier score        mean of (p - y)^2
    AUC                chance that a test that overturned ranks above one that stood, ties half

Tests under one record are alike: bands come from records drawn again with replacement, all tests of
a record together (the bootstrap), at the same draws for all predictions.

References:
    Brier (1950), Verification of forecasts expressed in terms of probability, *Monthly Weather
    Review* 78. Hanley and McNeil (1982), The meaning and use of the area under a receiver operating
    characteristic curve, *Radiology* 143. McNemar (1947), Note on the sampling error of the
    difference between correlated proportions or percentages, *Psychometrika* 12; exact as a
    binomial test. Broecker and Smith (2007), Increasing the reliability of reliability diagrams,
    *Weather and Forecasting* 22.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from warprock.analysis.bands import BAND, LEAST_RECORDS

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Records = npt.NDArray[np.intp]

DRAWS = 1000
"""Draws of records: the ends of a band vary by some 5 % of its width from seed to seed."""
SCORES = ("accuracy", "balanced_accuracy", "auc", "brier")
"""Scores in the order of tables; the Brier score is better the smaller it is."""
LEAST_RANKED = 3
"""Tests below which nothing is said of their order."""
BINS = 10
"""Intervals of equal width that a reliability diagram parts probabilities into."""


@dataclasses.dataclass(frozen=True)
class Prediction:
    """What is predicted of some tests.

    Attributes:
        name: Who predicts.
        probability: Probability of overturning, 0 to 1, shape [test].
        says: Whether the test is said to overturn, shape [test].
        rank: What tests are ranked by, the likeliest to overturn last, shape [test].
    """

    name: str
    probability: Array
    says: Mask
    rank: Array

    def take(self, tests: npt.NDArray[np.intp] | Mask) -> Prediction:
        """What is predicted of some of the tests."""
        parts = (self.probability[tests], self.says[tests], self.rank[tests])
        return Prediction(self.name, *parts)


@dataclasses.dataclass(frozen=True)
class Scores:
    """Scores of one prediction.

    Attributes:
        tests: Tests that are predicted.
        hits: Overturned, and said to.
        misses: Overturned, and said to stand.
        false_alarms: Stood, and said to overturn.
        correct_rejections: Stood, and said to.
        values: The `SCORES`; NaN where there is none, such as the AUC where no test overturned.
        bands: Their percentiles `BAND` over records; NaN with too few records.
    """

    tests: int
    hits: int
    misses: int
    false_alarms: int
    correct_rejections: int
    values: dict[str, float]
    bands: dict[str, tuple[float, float]]

    @property
    def right(self) -> int:
        """Tests whose outcome was predicted correctly."""
        return self.hits + self.correct_rejections


def score(said: Prediction, observed: Mask, records: Records) -> Scores:
    """Scores of a prediction.

    Args:
        said: The prediction.
        observed: Whether each test overturned, shape [test].
        records: Number of the record of each test, shape [test].

    Raises:
        ValueError: No tests.
    """
    if not len(observed):
        raise ValueError("tests: got 0, must be at least 1")
    values = {name: float(found[0]) for name, found in _scores(said, observed, None).items()}
    bands = dict.fromkeys(SCORES, (np.nan, np.nan))
    if len(np.unique(records)) >= LEAST_RECORDS:
        drawn = _scores(said, observed, draws(records))
        bands = {name: ends(found) for name, found in drawn.items()}
    return Scores(
        tests=len(observed),
        hits=int((observed & said.says).sum()),
        misses=int((observed & ~said.says).sum()),
        false_alarms=int((~observed & said.says).sum()),
        correct_rejections=int((~observed & ~said.says).sum()),
        values=values,
        bands=bands,
    )


def draws(records: Records) -> Array:
    """How often each test is in a sample of records drawn with replacement, shape [draw, test]."""
    numbers = np.unique(records, return_inverse=True)[1]
    count = int(numbers.max()) + 1
    drawn = np.random.default_rng(1).multinomial(count, np.full(count, 1.0 / count), size=DRAWS)
    return drawn[:, numbers].astype(np.float64)


def ends(drawn: Array) -> tuple[float, float]:
    """Percentiles `BAND` of the draws that have a number."""
    there = drawn[np.isfinite(drawn)]
    if not len(there):
        return np.nan, np.nan
    low, high = np.percentile(there, BAND)
    return float(low), float(high)


def _scores(said: Prediction, observed: Mask, weights: Array | None) -> dict[str, Array]:
    """The scores of samples, shape [draw] each; of the tests as they are without weights."""
    weight = np.ones((1, len(observed))) if weights is None else weights
    right = (said.says == observed).astype(np.float64)
    total, fell = weight.sum(axis=1), weight @ observed
    stood = total - fell
    with np.errstate(invalid="ignore", divide="ignore"):
        among = (weight @ (right * observed) / fell, weight @ (right * ~observed) / stood)
        return {
            "accuracy": weight @ right / total,
            "balanced_accuracy": 0.5 * (among[0] + among[1]),
            "auc": _auc(said.rank, observed, weight, fell * stood),
            "brier": weight @ (said.probability - observed) ** 2 / total,
        }


def _auc(rank: Array, observed: Mask, weight: Array, pairs: Array) -> Array:
    """Share of pairs, one test that overturned and one that stood, in the right order."""
    order = np.argsort(rank, kind="stable")
    first = np.flatnonzero(np.append(True, np.diff(rank[order]) > 0.0))
    fell, stood = (
        np.add.reduceat(weight[:, order] * mask[order], first, axis=1)
        for mask in (observed, ~observed)
    )
    below = np.cumsum(stood, axis=1) - 0.5 * stood
    return np.asarray((fell * below).sum(axis=1) / pairs)


@dataclasses.dataclass(frozen=True)
class Paired:
    """Two predictions of the same tests.

    Attributes:
        names: Who predicts, the first and the second.
        tests: Tests that both predict.
        first_only: Tests that only the first predicts correctly.
        second_only: Tests that only the second predicts correctly.
        p_value: Of McNemar's exact test: chance that they part at least so far where both are
            right equally often; 1 where they never part.
        brier_difference: Brier score of the first less that of the second.
        brier_band: Its percentiles `BAND` over records; NaN with too few records.
    """

    names: tuple[str, str]
    tests: int
    first_only: int
    second_only: int
    p_value: float
    brier_difference: float
    brier_band: tuple[float, float]


def compare_pair(first: Prediction, second: Prediction, observed: Mask, records: Records) -> Paired:
    """Whether one of two predictions is right more often than chance explains.

    Args:
        first: A prediction.
        second: Another one of the same tests.
        observed: Whether each test overturned, shape [test].
        records: Number of the record of each test, shape [test].
    """
    from scipy.stats import binomtest

    right = [each.says == observed for each in (first, second)]
    only = [int((right[0] & ~right[1]).sum()), int((right[1] & ~right[0]).sum())]
    apart = sum(only)
    error = (first.probability - observed) ** 2 - (second.probability - observed) ** 2
    band = (np.nan, np.nan)
    if len(np.unique(records)) >= LEAST_RECORDS:
        weight = draws(records)
        band = ends(weight @ error / weight.sum(axis=1))
    return Paired(
        names=(first.name, second.name),
        tests=len(observed),
        first_only=only[0],
        second_only=only[1],
        p_value=float(binomtest(only[0], apart).pvalue) if apart else 1.0,
        brier_difference=float(error.mean()),
        brier_band=band,
    )


def reliability(probability: Array, observed: Mask) -> list[dict[str, float]]:
    """How often tests overturned that were given about the same probability.

    Args:
        probability: Probability of overturning, shape [test].
        observed: Whether each test overturned, shape [test].

    Returns:
        One row an interval of probabilities that has tests, of `BINS` from 0 to 1: its ends `from`
        and `to`, `tests`, their mean `predicted` probability, the share `observed`.
    """
    place = np.minimum(np.floor(BINS * probability), BINS - 1).astype(np.intp)
    rows = []
    for bin_number in np.unique(place):
        inside = place == bin_number
        rows.append(
            {
                "from": bin_number / BINS,
                "to": (bin_number + 1) / BINS,
                "tests": int(inside.sum()),
                "overturned": int(observed[inside].sum()),
                "predicted": float(probability[inside].mean()),
                "observed": float(observed[inside].mean()),
            }
        )
    return rows


def rank_correlation(first: Array, second: Array) -> float:
    """Spearman's rank correlation; NaN of too few numbers, or where all are the same."""
    from scipy.stats import spearmanr

    if len(first) < LEAST_RANKED or not np.ptp(first) > 0.0 or not np.ptp(second) > 0.0:
        return np.nan
    return float(spearmanr(first, second).statistic)
