"""The blocks of a stack from the values of a case, lane by lane, and their input columns."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.case.values import LaneValues
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.stacking import contact_ends, uplift_ratio

Array = npt.NDArray[np.float64]

_COLUMNS = {
    "width": ("m", 1.0),
    "height": ("m", 1.0),
    "depth": ("m", 1.0),
    "density": ("kg_m3", 1.0),
    "chamfer": ("mm", 1e3),
    "offset": ("mm", 1e3),
}
"""Attribute of `Lanes` -> unit of its column and factor from SI."""


def stack_lanes(values: LaneValues) -> Lanes:
    """Stacks and their starts.

    Raises:
        InputError: A block that no face is left of, or one beside the block below.
    """
    count = values.case.tables.block_count
    numbers = {
        name: np.stack([values.numbers(f"block.{k}.{name}") for k in range(1, count + 1)], axis=1)
        for name in (*_COLUMNS, "rotation")
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
        number = block + 1
        for name, (unit, factor) in _COLUMNS.items():
            written = getattr(lanes, name)[:, block] * factor
            # Written in mm, so 5 mm shall read 5 and not 5.000000000000001.
            columns[f"{name}_{number}_{unit}"] = np.round(written, 12) if factor != 1.0 else written
        columns[f"friction_{number}"] = lanes.friction[:, block]
        columns[f"slenderness_angle_{number}_rad"] = lanes.slenderness_angle[:, block]
        columns[f"rotation_start_{number}_rad"] = lanes.rotation_start[:, block]
    columns["uplift_ratio"] = uplift_ratio(lanes).min(axis=1)
    return columns
