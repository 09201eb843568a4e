"""Scrambled Sobol' points by their numbers.

The points are those of SciPy (`scipy.stats.qmc.Sobol`), to the last bit, without the second that
its import takes in every command.

I. M. Sobol' (1967), On the distribution of points in a cube, *USSR Computational Mathematics and
Mathematical Physics* 7. S. Joe and F. Y. Kuo (2008), Constructing Sobol sequences with better
two-dimensional projections, *SIAM Journal on Scientific Computing* 30: the numbers below. J.
Matousek (1998), On the L2-discrepancy for anchored boxes, *Journal of Complexity* 14: the scramble.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Digits = npt.NDArray[np.uint32]

BITS = 30
"""Binary digits of a coordinate."""

_TAKEN = 10
"""Digits of a number whose part of a point is looked up at once."""

_FIRST = (
    (3, 1),
    (7, 1, 3),
    (11, 1, 3, 1),
    (13, 1, 1, 1),
    (19, 1, 1, 3, 3),
    (25, 1, 3, 5, 13),
    (37, 1, 1, 5, 5, 17),
    (41, 1, 1, 5, 5, 5),
    (47, 1, 1, 7, 11, 19),
    (55, 1, 1, 5, 1, 1),
    (59, 1, 1, 1, 3, 11),
    (61, 1, 3, 5, 5, 31),
    (67, 1, 3, 3, 9, 7, 49),
    (91, 1, 1, 1, 15, 21, 21),
    (97, 1, 3, 1, 13, 27, 49),
)
"""Of the second dimension and those after it: the primitive polynomial, its coefficients as binary
digits, and the first direction numbers."""

OWN_DIMENSIONS = len(_FIRST) + 1


class Sobol:
    """A scrambled Sobol' sequence.

    Args:
        dimensions: Numbers that a point has, at most `OWN_DIMENSIONS`.
        seed: Seed of the scramble.
    """

    def __init__(self, dimensions: int, seed: int) -> None:
        (chance,) = np.random.default_rng(seed).spawn(1)
        powers = 2 ** np.arange(BITS, dtype=np.uint32)
        shift = chance.integers(2, size=(dimensions, BITS), dtype=np.uint32)
        mixing = np.tril(chance.integers(2, size=(dimensions, BITS, BITS), dtype=np.uint32))
        mixing[:, range(BITS), range(BITS)] = 1
        # Digit p of a scrambled number, from the left, is a sum of digits up to p of the number.
        plain = np.array([_directions(number) for number in range(dimensions)], dtype=np.uint32)
        digits = (plain[:, :, None] >> np.arange(BITS - 1, -1, -1, dtype=np.uint32)) & 1
        scrambled = np.einsum("dpi,dji->djp", mixing, digits) % 2
        numbers = (scrambled * powers[::-1]).sum(axis=2, dtype=np.uint32)
        self._shift = shift @ powers
        self._parts = [
            _sums(numbers[:, first : first + _TAKEN]) for first in range(0, BITS, _TAKEN)
        ]

    def run(self, low: int, high: int) -> Array:
        """Points from one number to before another, shape [point, dimension]."""
        numbers = np.arange(low, high, dtype=np.uint32)
        gray = numbers ^ (numbers >> 1)
        found = np.broadcast_to(self._shift, (len(numbers), len(self._shift)))
        for at, part in enumerate(self._parts):
            found = found ^ part[(gray >> (at * _TAKEN)) & (2**_TAKEN - 1)]
        return np.asarray(found * 2.0**-BITS)


def _directions(dimension: int) -> list[int]:
    """Direction numbers of a dimension, as binary fractions of `BITS` digits."""
    if dimension == 0:
        found = [1] * BITS
    else:
        polynomial, *found = _FIRST[dimension - 1]
        degree = len(found)
        for at in range(degree, BITS):
            number = found[at - degree]
            for back in range(1, degree + 1):
                if polynomial >> (degree - back) & 1:
                    number ^= found[at - back] << back
            found.append(number)
    return [number << (BITS - 1 - at) for at, number in enumerate(found)]


def _sums(numbers: Digits) -> Digits:
    """Sums of any of some numbers without carry, by binary digits that say which.

    Args:
        numbers: Shape [dimension, number].

    Returns:
        Shape [digits, dimension].
    """
    found = np.zeros((1, len(numbers)), dtype=np.uint32)
    for number in numbers.T:
        found = np.concatenate([found, found ^ number])
    return found
