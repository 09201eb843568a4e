"""Closed equations of motion of two stacked blocks, for tests.

Written out by hand for the model of Psycharis (1990), whose own text was not at hand; the oracle
gets its accelerations from a Jacobian instead.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from warprock.oracle.pair_mechanics import Pattern, TwoBlocks
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]


def closed_form(
    blocks: TwoBlocks, pattern: Pattern, rotation: Array, rate: Array, base: float
) -> tuple[float, float]:
    """Accelerations of both rotations, for the three patterns that move."""
    (m1, m2), (b1, c) = blocks.mass, (blocks.ground_half_width, blocks.interface_half_width)
    (h1, h2), (s1, s2) = (0.5 * h for h in blocks.height), pattern
    i1, i2 = (
        m * (w * w + h * h) / 12.0
        for m, w, h in zip((m1, m2), blocks.width, blocks.height, strict=True)
    )
    (t1, t2), (w1, w2), g = rotation, rate, GRAVITY
    if s2 == 0:
        z = m1 * h1 + m2 * (2 * h1 + h2)
        total = i1 + m1 * (b1**2 + h1**2) + i2 + m2 * (b1**2 + (2 * h1 + h2) ** 2)
        arm = (m1 + m2) * s1 * b1
        moment = g * (z * math.sin(t1) - arm * math.cos(t1))
        moment -= base * (arm * math.sin(t1) + z * math.cos(t1))
        return moment / total, moment / total
    q2 = m2 * g * (h2 * math.sin(t2) - s2 * c * math.cos(t2))
    q2 -= m2 * base * (s2 * c * math.sin(t2) + h2 * math.cos(t2))
    m22 = i2 + m2 * (c**2 + h2**2)
    if s1 == 0:
        return 0.0, q2 / m22
    d = s2 * c - s1 * b1
    k, s, gap = 2 * h1 * h2 - s2 * c * d, d * h2 + 2 * h1 * s2 * c, t1 - t2
    a, b = m1 * s1 * b1 - m2 * d, m1 * h1 + 2 * m2 * h1
    m11 = i1 + m1 * (b1**2 + h1**2) + m2 * (d**2 + 4 * h1**2)
    m12 = m2 * (k * math.cos(gap) - s * math.sin(gap))
    turn = m2 * (k * math.sin(gap) + s * math.cos(gap))
    q1 = g * (b * math.sin(t1) - a * math.cos(t1))
    q1 -= base * (a * math.sin(t1) + b * math.cos(t1))
    found = np.linalg.solve([[m11, m12], [m12, m22]], [q1 - turn * w2**2, q2 + turn * w1**2])
    return float(found[0]), float(found[1])
