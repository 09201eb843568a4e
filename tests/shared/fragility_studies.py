"""Synthetic studies of a known fragility, and how often bands hold the truth.

`python -m tests.shared.fragility_studies [STUDIES]` prints the shares by number of records, by
default of 1000 studies each, with a standard error of 1 %: studies of ten intensities a record, of
which the records take no part, 60 % or all of the variance of the capacities. The yearly rate is
that under a hazard that falls with the square of the intensity.
"""

from __future__ import annotations

import sys

import numpy as np
import numpy.typing as npt

from warprock.analysis.hazard import power_law
from warprock.analysis.likelihood import Brackets
from warprock.analysis.lognormal import Verdict, fit_lognormal, observe, record_band
from warprock.analysis.risk import rates_of

Array = npt.NDArray[np.float64]

MEDIAN, DISPERSION = 1.1, 0.45
RECORDS = (5, 6, 8, 10, 15, 20, 44)
SPREADS = (0.0, 0.6, 1.0)
HAZARD = power_law("a power law", "peak_acceleration_m_s2", 1e-3, 2.0, 1.0)


def stripes(
    records: int, seed: int, spread: float = 0.0, levels: int = 10
) -> tuple[Array, npt.NDArray[np.bool_], npt.NDArray[np.intp]]:
    """Lanes of a known fragility, some intensities a record.

    The capacity of a lane is lognormal; a part `spread` of its variance is one draw a record.
    """
    rng = np.random.default_rng(seed)
    at = np.geomspace(0.2, 4.0, levels)
    intensity = np.tile(at, records)
    record = np.repeat(np.arange(records), levels)
    common = rng.standard_normal(records)[record]
    own = rng.standard_normal(len(intensity))
    capacity = np.sqrt(spread) * common + np.sqrt(1.0 - spread) * own
    return intensity, np.log(intensity / MEDIAN) / DISPERSION >= capacity, record


def study(records: int, seed: int, spread: float = 0.0, levels: int = 10) -> Brackets:
    """The lanes of one study."""
    return observe(*stripes(records, seed, spread, levels)).brackets


def coverage(
    records: int, studies: int, spread: float, levels: int = 10
) -> tuple[int, float, float, float, float]:
    """Studies that have a fit, and the share of them whose bands hold the truth.

    Returns:
        Studies with a fit; shares for the median, the dispersion, the probability at the median of
        the studies, and the yearly rate under `HAZARD`.
    """
    inside, fitted = np.zeros(4), 0
    rate = float(rates_of(HAZARD, np.array([MEDIAN]), np.array([DISPERSION]))[0])
    for seed in range(studies):
        seen = study(records, seed, spread, levels)
        fit = fit_lognormal(seen)
        if fit.verdict is not Verdict.FITTED:
            continue
        fitted += 1
        band = record_band(seen, fit)
        low, high = band.probabilities(np.array([MEDIAN]))
        ends = [
            (*band.interval("median"), MEDIAN),
            (*band.interval("dispersion"), DISPERSION),
            (low[0], high[0], 0.5),
            (*band.following(lambda median, spread: rates_of(HAZARD, median, spread)), rate),
        ]
        inside += [low <= truth <= high for low, high, truth in ends]
    return fitted, *(float(share) for share in inside / fitted)


def main(studies: int) -> None:
    """Prints a row for each part of the variance and number of records."""
    print(
        "variance of records   records   studies fitted   median   dispersion   probability   rate"
    )
    for spread in SPREADS:
        for records in RECORDS:
            fitted, *shares = coverage(records, studies, spread)
            cells = "   ".join(f"{100.0 * share:6.1f} %" for share in shares)
            print(f"{spread:19.1f}   {records:7d}   {fitted:14d}   {cells}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
