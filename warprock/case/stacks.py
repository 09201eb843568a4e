"""The blocks of a stack from the values of a case, lane by lane, and their input columns."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.case.body_stacks import (
    profiles_of,
    stacked_bodies,
    stacked_body_columns,
    stacked_body_sizes,
)
from warprock.case.input_columns import attribute, computed, lane_columns
from warprock.case.values import LaneValues
from warprock.model import rocking
from warprock.model.bodies import Bodies
from warprock.model.lanes import Lanes
from warprock.model.stacking import contact_ends, uplift_ratio

Array = npt.NDArray[np.float64]

_KEYS = tuple(
    f"block.N.{name}"
    for name in ("width", "height", "depth", "density", "chamfer", "offset", "friction")
)
"""Keys of a block in the order of their columns; its slenderness and its rotation follow."""


def stack_lanes(values: LaneValues, *, in_space: bool) -> Lanes:
    """Stacks and their starts.

    Raises:
        InputError: A block that no face is left of, one beside the block below, or a body in space.
    """
    numbers = range(1, values.case.tables.block_count + 1)
    friction = [
        values.numbers(key if values.given(key) else "contact.friction")
        for key in (f"block.{number}.friction" for number in numbers)
    ]
    bodies = stacked_bodies(values, in_space=in_space)
    blocks = [_sizes(values, number, bodies) for number in numbers]
    found: dict[str, Any] = {
        name: np.stack([block[name] for block in blocks], axis=1) for name in blocks[0]
    }
    width, height = found["width"][:, 0], found["height"][:, 0]
    lanes = Lanes(
        **found,
        friction=np.stack(friction, axis=1),
        # Of the lowest block alone; no engine of stacks follows it.
        angular_restitution=rocking.angular_restitution(np.arctan2(width, height)),
    )
    if bodies:
        lanes = dataclasses.replace(lanes, profiles=profiles_of(values, lanes, bodies))
    _refuse(values, lanes)
    return lanes


def _sizes(values: LaneValues, number: int, bodies: Mapping[int, Bodies]) -> dict[str, Array]:
    """What a block has as a box, or the box around it, and where it starts; by attribute."""
    keys = {attribute(key): f"block.{number}.{key[8:]}" for key in (*_KEYS, "block.N.rotation")}
    del keys["friction"]
    if number not in bodies:
        return {name: values.numbers(key) for name, key in keys.items()}
    found = stacked_body_sizes(values, number, bodies[number])
    found["chamfer"] = np.zeros_like(found["width"])
    return found | {name: values.numbers(key) for name, key in keys.items() if name not in found}


def _refuse(values: LaneValues, lanes: Lanes) -> None:
    """Refuses blocks that cannot stand on one another."""
    allowed = "must be 0: the base is as wide as it needs to be, so block 1 is centred anywhere"
    values.refuse(lanes.offset[:, 0] != 0.0, "block.1.offset", allowed)
    low, high = contact_ends(lanes)
    for block in range(lanes.block_count):
        key = f"block.{block + 1}"
        allowed = f"must be less than half of {key}.width, so that a face is left"
        values.refuse(lanes.face_width[:, block] <= 0.0, f"{key}.chamfer", allowed)
        allowed = f"must leave {key} on the face of the block below"
        values.refuse(high[:, block] <= low[:, block], f"{key}.offset", allowed)


def stack_columns(values: LaneValues, lanes: Lanes) -> dict[str, object]:
    """Input columns of stacks: of every block in turn, lowest first, its number in the name."""
    columns: dict[str, object] = {}
    for block in range(lanes.block_count):
        angle = lanes.slenderness_angle[:, block]
        if lanes.profiles is not None and lanes.profiles.is_body[block]:
            columns |= stacked_body_columns(values, lanes, block)
            continue
        columns |= lane_columns(_KEYS, lanes, block)
        columns |= computed("slenderness_angle", angle, f"_{block + 1}")
        columns |= lane_columns(["block.N.rotation"], lanes, block)
    return columns | computed("uplift_ratio", uplift_ratio(lanes).min(axis=1))
