"""Where the blocks of a lane are at the samples of its histories, seen from the base.

Kernels whose blocks slide tell where their centres of mass are. Of blocks that do not slide the
rotations tell it. The slide follows from the place and the rotation, by the law that the kernels
observe it by: in the plane `place_on` of kernels/shape/interface.py, in space `slide_of` of
kernels/shape_space/block.py.
"""

from __future__ import annotations

from typing import cast

import numpy as np
import numpy.typing as npt

from warprock.engines.blocks import spatial_columns
from warprock.engines.bodies import Corners, rotate_lever
from warprock.engines.spatial_bodies import body_of, existing_points, standing_places
from warprock.engines.stack_bodies import profile_slides
from warprock.model.lanes import Lanes, SpatialLanes, as_stacks
from warprock.model.pose import rotate_yaw
from warprock.model.turning import inverse, rotate

Array = npt.NDArray[np.float64]

ENDLESS = 1e9
"""Half width of the ground [m]."""
TOUCH = 1e-4
"""Height above the lowest corner, over the half width, up to which a corner counts as touching."""


def planar_places(lanes: Lanes, rotation: Array, places: Array | None) -> dict[str, Array]:
    """Histories of the places and the slides of blocks in the plane.

    Args:
        lanes: The lanes.
        rotation: Rotations [rad], shape [lane, block, sample].
        places: Centres x and z [m], shape [lane, block, sample, 2]; None of blocks that do not
            slide.

    Returns:
        By field, shape [lane, block, sample] each.
    """
    stacks = as_stacks(lanes)
    if places is None and lanes.body is not None:
        x, z = (each[:, None] for each in lanes.body.roll_centres(rotation[:, 0]))
        return {"slide": np.zeros_like(rotation), "x": x, "z": z}
    if places is None and lanes.hold is not None and lanes.hold.strip is not None:
        lower = lanes.hold.strip.places(rotation[:, 0])[:, :1]
        return {"slide": np.zeros_like(rotation), "x": lower[..., 0], "z": lower[..., 1]}
    if places is None:
        x, z = _pivot(stacks, rotation)
        return {"slide": np.zeros_like(rotation), "x": x, "z": z}
    x, z = places[..., 0], places[..., 1]
    if lanes.body is not None:
        slide = Corners.of(lanes.body).slide(rotation[:, 0], x[:, 0])
        return {"slide": slide[:, None], "x": x, "z": z}
    slides = _planar_slides if lanes.profiles is None else profile_slides
    return {"slide": slides(stacks, rotation, x, z), "x": x, "z": z}


def _pivot(stacks: Lanes, rotation: Array) -> tuple[Array, Array]:
    """Centres of blocks that turn about the ends of what their faces share, and never slide."""
    x, z = np.zeros_like(rotation), np.zeros_like(rotation)
    at_x, at_z, below, below_height = np.zeros((4, *rotation[:, 0].shape))
    half_face, half_height = 0.5 * stacks.face_width, 0.5 * stacks.height
    lower_face = np.full(stacks.lane_count, np.inf)
    for k in range(stacks.block_count):
        turn, height = rotation[:, k], half_height[:, k, None]
        shared = np.minimum(lower_face, half_face[:, k])[:, None]
        end = np.where(turn < below, -shared, shared)
        foot_x, foot_z = rotate_lever(end, below_height, below)
        arm_x, arm_z = rotate_lever(-end, height, turn)
        at_x, at_z = at_x + foot_x + arm_x, at_z + foot_z + arm_z
        x[:, k], z[:, k] = at_x, at_z
        below, below_height, lower_face = turn, height, half_face[:, k]
    return x, z


def _planar_slides(stacks: Lanes, rotation: Array, x: Array, z: Array) -> Array:
    """Slides along what the blocks stand on, of the lower corner or of the one below it."""
    slides = np.zeros_like(rotation)
    below_x, below_z, below, low_height = np.zeros((4, *rotation[:, 0].shape))
    low_face = np.full((stacks.lane_count, 1), ENDLESS)
    half_face, half_height = 0.5 * stacks.face_width[..., None], 0.5 * stacks.height[..., None]
    for k in range(stacks.block_count):
        turn = rotation[:, k] - below
        lean = np.where(turn < 0.0, -1.0, 1.0)
        face, height = half_face[:, k], half_height[:, k]
        # The middle of the bottom face, seen from the middle of the face below, along that.
        foot_x, foot_z = rotate_lever(np.zeros_like(turn), -height, rotation[:, k])
        from_x, from_z = x[:, k] + foot_x - below_x, z[:, k] + foot_z - below_z
        along, _above = rotate_lever(from_x, from_z, -below)
        corner = along + lean * face * np.cos(turn)
        # The end of the face below, seen from the middle of the block, along its bottom.
        end_x, end_z = rotate_lever(lean * low_face, low_height, below)
        under, _deep = rotate_lever(
            end_x + below_x - x[:, k], end_z + below_z - z[:, k], -rotation[:, k]
        )
        inside = lean * corner <= low_face
        place = np.where(inside, corner - lean * face, lean * low_face - under)
        slides[:, k] = place - stacks.offset[:, k, None]
        below_x, below_z, below = x[:, k], z[:, k], rotation[:, k]
        low_face, low_height = face, height
    return slides


