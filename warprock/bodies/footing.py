"""What a body stands on: contact points, their polygon, and how far it leans before it falls.

Seen from the centre of mass, which is at height h over the ground, the polygon of the contact
points has the border r(d) in the direction d, and its farthest point lies at s(d) along d. In space
the body leans over the edge that lies there, and the vertical through its centre leaves the polygon
at

    tan(slenderness angle) = r(d) / h.

In the plane of shaking d it turns about the axis across the plane through its farthest point, at

    tan(slenderness angle) = s(d) / h.

Both are least in the same direction: across the nearest edge, the weakest direction.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

STRAIGHT = 1e-6
"""Area that a corner adds, over the square of the size, at which the edge is straight there."""
DIRECTIONS = 360
"""Directions around a body at which its slenderness angles are listed: one a degree."""


@dataclasses.dataclass(frozen=True, eq=False)
class Footing:
    """Contact points of a body at rest, and its centre of mass over them.

    Attributes:
        polygon: Corners of their convex polygon against the clock, from the point of the ground
            below the centre of mass [m], shape [point, 2]; two or one where there is no polygon.
        height: Height of the centre of mass over the ground [m].
    """

    polygon: Array
    height: float

    @property
    def arm(self) -> float:
        """Distance from below the centre to the nearest edge [m]; negative outside the polygon."""
        return float(self._edges()[1].min()) if len(self.polygon) > 2 else -math.inf

    @property
    def slenderness_angle(self) -> float:
        """Slenderness angle in the weakest direction [rad]; negative where the body falls over."""
        return float(np.arctan2(self.arm, self.height))

    def edge_directions(self) -> Array:
        """Directions across the edges, outwards [rad], shape [edge]."""
        normals, _ = self._edges()
        return np.asarray(np.arctan2(normals[:, 1], normals[:, 0]))

    def in_space(self, directions: Array) -> Array:
        """Slenderness angles of a body that may turn about any edge [rad].

        Args:
            directions: From the x axis towards y [rad], shape [direction].
        """
        normals, distances = self._edges()
        along = _unit(directions) @ normals.T
        with np.errstate(divide="ignore"):
            reach = np.where(along > 1e-12, distances / np.maximum(along, 1e-12), np.inf)
        return np.asarray(np.arctan2(reach.min(axis=1), self.height))

    def in_plane(self, directions: Array) -> Array:
        """Slenderness angles of a body that turns about the axis across a direction [rad].

        Args:
            directions: From the x axis towards y [rad], shape [direction].
        """
        farthest = (_unit(directions) @ self.polygon.T).max(axis=1)
        return np.asarray(np.arctan2(farthest, self.height))

    def _edges(self) -> tuple[Array, Array]:
        """Outward normals of the edges, shape [edge, 2], and their distances [m], shape [edge]."""
        along = np.roll(self.polygon, -1, axis=0) - self.polygon
        normals = np.stack([along[:, 1], -along[:, 0]], axis=1)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        # Zero and not -0, whose direction would be -pi.
        return normals + 0.0, np.einsum("ij,ij->i", normals, self.polygon)


def footing_of(points: Array, centre: Array, tolerance: float) -> Footing:
    """What a body stands on.

    Args:
        points: Its points in the pose at rest, z upwards [m], shape [point, 3].
        centre: Its centre of mass in the same axes [m], shape [3].
        tolerance: Points that are at most so high above the lowest one touch the ground [m].
    """
    ground = points[:, 2].min()
    low = points[points[:, 2] <= ground + tolerance]
    return Footing(hull_of(low[:, :2] - centre[:2]), float(centre[2] - ground))


def hull_of(points: Array) -> Array:
    """Corners of the convex hull of points in a plane against the clock, shape [corner, 2].

    Points on one line give its two ends, and points at one place that place.
    """
    from scipy.spatial import ConvexHull, QhullError

    spread = points - points.mean(axis=0)
    if not np.any(spread):
        return points[:1]
    along = np.linalg.svd(spread, full_matrices=False)[2][0]
    across = spread @ np.array([-along[1], along[0]])
    if np.ptp(across) > 1e-9 * np.ptp(spread @ along):
        try:
            return np.asarray(points[ConvexHull(points).vertices])
        except QhullError:
            pass
    ends = spread @ along
    return points[[int(np.argmin(ends)), int(np.argmax(ends))]]


def thin_polygon(polygon: Array, most: int, direction: float | None = None) -> Array:
    """A polygon with fewer corners, of the corners that it has.

    The corner that takes the least area goes first, after M. Visvalingam and J. D. Whyatt (1993),
    Line generalisation by repeated elimination of points, *The Cartographic Journal* 30(1); corners
    on a straight edge go in any case. In a plane of shaking a body turns about its farthest corner:
    those of a direction and of the opposite one stay, but in a triangle, as one on both may leave
    the centre of mass outside.

    Args:
        polygon: Corners against the clock, shape [corner, 2].
        most: Corners that may stay, at least 3.
        direction: Of shaking, from the x axis towards y [rad]; None if it is not known.
    """
    kept, size = polygon, float(np.ptp(polygon, axis=0).max()) ** 2
    stays = np.zeros(len(polygon), dtype=np.bool_)
    if direction is not None and most > 3:
        along = polygon @ _unit(np.array([direction]))[0]
        stays[[np.argmax(along), np.argmin(along)]] = True
    while len(kept) > 3:
        before, after = kept - np.roll(kept, 1, axis=0), np.roll(kept, -1, axis=0) - kept
        areas = 0.5 * np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
        # Equal ones in their order: of a round base every other corner goes.
        costs = np.where(stays & (areas > STRAIGHT * size), np.inf, np.round(areas / size, 9))
        smallest = int(np.argmin(costs if np.isfinite(costs).any() else areas))
        if len(kept) <= most and areas[smallest] > STRAIGHT * size:
            break
        kept, stays = np.delete(kept, smallest, axis=0), np.delete(stays, smallest)
    return kept


def _unit(directions: Array) -> Array:
    """Unit vectors, shape [direction, 2]."""
    return np.stack([np.cos(directions), np.sin(directions)], axis=-1)
