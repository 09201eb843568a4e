"""Amounts of energy: what blocks on their base hold, need to overturn, and can have been given.

`soundness` judges a lane by them.

All are above the state in which every block is flat, in the frame of the base [J]. What a base has
supplied is told by the account of an engine in the plane; in space there is a bound that is known
before a run. In the frame of its base the energy E of a lane changes by the work of the base,
-a . sum(m v) with the acceleration a of the base, and by that of the contacts, which can only take.
As long as no block lies below its flat place, sum(m v^2) / 2 is at most E. With the mass M of all
blocks |d sqrt(E) / dt| <= sqrt(M / 2) |a|. So E never exceeds (sqrt(E at the start) +
sqrt(M / 2) S)^2, where S is the total variation of the base velocity. The longer the base moves,
the looser is this bound: energy that contacts give in a long record passes unseen below it.
"""

from __future__ import annotations

import dataclasses
from typing import cast

import numpy as np
import numpy.typing as npt

from warprock.engines.blocks import start_on_corners
from warprock.engines.bodies import Corners
from warprock.model import rocking
from warprock.model.bodies import Bodies
from warprock.model.lanes import Lanes, SpatialLanes, as_stacks
from warprock.model.motion import GroundMotions
from warprock.model.pose import product, start_poses
from warprock.model.stacking import centre_height, sum_above
from warprock.model.turning import inverse, rotate
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]


def energy_at_start(lanes: Lanes) -> Array:
    """Energy at the start [J], shape [lane]; negative where a stack in the plane is to fall."""
    if lanes.spatial:
        return np.maximum(spatial_energy_held(lanes), 0.0) + kinetic_energy_at_start(lanes)
    if lanes.stacked:
        return stack_energy_held(lanes)
    return energy_held(lanes, lanes.rotation_start) + kinetic_energy_at_start(lanes)


def kinetic_energy_at_start(lanes: Lanes) -> Array:
    """Kinetic energy of single blocks at the start [J], shape [lane]."""
    release = lanes.release
    if release is None:
        return np.zeros(lanes.lane_count)
    squares = np.stack([lanes.width, lanes.depth, lanes.height], axis=-1) ** 2
    inertia = (squares.sum(axis=-1, keepdims=True) - squares) / 12.0
    if release.gyration is not None:
        inertia = release.gyration
    if lanes.body is not None:
        inertia = lanes.body.gyration.reshape(lanes.lane_count, -1)
    spin = release.angular_velocity
    if lanes.spatial:
        attitude = start_poses(cast(SpatialLanes, lanes))[1]
        if lanes.body is not None:
            attitude = product(attitude, lanes.body.axes)
        spin = rotate(inverse(attitude), spin)
    moving = (release.velocity**2).sum(axis=-1) + (inertia * spin**2).sum(axis=-1)
    return np.asarray(0.5 * lanes.mass * moving)


def energy_held(lanes: Lanes, rotation: Array) -> Array:
    """Least energy above the flat state of single blocks that turned to a rotation [J], [lane].

    Beyond the slenderness angle it is what it takes to get there.
    """
    if lanes.body is not None:
        rise = Corners.of(lanes.body).rise(rotation, lanes.slenderness_angles)
        return np.asarray(GRAVITY * lanes.mass * rise)
    turned = np.minimum(np.abs(rotation), lanes.slenderness_angle)
    return rocking.energy(lanes.width, lanes.height, lanes.depth, lanes.density, turned, 0.0)


def overturning_rise(lanes: Lanes) -> Array:
    """How far the centres of blocks rise where they overturn, each by itself [m].

    Shape [lane], or [lane, block] for stacks.
    """
    if lanes.body is not None and lanes.spatial:
        height = lanes.body.centre_height
        return np.asarray(np.hypot(np.maximum(nearest_edge(lanes), 0.0), height) - height)
    if lanes.body is not None:
        return _body_rise(lanes.body, lanes.slenderness_angles)
    if lanes.profiles is not None:
        found = [_body_rise(each, each.slenderness_angles) for each in lanes.profiles.each]
        return np.stack(found, axis=1)
    return np.asarray(0.5 * (np.hypot(lanes.width, lanes.height) - lanes.height))


def _body_rise(body: Bodies, angles: Array) -> Array:
    """How far bodies in the plane rise to where they overturn, to the easier side [m], [lane]."""
    corners = Corners.of(body)
    rises = [
        corners.rise(side * each, angles) for side, each in zip((-1, 1), angles.T, strict=True)
    ]
    return np.asarray(np.min(rises, axis=0))


def stack_energy_held(lanes: Lanes) -> Array:
    """Energy at the start above the state in which all blocks of a stack are flat [J], [lane].

    Negative where the stack starts so far turned that it falls.
    """
    start, flat = (start_on_corners(each)[1] for each in (lanes, _flat(lanes)))
    return np.asarray(GRAVITY * (lanes.mass * (start - flat)).sum(axis=1))


def spatial_energy_held(lanes: Lanes) -> Array:
    """Energy at the start above the state in which all blocks are flat [J], shape [lane]."""
    stacks = cast(SpatialLanes, as_stacks(lanes))
    height = np.cumsum(stacks.height, axis=1) - 0.5 * stacks.height
    if lanes.thrown:
        height = 0.5 * np.minimum(np.minimum(stacks.width, stacks.depth), stacks.height)
    if lanes.body is not None:
        body = lanes.body
        height = (body.inner_radius if lanes.thrown else body.centre_height)[:, None]
    rise = start_poses(stacks)[0][..., 2] - height
    return np.asarray(GRAVITY * (stacks.mass * rise).sum(axis=1))


