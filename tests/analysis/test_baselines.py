"""What an intensity measure predicts alone: thresholds by hand, and tests that are not seen."""

from __future__ import annotations

import numpy as np
import pytest

from warprock.analysis.baselines import baseline, observed_function, threshold_of


def observed(text: str):
    return np.array([mark == "1" for mark in text])


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("0011", np.sqrt(2.0 * 3.0)),
        # That all fall is as good as that none does: the lower of the two.
        ("1100", 0.0),
        ("0000", np.inf),
        ("1111", 0.0),
        # As good from 3.5 on.
        ("0101", np.sqrt(1.0 * 2.0)),
    ],
)
def test_thresholds_by_hand(text: str, wanted: float):
    found = threshold_of(np.array([1.0, 2.0, 3.0, 4.0]), observed(text))
    assert found == pytest.approx(wanted, rel=1e-12)


def test_equal_intensities_are_not_parted():
    # At 2 one fell and one stood: right 3 of 4 whichever side they are on.
    found = threshold_of(np.array([1.0, 2.0, 2.0, 3.0]), observed("0101"))
    assert found == pytest.approx(np.sqrt(2.0), rel=1e-12)


def test_a_record_is_judged_by_the_others():
    # Record 0 says that all fall from 1 on, record 1 that none does up to 8.
    intensity = np.array([1.0, 2.0, 4.0, 8.0])
    fell, records = observed("1100"), np.array([0, 0, 1, 1])
    found = baseline("PGV", intensity, fell, records, observed_function(intensity, fell, records))
    assert found is not None
    # By record 1 none falls, by record 0 all: each is wrong everywhere.
    assert (found.says == ~fell).all()
    assert found.rank.tolist() == intensity.tolist()
    one = baseline(
        "PGV",
        intensity,
        fell,
        np.zeros(4, dtype=np.intp),
        observed_function(intensity, fell, np.zeros(4, dtype=np.intp)),
    )
    assert one is None


def test_probabilities_are_those_of_functions_fitted_without_the_record():
    rng = np.random.default_rng(1)
    records = np.repeat(np.arange(12), 5)
    intensity = np.tile(np.geomspace(0.1, 1.0, 5), 12)
    fell = rng.random(60) < np.interp(np.log(intensity), np.log([0.1, 1.0]), [0.05, 0.95])
    fitted = observed_function(intensity, fell, records)
    found = baseline("PGV", intensity, fell, records, fitted)
    assert found is not None
    others = records != 7
    alone, _ = observed_function(intensity[others], fell[others], records[others])
    mine = records == 7
    # Newton's method stops within 1e-12 of both.
    assert found.probability[mine] == pytest.approx(alone.probability(intensity[mine]), rel=1e-9)
