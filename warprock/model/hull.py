"""Convex hulls: which points of a body can touch flat ground, and how near the centre comes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int32]

LEVEL = 1e-6
"""Height above the lowest point, over the size of the base, up to which a body stands on a point:
far above the round-off of a file of text, far below what a base is known to."""


def lower_hull(points: Array) -> Array:
    """Corners of the lower convex hull of points [m], shape [point, 2], from -x to +x.

    They are the points that can touch flat ground.

    Points on an edge of the hull are kept: a body that lies on that edge touches there, too.
    """
    hulls, count = lower_hulls(points[None])
    return np.asarray(hulls[0, : count[0]])


def lower_hulls(points: Array) -> tuple[Array, Counts]:
    """Corners of the lower convex hulls of many bodies, by gift wrapping.

    It begins at the lowest of the leftmost points. The next corner is the point at the least slope
    from the last one; of several on that line it is the nearest.

    Args:
        points: [m], shape [lane, point, 2].

    Returns:
        Points of the hulls, the last one repeated, shape [lane, most, 2], and how many there are,
        shape [lane].
    """
    x, z = points[..., 0], points[..., 1]
    near = LEVEL * np.ptp(points, axis=1).max(axis=1)
    first = x <= x.min(axis=1, keepdims=True) + near[:, None]
    at = np.argmin(np.where(first, z, np.inf), axis=1)
    lanes, kept, count = np.arange(len(points)), [at], np.ones(len(points), np.int32)
    while True:
        here = points[lanes, at]
        along, up = x - here[:, :1], z - here[:, 1:]
        ahead = along > near[:, None]
        if not ahead.any():
            break
        slope = np.divide(up, along, out=np.full_like(up, np.inf), where=ahead)
        steepest = slope.min(axis=1, keepdims=True)
        steepest = np.where(np.isfinite(steepest), steepest, 0.0)
        aside = (up - steepest * along) / np.hypot(1.0, steepest)
        on_the_way = ahead & (aside <= near[:, None])
        more = ahead.any(axis=1)
        at = np.where(more, np.argmin(np.where(on_the_way, x, np.inf), axis=1), at)
        kept.append(at)
        count += more
    return points[lanes[:, None], np.stack(kept, axis=1)], count


def inner_radius(points: Array) -> float:
    """Radius of the largest ball about the origin in the convex hull of points [m].

    Args:
        points: [m], shape [point, 3].

    Returns:
        Zero where the origin is not inside, or on the hull but for round-off.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        nearest = -ConvexHull(points).equations[:, -1].max()
    except QhullError:
        # The points lie in a plane.
        return 0.0
    return float(nearest) if nearest > LEVEL * np.ptp(points, axis=0).max() else 0.0


def hull_surface(points: Array) -> tuple[Array, Array]:
    """The triangles of the convex hull of points.

    Args:
        points: Not all in a plane [m], shape [point, 3].

    Returns:
        Corners of the triangles, against the clock as seen from outside [m], shape
        [triangle, 3, 3], and their normals outwards, of length 1, shape [triangle, 3].
    """
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    corners, normals = points[hull.simplices], hull.equations[:, :3]
    first, second, third = np.moveaxis(corners, 1, 0)
    inwards = np.sum(np.cross(second - first, third - first) * normals, axis=-1) < 0.0
    corners[inwards] = corners[inwards][:, ::-1]
    return corners, normals


def rounded_centres(points: Array, radius: Array) -> Array:
    """Points moved inwards by a radius from both edges that meet in them.

    Args:
        points: Lower convex hulls from -x to +x [m], shape [lane, point, 2].
        radius: [m], shape [lane].
    """
    edge = np.diff(points, axis=1)
    length = np.hypot(edge[..., 0], edge[..., 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        inwards = np.stack([-edge[..., 1], edge[..., 0]], axis=-1) / length[..., None]
    # Rows that repeat the last point have edges of no length: the vertical takes their place.
    inwards = np.where((length > 0.0)[..., None], inwards, np.array([-1.0, 0.0]))
    sides = np.ones_like(points[:, :1])
    before = np.concatenate([sides * np.array([1.0, 0.0]), inwards], axis=1)
    behind = np.concatenate([inwards, sides * np.array([-1.0, 0.0])], axis=1)
    # Moved by r along (u + v) / (1 + u . v), a point lies r inside both edges.
    share = 1.0 + np.sum(before * behind, axis=-1, keepdims=True)
    moved = points + radius[:, None, None] * (before + behind) / share
    repeats = np.concatenate([np.zeros_like(length[:, :1], dtype=bool), length == 0.0], axis=1)
    last = np.maximum.accumulate(np.where(repeats, 0, np.arange(points.shape[1])), axis=1)
    return np.take_along_axis(moved, last[..., None], axis=1)
