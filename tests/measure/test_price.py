"""What an error costs: medians over starts, the cheapest setting of each, ratios."""

from __future__ import annotations

import math

import numpy as np
import pytest

from warprock.findings.numbers import about
from warprock.measure import price
from warprock.measure.price import Trial
from warprock.model import rocking
from warprock.model.motion import StillBase
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings, ImpulseSettings


def test_the_error_of_a_setting_is_the_median_over_the_starts() -> None:
    lanes = price.b0_lanes(price.STARTS)
    assert lanes.rotation_start[4] == 0.5 * rocking.slenderness_angle(1.0, 5.0)
    coarse = EventSettings(time_step=0.1)
    found = run_batch("event", lanes, StillBase(9), price.TIMES, settings=coarse)["rotation"]
    right = run_batch("housner", lanes, StillBase(9), price.TIMES)["rotation"]
    by_hand = [np.abs(found[k] - right[k]).max() / lanes.slenderness_angle[k] for k in range(9)]
    np.testing.assert_array_equal(price.start_errors(found), by_hand)
    (trial,) = price.own_trials("event", 0.01, (1e-4,))
    assert (trial.error, trial.error_most) == (np.median(by_hand), max(by_hand))
    assert 0.0 < trial.cost < trial.cost_alone
    with pytest.raises(ValueError, match="rotation"):
        price.start_errors(found[:, :-1])


def test_of_each_level_the_coarsest_setting_that_meets_it_is_measured(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    kinds = tuple(ImpulseSettings(substeps=count) for count in (1, 3, 9, 39))
    monkeypatch.setitem(price.OWN_SETTINGS, "impulse", kinds)
    monkeypatch.setattr(price, "_costs", lambda *_: (1.0, 2.0))
    trials = price.own_trials("impulse", 0.0, (3e-2, 3e-3, 1e-7))
    assert len(trials) == 2
    assert trials[0].error <= 3e-2
    assert trials[1].error <= 3e-3
    # A level that is met by none has no trial of its own.
    assert all(trial.error > 1e-7 for trial in trials)


def test_a_price_is_that_of_the_cheapest_setting_that_meets_the_error() -> None:
    trials = [
        Trial("event", "coarse", 2e-5, 3e-5, 2e-7, 4e-4),
        Trial("event", "fine", 2e-6, 3e-6, 3e-7, 3e-4),
        Trial("other", "lucky", 9e-4, 5e-3, 0.02, 0.02),
        Trial("other", "dear", 1e-4, 1e-4, 0.3, 0.3),
        Trial("other", "cheap", 5e-3, 9e-3, 4e-3, 4e-3),
        Trial("housner", "defaults", math.nan, math.nan, 1e-7, 1e-4),
    ]
    rows = price.price_rows(trials, (1e-2, 1e-3, 1e-5))
    of = {(row["error_met"], row["name"]): row for row in rows}
    assert of[1e-2, "other"]["settings"] == "cheap"
    assert of[1e-2, "other"]["cost / event"] == pytest.approx(20_000)
    # Alone another setting of ours is the cheapest.
    assert of[1e-2, "other"]["cost / event_alone"] == pytest.approx(4e-3 / 3e-4)
    assert of[1e-3, "other"]["settings"] == "lucky"
    assert of[1e-3, "other"]["error_most"] == 5e-3
    assert of[1e-5, "event"]["settings"] == "fine"
    assert of[1e-5, "housner"]["cost / event"] == pytest.approx(1 / 3)
    assert set(of[1e-5, "other"]) == {"error_met", "name"}


@pytest.mark.parametrize(
    ("ratio", "text"),
    [
        (823_456.0, "800,000"),
        (183_000.0, "180,000"),
        (197_000.0, "200,000"),
        (13.4, "13"),
        (5.2, "5"),
        (1.0, "1.0"),
        (0.00084, "0.0008"),
        (0.0171, "0.017"),
        (math.nan, "-"),
    ],
)
def test_a_ratio_of_times_claims_no_more_than_was_measured(ratio: float, text: str) -> None:
    assert about(ratio) == text
