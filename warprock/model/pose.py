"""Attitudes of blocks in space, and where blocks start.

Quaternions are (x, y, z, w), as in Warp. The body axes of a block are along its width, its depth
and its height, its origin is the centre of mass; those of the base are x in the plane of rocking,
y across it and z upwards.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.turning import inverse, rotate

Array = npt.NDArray[np.float64]


def product(first: Array, second: Array) -> Array:
    """Quaternion of the turn `second` followed by the turn `first`, shape [..., 4]."""
    a, b = first[..., :3], second[..., :3]
    v, w = first[..., 3:], second[..., 3:]
    imaginary = v * b + w * a + np.cross(a, b)
    return np.concatenate([imaginary, v * w - np.sum(a * b, axis=-1, keepdims=True)], axis=-1)


def quaternion(rotation_vector: Array) -> Array:
    """Quaternion of a turn about an axis by the length of that axis [rad], shape [..., 3]."""
    half = 0.5 * np.linalg.norm(rotation_vector, axis=-1, keepdims=True)
    return np.concatenate([0.5 * np.sinc(half / np.pi) * rotation_vector, np.cos(half)], axis=-1)


FALLS = 0.5
"""Height of the top of a block's axis, as a part of its length, below which the block falls: it
leans by more than 60 degrees."""


def rotations(attitude: Array) -> tuple[Array, Array, Array]:
    """Rotation in the plane of rocking and across it, and yaw [rad], of attitudes [..., 4].

    With the block's axis (x, y, z) the rotation is atan2(x, z) and the rotation across atan2(y, z).
    These say nothing once z is zero. Of a block that falls, z < 1/2, they go over to the angles of
    an axis that lies on the ground, atan2(x, |y|) and atan2(y, |x|): 90 degrees and 0 after a fall
    along x, 0 and 90 after one across. In between they are atan2(x, sqrt(z^2 + (1 - 4 z^2)^2 y^2))
    and the same with x and y in each other's place; z < 0 counts as 0. In the plane y is zero and
    nothing changes.

    NumPy 1.26 takes another arctan2, with other last bits, for components that lie apart in memory
    where its result happens to lie right behind them: so each is put together first.
    """
    axis = rotate(attitude, np.broadcast_to((0.0, 0.0, 1.0), (*attitude.shape[:-1], 3)))
    x, y, z = np.ascontiguousarray(np.moveaxis(axis, -1, 0))
    about, real = np.ascontiguousarray(np.moveaxis(attitude[..., 2:], -1, 0))
    yaw = 2.0 * np.arctan2(about, real)
    yaw -= 2.0 * np.pi * np.round(yaw / (2.0 * np.pi))
    up = np.maximum(z, 0.0)
    part = np.maximum(1.0 - (up / FALLS) ** 2, 0.0)
    beside_x, beside_y = (
        np.where(part > 0.0, np.sqrt(up**2 + (part * side) ** 2), up) for side in (y, x)
    )
    return np.arctan2(x, beside_x), np.arctan2(y, beside_y), yaw


def bottom_corners(lanes: SpatialLanes) -> Array:
    """Corners of the bottom faces in body axes [m], shape [lane, 4, 3] or [lane, block, 4, 3]."""
    half = np.stack([0.5 * lanes.face_width, 0.5 * lanes.face_depth], axis=-1)
    signs = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    centre = np.stack([lanes.centre_offset_x, lanes.centre_offset_y], axis=-1)
    flat = half[..., None, :] * signs - centre[..., None, :]
    low = np.broadcast_to(-0.5 * lanes.height[..., None, None], (*flat.shape[:-1], 1))
    return np.concatenate([flat, low], axis=-1)


def start_corners(lanes: Lanes) -> Array:
    """Corners of single blocks that touch at the start, from the centre of mass [m].

    Along the axes of the base, shape [lane, corner, 3]; NaN where one does not touch.
    """
    if isinstance(lanes, SpatialLanes):
        position, attitude = start_poses(lanes)
        body = lanes.body
        corners = bottom_corners(lanes) if body is None else body.points_in_block_axes
        seen, height = rotate(attitude[:, None], corners), position[:, 2]
    else:
        side = np.array([-0.5, 0.5])
        s, c = np.sin(lanes.rotation_start)[:, None], np.cos(lanes.rotation_start)[:, None]
        x, z = side * lanes.face_width[:, None], -0.5 * lanes.height[:, None]
        if lanes.body is not None:
            x, z = np.moveaxis(lanes.body.centres, -1, 0)
        seen = np.stack([x * c + z * s, np.zeros_like(x), z * c - x * s], axis=-1)
        if lanes.body is not None:
            seen[..., 2] -= lanes.body.corner_radius[:, None]
        height = -seen[..., 2].min(axis=1)
    touches = seen[..., 2] + height[:, None] <= TOUCHING
    return np.where(touches[..., None], seen, np.nan)


TOUCHING = 1e-9
"""Height above the ground up to which a corner touches at the start [m]."""


def start_poses(lanes: SpatialLanes) -> tuple[Array, Array]:
    """Centres of mass [m] and attitudes at the start.

    Returns:
        Positions, shape [lane, 3], and quaternions, shape [lane, 4]; with a block axis after the
        lane's for stacks. The middle of the lowest block's flat bottom is the origin; of a body
        the place below its centre of mass, and of a block that is thrown. Attitudes are those of
        the axes of the block.
    """
    thrown = lanes.release
    if thrown is not None and thrown.attitude is not None and thrown.height is not None:
        place = np.stack([0.0 * thrown.height, 0.0 * thrown.height, thrown.height], axis=-1)
        shape = lanes.width.shape
        return place.reshape(*shape, 3), thrown.attitude.reshape(*shape, 4)
    nothing = np.zeros_like(lanes.width)
    body = lanes.body
    yaw = quaternion(np.stack([nothing, nothing, lanes.yaw_start], axis=-1))
    lean = np.stack([-lanes.rotation_across_start, lanes.rotation_start, nothing], axis=-1)
    attitude = product(yaw, quaternion(lean))
    corners = bottom_corners(lanes) if body is None else body.points_in_block_axes
    rise = 0.5 * lanes.height if body is None else body.centre_height
    if lanes.stacked and body is not None:
        corners, rise = corners[:, None], rise[:, None]
    seen = rotate(attitude[..., None, :], corners)
    lowest = np.argmin(seen[..., 2], axis=-1)[..., None, None]
    touching = np.take_along_axis(seen, lowest, axis=-2)[..., 0, :]
    centre = np.stack([lanes.centre_offset_x, lanes.centre_offset_y, rise], axis=-1)
    flat = np.take_along_axis(corners, lowest, axis=-2)[..., 0, :] + centre
    stands = np.stack([lanes.offset, lanes.offset_across, lanes.gap_start], axis=-1)
    if lanes.stacked:
        stands[..., :2] = np.cumsum(stands[..., :2], axis=1)
        stands[:, 1:, 2] += np.cumsum(lanes.height[:, :-1], axis=1)
    position = rotate(yaw, flat) + stands - touching
    if lanes.stacked and lanes.block_count > 1:
        leans = (lanes.rotation_start != 0.0) | (lanes.rotation_across_start != 0.0)
        tilted = leans.any(axis=1)
        if tilted.any():
            on_faces = _centres_on_faces(lanes, yaw, attitude)
            position = np.where(tilted[:, None, None], on_faces, position)
    return position, attitude


def _centres_on_faces(lanes: SpatialLanes, yaw: Array, attitude: Array) -> Array:
    """Centres of mass of stacks whose blocks lean [m], shape [lane, block, 3].

    A block lies flush on the face below, as it would on a level one, and is turned out of that
    about the lowest corner of what both faces share: so blocks that lean alike stand as one.
    """
    position = np.zeros((*lanes.width.shape, 3))
    centre = np.stack([lanes.centre_offset_x, lanes.centre_offset_y, 0.5 * lanes.height], axis=-1)
    offset = np.stack([lanes.offset, lanes.offset_across, 0.0 * lanes.offset], axis=-1)
    # Middle of the face below, and its tilt: the ground's.
    face, tilt = np.zeros((lanes.lane_count, 3)), quaternion(np.zeros((lanes.lane_count, 3)))
    for block in range(lanes.block_count):
        turned, flush = attitude[:, block], product(tilt, yaw[:, block])
        flat = face + rotate(tilt, offset[:, block]) + rotate(flush, centre[:, block])
        axis = rotate(turned, np.broadcast_to((0.0, 0.0, 1.0), face.shape))
        foot = _lowest_shared(lanes, block, rotate(inverse(tilt), axis)[:, :2])
        pivot = face + rotate(tilt, np.concatenate([foot, 0.0 * foot[:, :1]], axis=1))
        place = pivot + rotate(product(turned, inverse(flush)), flat - pivot)
        place[:, 2] += lanes.gap_start[:, block]
        position[:, block] = place
        tilt = product(turned, inverse(yaw[:, block]))
        face = place + rotate(turned, centre[:, block] * (-1.0, -1.0, 1.0))
    return position


INSIDE = 1e-9
"""Part of a face by which a point may lie outside and still count as on its edge."""


def _lowest_shared(lanes: SpatialLanes, block: int, downhill: Array) -> Array:
    """The corner farthest downhill of what a block's face and the one below share [m], [lane, 2].

    In the plan of the face below, from its middle, along axes that are not turned by its yaw.

    Args:
        lanes: The stacks.
        block: The block.
        downhill: Where to in that plan, shape [lane, 2].
    """
    turn = lanes.yaw_start[:, block]
    upper = 0.5 * np.stack([lanes.face_width[:, block], lanes.face_depth[:, block]], axis=-1)
    middle = np.stack([lanes.offset[:, block], lanes.offset_across[:, block]], axis=-1)
    signs = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    corners = middle[:, None] + rotate_yaw(upper[:, None] * signs, turn[:, None])
    if block == 0:
        return _farthest(corners, np.ones(corners.shape[:2], dtype=bool), downhill)
    below = lanes.yaw_start[:, block - 1]
    lower = 0.5 * np.stack([lanes.face_width, lanes.face_depth], axis=-1)[:, block - 1]
    # Ends of what the lower face leaves of the upper edges, in its own axes.
    first = rotate_yaw(corners, -below[:, None])
    run = np.roll(first, -1, axis=1) - first
    with np.errstate(divide="ignore", invalid="ignore"):
        cuts = [(side * lower[:, None] - first) / run for side in (-1.0, 1.0)]
    beside = np.abs(first) > lower[:, None] * (1.0 + INSIDE)
    still = np.abs(run) <= INSIDE * lower[:, None]
    start = np.where(still, np.where(beside, np.inf, 0.0), np.minimum(*cuts)).max(axis=-1)
    end = np.where(still, 1.0, np.maximum(*cuts)).min(axis=-1)
    start, end = np.maximum(start, 0.0), np.minimum(end, 1.0)
    ends = [first + np.where(start <= end, at, 0.0)[..., None] * run for at in (start, end)]
    # Corners of the lower face under the upper one.
    own = lower[:, None] * signs
    seen = rotate_yaw(rotate_yaw(own, below[:, None]) - middle[:, None], -turn[:, None])
    under = np.all(np.abs(seen) <= upper[:, None] * (1.0 + INSIDE), axis=-1)
    places = rotate_yaw(np.concatenate([*ends, own], axis=1), below[:, None])
    there = np.concatenate([start <= end, start <= end, under], axis=1)
    return _farthest(places, there, downhill)


def _farthest(places: Array, there: npt.NDArray[np.bool_], way: Array) -> Array:
    """That of some places [lane, place, 2] which lies farthest along a way [lane, 2]."""
    along = np.where(there, (places * way[:, None]).sum(axis=-1), -np.inf)
    return np.asarray(np.take_along_axis(places, np.argmax(along, axis=1)[:, None, None], 1)[:, 0])


def rotate_yaw(vector: Array, angle: Array) -> Array:
    """Rotates vectors [..., 2] by angles [rad], from +x to +y."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)
