"""Points of a sample by their numbers, and the distributions drawn with them."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats
from scipy.stats import qmc

from warprock.case.sampling import (
    END_SCORE,
    ENDS,
    MOST_POINTS,
    SAMPLING,
    Distribution,
    Sample,
    Shape,
)
from warprock.units import Dimension


@pytest.mark.parametrize("sampling", SAMPLING.choices)
@pytest.mark.parametrize("count", [2, 3, 1000, 4096])
def test_a_point_depends_on_its_number_alone(sampling: str, count: int):
    sample = Sample(sampling, 7, count, 3)
    whole = sample.points(np.arange(count))
    assert whole.shape == (count, 3)
    assert (whole >= 0.0).all()
    assert (whole < 1.0).all()
    third = count // 3
    wrapped = np.concatenate([np.arange(count - third - 1, count), np.arange(third)])
    scattered = np.array([0, count - 1, count // 2, 0])
    for numbers in (np.arange(third, count), wrapped, scattered):
        assert (sample.points(numbers) == whole[numbers]).all()
    assert (whole != Sample(sampling, 8, count, 3).points(np.arange(count))).any()


def test_sobol_points_are_the_scrambled_sequence_of_scipy():
    expected = qmc.Sobol(4, scramble=True, rng=3).random_base2(11)
    found = Sample("sobol", 3, 2000, 4).points(np.arange(2000))
    np.testing.assert_array_equal(found, expected[:2000])


@pytest.mark.parametrize("count", [2, 5, 64, 65, 5000])
def test_a_latin_hypercube_has_one_point_in_every_stratum(count: int):
    points = Sample("lhs", 11, count, 4).points(np.arange(count))
    strata = np.sort(np.floor(points * count), axis=0)
    np.testing.assert_array_equal(strata, np.arange(count)[:, None].repeat(4, axis=1))


def test_dimensions_of_a_latin_hypercube_know_nothing_of_one_another():
    # Correlations of independent permutations have a standard deviation of 1 / sqrt(99).
    scores = []
    for seed in range(200):
        points = Sample("lhs", seed, 100, 2).points(np.arange(100))
        scores.append(np.corrcoef(points.T)[0, 1] * np.sqrt(99))
    assert scipy.stats.kstest(scores, "norm").pvalue > 0.01
    points = Sample("lhs", 1, 4096, 2).points(np.arange(4096))
    counts = np.histogram2d(*points.T, bins=16)[0]
    # Sums over rows and columns are fixed, so 15 x 15 of the cells are free.
    assert scipy.stats.chi2(225).sf(np.sum((counts - 16.0) ** 2 / 16.0)) > 0.01


def test_the_last_points_of_the_longest_sample_cost_no_more_than_the_first():
    last = np.arange(MOST_POINTS - 1000, MOST_POINTS)
    points = Sample("lhs", 1, MOST_POINTS, 2).points(last)
    assert scipy.stats.kstest(points[:, 0], "uniform").pvalue > 0.01
    strata = np.floor(points * MOST_POINTS)
    assert len(np.unique(strata[:, 0])) == 1000


def distribution(shape: Shape, low: float, high: float, **more: float) -> Distribution:
    return Distribution(shape, Dimension.LENGTH, low, high, "1 m", **more)


@pytest.mark.parametrize(
    ("drawn", "expected"),
    [
        (distribution(Shape.UNIFORM, 2.0, 5.0), scipy.stats.uniform(2.0, 3.0)),
        (distribution(Shape.LOGUNIFORM, 0.1, 10.0), scipy.stats.loguniform(0.1, 10.0)),
        (
            distribution(Shape.LOGNORMAL, 0.0, np.inf, median=3.0, dispersion=0.4),
            scipy.stats.lognorm(0.4, scale=3.0),
        ),
    ],
)
def test_quantiles_are_those_of_the_distribution(drawn: Distribution, expected):
    at = np.linspace(0.001, 0.999, 999)
    np.testing.assert_allclose(drawn.quantile(at), expected.ppf(at), rtol=1e-12)
    ends = drawn.quantile(np.array([0.0, 1.0 - 2.0**-53]))
    np.testing.assert_allclose(ends, expected.ppf([ENDS, 1.0 - ENDS]), rtol=1e-9)


def test_a_cut_lognormal_keeps_its_shape_inside():
    drawn = distribution(Shape.LOGNORMAL, 2.0, 4.0, median=3.0, dispersion=0.4)
    whole = scipy.stats.lognorm(0.4, scale=3.0)
    at = np.linspace(0.0, 1.0, 101)
    values = drawn.quantile(at)
    assert values.min() >= 2.0
    assert values.max() <= 4.0
    share = (whole.cdf(values) - whole.cdf(2.0)) / (whole.cdf(4.0) - whole.cdf(2.0))
    np.testing.assert_allclose(share, at, atol=1e-9)


def test_the_outermost_score_is_just_beyond_the_ends_of_a_probability():
    from scipy.stats import norm

    # Two digits behind the point, rounded up.
    assert END_SCORE - 0.01 < -norm.ppf(ENDS) < END_SCORE
