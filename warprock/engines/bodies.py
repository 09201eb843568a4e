"""Bodies on contact points in the plane as the kernels take them: their corners, shape [lane, 1].

Corners are the contact points that can touch flat ground, one a convex corner: a point on an edge
touches together with both ends of it, and an impulse there is the same as one shared by the ends.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from warprock.engines.launching import NEVER
from warprock.model.bodies import Bodies
from warprock.model.hull import LEVEL
from warprock.model.lanes import Lanes
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class Corners:
    """Corners of bodies, from -x to +x, seen from the centre of mass at the rotation zero.

    Rows beyond the last corner of a lane repeat it.

    Attributes:
        x: [m], shape [lane, corner]; of a rounded corner the centre of its arc.
        z: The same upwards.
        angle: Rotation at which the edge to the next corner lies flat [rad]; NEVER from the last
            one on.
        along: Where a corner comes to stand if the body rolls on [m].
        radius: Of the arcs [m], shape [lane].
    """

    x: Array
    z: Array
    angle: Array
    along: Array
    radius: Array

    @classmethod
    def of(cls, bodies: Bodies) -> Corners:
        """The corners of bodies in the plane."""
        points = bodies.centres.copy()
        # What it stands on at rest is level: round-off there would be an edge of its own.
        base = points[..., 1].min(axis=1, keepdims=True)
        level = LEVEL * np.ptp(points, axis=1).max(axis=-1)[:, None]
        points[..., 1] = np.where(points[..., 1] - base <= level, base, points[..., 1])
        x, z = _convex(points, bodies.count)
        dx, dz = np.diff(x, axis=1), np.diff(z, axis=1)
        length = np.hypot(dx, dz)
        last = np.full((len(x), 1), NEVER)
        angle = np.where(length > 0.0, np.arctan2(dz, dx), NEVER)
        # Rolled out from the corner that is lowest at first.
        rolled = np.concatenate([np.zeros_like(last), np.cumsum(length, axis=1)], axis=1)
        lowest = np.argmin(z, axis=1)[:, None]
        from_there = rolled - np.take_along_axis(rolled, lowest, axis=1)
        along = np.take_along_axis(x, lowest, axis=1) + from_there
        return cls(x, z, np.concatenate([angle, last], axis=1), along, bodies.corner_radius)

    @property
    def columns(self) -> dict[str, Array]:
        """Fields of the struct `Corner` of kernels/shape/body.py, shape [lane, corner]."""
        return {"x": self.x, "z": self.z, "angle": self.angle, "along": self.along}

    @property
    def last(self) -> npt.NDArray[np.intp]:
        """Number of the last corner, shape [lane]."""
        return np.asarray((self.angle < NEVER).sum(axis=1))

    @property
    def reach(self) -> Array:
        """Distance of the farthest corner from the centre of mass [m], shape [lane]."""
        return np.asarray(np.hypot(self.x, self.z).max(axis=1))

    def fastest_rate(self, gyration: Array) -> Array:
        """Largest rate at which a body falls about one of its corners [1/s], shape [lane].

        sqrt(g R / (k^2 + R^2)), R the distance of the corner, k^2 the gyration; largest at R = k.
        """
        square = self.x**2 + self.z**2
        rates = GRAVITY * np.sqrt(square) / (gyration[:, None] + square)
        return np.asarray(np.sqrt(rates.max(axis=1)))

    def lowest(self, rotation: Array) -> npt.NDArray[np.intp]:
        """Number of the corner that is lowest at rotations [rad], shape [lane, sample]."""
        return np.asarray((rotation[..., None] > self.angle[:, None]).sum(axis=-1))

    def lever(self, rotation: Array) -> tuple[Array, Array]:
        """What touches at rotations [rad], from the centre of mass: x and z [m], as `rotation`."""
        at = self.lowest(rotation)
        x, z = (np.take_along_axis(part, at, axis=1) for part in (self.x, self.z))
        s, c = np.sin(rotation), np.cos(rotation)
        return x * c + z * s, z * c - x * s - self.radius[:, None]

    def rise(self, rotation: Array, balance: Array) -> Array:
        """How far the centre of mass has risen since the rotation zero [m], shape [lane].

        Args:
            rotation: [rad], shape [lane].
            balance: Rotations of unstable balance to -x and to +x [rad], both positive, shape
                [lane, 2]; beyond it is what it takes to get there.
        """
        turned = np.clip(rotation, -balance[:, 0], balance[:, 1])
        both = self.lever(np.stack([turned, np.zeros_like(turned)], axis=1))[1]
        return np.asarray(both[:, 1] - both[:, 0])

    def least_rise(self, rotation: Array) -> Array:
        """The lesser rise of a body that turned from zero to either side [m], shape [lane]."""
        turns = np.stack([-rotation, rotation, np.zeros_like(rotation)], axis=1)
        heights = -self.lever(turns)[1]
        return np.asarray(heights[:, :2].min(axis=1) - heights[:, 2])

    def slide(self, rotation: Array, x: Array) -> Array:
        """Slide [m] of bodies with their centres of mass at x [m], shape [lane, sample] each."""
        rolled = np.take_along_axis(self.along, self.lowest(rotation), axis=1)
        rolled = rolled + self.radius[:, None] * rotation
        return np.asarray(x + self.lever(rotation)[0] - rolled)


def rotate_lever(x: Array, z: Array, rotation: Array) -> tuple[Array, Array]:
    """A lever [m] turned clockwise by a rotation [rad], its x and z: arrays of one shape."""
    s, c = np.sin(rotation), np.cos(rotation)
    return x * c + z * s, z * c - x * s


def box_bodies(lanes: Lanes) -> Bodies:
    """Single boxes in the plane as bodies."""
    half = 0.5 * lanes.face_width
    x, z = np.stack([-half, half], axis=1), np.repeat(-0.5 * lanes.height[:, None], 2, axis=1)
    return Bodies(
        mass=lanes.mass,
        gyration=(lanes.width**2 + lanes.height**2) / 12.0,
        points=np.stack([x, z], axis=-1),
        count=np.full(lanes.lane_count, 2, np.int32),
        corner_radius=np.zeros(lanes.lane_count),
        axes=np.broadcast_to((0.0, 0.0, 0.0, 1.0), (lanes.lane_count, 4)),
    )


def _convex(points: Array, count: npt.NDArray[np.int32]) -> tuple[Array, Array]:
    """Points [lane, point, 2] but for those on an edge between two others: x and z.

    One by one, a lane loses the point that is least below the line between those beside it, until
    all are further below than round-off. The ends, and those of what it stands on at rest, stay.
    """
    number, level = np.arange(points.shape[1]), points[..., 1]
    near = LEVEL * np.ptp(points, axis=1).max(axis=-1)
    stands = (level == level.min(axis=1, keepdims=True)) & (number < count[:, None])
    ends = (number == 0) | (number == count[:, None] - 1)
    fixed = ends | (number == np.argmax(stands, axis=1)[:, None])
    fixed |= number == (points.shape[1] - 1 - np.argmax(stands[:, ::-1], axis=1))[:, None]
    while True:
        before, behind = points[:, :-2], points[:, 2:]
        chord, arm = behind - before, points[:, 1:-1] - before
        length = np.hypot(chord[..., 0], chord[..., 1])
        below = arm[..., 0] * chord[..., 1] - arm[..., 1] * chord[..., 0]
        loose = ~fixed[:, 1:-1] & (below <= near[:, None] * length)
        loose &= np.arange(1, points.shape[1] - 1) < count[:, None] - 1
        if not loose.any():
            break
        depth = np.where(loose, below / np.where(loose, length, 1.0), np.inf)
        least = np.where(loose.any(axis=1), 1 + np.argmin(depth, axis=1), points.shape[1])
        # Those behind it move up, and the last one is repeated.
        rows = np.arange(points.shape[1])
        rows = np.minimum(rows + (rows >= least[:, None]), points.shape[1] - 1)
        points = np.take_along_axis(points, rows[..., None], axis=1)
        fixed = np.take_along_axis(fixed, rows, axis=1)
        count = count - loose.any(axis=1)
    most = int(count.max())
    return points[:, :most, 0], points[:, :most, 1]
