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
from warprock.analysis.lognormal import (
    Verdict,
    fit_errors,
    fit_lognormal,
    observe,
    record_band,
)
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


NUMBERS = ("median", "dispersion", "probability", "rate")


def coverage(
    records: int, studies: int, spread: float, levels: int = 10
) -> tuple[int, Array, Array]:
    """Studies that have a fit, and the share of them whose bands hold the truth.

    Returns:
        Studies with a fit; shares for the `NUMBERS`: the median, the dispersion, the probability at
        the median of the studies and the yearly rate under `HAZARD`, of bands over records and of
        bands of the fit alone, which know nothing of records.
    """
    over, alone, fitted = np.zeros(4), np.zeros(4), 0
    rate = float(_rates(np.array([MEDIAN]), np.array([DISPERSION]))[0])
    truth = np.array([MEDIAN, DISPERSION, 0.0, rate])
    for seed in range(studies):
        seen = study(records, seed, spread, levels)
        fit = fit_lognormal(seen)
        if fit.verdict is not Verdict.FITTED:
            continue
        fitted += 1
        for inside, estimate in (
            (over, record_band(seen, fit).estimate),
            (alone, fit_errors(seen, fit)),
        ):
            low, high = estimate.scores(np.array([MEDIAN]))
            ends = np.array(
                [
                    estimate.following(lambda median, _: median),
                    estimate.following(lambda _, dispersion: dispersion),
                    (low[0], high[0]),
                    estimate.following(_rates),
                ]
            )
            inside += (ends[:, 0] <= truth) & (truth <= ends[:, 1])
    return fitted, over / fitted, alone / fitted


def _rates(median: Array, dispersion: Array) -> Array:
    return rates_of(HAZARD, median, dispersion)


def main(studies: int) -> None:
    """Prints a row for each part of the variance and number of records."""
    heads = "".join(f"{name:>13s}" for name in NUMBERS)
    print(f"variance of records   records   studies fitted{heads}    of the fit:{heads}")
    out = 0
    for spread in SPREADS:
        for records in RECORDS:
            fitted, over, alone = coverage(records, studies, spread)
            row = f"{spread:19.1f}   {records:7d}   {fitted:14d}"
            for gap, shares in (("", over), (" " * 15, alone)):
                row += gap + "".join(f"{100.0 * share:11.1f} %" for share in shares)
            print(row, flush=True)
            out += int(((over < 0.85) | (over > 0.95)).sum())
    print(f"Bands over records that hold the truth in less than 85 % or more than 95 %: {out} of "
          f"{len(SPREADS) * len(RECORDS) * len(NUMBERS)}")  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
