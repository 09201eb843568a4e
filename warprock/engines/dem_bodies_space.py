"""Springs under bodies on contact points in space, for the soft-spring engine.

Every point stands on a spring, as the corners of a box with two sub-contacts along and across do:
it has its part of the area of the base that the body stands on at rest.
"""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any, Self, cast

import numpy as np
import numpy.typing as npt

from warprock.engines.launching import NEVER
from warprock.engines.spatial_bodies import body_of, existing_points, spatial_inputs
from warprock.model.bodies import Bodies, boxes_on_corners
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.pose import product, quaternion, start_poses
from warprock.model.turning import inverse, rotate
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

TRIALS = 100
"""Trials of which points carry; as many as there are points end it."""
LEAST_CREEP = 1e-9
"""Speed that is round-off of a body that nothing holds [m/s]."""
ALMOST = 1e-9
"""Part of a stiffness, or of a second moment, that is round-off."""


@dataclasses.dataclass(frozen=True)
class PointSprings:
    """Bodies in space and the springs under their points.

    Attributes:
        lanes: Their lanes.
        body: The bodies.
        area: That a point stands for [m^2], shape [lane].
        stiffness: Normal stiffness of a point [N/m], shape [lane].
        shear: Shear stiffness of a point [N/m], shape [lane].
    """

    lanes: SpatialLanes
    body: Bodies
    area: Array
    stiffness: Array
    shear: Array

    @classmethod
    def of(cls, lanes: Lanes, settings: DemSettings) -> Self:
        """The springs of lanes of bodies."""
        body = body_of(lanes)
        area = base_area(body) / base_of(body).sum(axis=1)
        return cls(
            lanes=cast(SpatialLanes, lanes),
            body=body,
            area=area,
            stiffness=settings.normal_stiffness * area,
            shear=settings.shear_stiffness * area,
        )

    @property
    def feet(self) -> Mask:
        """Points that a body stands on at rest, shape [lane, point]."""
        return np.asarray(self.body.standing & existing_points(self.body))

    def standing_ratio(self) -> Array:
        """Rocking stiffness of the springs / that needed to stand, shape [lane, 1].

        About the weaker axis through the middle of the base, see `dem_springs.standing_ratio`.
        """
        least = _least_moment(self.body, base_of(self.body))
        load = GRAVITY * self.body.mass * self.body.centre_height
        return np.asarray(self.stiffness * np.maximum(least, 0.0) / load)[:, None]

    def stiffest_frequency(self) -> Array:
        """Largest angular frequency of small motions [rad/s], all points closed, shape [lane]."""
        body = self.body
        # The axes of the base as seen along the principal axes.
        back = inverse(body.axes)
        matrix = np.zeros((len(body.mass), 6, 6))
        weight = existing_points(body)[..., None]
        for axis, spring in zip(np.eye(3), (self.shear, self.shear, self.stiffness), strict=True):
            way = np.broadcast_to(rotate(back, axis[None])[:, None], body.points.shape)
            row = weight * np.concatenate([way, np.cross(body.points, way)], axis=-1)
            matrix += spring[:, None, None] * np.einsum("lpi,lpj->lij", row, row)
        moments = np.concatenate([np.ones_like(body.gyration), body.gyration], axis=1)
        root = np.sqrt(body.mass[:, None] * moments)
        roots = np.linalg.eigvalsh(matrix / (root[:, :, None] * root[:, None, :]))
        return np.asarray(np.sqrt(roots[:, -1]))

    def start(self) -> tuple[Array, Array]:
        """Centres of mass [m], over the height of the rigid body at rest, and attitudes at start.

        A body at rest is in static equilibrium; one that is let go from a lean bears its weight on
        the points that reach the base, one in the air none.
        """
        lanes, body = self.lanes, self.body
        place, attitude = start_poses(lanes)
        away = (lanes.rotation_start != 0.0) | (lanes.rotation_across_start != 0.0)
        flies = (lanes.gap_start > 0.0) | lanes.thrown
        rests = ~away & ~flies
        depth, slope = self._bearing()
        lean = np.stack([-slope[:, 1], slope[:, 0], np.zeros_like(depth)], axis=-1)
        yaw = quaternion(lanes.yaw_start[:, None] * np.array([0.0, 0.0, 1.0]))
        lean = rotate(yaw, lean)
        up = body.centre_height[:, None] * np.array([0.0, 0.0, 1.0])
        sunk = np.cross(lean, up) - depth[:, None] * np.array([0.0, 0.0, 1.0])
        levers = rotate(attitude[:, None], body.points_in_block_axes)[..., 2]
        pressed = self._sink(place[:, 2, None] + levers)
        down = pressed[:, None] * np.array([0.0, 0.0, -1.0])
        moved = np.where(rests[:, None], sunk, np.where(flies[:, None], 0.0, down))
        turn = np.where(rests[:, None], product(quaternion(lean), attitude), attitude)
        moved[:, 2] -= body.centre_height
        return place + moved, turn

    def _bearing(self) -> tuple[Array, Array]:
        """Overlap below the centre of mass [m] and its slopes along the block's x and y at rest."""
        plan = self.body.points_in_block_axes[..., :2]
        shape = np.concatenate([np.ones((*plan.shape[:2], 1)), plan], axis=-1)
        closed, weight = self.feet, GRAVITY * self.body.mass
        found = np.zeros((len(weight), 3))
        tips = (weight * self.body.centre_height)[:, None, None] * np.diag([0.0, 1.0, 1.0])
        for _ in range(TRIALS):
            stiff = self.stiffness[:, None] * closed
            held = np.einsum("lp,lpi,lpj->lij", stiff, shape, shape)
            bound = np.trace(held, axis1=1, axis2=2) + weight
            matrix = held - tips
            solvable = np.linalg.eigvalsh(held)[:, 0] > ALMOST * bound
            safe = np.where(solvable[:, None, None], matrix, np.eye(3))
            load = weight[:, None] * np.array([1.0, 0.0, 0.0])
            answer = np.linalg.solve(safe, load[..., None])[..., 0]
            found = np.where(solvable[:, None], answer, found)
            now = self.feet & (np.einsum("lpi,li->lp", shape, found) > 0.0)
            if np.array_equal(now, closed):
                break
            closed = np.where(now.any(axis=1, keepdims=True), now, closed)
        return found[:, 0], found[:, 1:]

    def _sink(self, height: Array) -> Array:
        """How far a body sinks until points at heights [m], [lane, point], bear its weight [m]."""
        rise = np.sort(np.where(existing_points(self.body), height, np.inf), axis=1)
        settles = GRAVITY * self.body.mass / self.stiffness
        number = np.arange(1, rise.shape[1] + 1)
        with np.errstate(invalid="ignore"):
            depth = (settles[:, None] + np.cumsum(rise, axis=1)) / number
        carried = depth > rise
        return np.take_along_axis(depth, carried.sum(axis=1, keepdims=True) - 1, axis=1)[:, 0]


