"""Contact points above the ground: a base that is not flat, which a body rolls on as it leans.

The height of the centre of mass is the support function of the hull (`bodies.rests`). Of a few of
its corners it is lower where the corner that touches there is missing: where that is most, over the
rise that turns the body over in that direction, the missing one is taken next.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.bodies.footing import Footing, thin_polygon
from warprock.bodies.rests import heights_at, turns_over

Array = npt.NDArray[np.float64]

AROUND = np.radians(np.arange(-180.0, 180.0, 5.0))
"""Directions in which the body leans, to find what touches the ground [rad]."""
LEANS = np.radians(np.arange(1.0, 31.0))
"""How far it leans [rad]: beyond, nearly every body has fallen."""
FALLEN = np.radians(2.0)
"""Lean beyond that at which it turns over after which nothing has to be known [rad]."""

CLOSE = 0.01
"""Error of the centre's height, over its rise until the body turns over, that is small enough."""


def touching_points(hull: Array, footing: Footing, tolerance: float) -> Array:
    """All that may touch as a body leans: its footing, and what is above the ground.

    Args:
        hull: Corners of the hull from the centre of mass, z upwards [m], shape [corner, 3].
        footing: What touches the ground at rest.
        tolerance: Height over the ground up to which points are pressed to it [m].

    Returns:
        From the centre of mass [m], shape [point, 3].
    """
    return np.vstack([lift_base(footing), hull[hull[:, 2] > tolerance - footing.height]])


def flat_points(footing: Footing, most: int, direction: float | None = None) -> Array:
    """Contact points pressed to the ground, from the centre of mass [m], shape [point, 3].

    Args:
        footing: All that touches.
        most: Points that there may be.
        direction: Of shaking, see `footing.thin_polygon` [rad].
    """
    return lift_base(Footing(thin_polygon(footing.polygon, most, direction), footing.height))


def raise_points(
    hull: Array,
    footing: Footing,
    most: int,
    tolerance: float,
    direction: float | None = None,
) -> Array:
    """Contact points at their heights, those that touch first pressed to the ground.

    Args:
        hull: Corners of the hull from the centre of mass, z upwards [m], shape [corner, 3].
        footing: What touches the ground at rest.
        most: Points that there may be.
        tolerance: Height over the ground up to which points are pressed to it [m].
        direction: Of shaking, see `footing.thin_polygon` [rad].

    Returns:
        From the centre of mass [m], shape [point, 3], those on the ground first.
    """
    found = flat_points(footing, min(most, max(4, most // 3)), direction)
    others = touching_points(hull, footing, tolerance)
    wanted = heights_at(hull, AROUND, LEANS)
    ends, rises = np.array(turns_over(hull, AROUND)).T
    fallen = ends[:, None] + FALLEN < LEANS
    while len(found) < most:
        lower = np.where(fallen, 0.0, wanted - heights_at(found, AROUND, LEANS))
        missing = lower / rises[:, None]
        towards, lean = np.unravel_index(int(np.argmax(missing)), missing.shape)
        if missing[towards, lean] < CLOSE:
            break
        touching = others @ _down(AROUND[towards], LEANS[lean])
        found = np.vstack([found, others[int(np.argmax(touching))]])
    return found[np.argsort(found[:, 2], kind="stable")]


def lift_base(footing: Footing) -> Array:
    """What a body stands on from its centre of mass [m], shape [point, 3]."""
    return np.column_stack([footing.polygon, np.full(len(footing.polygon), -footing.height)])


def _down(direction: float, lean: float) -> Array:
    """What points downwards in the axes of a body that leans, shape [3]."""
    aside = np.sin(lean)
    return np.array([aside * np.cos(direction), aside * np.sin(direction), -np.cos(lean)])
