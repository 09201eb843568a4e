"""Input columns of the lane table: those of keys, as they declare them, and computed ones."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warprock.case.axes import LABEL
from warprock.case.keys import KEYS, general_key
from warprock.model.lanes import Lanes
from warprock.quantity import Column, NumberKey
from warprock.units import UNITS, Dimension

Array = npt.NDArray[np.float64]

SPECTRAL = "spectral_acceleration"
"""Column of the spectral acceleration of a record as it was scaled."""

_COMPUTED = (
    Column("lane", text="Number of the lane"),
    Column(
        "slenderness_angle",
        "rad",
        "Slenderness (critical) angle; of an eccentric block that of its weaker side, of an "
        "assembly that whose tangent is the length of its joints over its height",
    ),
    Column("slenderness_angle_across", "rad", "The same about the edges at the ends of its depth"),
    Column("ground_depth", "m", "Depth at which the block lies in the ground at rest"),
    Column("slenderness_angle_left", "rad", "Slenderness angle of a body to its side at -x"),
    Column("slenderness_angle_right", "rad", "Slenderness angle of a body to its side at +x"),
    Column(
        "half_diagonal",
        "m",
        "Half diagonal; of a body the distance from its centre of mass to the nearer end of its "
        "base",
    ),
    Column("frequency_parameter", "rad/s", "Frequency parameter"),
    Column("blocks", text="Number of blocks of the assembly that can move"),
    Column("joints", text="Number of joints of the assembly, each with two contact points"),
    Column("record_source", text="Where the record is from"),
    Column("record_licence", text="Licence of the record"),
    Column("record_sha256", text="SHA-256 of the record's file"),
    Column("record_processing", text="What was done to the record before the run"),
    Column("stop", "s", "Time at which the motion stops"),
    Column("peak_acceleration", "m/s^2", "Largest acceleration of the base, velocity steps apart"),
    Column(
        "support_peak_acceleration",
        "m/s^2",
        "Largest acceleration of the floor or isolator under the block, velocity steps apart",
    ),
    Column(
        "support_peak_displacement",
        "m",
        "Largest displacement of the floor or isolator under the block against the ground",
    ),
    Column("peak_velocity", "m/s", "Largest velocity of the base, PGV"),
    Column(SPECTRAL, "m/s^2", "Spectral acceleration of the motion, 5 % damping, at sa_period"),
    Column("member", text="Number of the member in its cell"),
    Column("time_step_factor", text="Factor on the engine's time step"),
    Column("normalised_velocity", text="Frequency parameter x PGV / (g tan(slenderness angle))"),
    Column(
        "normalised_acceleration",
        text="Largest acceleration / that which lifts the block to its weaker side, g "
        "tan(slenderness angle); in space with its yaw",
    ),
    Column(
        "uplift_ratio", text="Base acceleration / g at which a part of the stack begins to rock"
    ),
)
"""Columns that no key has."""

_OF_KEYS = [column for declared in KEYS.values() for column in declared.columns]

INPUTS: dict[str, Column] = {}
"""Full name of an input column, of a block without its number -> the column."""
for _column in (*_OF_KEYS, *_COMPUTED):
    INPUTS.setdefault(_column.named(), _column)

_DIRECTIONS = {"_y": "across the plane of rocking", "_z": "upwards"}
"""End of an input column of a motion besides that in the plane -> direction."""

_BLOCK_NUMBER = re.compile(r"_([1-9])(?=_|$)")


def computed(name: str, values: Array, number: str = "") -> dict[str, Array]:
    """A column that no key has, by its full name.

    Args:
        name: Its name without the unit.
        values: SI units or rad, shape [lane].
        number: Number of a block in a stack, such as "_2".
    """
    column = next(column for column in _COMPUTED if column.name == name)
    return {column.named(number): values}


def key_column(
    key: str, values: Array, number: str = "", dimension: Dimension | None = None
) -> dict[str, Array]:
    """The column of a key, by its full name, in the unit that it declares.

    Args:
        key: A key of `KEYS` whose values are numbers.
        values: Its values, SI units or rad, shape [lane].
        number: Number of a block in a stack, such as "_2".
        dimension: What the values measure, where the key may hold several kinds.
    """
    declared = KEYS[key]
    assert isinstance(declared, NumberKey)
    dimension = dimension or declared.column_dimensions[0]
    column = declared.column_of(dimension)
    size = UNITS[dimension].get(column.unit, "1")
    # Written in mm, so 8 mm shall read 8 and not 8.000000000000002.
    written = values if size == "1" else np.round(values * (1.0 / float(size)), 12)
    return {column.named(number): np.asarray(written)}


def attribute(key: str) -> str:
    """Field of `Lanes` that holds the values of a key of a block: it bears its column's name."""
    column = KEYS[key].column
    assert column is not None, key
    return column.name


def lane_columns(keys: Sequence[str], lanes: Lanes, block: int | None = None) -> dict[str, Array]:
    """Columns of keys of a block, in the order of the keys.

    Args:
        keys: Keys of `KEYS`, each with a field of `Lanes`.
        lanes: Blocks and starts.
        block: Place of the block in a stack, from 0; None of single blocks.
    """
    found: dict[str, Array] = {}
    for key in keys:
        values = getattr(lanes, attribute(key))
        if block is None:
            found |= key_column(key, values)
        else:
            found |= key_column(key, values[:, block], f"_{block + 1}")
    return found


def columns_of(key: str) -> set[str]:
    """Full names of the input columns that can show a key: `{"height_m"}` for `block.height`.

    Args:
        key: A key that may be swept, or `label.NAME`, which is a column itself.
    """
    if key.startswith(LABEL):
        return {key.removeprefix(LABEL)}
    table, part = key.split(".")[0], key.split(".")[1]
    number = f"_{part}" if table in ("block", "tie") and part.isdecimal() else ""
    direction = f"_{part}" if table == "motion" and part in ("y", "z") else ""
    return {column.named(number) + direction for column in KEYS[general_key(key)].columns}


def input_meaning(column: str) -> tuple[str, str]:
    """Unit and meaning of an input column; the number of a block or of a tie does not matter."""
    known = INPUTS.get(column)
    if known is not None:
        return known.unit or "-", known.text
    direction = _DIRECTIONS.get(column[-2:])
    if direction is not None and column[:-2] in INPUTS:
        unit, text = input_meaning(column[:-2])
        return unit, f"{text}, of the motion {direction}"
    number = _BLOCK_NUMBER.search(column)
    general = _BLOCK_NUMBER.sub("", column, count=1)
    if number is None or general not in INPUTS:
        return "-", "Label of the case"
    unit, text = input_meaning(general)
    return unit, f"{text}, {'tie' if column.startswith('tie_') else 'block'} {number[1]}"