def spatial_places(lanes: Lanes, attitude: Array, places: Array) -> dict[str, Array]:
    """Histories of the places, the attitudes and the slides of blocks in space.

    Args:
        lanes: The lanes.
        attitude: Quaternions, shape [lane, block, sample, 4].
        places: Centres of mass [m], shape [lane, block, sample, 3].

    Returns:
        By field, shape [lane, block, sample] each; x, y and z are those of the middle of the box,
        of a body of its centre of mass.
    """
    stacks = cast(SpatialLanes, as_stacks(lanes))
    zero = np.zeros_like(stacks.width)
    beside = np.stack([stacks.centre_offset_x, stacks.centre_offset_y, zero], axis=-1)
    middle = places - rotate(attitude, np.broadcast_to(beside[:, :, None], places.shape))
    if lanes.thrown:
        # Of a block that tumbles, the way of its centre.
        slide = places[..., :2]
    else:
        slide = (_body_slides if lanes.bodies else _spatial_slides)(stacks, attitude, places)
    found = {"slide": slide[..., 0], "slide_across": slide[..., 1]}
    found |= {name: middle[..., axis] for axis, name in enumerate("xyz")}
    return found | {f"attitude_{name}": attitude[..., k] for k, name in enumerate("xyzw")}


def _spatial_slides(stacks: SpatialLanes, attitude: Array, places: Array) -> Array:
    """Slides along what the blocks stand on, mean of the corners that touch, [..., 2].

    Along the axes of what they stand on, turned by its yaw at the start.
    """
    columns = {name: part[..., None, None] for name, part in spatial_columns(stacks).items()}
    signs = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    slides = np.zeros((*places.shape[:-1], 2))
    still = np.zeros_like(attitude[:, 0])
    still[..., 3] = 1.0
    below, below_place, below_yaw = still, np.zeros_like(places[:, 0]), np.zeros(stacks.lane_count)
    for k in range(stacks.block_count):
        own = {name: part[:, k] for name, part in columns.items()}
        x, y = signs[:, 0] * own["half_width"], signs[:, 1] * own["half_depth"]
        low = np.broadcast_to(-own["half_height"], x.shape)
        corners = np.stack([x - own["centre_x"], y - own["centre_y"], low], axis=-1)
        frames = (*places[:, k].shape[:-1], 4, 3)
        arms = rotate(attitude[:, k, :, None], np.broadcast_to(corners, frames))
        back = inverse(below)
        seen = rotate(back[:, :, None], arms + (places[:, k] - below_place)[:, :, None])
        lowest = seen[..., 2].min(axis=-1, keepdims=True)
        touches = seen[..., 2] <= lowest + TOUCH * own["half_width"]
        stood_x = own["flat_x"] + own["flat_c"] * x - own["flat_s"] * y
        stood_y = own["flat_y"] + own["flat_s"] * x + own["flat_c"] * y
        way = seen[..., :2] - np.stack([stood_x, stood_y], axis=-1)
        mean = np.where(touches[..., None], way, 0.0).sum(axis=-2) / touches.sum(axis=-1)[..., None]
        slides[:, k] = rotate_yaw(mean, below_yaw[:, None])
        below, below_place, below_yaw = attitude[:, k], places[:, k], stacks.yaw_start[:, k]
    return slides


def _body_slides(stacks: SpatialLanes, attitude: Array, places: Array) -> Array:
    """Slides of bodies [m], mean of the points that touch, shape [lane, 1, sample, 2]."""
    body = body_of(stacks)
    points, stood = body.points_in_block_axes, standing_places(stacks)
    seen = rotate(attitude[:, 0, :, None], points[:, None]) + places[:, 0, :, None]
    there = existing_points(body)[:, None]
    height = np.where(there, seen[..., 2], np.inf)
    lowest = height.min(axis=-1, keepdims=True)
    touches = there & (height <= lowest + TOUCH * 0.5 * stacks.width[..., None])
    way = np.where(touches[..., None], seen[..., :2] - stood[:, None], 0.0).sum(axis=-2)
    return np.asarray((way / touches.sum(axis=-1)[..., None])[:, None])
