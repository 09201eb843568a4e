"""Points of a sample by their numbers, and the distributions that turn them into values.

A point is a pure function of the sample and its number: a chunk of lanes makes its own points
alone, however many the sample has. Sobol' sequences are wound forward to a number. In a Latin
hypercube every dimension deals the strata by a permutation that is computed number by number: a
scramble of as many bits as the number of points needs, done again while it leads past the last
point (cycle walking, Black and Rogaway 2002).

A. B. Owen (1998), Scrambling Sobol' and Niederreiter-Xing points, *Journal of Complexity* 14.
M. D. McKay, R. J. Beckman and W. J. Conover (1979), *Technometrics* 21. J. Black and P. Rogaway
(2002), Ciphers with arbitrary finite domains, *CT-RSA 2002*. G. L. Steele, D. Lea and C. H. Flood
(2014), Fast splittable pseudorandom number generators, *OOPSLA 2014*.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import threading

import numpy as np
import numpy.typing as npt

from warprock.case.value_kinds import ChoiceKey, WholeKey
from warprock.units import Dimension

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.uint64]

SAMPLING = ChoiceKey("scrambled Sobol' points or a Latin hypercube", ("sobol", "lhs"))
"""How the points of a sample are made."""

MOST_POINTS = 2**30
"""Points after which SciPy's Sobol' sequence has used up its 30 bits."""

SEED = WholeKey("the seed of the sample", 0, 2**63 - 1)

ENDS = 2.0**-31
"""Least probability that is drawn, and greatest one below 1: half a step of 30 bits."""

END_SCORE = 6.13
"""Standard normal scores that `ENDS` allows are less than this in size."""

_ROUNDS = 6
_PLACE_BITS = 20
"""Places in a stratum: few enough that rounding takes no point of 2^30 out of its own."""


@dataclasses.dataclass(frozen=True)
class Sample:
    """Points in the unit cube.

    Attributes:
        sampling: "sobol" (scrambled, Owen 1998) or "lhs" (McKay, Beckman and Conover 1979).
        seed: Seed, from 0 to the bound of `SEED`.
        count: Points, at most `MOST_POINTS`.
        dimensions: Numbers that a point has.
    """

    sampling: str
    seed: int
    count: int
    dimensions: int

    def points(self, numbers: npt.NDArray[np.intp]) -> Array:
        """Some points, from 0 to less than 1, shape [point, dimension].

        Args:
            numbers: Their numbers, from 0; mostly runs of consecutive ones.
        """
        low, high = int(numbers.min()), int(numbers.max()) + 1
        if high - low <= 2 * len(numbers):
            return self._run(low, high)[numbers - low]
        # Lanes that pass the end of a cell: the last points of the sample, then the first.
        cuts = np.flatnonzero(np.diff(numbers) != 1) + 1
        return np.concatenate(
            [self._run(int(run[0]), int(run[-1]) + 1) for run in np.split(numbers, cuts)]
        )

    def _run(self, low: int, high: int) -> Array:
        if self.sampling == "lhs":
            return self._latin(np.arange(low, high, dtype=np.uint64))
        return _sequence(self.dimensions, self.seed).run(low, high)

    def _latin(self, numbers: Places) -> Array:
        """Points of which every dimension has one in each of `count` equal strata."""
        keys = np.random.SeedSequence(self.seed).generate_state(
            self.dimensions * (_ROUNDS + 1), np.uint64
        )
        found = np.empty((len(numbers), self.dimensions))
        for at, (place_key, *round_keys) in enumerate(keys.reshape(self.dimensions, -1)):
            strata = _permute(numbers, self.count, round_keys)
            places = (_mix(numbers ^ place_key) >> np.uint64(64 - _PLACE_BITS)) + 0.5
            found[:, at] = (strata + places * 2.0**-_PLACE_BITS) / self.count
        return found


class _Sequence:
    """A Sobol' sequence whose digits SciPy scrambles; it goes on from where it is at no cost."""

    def __init__(self, dimensions: int, seed: int) -> None:
        from scipy.stats import qmc

        self._points = qmc.Sobol(dimensions, scramble=True, rng=seed)
        self._lock = threading.Lock()

    def run(self, low: int, high: int) -> Array:
        """Points from one number to before another."""
        with self._lock:
            if low < self._points.num_generated:
                self._points.reset()
            if low > self._points.num_generated:
                self._points.fast_forward(low - self._points.num_generated)
            # SciPy warns of a start with a number of points that is no power of two; one is.
            drawn = [self._points.random(1), self._points.random(high - low - 1)]
        return np.asarray(np.concatenate(drawn), dtype=np.float64)


