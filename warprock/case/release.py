"""Velocities and attitudes that a case gives single blocks at their start, lane by lane."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, cast

import numpy as np
import numpy.typing as npt

from warprock.case.input_columns import key_column
from warprock.case.space import optional
from warprock.case.start import ATTITUDE, AXES
from warprock.errors import NOTHING, InputError
from warprock.model.bodies import boxes_on_corners
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.pose import start_corners
from warprock.model.release import Release, rolling
from warprock.model.turning import inverse, rotate

if TYPE_CHECKING:
    from warprock.case.values import LaneValues

Array = npt.NDArray[np.float64]

VELOCITY = tuple(f"start.velocity_{axis}" for axis in AXES)
SPIN = tuple(f"start.angular_velocity_{axis}" for axis in AXES)
PARTS = tuple(f"start.attitude_{part}" for part in ATTITUDE)
HEIGHT = "start.height"

UNIT = 1e-3
"""By how much the length of a quaternion may differ from 1: what three digits leave."""
SUNK = 1e-9
"""Part of a block's size by which its lowest corner may start below the ground: round-off."""


def release_blocks(values: LaneValues, lanes: Lanes) -> Lanes:
    """Single blocks as the case lets them go: from rest on their bottom, or as it says.

    A body that the case describes by the eight corners of a box is thrown as that box. A box with
    its centre of mass beside its middle is thrown as a body. Other bodies can be thrown if their
    points surround their centre of mass; the points of a base alone leave nothing to fall on.

    Args:
        values: Values of the case.
        lanes: Its blocks.

    Raises:
        InputError: A part of an attitude is missing, it is no unit quaternion, a block would start
            in the ground, or is a body that cannot be thrown.
    """
    given = [key for key in (*VELOCITY, *SPIN, *PARTS, HEIGHT) if values.given(key)]
    if not given:
        return lanes
    # Frequencies are in Hz.
    spin = 2.0 * np.pi * np.stack([optional(values, key) for key in SPIN], axis=-1)
    velocity = np.stack([optional(values, key) for key in VELOCITY], axis=-1)
    if {*PARTS, HEIGHT}.intersection(given):
        attitude = _attitude(values)
        blocks = _that_tumble(values, lanes)
        height = _height(values, blocks, attitude)
        boxed = lanes.body is not None and blocks.body is None
        gyration = lanes.body.gyration if lanes.body is not None and boxed else None
        thrown = Release(velocity, spin, attitude, height, gyration)
        return dataclasses.replace(blocks, release=thrown)
    if not any(values.given(key) for key in VELOCITY):
        velocity = rolling(start_corners(lanes), spin)
    return dataclasses.replace(lanes, release=Release(velocity, spin))


def _that_tumble(values: LaneValues, lanes: Lanes) -> Lanes:
    """Blocks that are thrown: boxes about their centre, and bodies with points all round."""
    blocks, body = cast(SpatialLanes, lanes), lanes.body
    if body is None:
        # Of a sweep all lanes are bodies, or none, however they are run in parts.
        aside = any(values.given(f"block.centre_offset_{axis}") for axis in "xy")
        return _beside_their_middle(blocks) if aside else lanes
    if not body.boxed:
        allowed = (
            "must be left out: the points of block.base do not surround the centre of mass, so "
            "that in some attitudes it has none to land on (start.rotation and start.gap tilt it)"
        )
        values.refuse(body.inner_radius <= 0.0, PARTS[-1], allowed)
        return lanes
    width, depth, height = np.ptp(body.points, axis=1).T
    sizes = {"width": width, "depth": depth, "height": height}
    return dataclasses.replace(
        lanes, body=None, density=body.mass / (width * depth * height), **sizes
    )


def _beside_their_middle(lanes: SpatialLanes) -> Lanes:
    """Boxes whose centres of mass lie beside their middles, as bodies."""
    nothing = np.zeros_like(lanes.width)
    centre = np.stack([lanes.centre_offset_x, lanes.centre_offset_y, nothing], axis=-1)
    sizes = np.stack([lanes.width, lanes.depth, lanes.height], axis=-1)
    body = boxes_on_corners(sizes=sizes, mass=lanes.mass, centre=centre)
    return dataclasses.replace(lanes, body=body, centre_offset_x=nothing, centre_offset_y=nothing)


def _attitude(values: LaneValues) -> Array:
    """Quaternions (x, y, z, w), of length 1, shape [lane, 4]."""
    for key in PARTS:
        if not values.given(key):
            source = values.case.source_of(HEIGHT)
            allowed = "must be given: a thrown block has all four parts of its attitude"
            raise InputError(source, key, NOTHING, allowed)
    found = np.stack([values.numbers(key) for key in PARTS], axis=-1)
    length = np.linalg.norm(found, axis=-1)
    off = np.abs(length - 1.0) > UNIT
    said = f"must make a quaternion of length 1 (this one has {length[int(np.argmax(off))]:.4g})"
    values.refuse(off, PARTS[-1], said)
    return np.asarray(found / length[:, None])


def _height(values: LaneValues, lanes: Lanes, attitude: Array) -> Array:
    """Heights of the centres of thrown blocks [m]; without one the lowest corner touches."""
    half = 0.5 * np.stack([lanes.width, lanes.depth, lanes.height], axis=-1)
    back = inverse(attitude)
    up = rotate(back, np.broadcast_to((0.0, 0.0, 1.0), half.shape))
    reach = np.sum(np.abs(up) * half, axis=-1)
    if lanes.body is not None:
        reach = -np.einsum("li,lpi->lp", up, lanes.body.points_in_block_axes).min(axis=1)
    if not values.given(HEIGHT):
        return np.asarray(reach)
    height = values.numbers(HEIGHT)
    low = height < reach - SUNK * half.max(axis=-1)
    least = reach[int(np.argmax(low))]
    values.refuse(low, HEIGHT, f"must be at least {least:.6g} m, so that no corner is underground")
    return np.asarray(np.maximum(height, reach))


def release_columns(values: LaneValues) -> dict[str, object]:
    """Input columns of what the blocks start with: those of the keys that are given."""
    columns: dict[str, object] = {}
    for key in (*VELOCITY, *SPIN, *PARTS, HEIGHT):
        if values.given(key):
            columns |= key_column(key, values.numbers(key))
    return columns
