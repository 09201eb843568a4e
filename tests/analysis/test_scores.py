"""Scores of predictions against values worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from warprock.analysis.scores import (
    Prediction,
    compare_pair,
    draws,
    rank_correlation,
    reliability,
    score,
)

ROUND_OFF = 1e-12


def said(probability, name: str = "x", rank=None) -> Prediction:
    p = np.asarray(probability, dtype=np.float64)
    return Prediction(name, p, p >= 0.5, p if rank is None else np.asarray(rank, dtype=np.float64))


def observed(text: str):
    return np.array([mark == "1" for mark in text])


def test_scores_by_hand():
    # Fell: .9 .4 .6; stood: .2 .6 .1 .0. Hits 2, misses 1, false alarms 1, correct rejections 3.
    found = score(
        said([0.9, 0.4, 0.6, 0.2, 0.6, 0.1, 0.0]), observed("1110000"), np.zeros(7, dtype=np.intp)
    )
    counts = (found.hits, found.misses, found.false_alarms, found.correct_rejections)
    assert counts == (2, 1, 1, 3)
    # Pairs in order: .9 beats 4, .6 beats 3 and ties with one, .4 beats 3: 10.5 of 12.
    brier = (0.01 + 0.36 + 0.16 + 0.04 + 0.36 + 0.01 + 0.0) / 7.0
    wanted = {
        "accuracy": 5.0 / 7.0,
        "balanced_accuracy": 0.5 * (2.0 / 3.0 + 3.0 / 4.0),
        "auc": 10.5 / 12.0,
        "brier": brier,
    }
    assert found.values == pytest.approx(wanted, abs=ROUND_OFF)
    # One record: no band.
    assert np.isnan([end for band in found.bands.values() for end in band]).all()


def test_where_nothing_fell_there_is_no_order():
    found = score(said([0.1, 0.6]), observed("00"), np.arange(2))
    assert found.values["accuracy"] == 0.5
    assert np.isnan(found.values["auc"])
    assert np.isnan(found.values["balanced_accuracy"])
    with pytest.raises(ValueError, match="got 0"):
        score(said([]), observed(""), np.arange(0))


def test_the_rank_alone_orders_tests():
    # All probabilities are 0 or 1, the rank tells more.
    found = score(said([0, 0, 0, 1], rank=[1, 3, 2, 4]), observed("0101"), np.arange(4))
    assert found.values["auc"] == 1.0


def test_bands_hold_records_together():
    # Two tests a record that agree: as if there were half as many tests, each twice.
    rng = np.random.default_rng(3)
    y, p = rng.random(40) < 0.5, rng.random(40)
    once = score(said(p), y, np.arange(40))
    twice = score(said(np.repeat(p, 2)), np.repeat(y, 2), np.repeat(np.arange(40), 2))
    for name, band in once.bands.items():
        assert twice.bands[name] == pytest.approx(band, abs=ROUND_OFF)
        assert band[0] < once.values[name] < band[1]
    # Of tests taken apart the band is narrower: by about the root of 2.
    apart = score(said(np.repeat(p, 2)), np.repeat(y, 2), np.arange(80))
    width = [band[1] - band[0] for band in (once.bands["accuracy"], apart.bands["accuracy"])]
    assert 1.2 < width[0] / width[1] < 1.7


def test_draws_hold_as_many_records_as_there_are():
    weights = draws(np.array([4, 4, 9, 7, 7, 7]))
    assert (weights[:, 0] == weights[:, 1]).all()
    assert (weights[:, [0, 2, 3]].sum(axis=1) == 3.0).all()


def test_mcnemar_by_hand():
    # The first alone is right 5 times, the second alone once: p = 2 (1 + 6) / 2^6.
    y = observed("0000000000")
    first = said([0, 0, 0, 0, 0, 1, 0, 0, 1, 0], "a")
    second = said([1, 1, 1, 1, 1, 0, 0, 0, 1, 0], "b")
    found = compare_pair(first, second, y, np.arange(10))
    assert (found.names, found.first_only, found.second_only) == (("a", "b"), 5, 1)
    assert found.p_value == pytest.approx(14.0 / 64.0, abs=ROUND_OFF)
    assert found.brier_difference == pytest.approx((2 - 6) / 10, abs=ROUND_OFF)
    low, high = found.brier_band
    assert low < found.brier_difference < high
    same = compare_pair(first, first, y, np.arange(10))
    assert (same.p_value, same.brier_difference, same.brier_band) == (1.0, 0.0, (0.0, 0.0))


def test_reliability_by_hand():
    rows = reliability(np.array([0.0, 0.04, 0.31, 0.35, 0.38, 1.0]), observed("010111"))
    assert [(row["from"], row["to"], row["tests"], row["overturned"]) for row in rows] == [
        (0.0, 0.1, 2, 1),
        (0.3, 0.4, 3, 2),
        (0.9, 1.0, 1, 1),
    ]
    assert rows[1]["predicted"] == pytest.approx(1.04 / 3.0, abs=ROUND_OFF)
    assert rows[1]["observed"] == pytest.approx(2.0 / 3.0, abs=ROUND_OFF)


def test_rank_correlation_by_hand():
    # Differences of ranks 1, -1, 1, -1: 1 - 6 x 4 / (4 x 15).
    found = rank_correlation(np.array([1.0, 5.0, 9.0, 20.0]), np.array([2.0, 1.0, 8.0, 7.0]))
    assert found == pytest.approx(1.0 - 24.0 / 60.0, abs=ROUND_OFF)
    assert np.isnan(rank_correlation(np.zeros(4), np.arange(4.0)))
    assert np.isnan(rank_correlation(np.arange(2.0), np.arange(2.0)))
