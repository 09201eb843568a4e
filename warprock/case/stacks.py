"""The blocks of a stack from the values of a case, lane by lane, and their input columns."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.case.columns import computed, key_column
from warprock.case.values import LaneValues
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.stacking import contact_ends, uplift_ratio

Array = npt.NDArray[np.float64]

_OF_A_BLOCK = ("width", "height", "depth", "density", "chamfer", "offset")
"""Keys of a block that are attributes of `Lanes`, in the order of their columns."""


def stack_lanes(values: LaneValues) -> Lanes:
    """Stacks and their starts.

    Raises:
        InputError: A block that no face is left of, or one beside the block below.
    """
    count = values.case.tables.block_count
    numbers = {
        name: np.stack([values.numbers(f"block.{k}.{name}") for k in range(1, count + 1)], axis=1)
        for name in (*_OF_A_BLOCK, "rotation")
    }
    friction = [
        values.numbers(key if values.given(key) else "contact.friction")
        for key in (f"block.{k}.friction" for k in range(1, count + 1))
    ]
    width, height = numbers["width"], numbers["height"]
    lanes = Lanes(
        width=width,
        height=height,
        depth=numbers["depth"],
        density=numbers["density"],
        friction=np.stack(friction, axis=1),
        chamfer=numbers["chamfer"],
        offset=numbers["offset"],
        rotation_start=numbers["rotation"],
        # Of the lowest block alone; no engine of stacks follows it.
        angular_restitution=rocking.angular_restitution(np.arctan2(width[:, 0], height[:, 0])),
    )
    _refuse(values, lanes)
    return lanes


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


def stack_columns(lanes: Lanes) -> dict[str, object]:
    """Input columns of stacks: of every block in turn, lowest first, its number in the name."""
    columns: dict[str, object] = {}
    for block in range(lanes.block_count):
        number = f"_{block + 1}"
        for name in (*_OF_A_BLOCK, "friction"):
            columns |= key_column(f"block.N.{name}", getattr(lanes, name)[:, block], number)
        columns |= computed("slenderness_angle", lanes.slenderness_angle[:, block], number)
        columns |= key_column("block.N.rotation", lanes.rotation_start[:, block], number)
    return columns | computed("uplift_ratio", uplift_ratio(lanes).min(axis=1))
