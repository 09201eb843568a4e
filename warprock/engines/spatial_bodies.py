"""Bodies in space as the kernels take them: rows of the structs of kernels/shape_space/body.py."""

from __future__ import annotations

from typing import cast

import numpy as np
import numpy.typing as npt

from warprock.engines.blocks import spatial_columns, throw_columns
from warprock.errors import InputError
from warprock.model.bodies import Bodies
from warprock.model.hull import LEVEL
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.pose import rotate_yaw, start_poses
from warprock.model.scene import SceneKind
from warprock.model.turning import rotate
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

MOST_POINTS = 64
"""Most contact points of a body: the rows that kernels have room for."""


def point_rows(scene: SceneKind | Lanes) -> int:
    """Rows for points of a kernel that has a constant number of them: a power of two, at least 8.

    So bodies of different bases share few kernels.
    """
    return 1 << max(3, (scene.contact_point_count - 1).bit_length())


def quickest(body: Bodies) -> Array:
    """Largest frequency parameter about any of the contact points [rad/s], shape [lane]."""
    square = np.sum(body.points**2, axis=-1)
    least = body.gyration.min(axis=1, keepdims=True)
    rate = np.sqrt(GRAVITY * np.sqrt(square) / (least + square))
    return np.asarray(rate.max(axis=1))


def body_of(lanes: Lanes) -> Bodies:
    """The bodies of lanes that have some."""
    assert lanes.body is not None
    return lanes.body


def spatial_inputs(lanes: Lanes) -> dict[str, dict[str, Array]]:
    """What kernels take of blocks in space, or of bodies, by the names of their arguments.

    Raises:
        InputError: A body has more points than kernels have room for.
    """
    if lanes.body is None:
        return {"blocks": spatial_columns(lanes), "throws": throw_columns(lanes)}
    columns = {"blocks": _body_columns(lanes), "frames": _frame_columns(lanes)}
    return columns | {"points": _point_columns(lanes)}


def _body_columns(lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct `Block` of kernels/shape_space/block.py, shape [lane, 1] each."""
    body, blocks = body_of(lanes), cast(SpatialLanes, lanes)
    height = body.centre_height[:, None]
    columns = spatial_columns(lanes)
    columns |= {"half_height": height, "standing": _standing(blocks)[:, None]}
    for name, gyration in zip("xyz", body.gyration.T, strict=True):
        columns[f"inverse_{name}"] = 1.0 / gyration[:, None]
    return columns


def _frame_columns(lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct `Frame`, shape [lane] each."""
    body = body_of(lanes)
    columns = {f"a{name}": part for name, part in zip("xyzw", body.axes.T, strict=True)}
    feet = (body.standing & existing_points(body)).sum(axis=1)
    columns |= {"reach": farthest(body), "feet": feet.astype(np.float64)}
    return columns | throw_columns(lanes)


def _point_columns(lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct `Point`, shape [lane, point] each.

    Raises:
        InputError: There are more points than kernels have room for.
    """
    body, blocks = body_of(lanes), cast(SpatialLanes, lanes)
    if body.most_points > MOST_POINTS:
        allowed = f"must have at most {MOST_POINTS} contact points"
        raise InputError("run_batch", "lanes.body.points", body.most_points, allowed)
    stood, there = standing_places(blocks), existing_points(body)
    columns = {name: body.points[..., axis] for axis, name in enumerate("xyz")}
    columns |= {"stood_x": stood[..., 0], "stood_y": stood[..., 1]}
    return columns | {"foot": np.where(there, body.standing, -1.0)}


def standing_places(lanes: SpatialLanes) -> Array:
    """Where the contact points would be on the ground, did the bodies stand at the start [m].

    Shape [lane, point, 2].
    """
    body, offset = body_of(lanes), np.stack([lanes.offset, lanes.offset_across], axis=-1)
    yaw = lanes.yaw_start.reshape(lanes.lane_count, 1)
    stood = rotate_yaw(body.points_in_block_axes[..., :2], yaw)
    return np.asarray(stood + offset.reshape(lanes.lane_count, 1, 2))


def farthest(body: Bodies) -> Array:
    """Distance of the farthest contact point from the centre of mass [m], shape [lane]."""
    return np.asarray(np.linalg.norm(body.points, axis=-1).max(axis=1))


def existing_points(body: Bodies) -> npt.NDArray[np.bool_]:
    """Which rows are points, shape [lane, point]."""
    return np.asarray(np.arange(body.most_points) < body.count[:, None])


def _standing(lanes: SpatialLanes) -> Array:
    """How many of the points that a body stands on at rest touch at the start, shape [lane]."""
    body = body_of(lanes)
    attitude = start_poses(lanes)[1]
    low = rotate(attitude[:, None], body.points_in_block_axes)[..., 2]
    touches = low - low.min(axis=1, keepdims=True) <= LEVEL * farthest(body)[:, None]
    return np.asarray(
        (touches & body.standing & existing_points(body)).sum(axis=1), dtype=np.float64
    )
