"""Poses in which a body stands by itself.

A body rolls down to where its centre of mass is lowest: in such a pose the foot of the centre on a
facet of the convex hull lies inside that facet. The height of the centre in any other pose is the
support function of the hull, the distance to the plane that touches it,

    height(down) = largest (corner - centre) . down   over all corners of the hull.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.bodies.footing import Footing, footing_of, thin_polygon
from warprock.bodies.mesh import Solid

Array = npt.NDArray[np.float64]

DOWN = np.array([0.0, 0.0, -1.0])
STEADY = np.radians(1.0)
"""Least lean at which a body that stands turns over [rad]: with less it falls when a door shuts."""
NEAR = np.radians(2.0)
"""Turn between two poses that are one [rad]: a scan of a flat face has many facets."""
MOST_FACETS = 200
"""Facets that are looked at, those that ask for the least turn first: a fine ball rests on each."""
ROLLING = 0.015
"""Change of the centre's height, over the height, within `LEAN` below which a body rolls. On a flat
base it changes by 0.024 at least (at a slenderness angle of 12 degrees), whatever the shape."""
LEAN, LEANS = np.radians(30.0), 16
LEVEL = 1e-9
"""Part of its height by which a centre is as high as at rest: round-off."""
EDGES = 24
"""Edges that are looked at."""


@dataclasses.dataclass(frozen=True, eq=False)
class Rest:
    """A pose in which a body stands.

    Attributes:
        turn: Angle by which the body is turned from the pose of its file [rad].
        rotation: What takes the axes of the file to those of the pose, z upwards, shape [3, 3].
        footing: What it stands on.
    """

    turn: float
    rotation: Array
    footing: Footing


def hull_points(solid: Solid) -> Array:
    """Corners of the convex hull of a body [m], shape [corner, 3]."""
    from scipy.spatial import ConvexHull

    return np.asarray(solid.corners[ConvexHull(solid.corners - solid.centre).vertices])


def rests_of(solid: Solid, tolerance: float) -> list[Rest]:
    """Poses in which a body stands, those that ask for the least turn first.

    Args:
        solid: The body, in axes of which the third points upwards in the pose of its file.
        tolerance: Points that are at most so high above the lowest one touch the ground [m].
    """
    from scipy.spatial import ConvexHull

    hull = ConvexHull(solid.corners - solid.centre)
    normals, distances = hull.equations[:, :3], -hull.equations[:, 3]
    inside = _holds_foot(hull.points[hull.simplices], normals * distances[:, None])
    order = np.flatnonzero(inside)[np.argsort(-(normals[inside] @ DOWN), kind="stable")]
    order = order[:MOST_FACETS]
    points, found = hull.points[hull.vertices], list[Rest]()
    seen = np.empty((0, 3))
    for facet in order[np.argsort(distances[order], kind="stable")]:
        down = normals[facet]
        if (seen @ down > np.cos(NEAR)).any():
            continue
        seen = np.vstack([seen, down])
        rest = rest_at(points, down, tolerance)
        if stands(points @ rest.rotation.T, rest.footing):
            found.append(rest)
    return sorted(found, key=lambda rest: rest.turn)


def rest_at(points: Array, down: Array, tolerance: float) -> Rest:
    """A pose, whether the body stands in it or not.

    Args:
        points: Corners of its hull from the centre of mass [m], shape [corner, 3].
        down: Unit vector that points downwards in the pose, in the axes of the file, shape [3].
        tolerance: As in `rests_of`.
    """
    from scipy.spatial.transform import Rotation

    turned, _ = Rotation.align_vectors(DOWN[None], down[None])
    turn = float(turned.magnitude())
    rotation = np.eye(3) if turn < 1e-9 else np.asarray(turned.as_matrix())
    return Rest(turn, rotation, footing_of(points @ rotation.T, np.zeros(3), tolerance))


def stands(points: Array, footing: Footing) -> bool:
    """Whether a body stands in a pose: it leans `STEADY` without falling, and does not roll.

    Args:
        points: Corners of its hull from the centre of mass, z upwards [m], shape [corner, 3].
        footing: What it stands on there.
    """
    if len(footing.polygon) < 3 or footing.arm <= 0.0 or rolls(points, footing):
        return False
    return bool(least_lean(points, footing) >= STEADY)


def least_lean(points: Array, footing: Footing) -> float:
    """Least lean at which a body turns over across an edge [rad]; arguments as `stands`."""
    return min(fall.lean for fall in turns_over(points, _across(footing)))


def rolls(points: Array, footing: Footing) -> bool:
    """Whether a body rolls over one of its edges, as a ball or a lying drum: nothing holds it.

    Args:
        points: As in `stands`.
        footing: As in `stands`.
    """
    heights = heights_at(points, _across(footing), np.linspace(0.0, LEAN, LEANS))
    change = np.abs(heights / heights[:, :1] - 1.0).max(axis=1)
    return bool((change < ROLLING).any())


def _across(footing: Footing) -> Array:
    """Directions across the edges of a base, or of the largest of them [rad]."""
    return Footing(thin_polygon(footing.polygon, EDGES), footing.height).edge_directions()


def heights_at(points: Array, directions: Array, leans: Array) -> Array:
    """Height of the centre of mass of a body that leans, rolling on its hull [m].

    Args:
        points: Corners of its hull from the centre of mass, z upwards [m], shape [corner, 3].
        directions: Where to it leans, from the x axis towards y [rad], shape [direction].
        leans: How far [rad], shape [lean].

    Returns:
        Heights, shape [direction, lean].
    """
    found = np.empty((len(directions), len(leans)))
    for row, direction in enumerate(directions):
        along = points[:, :2] @ np.array([np.cos(direction), np.sin(direction)])
        lowest = np.outer(along, np.sin(leans)) - np.outer(points[:, 2], np.cos(leans))
        found[row] = lowest.max(axis=0)
    return found


class Fall(NamedTuple):
    """Where a body turns over, in one direction.

    Attributes:
        lean: Lean at which its centre of mass is highest [rad]; a right angle where it only rises.
        rise: How much higher than at rest [m].
    """

    lean: float
    rise: float


def turns_over(points: Array, directions: Array) -> list[Fall]:
    """Where a body turns over in planes of shaking, rolling on its points.

    It has turned over where its centre of mass is lower than at rest. Until then it may roll over
    bumps, and lie on others.

    Args:
        points: Corners of its hull from the centre of mass, z upwards [m], shape [corner, 3].
        directions: Where to it leans, from the x axis towards y [rad], shape [direction].

    Returns:
        One a direction.
    """
    leans = np.radians(np.linspace(0.0, 90.0, 361))
    heights = heights_at(points, directions, leans)
    over = heights < heights[:, :1] * (1.0 - LEVEL)
    ends = np.where(over.any(axis=1), over.argmax(axis=1), len(leans))
    found = []
    for direction, row, end in zip(directions, heights, ends, strict=True):
        top = int(np.argmax(row[:end]))
        lean, height = float(leans[top]), float(row[top])
        # On a corner the centre goes round in a circle, and is highest straight above it.
        aside = points[:, :2] @ np.array([np.cos(direction), np.sin(direction)])
        touches = int(np.argmax(aside * np.sin(lean) - points[:, 2] * np.cos(lean)))
        above = float(np.arctan2(aside[touches], -points[touches, 2]))
        if abs(above - lean) <= leans[1]:
            lean, height = above, float(np.hypot(aside[touches], points[touches, 2]))
        found.append(Fall(lean, height - float(row[0])))
    return found


def _holds_foot(facets: Array, feet: Array) -> npt.NDArray[np.bool_]:
    """Whether each triangle holds a point of its plane.

    Args:
        facets: Corners, shape [facet, 3, 3].
        feet: Points, shape [facet, 3].
    """
    first, second = facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0]
    foot = feet - facets[:, 0]
    across = np.cross(first, second)
    size = np.einsum("ij,ij->i", across, across)
    size = np.where(size > 0.0, size, np.inf)
    share_second = np.einsum("ij,ij->i", np.cross(first, foot), across) / size
    share_first = np.einsum("ij,ij->i", np.cross(foot, second), across) / size
    least = np.minimum(np.minimum(share_first, share_second), 1.0 - share_first - share_second)
    return np.asarray((least > -1e-9) & np.isfinite(size))
