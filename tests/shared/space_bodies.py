"""Bodies in space that several test files share."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from tests.shared.spatial_blocks import spatial_lanes
from warprock.model.bodies import Bodies
from warprock.model.lanes import SpatialLanes
from warprock.model.pose import bottom_corners
from warprock.model.turning import inverse, principal_axes, rotate

Array = npt.NDArray[np.float64]

ROCK_POINTS = np.array(
    [
        (-0.1, -0.12, -0.3), (0.2, -0.1, -0.3), (0.22, 0.1, -0.3), (0.05, 0.2, -0.3),
        (-0.12, 0.1, -0.3), (0.3, 0.0, -0.25),
    ]
)  # fmt: skip
"""Contact points of a rock without symmetry, from its centre of mass [m]; the last hangs."""
BOULDER = np.concatenate(
    [ROCK_POINTS, [(-0.08, -0.1, 0.2), (0.12, -0.05, 0.25), (0.1, 0.12, 0.22), (-0.1, 0.06, 0.28)]]
)
"""The rock with points on its top: it has some to land on in every attitude [m]."""
ROCK_TENSOR = np.array([(0.05, 0.008, 0.004), (0.008, 0.042, -0.003), (0.004, -0.003, 0.03)])
"""Its moments of inertia over its mass [m^2]."""


def bodies_of(points: Array, tensor: Array, count: int, mass: float = 100.0) -> Bodies:
    """The same body in every lane.

    Args:
        points: From the centre of mass in the axes of the block [m], shape [point, 3].
        tensor: Moments of inertia over the mass [m^2], shape [3, 3].
        count: Lanes.
        mass: [kg].
    """
    moments, axes = principal_axes(tensor)
    own = rotate(inverse(axes), np.asarray(points, dtype=np.float64))
    return Bodies(
        mass=np.full(count, mass),
        gyration=np.tile(moments, (count, 1)),
        points=np.tile(own, (count, 1, 1)),
        count=np.full(count, len(own), np.int32),
        corner_radius=np.zeros(count),
        axes=np.tile(axes, (count, 1)),
    )


def body_lanes(
    points: Array, tensor: Array, count: int, mass: float = 100.0, **more: npt.ArrayLike
) -> SpatialLanes:
    """Lanes of a body; starts and friction by name."""
    size = np.ptp(points, axis=0)
    lanes = spatial_lanes(np.full(count, size[0]), np.full(count, -2.0 * points[:, 2].min()))
    parts = {name: np.broadcast_to(np.asarray(value, float), count) for name, value in more.items()}
    body = bodies_of(np.asarray(points, dtype=np.float64), tensor, count, mass)
    depth = np.full(count, size[1])
    parts["density"] = mass / (lanes.width * lanes.height * depth)
    return dataclasses.replace(lanes, depth=depth, body=body, **parts)


def box_as_body(lanes: SpatialLanes) -> SpatialLanes:
    """Boxes as bodies: their four corners, mass and moments of inertia."""
    width, depth, height = lanes.width, lanes.depth, lanes.height
    squares = np.stack([depth**2 + height**2, width**2 + height**2, width**2 + depth**2], axis=-1)
    count = lanes.lane_count
    body = Bodies(
        mass=lanes.mass,
        gyration=squares / 12.0,
        points=bottom_corners(lanes),
        count=np.full(count, 4, np.int32),
        corner_radius=np.zeros(count),
        axes=np.tile((0.0, 0.0, 0.0, 1.0), (count, 1)),
    )
    return dataclasses.replace(lanes, body=body)


def some_boxes() -> SpatialLanes:
    """Boxes that rock in the plane, over corners and while they slide, and one that stands."""
    lanes = spatial_lanes(
        [0.2, 0.2, 0.3, 0.3], [1.0, 1.0, 0.8, 0.8], friction=[0.8, 0.6, 0.4, 0.5],
        rotation_start=[0.1, 0.15, 0.2, 0.0], rotation_across_start=[0.0, 0.05, 0.1, 0.0],
        yaw_start=[0.0, 0.1, 0.2, 0.4],
    )  # fmt: skip
    return dataclasses.replace(lanes, depth=np.array([0.3, 0.3, 0.2, 0.2]))
