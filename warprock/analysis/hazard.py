"""Hazard curves: how often in a year a motion is stronger than an intensity.

Between two rows of a table the rate is a power of the intensity, straight over the logarithms of
both, lambda = c x^-k. Beyond the ends of a table it goes on as between the two rows next to them;
what that adds to a rate is told apart, for nobody has computed it.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from warprock.errors import InputError, Said

Array = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class Hazard:
    """A hazard curve, piece by piece from the weakest motions to the strongest.

    Attributes:
        source: Where it is from, as errors and pages say.
        measure: Column of the lane table that it is over.
        edges: Intensities between pieces, in the unit of the column, shape [piece - 1].
        log_size: ln c of every piece, shape [piece].
        slope: k of every piece, from 0 up, shape [piece].
        start: Intensity from which on rates are known; 0 of a power law.
        end: Intensity up to which they are known; infinite of a power law.
        period: Period of a spectral acceleration [s]; NaN of any other measure.
    """

    source: str
    measure: str
    edges: Array
    log_size: Array
    slope: Array
    start: float = 0.0
    end: float = np.inf
    period: float = np.nan

    def rate(self, intensity: Array) -> Array:
        """How often in a year an intensity is exceeded, shape of `intensity`."""
        piece = np.searchsorted(self.edges, intensity)
        return np.asarray(np.exp(self.log_size[piece] - self.slope[piece] * np.log(intensity)))

    def cut(self, at: Array) -> Hazard:
        """The same curve with further edges between its pieces.

        Args:
            at: Intensities above 0, shape [edge].
        """
        edges = np.unique(np.append(self.edges, at))
        piece = np.searchsorted(self.edges, np.append(edges, np.inf))
        return dataclasses.replace(
            self, edges=edges, log_size=self.log_size[piece], slope=self.slope[piece]
        )


def power_law(source: str, measure: str, rate: float, slope: float, at: float) -> Hazard:
    """The hazard lambda = rate (x / at)^-slope.

    Args:
        source: Where it is from.
        measure: Column of the lane table that it is over.
        rate: Exceedances of `at` in a year, > 0.
        slope: k, > 0.
        at: Intensity in the unit of the column, > 0.
    """
    log_size = np.array([np.log(rate) + slope * np.log(at)])
    return Hazard(source, measure, np.empty(0), log_size, np.array([slope]))


def hazard_table(source: str, measure: str, intensity: Array, rate: Array) -> Hazard:
    """The hazard of a table.

    Args:
        source: Where it is from, as errors say.
        measure: Column of the lane table that it is over.
        intensity: In the unit of the column, shape [row].
        rate: Exceedances in a year, shape [row]. Rows without any at the end of the table say where
            it ends.

    Raises:
        InputError: Rows that are not sorted, or fewer than two with a rate.
    """
    _require_rows(source, intensity, rate)
    known = rate > 0.0
    x, y = np.log(intensity[known]), np.log(rate[known])
    if len(x) < 2:
        allowed = "must have at least 2 rows with a finite rate above 0"
        raise InputError(source, "rate", Said(f"{len(x)} such row{'s' * (len(x) != 1)}"), allowed)
    # Minus the slope is never negative: -0.0 of equal rates becomes 0.
    slope = np.abs(np.diff(y) / np.diff(x))
    slope = np.concatenate([slope[:1], slope, slope[-1:]])
    log_size = np.append(y[:1], y) + slope * np.append(x[:1], x)
    edges = intensity[known]
    return Hazard(source, measure, edges, log_size, slope, float(edges[0]), float(edges[-1]))


def _require_rows(source: str, intensity: Array, rate: Array) -> None:
    """Refuses the first row that no hazard curve has."""
    # Without the round-off of their units.
    rows = [(float(f"{x:.12g}"), float(f"{y:.12g}")) for x, y in zip(intensity, rate, strict=True)]
    for row, (x, y) in enumerate(rows, start=1):
        before = rows[row - 2]
        if not (np.isfinite(x) and x > 0.0):
            raise InputError(source, "intensity", x, f"must be finite and > 0 (row {row})")
        if row > 1 and not x > before[0]:
            allowed = f"must be above that of the row before, {before[0]:g} (row {row})"
            raise InputError(source, "intensity", x, allowed)
        if not (np.isfinite(y) and y >= 0.0):
            raise InputError(source, "rate", y, f"must be finite and >= 0 (row {row})")
        if row > 1 and not y <= before[1]:
            allowed = f"must be at most that of the row before, {before[1]:g} (row {row})"
            raise InputError(source, "rate", y, allowed)
