"""The greatest likelihood of bracketed and censored capacities, and its bands."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import CensoredData, chi2, norm
from scipy.stats import t as student

from warprock.analysis import capacities
from warprock.analysis.likelihood import Brackets
from warprock.analysis.lognormal import Fit, bracket_lanes, fit_errors, observe, record_band
from warprock.analysis.lognormal import Verdict as FitVerdict

Array = np.ndarray


def lanes(low: Array, high: Array) -> Brackets:
    """Lanes of as many records."""
    return bracket_lanes(low, high, np.arange(len(low)))


def fit_capacities(low: Array, high: Array) -> Fit:
    return capacities.fit_capacities(lanes(low, high))


MEDIAN, DISPERSION = 1.1, 0.45


def bracketed(count: int, seed: int, grid: Array) -> tuple[Array, Array]:
    """Capacities of a known distribution, seen at the intensities of a grid alone."""
    draws = np.random.default_rng(seed).standard_normal(count)
    at = np.searchsorted(grid, MEDIAN * np.exp(DISPERSION * draws))
    return np.append(0.0, grid)[at], np.append(grid, np.inf)[at]


@pytest.mark.parametrize("top", [1.2, 4.0])
def test_the_fit_is_the_greatest_likelihood_of_censored_data(top: float):
    low, high = bracketed(60, 3, np.geomspace(0.6, top, 15))
    assert np.any(low == 0.0)
    assert np.any(np.isinf(high))
    inside = (low > 0.0) & np.isfinite(high)
    data = CensoredData(
        left=np.log(high[low == 0.0]),
        right=np.log(low[np.isinf(high)]),
        interval=np.log(np.stack([low[inside], high[inside]], axis=1)),
    )

    def simplex(loss, start, args, disp):
        options = {"xatol": 1e-10, "fatol": 1e-13}
        return minimize(lambda x: loss(x, *args), start, method="Nelder-Mead", options=options).x

    mean, deviation = norm.fit(data, optimizer=simplex)
    fit = fit_capacities(low, high)
    assert fit.verdict is FitVerdict.FITTED
    # The simplex sees the minimum through round-off of the loss: half of the digits.
    assert np.log(fit.median) == pytest.approx(mean, abs=1e-6)
    assert fit.dispersion == pytest.approx(deviation, rel=1e-6)


def test_narrow_brackets_are_a_sample_and_wide_ones_recover_its_distribution():
    draws = MEDIAN * np.exp(DISPERSION * np.random.default_rng(1).standard_normal(400))
    fit = fit_capacities(draws * (1.0 - 1e-4), draws * (1.0 + 1e-4))
    # The mean of a normal density over a bracket differs from its middle by (width / sigma)^2.
    assert np.log(fit.median) == pytest.approx(np.mean(np.log(draws)), abs=1e-6)
    assert fit.dispersion == pytest.approx(np.std(np.log(draws)), rel=1e-6)
    coarse = fit_capacities(*bracketed(400, 1, np.geomspace(0.3, 3.0, 8)))
    # Standard errors of 400 capacities, four of them.
    assert np.log(coarse.median / MEDIAN) == pytest.approx(0.0, abs=4.0 * DISPERSION / 20.0)
    assert coarse.dispersion == pytest.approx(DISPERSION, abs=4.0 * DISPERSION / np.sqrt(800.0))


def test_censored_lanes_count_and_not_as_fallen():
    low, high = bracketed(200, 5, np.geomspace(0.3, 1.2, 12))
    there = np.isfinite(high)
    dropped = fit_capacities(low[there], high[there])
    assert dropped.median < 0.9 * fit_capacities(low, high).median


@pytest.mark.parametrize(
    ("ends", "verdict", "low", "high"),
    [
        ([(1, np.inf), (2, np.inf)], FitVerdict.NONE_REACHED, 1.0, np.nan),
        ([(0, 1), (0, 3)], FitVerdict.ALL_REACHED, np.nan, 3.0),
        ([(1, 3), (2, 4), (0, 5), (1, np.inf)], FitVerdict.SEPARATED, 2.0, 3.0),
        ([(1, 2), (2, 4), (0, 5)], FitVerdict.SEPARATED, 2.0, 2.0),
        ([(0, 2), (5, np.inf)], FitVerdict.FALLING, np.nan, np.nan),
        ([(1, 2), (3, 4)], FitVerdict.FITTED, np.nan, np.nan),
    ],
)
def test_capacities_without_a_distribution_say_so(
    ends: list[tuple[float, float]], verdict: FitVerdict, low: float, high: float
):
    fit = fit_capacities(*np.array(ends, dtype=float).T)
    assert fit.verdict is verdict
    np.testing.assert_equal([fit.low, fit.high], [low, high])


def test_bands_are_over_records():
    low, high = bracketed(60, 7, np.geomspace(0.3, 3.0, 20))
    record = np.repeat(np.arange(12), 5)
    same = np.repeat(low[::5], 5), np.repeat(high[::5], 5)
    fit = fit_capacities(*same)
    wide = record_band(bracket_lanes(*same, record), fit).interval("median")
    alone = record_band(lanes(*same), fit).interval("median")
    assert wide[1] - wide[0] > 1.5 * (alone[1] - alone[0])


def test_a_band_of_narrow_brackets_is_that_of_a_normal_sample():
    draws = MEDIAN * np.exp(DISPERSION * np.random.default_rng(2).standard_normal(12))
    low, high = draws * (1.0 - 1e-4), draws * (1.0 + 1e-4)
    band = record_band(lanes(low, high), fit_capacities(low, high))
    logs = np.log(draws)
    half = student.ppf(0.95, 11) * logs.std(ddof=1) / np.sqrt(12.0)
    # A mean without one value each has exactly this spread, and no bias.
    np.testing.assert_allclose(
        np.log(band.interval("median")), logs.mean() + np.array([-half, half]), rtol=1e-5
    )
    assert band.text == "ok"


def test_the_band_of_a_fit_alone_is_that_of_its_curvature():
    draws = MEDIAN * np.exp(DISPERSION * np.random.default_rng(5).standard_normal(200))
    low, high = draws * (1.0 - 1e-4), draws * (1.0 + 1e-4)
    errors = fit_errors(lanes(low, high), fit_capacities(low, high))
    spread = np.log(draws).std()
    # Of a normal sample: s / sqrt(n) and 1 / sqrt(2 n), without correlation.
    assert errors.errors[0] == pytest.approx(spread / np.sqrt(200.0), rel=1e-4)
    assert errors.errors[1] == pytest.approx(1.0 / np.sqrt(400.0), rel=1e-4)
    assert errors.correlation == pytest.approx(0.0, abs=1e-4)
    # The band of its dispersion is that of chi-square, to which Wilson and Hilferty's cube root is
    # right to about the error squared.
    ends = errors.following(lambda _, dispersion: dispersion)
    wanted = spread * np.sqrt(200.0 / chi2.ppf([0.95, 0.05], 200))
    np.testing.assert_allclose(ends, wanted, rtol=2.0 / 400.0)


@pytest.mark.thorough
def test_bands_of_few_capacities_hold_the_truth():
    inside, studies = np.zeros(2), 200
    for seed in range(studies):
        low, high = bracketed(10, seed, np.geomspace(0.1, 8.0, 60))
        band = record_band(lanes(low, high), fit_capacities(low, high))
        for k, (name, truth) in enumerate((("median", MEDIAN), ("dispersion", DISPERSION))):
            ends = band.interval(name)
            inside[k] += ends[0] <= truth <= ends[1]
    # The standard error of the share is 2 %; three of them either way.
    assert np.all(np.abs(inside / studies - 0.90) <= 0.06)


def test_a_lane_that_ran_once_is_a_bracket_with_one_open_end():
    intensity = np.array([1.0, 1.0, 1.0, 2.0, 3.0])
    reached = np.array([1, 0, 0, 0, 1], dtype=bool)
    known = observe(intensity, reached, np.zeros(5, dtype=np.intp)).brackets
    rows = sorted(zip(known.low, known.high, known.count, strict=True))
    assert rows == [(0.0, 1.0, 1.0), (0.0, 3.0, 1.0), (1.0, np.inf, 2.0), (2.0, np.inf, 1.0)]
