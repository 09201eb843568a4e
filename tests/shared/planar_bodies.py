"""Bodies on contact points in the plane that tests of engines share."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tests.shared.blocks import make_lanes
from warprock.model.bodies import Bodies
from warprock.model.hull import lower_hull
from warprock.model.lanes import Lanes

Points = Sequence[tuple[float, float]]

STEPPED: Points = ((-0.3, -0.44), (-0.22, -0.48), (-0.1, -0.5), (0.15, -0.5), (0.25, -0.47))
"""Corners of a base with steps on both sides, from the centre of mass [m]."""
GYRATION = 0.09
"""Moment of inertia of the bodies over their mass [m^2]."""


def planar_bodies(
    *,
    mass: npt.ArrayLike,
    inertia: npt.ArrayLike,
    points: npt.NDArray[np.float64],
    corner_radius: npt.ArrayLike = 0.0,
) -> Bodies:
    """Bodies in the plane, all with the same base.

    Args:
        mass: [kg], one or shape [lane].
        inertia: Moment of inertia about the centre of mass [kg m^2], one or shape [lane].
        points: Contact points from the centre of mass, x and z [m], shape [point, 2].
        corner_radius: [m], one or shape [lane].
    """
    parts = np.broadcast_arrays(*(np.asarray(v, float) for v in (mass, inertia, corner_radius)))
    mass, inertia, radius = (np.atleast_1d(part) for part in parts)
    base, count = lower_hull(points), len(mass)
    return Bodies(
        mass=mass,
        gyration=np.asarray(inertia / mass),
        points=np.broadcast_to(base, (count, *base.shape)),
        count=np.full(count, len(base), np.int32),
        corner_radius=radius,
        axes=np.broadcast_to((0.0, 0.0, 0.0, 1.0), (count, 4)),
    )


def body_lanes(
    points: Points,
    rotation: npt.ArrayLike,
    *,
    friction: float = 10.0,
    radius: float = 0.0,
    restitution: float | None = None,
) -> Lanes:
    """Bodies of 100 kg on the same corners, let go from rotations [rad]."""
    start = np.asarray(rotation, dtype=np.float64)
    count = len(start)
    body = planar_bodies(
        mass=np.full(count, 100.0),
        inertia=100.0 * GYRATION,
        points=np.asarray(points),
        corner_radius=radius,
    )
    lanes = make_lanes(np.full(count, np.ptp(points, axis=0)[0]), 1.0, friction=friction)
    given = restitution is not None
    kept = np.full(count, restitution) if given else lanes.angular_restitution
    return dataclasses.replace(
        lanes, rotation_start=start, body=body, restitution_given=given, angular_restitution=kept
    )


def mirrored(lanes: Lanes) -> Lanes:
    """The same bodies seen from behind, let go to the other side."""
    assert lanes.body is not None
    points = lanes.body.points[:, ::-1] * np.array([-1.0, 1.0])
    body = dataclasses.replace(lanes.body, points=points)
    return dataclasses.replace(lanes, body=body, rotation_start=-lanes.rotation_start)
