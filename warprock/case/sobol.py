"""Scrambled Sobol' points by their numbers.

Point n is a shift and, for each set bit of the Gray code n ^ (n >> 1), one direction number, all
added without carry. The shift and the digits of the direction numbers are scrambled at random, so
that a point is uniform and a sample keeps its balance. The points are those of SciPy's
`qmc.Sobol(dimensions, rng=seed)`, whose import alone takes longer than most commands do.

I. A. Antonov and V. M. Saleev (1979), *USSR Computational Mathematics and Mathematical Physics* 19
(the Gray code). P. Bratley and B. L. Fox (1988), Algorithm 659, *ACM Transactions on Mathematical
Software* 14 (the recurrence). S. Joe and F. Y. Kuo (2008), *SIAM Journal on Scientific Computing*
30 (the first direction numbers). J. Matousek (1998), On the L2-discrepancy for anchored boxes,
*Journal of Complexity* 14 (the scramble).
"""

from __future__ import annotations

import functools
import importlib.resources
import itertools

import numpy as np
import numpy.typing as npt

Words = npt.NDArray[np.uint32]

BITS = 30
"""Binary digits of a point."""

_PART = 10
"""Bits of a point's number that are looked up together."""


def sobol_points(
    numbers: npt.NDArray[np.intp], dimensions: int, seed: int
) -> npt.NDArray[np.float64]:
    """Some points of a scrambled Sobol' sequence, from 0 to less than 1, shape [point, dimension].

    Args:
        numbers: Their numbers, from 0 to less than 2^`BITS`.
        dimensions: Numbers that a point has, at most the 512 of `cases/sobol`.
        seed: Seed of the scramble.
    """
    shift, tables = _sequence(dimensions, seed)
    found = np.broadcast_to(shift, (len(numbers), dimensions)).copy()
    for part, table in enumerate(tables):
        found ^= table[(numbers >> (_PART * part)) % len(table)]
    return np.asarray(found * 2.0**-BITS, dtype=np.float64)


@functools.lru_cache(maxsize=4)
def _sequence(dimensions: int, seed: int) -> tuple[Words, list[Words]]:
    """The shift, shape [dimension], and what each value of each part of a number adds to it.

    Each of these tables has shape [value, dimension].
    """
    (random,) = np.random.default_rng(seed).spawn(1)
    digits = random.integers(2, size=(dimensions, BITS), dtype=np.uint32)
    shift: Words = (digits << np.arange(BITS, dtype=np.uint32)).sum(axis=1, dtype=np.uint32)
    directions = _scrambled(_directions(dimensions), random)
    values = np.arange(2**_PART, dtype=np.uint32)
    tables = list[Words]()
    for part in range(BITS // _PART):
        number = values << np.uint32(_PART * part)
        gray = number ^ (number >> np.uint32(1))
        table = np.zeros((len(values), dimensions), np.uint32)
        for bit in range(BITS):
            table ^= np.outer((gray >> np.uint32(bit)) & np.uint32(1), directions[:, bit])
        tables.append(table)
    return shift, tables


def _directions(dimensions: int) -> Words:
    """Direction numbers, not scrambled, shape [dimension, bit]."""
    found = np.ones((dimensions, BITS), np.int64)
    file = importlib.resources.files("warprock.cases").joinpath("sobol", "directions.csv")
    with file.open(encoding="utf-8") as stream:
        lines = list(itertools.islice(stream, 1, dimensions))
    for row, line in zip(found[1:], lines, strict=True):
        polynomial, first = line.split(",")
        degree = int(polynomial).bit_length() - 1
        row[:degree] = [int(number) for number in first.split()]
        for bit in range(degree, BITS):
            row[bit] = row[bit - degree]
            for back in range(1, degree + 1):
                if int(polynomial) >> (degree - back) & 1:
                    row[bit] ^= row[bit - back] << back
    return np.asarray(found << np.arange(BITS - 1, -1, -1), dtype=np.uint32)


def _scrambled(directions: Words, random: np.random.Generator) -> Words:
    """Direction numbers each of whose digits depends on all digits before it at random."""
    shape = (len(directions), BITS, BITS)
    mix = np.tril(random.integers(2, size=shape, dtype=np.uint32), -1)
    mix += np.eye(BITS, dtype=np.uint32)
    places = np.arange(BITS - 1, -1, -1, dtype=np.uint32)
    digits = directions[:, None, :] >> places[:, None] & np.uint32(1)
    mixed = mix @ digits & np.uint32(1)
    return np.asarray((mixed << places[:, None]).sum(axis=1, dtype=np.uint32))
