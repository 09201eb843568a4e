"""What a measure of the shaking alone predicts, without a simulation: the least to be beaten.

A threshold says that a block overturns from an intensity on; its probability is that of the
lognormal function. Both are judged on tests that they have not seen: those of each record, or of
each part of the records where there are many, by a threshold and a function of all other records
(cross-validation).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.analysis.bands import Band, without_one
from warprock.analysis.lognormal import Fit, fit_lognormal, observe, record_band
from warprock.analysis.scores import Prediction

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Records = npt.NDArray[np.intp]

LEAST_PARTS = 2
"""Records below which nothing is left to judge a threshold by."""


def threshold_of(intensity: Array, observed: Mask) -> float:
    """The threshold that most tests agree with.

    It lies in the middle, by logarithms, of two neighbouring intensities; where several are as
    good, the middle one is taken. 0 says that all overturn, infinity that none does.

    Args:
        intensity: Of every test, > 0, shape [test].
        observed: Whether each overturned, shape [test].
    """
    at, which = np.unique(intensity, return_inverse=True)
    fell = np.bincount(which, weights=observed)
    stood = np.bincount(which, weights=~observed)
    # Right with the threshold below intensity k: those that stood below it, those that fell above.
    right = np.append(0.0, np.cumsum(stood)) + np.append(np.cumsum(fell[::-1])[::-1], 0.0)
    best = np.flatnonzero(right == right.max())
    place = int(best[(len(best) - 1) // 2])
    if place == 0:
        return 0.0
    if place == len(at):
        return np.inf
    return float(np.sqrt(at[place - 1] * at[place]))


def baseline(
    name: str,
    intensity: Array,
    observed: Mask,
    records: Records,
    fitted: tuple[Fit, Band | None],
) -> Prediction | None:
    """What an intensity measure predicts; None with fewer records than `LEAST_PARTS`.

    Args:
        name: What it is called.
        intensity: Of every test, > 0, shape [test].
        observed: Whether each overturned, shape [test].
        records: Number of the record of each test, shape [test].
        fitted: What `observed_function` returned for the same tests.
    """
    from scipy.special import ndtr

    numbers = np.unique(records, return_inverse=True)[1]
    count = int(numbers.max()) + 1
    if count < LEAST_PARTS:
        return None
    # A record belongs to the one part whose sample lacks it.
    part = np.argmin(without_one(count), axis=0)[numbers]
    says = np.zeros(len(observed), dtype=np.bool_)
    for each in np.unique(part):
        out = part == each
        says[out] = intensity[out] >= threshold_of(intensity[~out], observed[~out])
    probability = says.astype(np.float64)
    band = fitted[1]
    if band is not None:
        scores = (np.log(intensity) - np.log(band.medians[part])) / band.dispersions[part]
        probability = np.asarray(ndtr(scores))
    return Prediction(name, probability, says, intensity)


def observed_function(
    intensity: Array, observed: Mask, records: Records
) -> tuple[Fit, Band | None]:
    """The lognormal function of what was observed, and its band over records.

    Args:
        intensity: Of every test, > 0, shape [test].
        observed: Whether each overturned, shape [test].
        records: Number of the record of each test, shape [test].

    Returns:
        The fit, or why there is none, and its band; None where there is no fit or one record.
    """
    seen = observe(intensity, observed, records)
    fit = fit_lognormal(seen.brackets)
    if not fit.dispersion > 0.0 or seen.record_count < LEAST_PARTS:
        return fit, None
    return fit, record_band(seen.brackets, fit)
