"""What holds single blocks, from the values of a case, lane by lane, and its input columns."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.case.hold import BY_FORMULA, Tie, TransverseWall
from warprock.case.input_columns import key_column
from warprock.errors import InputError
from warprock.model.hold import SIDES, Hold, Ties, three_impacts
from warprock.model.lanes import Lanes
from warprock.quantity import NumberKey, Said

if TYPE_CHECKING:
    from warprock.case.values import LaneValues

Array = npt.NDArray[np.float64]

WALL, TIE = TransverseWall.place, Tie.place.partition(".")[0]


def held(values: LaneValues, lanes: Lanes) -> tuple[Lanes, dict[str, object]]:
    """Single blocks with what the case holds them by, and its input columns.

    Args:
        values: Values of the case.
        lanes: Its blocks.

    Raises:
        InputError: A block that starts in its wall, a tie above its block, or forces and
            elongations of a tie that do not fit together.
    """
    columns: dict[str, object] = {}
    hold = Hold()
    if values.case.tables.transverse_wall is not None:
        hold, of_wall = _beside_wall(values, lanes)
        columns |= of_wall
    if values.case.tables.tie is not None:
        numbers = range(1, values.case.tables.tie.count + 1)
        found = [_tie(values, f"{TIE}.{number}", lanes) for number in numbers]
        parts = {name: np.stack([each[name] for each in found], axis=1) for name in found[0]}
        hold = dataclasses.replace(hold, ties=Ties(**parts))
        for number in numbers:
            columns |= _tie_columns(values, number)
    return (dataclasses.replace(lanes, hold=hold) if columns else lanes), columns


def _beside_wall(values: LaneValues, lanes: Lanes) -> tuple[Hold, dict[str, object]]:
    """Blocks beside a transverse wall, and its columns."""
    side, rebound = _sides(values, f"{WALL}.side"), values.numbers(f"{WALL}.rebound")
    towards = np.where(side < 0.0, "left", "right")
    into = side * lanes.rotation_start > 0.0
    allowed = f"must lean away from the wall at its {towards[int(np.argmax(into))]}"
    key = "start.rotation_ratio" if values.given("start.rotation_ratio") else "start.rotation"
    values.refuse(into, key, allowed)
    formula = rebound == BY_FORMULA
    rebound = np.where(formula, three_impacts(lanes.slenderness_angle), rebound)
    columns: dict[str, object] = {"wall_side": values.column(f"{WALL}.side")}
    return Hold(side, rebound), columns | key_column(f"{WALL}.rebound", rebound)


def _sides(values: LaneValues, key: str) -> Array:
    """Sides as -1 and 1, shape [lane]."""
    names, codes = values.texts(key)
    return np.array([SIDES[name] for name in names])[codes]


def _tie(values: LaneValues, table: str, lanes: Lanes) -> dict[str, npt.NDArray[Any]]:
    """Fields of `Ties` of one tie, shape [lane] each."""
    height, prestress, slack, stiffness = (
        values.numbers(f"{table}.{name}") for name in ("height", "prestress", "slack", "stiffness")
    )
    high = height > lanes.height
    top = lanes.height[int(np.argmax(high))]
    values.refuse(high, f"{table}.height", f"must be at most the height of the block, {top:g} m")
    limits = {}
    for name in ("yield_force", "ultimate_elongation"):
        given = values.given(f"{table}.{name}")
        limits[name] = values.numbers(f"{table}.{name}") if given else np.full_like(height, np.inf)
    weak = limits["yield_force"] <= prestress
    at = int(np.argmax(weak))
    allowed = f"must be more than {table}.prestress, {prestress[at]:g} N"
    values.refuse(weak, f"{table}.yield_force", allowed)
    names, codes = values.texts(f"{table}.acts")
    return {
        "side": _sides(values, f"{table}.side"),
        "height": height,
        "stiffness": stiffness,
        "slack": slack,
        "prestress": prestress,
        "pushes": np.array([name == "both" for name in names])[codes],
        **limits,
    }


def _tie_columns(values: LaneValues, number: int) -> dict[str, object]:
    """Input columns of a tie: those of the keys that are given."""
    columns: dict[str, object] = {}
    for name, declared in Tie.declared().items():
        key = f"{TIE}.{number}.{name}"
        if not values.given(key):
            continue
        if isinstance(declared, NumberKey):
            columns |= key_column(f"{Tie.place}.{name}", values.numbers(key), f"_{number}")
        else:
            columns |= {f"tie_{name}_{number}": values.column(key)}
    return columns


def refuse_elsewhere(values: LaneValues, place: str) -> None:
    """Refuses what holds a block where blocks are not single boxes in the plane.

    Args:
        values: Values of the case.
        place: What the case has instead.

    Raises:
        InputError: The case holds its block.
    """
    for name in (WALL, TIE):
        if getattr(values.case.tables, name) is not None:
            allowed = f"must be left out: it holds a single box in the plane, and the case {place}"
            raise InputError(values.case.source_of(name), name, Said("a table"), allowed)
