"""Blocks in space from the values of a case: what asks for space, starts, and input columns."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.case.assembly import SPATIAL_PATTERNS
from warprock.case.block import Block, StackedBlock
from warprock.case.body_lanes import DIRECTION, body_of
from warprock.case.body_stacks import stacked_tables
from warprock.case.case_file import PLANAR, SPATIAL
from warprock.case.input_columns import attribute, computed, lane_columns
from warprock.case.start import Start
from warprock.case.values import LaneValues
from warprock.errors import InputError
from warprock.model.lanes import Lanes, SpatialLanes

Array = npt.NDArray[np.float64]

_REASONS = {
    **Start.needs_space(),
    **Block.needs_space(),
    "motion.y": "moves its base across the plane of rocking",
}
"""Key that only a spatial model has a use for -> what the case then does."""

UPWARDS = "motion.z"
"""Table that moves the base upwards, which planar blocks follow where a case asks for it."""

_KEYS = (
    *("start.yaw", "block.centre_offset_x", "block.centre_offset_y"),
    *("start.rotation_across", "start.gap"),
)
_KEYS_OF_A_STACK = tuple(
    f"block.N.{name}" for name in ("yaw", "centre_offset_x", "centre_offset_y", "offset_across")
)
"""Keys that the plane does not know, in the order of their columns."""


def spatial_because(values: LaneValues) -> str:
    """What makes the case one of blocks in space; empty where the plane of rocking is enough.

    A base that moves along x, or along x and upwards, under blocks that are symmetric about the
    plane of rocking leaves them in it. Where it moves upwards a box runs in space all the same,
    unless the case asks for the plane: all engines of space follow that.

    Raises:
        InputError: The case asks for a planar model and for something that needs space.
    """
    tables = values.case.tables
    reasons = dict(_REASONS)
    if tables.assembly is not None and tables.assembly.pattern in SPATIAL_PATTERNS:
        reasons = {"assembly.pattern": "lays its blocks in space"} | reasons
    body = body_of(values)
    if tables.model != PLANAR and body is None:
        reasons[DIRECTION] = "moves its base at an angle to the plane of rocking"
    if tables.model != PLANAR and body is not None and body.spatial:
        reasons["block.base"] = "has a body in space"
    if tables.model != PLANAR:
        bodies = (n for n, table in stacked_tables(values).items() if table.spatial)
        reasons |= {f"block.{number}.base": "has a body in space" for number in bodies}
    # A profile has no other space than its plane.
    profiles = stacked_tables(values) if body is None else not body.spatial
    if tables.model != PLANAR and not profiles:
        reasons[UPWARDS] = f'moves its base upwards without model = "{PLANAR}"'
    for block in range(1, tables.block_count + 1):
        reasons |= StackedBlock.needs_space(f"block.{block}")
    given = [key for key in reasons if values.given(key)]
    if tables.model == PLANAR and given:
        source = values.case.source_of("model")
        allowed = f"must be {SPATIAL}, or left out: {given[0]} needs it"
        raise InputError(source, "model", PLANAR, allowed)
    if given:
        return f"{reasons[given[0]]} ({given[0]})"
    return f'asks for model = "{SPATIAL}"' if tables.model == SPATIAL else ""


def spatial_lanes(values: LaneValues, planar: Lanes) -> SpatialLanes:
    """Blocks in space: what the plane knows of them, and what it does not.

    Raises:
        InputError: A start or an offset that leaves a block beside what it stands on.
    """
    parts: dict[str, Any] = {f.name: getattr(planar, f.name) for f in dataclasses.fields(planar)}
    more = _of_stacks(values, planar) if planar.stacked else _of_blocks(values, planar)
    parts |= more
    lanes = SpatialLanes(**parts)
    _refuse(values, lanes)
    return lanes


def optional(values: LaneValues, key: str) -> Array:
    """Values of a key that may be left out, zero there, shape [lane]."""
    return values.numbers(key) if values.given(key) else np.zeros(len(values.lanes))


def _of_blocks(values: LaneValues, planar: Lanes) -> dict[str, Array]:
    found = {attribute(key): optional(values, key) for key in _KEYS}
    return found | {"offset_across": np.zeros_like(planar.width)}


def _of_stacks(values: LaneValues, planar: Lanes) -> dict[str, Array]:
    numbers = [str(number) for number in range(1, planar.block_count + 1)]
    found = {
        attribute(key): np.stack([optional(values, key.replace("N", n)) for n in numbers], axis=1)
        for key in _KEYS_OF_A_STACK
    }
    return found | dict.fromkeys(
        ("rotation_across_start", "gap_start"), np.zeros_like(planar.width)
    )


def _refuse(values: LaneValues, lanes: SpatialLanes) -> None:
    """Refuses blocks that do not start above what they stand on."""
    if lanes.body is not None:
        return _refuse_fallen_bodies(values, lanes)
    for block in range(lanes.block_count):
        table = f"block.{block + 1}" if lanes.stacked else "block"
        one = _block(lanes, block)
        for axis, face in (("x", one.face_width), ("y", one.face_depth)):
            offset = getattr(one, f"centre_offset_{axis}")
            allowed = "must be less than half of the face that the block stands on"
            key = f"{table}.centre_offset_{axis}"
            values.refuse(np.abs(offset) >= 0.5 * face, key, allowed)
        if lanes.stacked:
            _refuse_in_stack(values, lanes, block, table)
    if not lanes.stacked:
        _refuse_fallen(values, lanes)


def _refuse_fallen(values: LaneValues, lanes: SpatialLanes) -> None:
    """Refuses blocks whose centre of mass is at the start beyond the edge that they lean over."""
    for key, start, face, offset, name in (
        ("rotation", lanes.rotation_start, lanes.face_width, lanes.centre_offset_x, ""),
        ("rotation_across", lanes.rotation_across_start, lanes.face_depth,
         lanes.centre_offset_y, " across"),
    ):  # fmt: skip
        angle = np.arctan2(face - 2.0 * np.sign(start) * offset, lanes.height)
        beyond = np.abs(start) >= angle
        limit = np.rad2deg(angle[int(np.argmax(beyond))])
        allowed = f"must be less than the block's slenderness angle{name}, {limit:.6g} deg"
        values.refuse(beyond & (start != 0.0), f"start.{key}", allowed)


def _refuse_fallen_bodies(values: LaneValues, lanes: SpatialLanes) -> None:
    """Refuses bodies whose centre of mass is at the start beyond the edge that they lean over."""
    body = lanes.body
    assert body is not None
    for key, start, sides in (
        ("rotation", lanes.rotation_start, body.slenderness_angles),
        ("rotation_across", lanes.rotation_across_start, body.slenderness_angles_across),
    ):
        angle = np.where(start < 0.0, sides[:, 0], sides[:, 1])
        beyond = np.abs(start) >= angle
        limit = np.rad2deg(angle[int(np.argmax(beyond))])
        allowed = f"must be less than the slenderness angle of that side, {limit:.6g} deg"
        values.refuse(beyond & (start != 0.0), f"start.{key}", allowed)


def _refuse_in_stack(values: LaneValues, lanes: SpatialLanes, block: int, table: str) -> None:
    depth = lanes.face_depth
    allowed = "must be less than half of the block's depth, so that a face is left"
    values.refuse(depth[:, block] <= 0.0, f"{table}.chamfer", allowed)
    key, across = f"{table}.offset_across", np.abs(lanes.offset_across[:, block])
    if block == 0:
        values.refuse(across > 0.0, key, "must be 0: the base is as deep as it needs to be")
    else:
        allowed = f"must leave {table} on the face of the block below"
        values.refuse(across >= 0.5 * (depth[:, block] + depth[:, block - 1]), key, allowed)


def _block(lanes: SpatialLanes, block: int) -> SpatialLanes:
    """One block of stacks as single blocks; single blocks as they are."""
    if not lanes.stacked:
        return lanes
    flat: dict[str, Any] = {k: v[:, block] if v.ndim == 2 else v for k, v in lanes.arrays.items()}
    return dataclasses.replace(lanes, **flat)


def spatial_columns(lanes: SpatialLanes) -> dict[str, object]:
    """Input columns of what the plane does not know; of a stack with the block's number."""
    if not lanes.stacked:
        columns: dict[str, object] = {
            **computed("slenderness_angle_across", lanes.slenderness_angle_across)
        }
        return columns | lane_columns(_KEYS, lanes)
    columns = {}
    for block in range(lanes.block_count):
        angle = lanes.slenderness_angle_across[:, block]
        columns |= computed("slenderness_angle_across", angle, f"_{block + 1}")
        columns |= lane_columns(_KEYS_OF_A_STACK, lanes, block)
    return columns
