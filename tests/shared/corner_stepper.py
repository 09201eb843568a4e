"""Two stacked blocks as corners that touch: a second route to driven runs, for tests.

Complementarity at four corners and a small step; it knows no patterns.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import numpy.typing as npt

from warprock.model.motion import Segment
from warprock.oracle.pair_mechanics import TwoBlocks
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]


def corner_rows(blocks: TwoBlocks, place: Array) -> tuple[Array, Array, Array]:
    """Gaps [m] of the four corners that can touch, and the rows of their normal and tangential
    relative velocities in (x1', z1', theta1', x2', z2', theta2')."""
    x1, z1, t1, x2, z2, t2 = place.tolist()
    (c1, s1), (c2, s2) = ((math.cos(t), math.sin(t)) for t in (t1, t2))
    half = [0.5 * h for h in blocks.height]
    gaps, normal, tangent = [], [], []
    for side in (1, -1):
        x, z = side * blocks.ground_half_width, -half[0]
        rx, rz = x * c1 + z * s1, z * c1 - x * s1
        gaps.append(z1 + rz)
        normal.append((0.0, 1.0, -rx, 0.0, 0.0, 0.0))
        tangent.append((1.0, 0.0, rz, 0.0, 0.0, 0.0))
    for side in (1, -1):
        x, z = side * blocks.interface_half_width, -half[1]
        rx, rz = x * c2 + z * s2, z * c2 - x * s2
        dx, dz = x2 + rx - x1, z2 + rz - z1
        gaps.append(s1 * dx + c1 * dz - half[0])
        for rows, (ax, az) in ((normal, (s1, c1)), (tangent, (c1, -s1))):
            rows.append((-ax, -az, az * dx - ax * dz, ax, az, ax * rz - az * rx))
    return np.array(gaps), np.array(normal), np.array(tangent)


def complementary(
    free: Array, inverse: Array, rows: tuple[Array, Array], near: list[int], last: tuple[int, ...]
) -> tuple[Array, tuple[int, ...]]:
    """Velocities after a step: corners push and stick, or open. Searches every set of corners."""
    normal, tangent = rows
    sets = [tuple(k for k in last if k in near)]
    for count in range(len(near), -1, -1):
        sets.extend(itertools.combinations(near, count))
    for held in sets:
        found = free
        if held:
            sticking = [next(k for k in held if k // 2 == body) for body in {k // 2 for k in held}]
            matrix = np.vstack([normal[list(held)], tangent[sticking]])
            response = (matrix * inverse) @ matrix.T
            impulse = np.linalg.solve(response, -matrix @ free)
            if np.any(impulse[: len(held)] < 0.0):
                continue
            found = free + inverse * (matrix.T @ impulse)
        if all(normal[k] @ found >= -1e-11 for k in near if k not in held):
            return found, held
    raise AssertionError("no set of corners is complementary")


def stepped_peaks(blocks: TwoBlocks, motion: Segment, duration: float, step: float) -> Array:
    """Peaks of both rotations by Moreau's midpoint scheme, first order in the step."""
    inertia = [
        m * (w * w + h * h) / 12.0
        for m, w, h in zip(blocks.mass, blocks.width, blocks.height, strict=True)
    ]
    inverse = 1.0 / np.array(
        [v for m, i in zip(blocks.mass, inertia, strict=True) for v in (m, m, i)]
    )
    low, high = blocks.height
    place, velocity = np.array((0.0, 0.5 * low, 0.0, 0.0, low + 0.5 * high, 0.0)), np.zeros(6)
    peak, held = np.zeros(2), (0, 1, 2, 3)
    for index in range(round(duration / step)):
        time = (index + 0.5) * step
        base = motion.acceleration(time) if time < motion.stop else 0.0
        middle = place + 0.5 * step * velocity
        gaps, normal, tangent = corner_rows(blocks, middle)
        near = [k for k in range(4) if gaps[k] <= 1e-6]
        free = velocity - step * np.array((base, GRAVITY, 0.0, base, GRAVITY, 0.0))
        velocity, held = complementary(free, inverse, (normal, tangent), near, held)
        place = middle + 0.5 * step * velocity
        peak = np.maximum(peak, np.abs(place[[2, 5]]))
    return peak