def least_barrier(lanes: Lanes) -> tuple[Array, Array]:
    """What it takes to turn the blocks of a stack about an end of a face, from some block up.

    Returns:
        The least energy [J], shape [lane], and the sines of the rotations there, about the end at
        -x and the one at +x, shape [2, lane, block].
    """
    x, z, left, right = start_on_corners(_flat(lanes))
    mass = lanes.mass
    # What stands on each interface, and its centre above it: sums from the top down.
    above, levers, heights = (sum_above(mass * each) for each in (np.ones_like(x), x, z))
    centre, rise = levers / above, heights / above - (z - centre_height(lanes))
    arms = np.maximum(np.stack([centre - left, right - centre]), 0.0)
    reach = np.hypot(arms, rise)
    return (GRAVITY * above * (reach - rise)).min(axis=(0, 2)), arms / reach


def most_energy(lanes: Lanes, held: Array, motions: GroundMotions, duration: float) -> Array:
    """The most energy above the flat state that a lane can have until a time [J], shape [lane].

    Args:
        lanes: The lanes.
        held: Their energy at the start [J], shape [lane].
        motions: Their ground motions.
        duration: The time [s].
    """
    mass = lanes.mass.reshape(lanes.lane_count, -1).sum(axis=1)
    variation = sum(part.velocity_variation(duration) for part in motions.components)
    return np.asarray((np.sqrt(held) + np.sqrt(0.5 * mass) * variation) ** 2)


def energy_to_tilt(lanes: Lanes, tilt: Array) -> Array:
    """Least energy above the flat state of single blocks whose axes lean by an angle [J], [lane].

    That is a turn about the nearest edge of the face; beyond where it overturns, what that takes.
    What starts beyond that falls, and needs no more than it has there.
    """
    axis = start_poses(cast(SpatialLanes, lanes))[1]
    start = np.arccos(np.clip(1.0 - 2.0 * (axis[:, 0] ** 2 + axis[:, 1] ** 2), -1.0, 1.0))
    if lanes.body is not None:
        return energy_to_tilt_bodies(lanes.body, tilt, start)
    arm, half = nearest_edge(lanes), 0.5 * lanes.height
    turned = np.maximum(np.minimum(np.abs(tilt), np.arctan2(arm, half)), start)
    rise = arm * np.sin(turned) + half * (np.cos(turned) - 1.0)
    return np.asarray(GRAVITY * lanes.mass * rise)


def nearest_edge(lanes: Lanes) -> Array:
    """Distance of the nearest edge of the bottom face from the centre of mass [m], [lane]."""
    if lanes.body is not None:
        return nearest_edge_of_bodies(lanes.body)
    blocks = cast(SpatialLanes, lanes)
    along = 0.5 * blocks.face_width - np.abs(blocks.centre_offset_x)
    across = 0.5 * blocks.face_depth - np.abs(blocks.centre_offset_y)
    return np.asarray(np.minimum(along, across))


TILTS, DIRECTIONS = 12, 96
"""Tilts, and directions of them, at which the height of a centre of mass is looked up."""


def energy_to_tilt_bodies(body: Bodies, tilt: Array, start: Array) -> Array:
    """Least energy above the flat state of bodies whose axes lean by an angle [J], shape [lane].

    On its way there from the start the axis passes all tilts between. At each of them the lowest
    point of the body says how high its centre of mass is at least, in the direction in which that
    is least.
    """
    points, rest = body.points_in_block_axes, body.centre_height
    lean, needed = np.minimum(np.abs(tilt), 0.5 * np.pi), np.zeros_like(rest)
    along = _along(points)
    for part in np.arange(1, TILTS + 1) / TILTS:
        turned = start + part * (np.maximum(lean, start) - start)
        up = np.cos(turned)[:, None] * points[..., 2]
        aside, lowest = np.sin(turned)[:, None], np.full_like(along[:, 0], np.inf)
        # One point after the other: all at once would not fit into the cache.
        for point in range(body.most_points):
            np.minimum(lowest, up[:, point, None] - aside * along[:, point], out=lowest)
        needed = np.maximum(needed, -lowest.max(axis=1) - rest)
    # Between two directions the height is less than at both by no more than this.
    far = np.linalg.norm(points, axis=-1).max(axis=1)
    missed = far * np.sin(lean) * np.pi / DIRECTIONS
    return np.asarray(GRAVITY * body.mass * np.maximum(needed - missed, 0.0))


def nearest_edge_of_bodies(body: Bodies) -> Array:
    """Distance of the nearest edge of the base from below the centre of mass [m], shape [lane].

    Zero or less where the centre of mass is not above what the body stands on.
    """
    along = _along(body.points_in_block_axes)
    ends = np.full_like(along[:, 0], -np.inf)
    for point in range(body.most_points):
        np.maximum(ends, along[:, point], out=ends, where=body.standing[:, point, None])
    return np.asarray(ends.min(axis=1))


def _along(points: Array) -> Array:
    """Points [lane, point, 3] along `DIRECTIONS` of the ground [m], [lane, point, direction]."""
    angle = np.arange(DIRECTIONS) * (2.0 * np.pi / DIRECTIONS)
    return np.asarray(points[..., :2] @ np.stack([np.cos(angle), np.sin(angle)]))


def _flat(lanes: Lanes) -> Lanes:
    """The same stacks with no block turned."""
    return dataclasses.replace(lanes, rotation_start=np.zeros_like(lanes.rotation_start))
