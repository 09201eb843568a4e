"""Columns of a table, one row a lane, as keys of a sweep: `height_mm` is `block.height` in mm."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from warprock.case.axes import LABEL
from warprock.case.keys import KEYS, SWEEP_KEYS, general_key
from warprock.errors import InputError, did_you_mean, listed
from warprock.model.runnable import MOST_BLOCKS
from warprock.quantity import NOTHING, Column, NumberKey, Said
from warprock.units import UNITS

if TYPE_CHECKING:
    import pandas as pd

_KEY_AND_UNIT = re.compile(r"\s*([\w.]+?)\s*(?:\[\s*(.*?)\s*\])?\s*")


def swept_columns(table: pd.DataFrame, source: str) -> dict[str, list[Any]]:
    """A [[sweep]] entry whose lanes are the rows of a table.

    Args:
        table: One row a lane. A column is a key, `block.height`, whose values have units; a key
            and a unit, `block.height [mm]`; or a column of the lane table in any unit of its kind,
            `height_m`, `height_mm`. Labels are `label.NAME`.
        source: What errors name as their source.

    Returns:
        Values by key, in the order of the columns.

    Raises:
        InputError: A column that is no key, two columns for one key, an empty cell, or no row.
    """
    if not len(table):
        raise InputError(source, "", "0 rows", "must have at least one row: each is a lane")
    found: dict[str, list[Any]] = {}
    for name in map(str, table.columns):
        key, unit = _key_of(name, source)
        if key in found:
            raise InputError(source, name, key, "must be there once")
        found[key] = list(_values(table, name, unit, source))
    return found


def _key_of(name: str, source: str) -> tuple[str, str]:
    """The key that a column is of, and the unit of its numbers."""
    match = _KEY_AND_UNIT.fullmatch(name)
    if match is not None:
        key, unit = match[1], match[2] or ""
        if key.startswith(LABEL) or general_key(key) in SWEEP_KEYS:
            return key, unit
    known = _keys_of_columns()
    if name in known:
        return known[name]
    near = [*SWEEP_KEYS, *known]
    allowed = (
        "must be a key, such as block.height, or a column of the lane table, such as height_m "
        f"({listed(name, near)}), or label.NAME{did_you_mean(name, near)}"
    )
    raise InputError(source, name, Said("the column"), allowed)


def _values(table: pd.DataFrame, name: str, unit: str, source: str) -> Iterator[Any]:
    """The values of a column as a case file holds them."""
    for row, value in enumerate(table[name].tolist()):
        if value is None or value != value:
            raise InputError(source, name, NOTHING, f"must be given in every row (row {row})")
        plain = isinstance(value, str | bool)
        yield value if plain or not unit else f"{value!r} {unit}"


@functools.cache
def _keys_of_columns() -> dict[str, tuple[str, str]]:
    """Key and unit by the name of a column of the lane table, in every unit of its kind."""
    found: dict[str, tuple[str, str]] = {}
    for general in SWEEP_KEYS:
        for key, number, direction in _instances(general):
            for column, unit in _columns(general):
                found.setdefault(column.named(number) + direction, (key, unit))
    return found


def _instances(general: str) -> Iterator[tuple[str, str, str]]:
    """The keys that a key of `KEYS` stands for, and what their columns have in and behind it."""
    if general.startswith("block.N."):
        for number in range(1, MOST_BLOCKS + 1):
            yield general.replace("N", str(number), 1), f"_{number}", ""
    else:
        yield general, "", ""
    if general.startswith("motion."):
        for axis in "yz":
            yield general.replace("motion.", f"motion.{axis}.", 1), "", f"_{axis}"


def _columns(general: str) -> Iterable[tuple[Column, str]]:
    """The columns that can show a key, in every unit."""
    declared = KEYS[general]
    if declared.column is None:
        return
    if not isinstance(declared, NumberKey):
        yield declared.column, ""
        return
    for dimension in declared.bounds:
        for unit in UNITS[dimension]:
            yield declared.column._replace(unit=unit), unit
