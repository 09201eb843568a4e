"""Rigid bodies that are no boxes: mass, moments of inertia, and the points that they stand on.

A body stands at rest on its lowest contact points. Of bodies in the plane those points are kept
that can touch flat ground at all, the lower convex hull, from -x to +x. With a point at (x, -h)
from the centre of mass the body is in balance above it at the rotation atan(x / h), and its centre
is then as high as that point is far from it: over the farthest point of a side it falls.

In an impact a body that turns about the point o comes to turn about the point n, both as seen from
the centre of mass. Its angular momentum about n stays. With a radius of gyration k it keeps the
part

    eta = (k^2 + o . n) / (k^2 + n . n)

of the angular velocity: Housner's 1 - 3/2 sin^2(alpha) where the body is a rectangle.

References:
    Housner, G. W. (1963). The behavior of inverted pendulum structures during earthquakes.
        Bulletin of the Seismological Society of America 53(2), 403-417.
"""

from __future__ import annotations

import dataclasses
import functools
from typing import Self

import numpy as np
import numpy.typing as npt

from warprock.model.hull import LEVEL, inner_radius, rounded_centres
from warprock.model.turning import inverse, rotate
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int32]

CORNERS = 8
"""Corners of a box."""


@dataclasses.dataclass(frozen=True)
class Bodies:
    """Bodies, one a lane, SI units.

    Attributes:
        mass: [kg], shape [lane].
        gyration: Moment of inertia about the centre of mass over the mass [m^2]: in the plane shape
            [lane]; in space those about the principal axes, [lane, 3].
        points: Contact points from the centre of mass [m]: in the plane x and z, shape
            [lane, point, 2], from -x to +x; in space [lane, point, 3], along the principal axes.
        count: Points of each lane, shape [lane]; rows beyond repeat the last point.
        corner_radius: Radius that the corners of the base are rounded with [m], shape [lane]; in
            space zero.
        axes: In space, the attitude of the principal axes as seen in the axes of the block,
            quaternions (x, y, z, w), shape [lane, 4]; in the plane (0, 0, 0, 1).
    """

    mass: Array
    gyration: Array
    points: Array
    count: Counts
    corner_radius: Array
    axes: Array

    @property
    def spatial(self) -> bool:
        """Whether they are bodies in space."""
        return bool(self.points.shape[-1] == 3)

    @property
    def most_points(self) -> int:
        """Contact points of the body that has most."""
        return int(self.points.shape[1])

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """Some of the lanes, by slice or by number."""
        parts = {f.name: getattr(self, f.name)[lanes] for f in dataclasses.fields(self)}
        return dataclasses.replace(self, **parts)

    @property
    def boxed(self) -> bool:
        """Whether all are boxes: eight corners about the centre of mass, along principal axes."""
        if not self.spatial or self.points.shape[1] != CORNERS or np.any(self.count != CORNERS):
            return False
        half = np.abs(self.points).max(axis=1, keepdims=True)
        near = LEVEL * half.max(axis=-1, keepdims=True)
        signs = np.sort((self.points > 0.0) @ np.array([1, 2, 4]), axis=1)
        straight = bool(np.all(np.abs(self.axes[:, :3]) <= LEVEL))
        at_corners = bool(np.all(np.abs(np.abs(self.points) - half) <= near))
        return straight and at_corners and bool(np.all(signs == np.arange(CORNERS)))

    @property
    def inner_radius(self) -> Array:
        """Radius of the largest ball about the centre of mass in the hull of points [m], [lane].

        Zero where the points do not surround the centre, as those of a base alone. Bodies with a
        ball may come to lie on any side: in every attitude a point is below the centre.
        """
        if not self.spatial:
            return np.zeros(len(self.mass))
        rows = np.column_stack([self.points.reshape(len(self.mass), -1), self.count])
        _, first, place = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        radii = [inner_radius(self.points[lane, : self.count[lane]]) for lane in first]
        return np.array(radii)[place.reshape(-1)]

    @functools.cached_property
    def points_in_block_axes(self) -> Array:
        """Contact points from the centre of mass along the axes of the block [m]."""
        if not self.spatial:
            return self.points
        return rotate(self.axes[:, None], self.points)

    @property
    def centre_height(self) -> Array:
        """Height of the centre of mass above the ground at rest [m], shape [lane]."""
        return np.asarray(-self.points_in_block_axes[..., -1].min(axis=1))

    @functools.cached_property
    def standing(self) -> npt.NDArray[np.bool_]:
        """Whether the body stands on a point at rest, shape [lane, point]."""
        points = self.points_in_block_axes
        low = points[..., -1] - points[..., -1].min(axis=1, keepdims=True)
        return np.asarray(low <= LEVEL * np.ptp(points, axis=1).max(axis=-1)[:, None])

    @property
    def base_ends(self) -> Array:
        """Ends of what the body stands on at rest, along x, from below the centre of mass [m].

        Shape [lane, 2]; of rounded corners, where the flat base ends. In space they are where the
        line along x leaves the base.
        """
        if self.spatial:
            return self.reach(np.zeros(len(self.mass)))
        x, stands = self.centres[..., 0], self.standing
        ends = [np.where(stands, x, np.inf).min(axis=1), np.where(stands, x, -np.inf).max(axis=1)]
        return np.stack(ends, axis=1)

    def reach(self, direction: Array) -> Array:
        """Where a line through the projected centre of mass leaves the base, in space.

        Args:
            direction: Angle of the line from the block's x axis [rad], shape [lane].

        Returns:
            Its ends behind (<= 0) and ahead of the centre [m], shape [lane, 2].
        """
        points, stands = self.points_in_block_axes, self.standing
        c, s = np.cos(direction)[:, None], np.sin(direction)[:, None]
        along = points[..., 0] * c + points[..., 1] * s
        across = points[..., 1] * c - points[..., 0] * s
        # The line crosses the hull where a chord between any two of its points does, outermost.
        first, second = np.triu_indices(points.shape[1], 1)
        a, b = across[:, first], across[:, second]
        crosses = (a * b <= 0.0) & (a != b) & stands[:, first] & stands[:, second]
        with np.errstate(divide="ignore", invalid="ignore"):
            at = (along[:, first] * b - along[:, second] * a) / (b - a)
        ends = [np.where(crosses, at, np.inf).min(axis=1), np.where(crosses, at, -np.inf).max(1)]
        return np.stack(ends, axis=1)

    @property
    def uplift_ratios(self) -> Array:
        """Base acceleration / g that lifts the body over its -x and its +x end, shape [lane, 2]."""
        ends = self.base_ends * np.array([-1.0, 1.0])
        return np.asarray(ends / self.centre_height[:, None])

    @property
    def slenderness_angles(self) -> Array:
        """Rotation of unstable balance to -x and to +x [rad], both positive, shape [lane, 2].

        In space that of the body's outline in the plane of x and z.
        """
        return self._balance(self.centres[..., [0, -1]])

    @property
    def slenderness_angles_across(self) -> Array:
        """Rotation of unstable balance in space to -y and to +y [rad], shape [lane, 2]."""
        return self._balance(self.points_in_block_axes[..., 1:])

    @property
    def centres(self) -> Array:
        """Centres of the arcs that round the corners, in the axes of the block [m].

        The contact points themselves where the radius is zero. A corner of the plane is rounded
        between the edges that meet in it, beside an end by the vertical.
        """
        points = self.points_in_block_axes
        return rounded_centres(points, self.corner_radius) if self.corner_radius.any() else points

    @property
    def reaches(self) -> Array:
        """Distances from the centre of mass to both ends of the base at rest [m], [lane, 2]."""
        return np.hypot(self.base_ends, self.centre_height[:, None])

    @property
    def frequency_parameter(self) -> Array:
        """sqrt(g R / (k^2 + R^2)) about the nearer end of the base at rest [rad/s], shape [lane].

        R is the distance to it; in space k that about y, which the body turns about in the plane.
        """
        radius = self.reaches.min(axis=1)
        return np.asarray(np.sqrt(GRAVITY * radius / (self.gyration_in_plane + radius**2)))

    @property
    def gyration_in_plane(self) -> Array:
        """Moment of inertia about y, through the centre of mass, over the mass [m^2], [lane]."""
        if not self.spatial:
            return self.gyration
        y = rotate(inverse(self.axes), np.array([[0.0, 1.0, 0.0]]))
        return np.asarray(np.sum(self.gyration * y**2, axis=1))

    def outline(self, height: Array) -> Array:
        """Corners of the bodies as pictures show them [m], along the axes of the block.

        That is the hull of their points where these surround the centre of mass. Else it is their
        base, and straight above it their top: of what lies between them a body says nothing.

        Args:
            height: Full height [m], shape [lane].

        Returns:
            From the centre of mass, shape [lane, corner, 2], going round from -x along the base; in
            space [lane, corner, 3], the hull of which is the picture.
        """
        base = self.points_in_block_axes
        if self.inner_radius.all():
            return base
        top = np.array(base if self.spatial else base[:, ::-1])
        top[..., -1] = np.maximum(height - self.centre_height, 0.0)[:, None]
        return np.concatenate([base, top], axis=1)

    def roll_centres(self, rotation: Array) -> tuple[Array, Array]:
        """Where the centre of mass of planar bodies is that have rolled without sliding [m].

        Args:
            rotation: [rad], shape [lane, sample].

        Returns:
            x from where it is at rest, and z above the ground, shape [lane, sample] each.
        """
        x, z = np.moveaxis(self.centres, -1, 0)
        far, alpha = np.hypot(x, z), np.arctan2(x, -z)

        def levers(turn: Array, foot: npt.NDArray[np.intp]) -> Array:
            at, angle = (np.take_along_axis(each, foot, axis=1) for each in (far, alpha))
            return np.asarray(at * np.sin(turn - angle))

        # Where one point takes over from another the centre does not jump.
        edge = np.arctan2(np.diff(z, axis=1), np.diff(x, axis=1))
        number = np.broadcast_to(np.arange(edge.shape[1]), edge.shape)
        jumps = levers(edge, number) - levers(edge, number + 1)
        stood = np.concatenate([np.zeros_like(x[:, :1]), np.cumsum(jumps, axis=1)], axis=1)

        def along(turn: Array) -> tuple[Array, Array]:
            high = far[:, None] * np.cos(turn[..., None] - alpha[:, None])
            foot = np.argmax(high, axis=-1)
            radius = self.corner_radius[:, None]
            at = np.take_along_axis(stood, foot, axis=1) + levers(turn, foot) + radius * turn
            return at, radius + high.max(axis=-1)

        start, _ = along(np.zeros_like(rotation[:, :1]))
        moved, above = along(rotation)
        return moved - start, above

    def _balance(self, points: Array) -> Array:
        """Angles above the farthest point of either side, shape [lane, 2]."""
        far = np.hypot(points[..., 0], points[..., 1])
        angles = []
        for sign in (-1.0, 1.0):
            beside = sign * points[..., 0] > 0.0
            at = np.argmax(np.where(beside, far, -1.0), axis=1)[:, None, None]
            x, z = np.moveaxis(np.take_along_axis(points, at, axis=1)[:, 0], -1, 0)
            angles.append(np.arctan2(sign * x, -z))
        return np.stack(angles, axis=1)

    @property
    def angular_restitutions(self) -> Array:
        """Part of the angular velocity kept by an impact on the -x and on the +x end, [lane, 2].

        Of planar bodies that turn from one end of the base at rest to the other.
        """
        ends = self.base_ends
        below = self.gyration + self.centre_height**2
        kept = below + ends.prod(axis=1)
        return np.asarray(kept[:, None] / (below[:, None] + ends**2))


def boxes_on_corners(
    *, sizes: Array, mass: Array, gyration: Array | None = None, centre: Array | None = None
) -> Bodies:
    """Boxes as bodies of their eight corners.

    Args:
        sizes: Width, depth and height [m], shape [lane, 3].
        mass: [kg], shape [lane].
        gyration: Moments of inertia over the mass [m^2], shape [lane, 3]; None where boxes are the
            same all through.
        centre: The centre of mass from the middle of the box [m], shape [lane, 3]; None where it
            is there.
    """
    squares, count = sizes**2, len(mass)
    if gyration is None:
        gyration = (squares.sum(axis=-1, keepdims=True) - squares) / 12.0
    signs = np.array([(x, y, z) for z in (-1.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
    points = 0.5 * sizes[:, None] * signs
    return Bodies(
        mass=mass,
        gyration=gyration,
        points=points if centre is None else points - centre[:, None],
        count=np.full(count, CORNERS, np.int32),
        corner_radius=np.zeros(count),
        axes=np.tile((0.0, 0.0, 0.0, 1.0), (count, 1)),
    )