def base_of(body: Bodies) -> Mask:
    """Points that a body can stand on, shape [lane, point].

    They are those that it stands on at rest, or all where these lie on a line.
    """
    there = existing_points(body)
    feet = body.standing & there
    size = np.ptp(body.points, axis=1).max(axis=1)
    flat = _least_moment(body, feet) > ALMOST * size**2
    return np.asarray(np.where(flat[:, None], feet, there))


def _least_moment(body: Bodies, chosen: Mask) -> Array:
    """Least second moment in plan of some points about an axis through their middle [m^2]."""
    plan = body.points_in_block_axes[..., :2]
    weight = chosen / chosen.sum(axis=1, keepdims=True)
    away = plan - (weight[..., None] * plan).sum(axis=1, keepdims=True)
    away = np.where(chosen[..., None], away, 0.0)
    return np.asarray(np.linalg.eigvalsh(np.einsum("lpi,lpj->lij", away, away))[:, 0])


def base_area(body: Bodies) -> Array:
    """Area of the convex hull of what a body can stand on [m^2], shape [lane]."""
    plan, feet = body.points_in_block_axes[..., :2], base_of(body)
    _found, first, place = np.unique(
        np.concatenate([plan.reshape(len(plan), -1), feet], axis=1), axis=0,
        return_index=True, return_inverse=True,
    )  # fmt: skip
    areas = [_hull_area(plan[lane][feet[lane]]) for lane in first]
    return np.array(areas)[place.reshape(-1)]


def _hull_area(points: Array) -> float:
    """Area of the convex hull of points in a plane [m^2], shape [point, 2]."""
    ordered = points[np.lexsort((points[:, 1], points[:, 0]))]
    area = 0.0
    for side in (ordered, ordered[::-1]):
        chain: list[Array] = []
        for point in side:
            while len(chain) > 1 and _cross(chain[-1] - chain[-2], point - chain[-2]) <= 0.0:
                chain.pop()
            chain.append(point)
        area += 0.5 * sum(_cross(a, b) for a, b in itertools.pairwise(chain))
    return area


def _cross(a: Array, b: Array) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def on_corners(lanes: Lanes) -> Lanes:
    """Boxes that are thrown, as bodies of eight points; other lanes as they are."""
    if lanes.release is None or not lanes.thrown or lanes.body is not None:
        return lanes
    sizes = np.stack([lanes.width, lanes.depth, lanes.height], axis=-1)
    gyration = lanes.release.gyration
    body = boxes_on_corners(sizes=sizes, mass=lanes.mass, gyration=gyration)
    return dataclasses.replace(lanes, body=body)


def sprung_inputs(
    lanes: Lanes, settings: DemSettings, per_lane: dict[str, npt.NDArray[Any]]
) -> dict[str, dict[str, npt.NDArray[Any]]]:
    """What the kernel of bodies in space takes but its knobs, by the names of its arguments.

    `per_lane` are the time steps, and along what the bases move, shape [lane] each.
    """
    springs = PointSprings.of(lanes, settings)
    place, attitude = springs.start()
    blocks, body = springs.lanes, springs.body
    columns = spatial_inputs(lanes)
    for names, values in ((("x", "y", "z"), place), (("qx", "qy", "qz", "qw"), attitude)):
        for name, part in zip(names, values.T, strict=True):
            columns["blocks"][name] = part[:, None]
    leans = (blocks.rotation_start != 0.0) | (blocks.rotation_across_start != 0.0)
    bound = lanes.friction * GRAVITY * lanes.mass
    bound = bound + settings.cohesion * springs.area * base_of(body).sum(axis=1)
    whole = springs.shear * base_of(body).sum(axis=1)
    columns["lanes"] = columns["frames"] | per_lane
    columns["lanes"] |= {
        "creep": np.maximum(bound / np.sqrt(whole * body.mass), LEAST_CREEP),
        "uplift_time": np.where(leans | (blocks.gap_start > 0.0), 0.0, NEVER),
        "height": body.centre_height,
        "area": springs.area,
    }
    return columns
