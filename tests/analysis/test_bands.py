"""Bands of fragility functions over records: how often they hold the truth, and few records."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.stats import t as student

from tests.shared.fragility_studies import MEDIAN, coverage, stripes, study
from warprock.analysis.bands import MOST_PARTS, Band, Estimate, without_one
from warprock.analysis.lognormal import fit_lognormal, observe, record_band


@pytest.mark.parametrize(
    ("records", "spread"), [(6, 0.6), pytest.param(10, 1.0, marks=pytest.mark.thorough)]
)
def test_bands_hold_the_truth_as_often_as_they_say(records: int, spread: float):
    # `python -m tests.shared.fragility_studies` has the shares of more studies. The standard error
    # of 150 is 2.5 %; the bound lies three of these below. Percentiles of resampled records, which
    # were the bands once, held 59 to 82 % of the dispersions of six to ten records.
    fitted, shares, alone = coverage(records, 150, spread)
    assert fitted >= 140
    assert shares.min() >= 0.90 - 0.075
    # A fit knows nothing of what records do to all of their lanes.
    assert alone[0] < shares[0] - 0.1


def test_a_band_of_many_capacities_known_well_is_that_of_a_mean():
    # Capacities of one draw a record, seen on a fine grid: ln(median) is their mean.
    intensity, reached, record = stripes(40, seed=4, spread=1.0, levels=100)
    seen = observe(intensity, reached, record).brackets
    fit = fit_lognormal(seen)
    low, high = np.log(record_band(seen, fit).interval("median"))
    first = np.array([intensity[(record == k) & reached].min() for k in range(40)])
    draws = np.log(first)
    half = student.ppf(0.95, 39) * draws.std(ddof=1) / np.sqrt(40.0)
    # Greatest likelihood of the stripes does not know that lanes of one record are alike, so that
    # its median is not the mean itself; its spread over records is.
    assert 0.5 * (high - low) == pytest.approx(half, rel=0.1)
    assert 0.5 * (low + high) == pytest.approx(draws.mean(), abs=0.3 * half)


def test_bands_of_lanes_that_records_share_are_wider():
    """With all of the variance one draw a record, lanes taken alone would make a narrow band."""
    intensity, reached, record = stripes(40, seed=11, spread=1.0)
    widths = []
    for number in (record, np.arange(len(record))):
        seen = observe(intensity, reached, number).brackets
        low, high = record_band(seen, fit_lognormal(seen)).interval("median")
        widths.append(np.log(high / low))
    assert widths[0] > 1.5 * widths[1]


def test_a_band_says_that_records_are_few_or_that_one_decides():
    assert _band(study(20, seed=1)).text == "ok"
    assert _band(study(6, seed=1)).text == "fewer than 10 records"
    # Without the one record that stands at 3 and above, one intensity parts the lanes.
    intensity = np.tile([1.0, 2.0, 3.0, 4.0], 12)
    record = np.repeat(np.arange(12), 4)
    reached = (intensity > 2.5) & ((record > 0) | (intensity > 3.5))
    reached |= (record == 0) & (intensity == 2.0)
    band = _band(observe(intensity, reached, record).brackets)
    assert band.text == "no fit without one of 1 records"
    assert np.all(np.isfinite([band.interval("median"), band.interval("dispersion")]))


def _band(seen) -> Band:
    return record_band(seen, fit_lognormal(seen))


def test_a_band_reaches_around_others():
    band = _band(study(20, seed=1))
    other = dataclasses.replace(band, median=1.3 * band.median, medians=1.3 * band.medians)
    both = dataclasses.replace(band, others=(other,))
    assert both.interval("median")[0] == band.interval("median")[0]
    assert both.interval("median")[1] == pytest.approx(1.3 * band.interval("median")[1])
    at = np.array([0.5 * MEDIAN, 2.0 * MEDIAN])
    assert np.all(both.probabilities(at)[0] <= band.probabilities(at)[0])
    np.testing.assert_array_equal(both.probabilities(at)[1], band.probabilities(at)[1])


def test_many_records_are_left_out_in_parts():
    weights = without_one(1000)
    assert weights.shape == (MOST_PARTS, 1000)
    np.testing.assert_array_equal((weights == 0.0).sum(axis=0), 1)
    np.testing.assert_array_equal((weights == 0.0).sum(axis=1), 10)
    np.testing.assert_array_equal(without_one(7).sum(axis=1), 6)
    # A part more or less of the same lanes is a band like the other.
    seen = study(150, seed=5)
    one_each = record_band(seen, fit_lognormal(seen)).interval("median")
    half = np.log(one_each[1] / one_each[0])
    fewer = study(75, seed=5)
    wide = np.log(np.divide(*_band(fewer).interval("median")[::-1]))
    assert wide == pytest.approx(np.sqrt(2.0) * half, rel=0.25)


def test_the_band_of_a_number_of_one_parameter_is_the_end_of_that_parameter():
    estimate = Estimate((0.2, -0.7), (0.1, 0.2), 0.5, 6.0)
    low, high = estimate.following(lambda median, _: median)
    twice = estimate.following(lambda median, _: 1.0 / median**2)
    np.testing.assert_allclose(twice, (high**-2.0, low**-2.0), rtol=1e-12)
    steep = estimate.following(lambda _, dispersion: dispersion)
    assert steep[1] / np.exp(-0.7) > np.exp(-0.7) / steep[0] > 1.0


def test_errors_that_go_together_add_and_others_cancel():
    """Of a product the relative errors add where their correlation is 1, and cancel where -1."""
    ends = {}
    for correlation in (-1.0, 0.0, 1.0):
        estimate = Estimate((0.0, 0.0), (0.1, 0.1), correlation)
        ends[correlation] = np.log(
            estimate.following(lambda median, dispersion: median * dispersion)
        )
    median, dispersion = (
        np.log(Estimate((0.0, 0.0), (0.1, 0.1), 0.0).following(number))
        for number in (lambda median, _: median, lambda _, dispersion: dispersion)
    )
    np.testing.assert_allclose(ends[1.0], median + dispersion, rtol=1e-12)
    np.testing.assert_allclose(
        ends[0.0], np.sign(median) * np.hypot(median, dispersion), rtol=1e-12
    )
    np.testing.assert_allclose(ends[-1.0], np.sign(median) * abs(abs(median) - abs(dispersion)))