@functools.lru_cache(maxsize=4)
def _sequence(dimensions: int, seed: int) -> _Sequence:
    return _Sequence(dimensions, seed)


def _permute(numbers: Places, count: int, keys: list[np.uint64]) -> Places:
    """Where a permutation of 0 to count - 1 takes some numbers."""
    bits = max(1, (count - 1).bit_length())
    found = _scramble(numbers, bits, keys)
    beyond = np.flatnonzero(found >= count)
    while len(beyond):
        found[beyond] = _scramble(found[beyond], bits, keys)
        beyond = beyond[found[beyond] >= count]
    return found


def _scramble(numbers: Places, bits: int, keys: list[np.uint64]) -> Places:
    """A permutation of 0 to 2^bits - 1: each of its steps can be undone."""
    mask, shift = np.uint64(2**bits - 1), np.uint64(max(1, bits // 2))
    found = numbers.copy()
    for key in keys:
        found = (found * (key | np.uint64(1)) + (key >> np.uint64(32))) & mask
        found ^= found >> shift
    return found


def _mix(numbers: Places) -> Places:
    """Bits of 64 that depend on every bit of a number (Steele, Lea and Flood 2014)."""
    found = numbers + np.uint64(0x9E3779B97F4A7C15)
    found = (found ^ (found >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    found = (found ^ (found >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return found ^ (found >> np.uint64(31))


class Shape(enum.StrEnum):
    """Shape of a distribution."""

    UNIFORM = "uniform"
    LOGUNIFORM = "loguniform"
    LOGNORMAL = "lognormal"


@dataclasses.dataclass(frozen=True)
class Distribution:
    """A distribution of one number, SI units or rad.

    Attributes:
        shape: Its shape.
        dimension: What the number measures.
        low: Least value; of a lognormal one where it is cut, 0 if it is not.
        high: Greatest value; of a lognormal one where it is cut, infinity if it is not.
        first: A value of it as it was written.
        median: Median of a lognormal one before it is cut.
        dispersion: Standard deviation of its logarithm.
    """

    shape: Shape
    dimension: Dimension
    low: float
    high: float
    first: object
    median: float = 1.0
    dispersion: float = 0.0

    def quantile(self, probability: Array) -> Array:
        """Values that are not exceeded with some probabilities, same shape."""
        inside = np.clip(probability, ENDS, 1.0 - ENDS)
        if self.shape is Shape.UNIFORM:
            return np.asarray(self.low + (self.high - self.low) * inside)
        if self.shape is Shape.LOGUNIFORM:
            return np.asarray(self.low * (self.high / self.low) ** inside)
        from scipy.special import ndtr, ndtri

        below, above = (ndtr(self._score(end)) for end in (self.low, self.high))
        scores = ndtri(below + (above - below) * inside)
        # Far out in a tail the score rounds past the cut.
        values = np.clip(self.median * np.exp(self.dispersion * scores), self.low, self.high)
        return np.asarray(values, dtype=np.float64)

    def _score(self, value: float) -> float:
        with np.errstate(divide="ignore"):
            return float(np.log(np.float64(value) / self.median) / self.dispersion)
