"""Columns of a table, one row a lane, as keys of a sweep: `height_mm` is `block.height` in mm.

A column may be a key, `block.height`, whose values have units; a key and a unit, `block.height
[mm]`; a column of the lane table in any unit of its kind, `height_m`, `height_mm`, or without one,
`height`, whose values have units. `file` is the record. `label` and `observed`, alone or with a
point and a name behind, change nothing: they become columns of the lane table.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Collection, Iterable, Iterator
from typing import TYPE_CHECKING, Any

from warprock.case.axes import LABEL
from warprock.case.hold import MOST_TIES
from warprock.case.keys import KEYS, SWEEP_KEYS, general_key
from warprock.errors import NOTHING, InputError, Said, did_you_mean, list_allowed
from warprock.model.runnable import HIGHEST_STACK
from warprock.quantity import Column, NumberKey
from warprock.units import UNITS, bare_number

if TYPE_CHECKING:
    import pandas as pd

_KEY_AND_UNIT = re.compile(r"\s*([\w.]+?)\s*(?:\[\s*(.*?)\s*\])?\s*")


OBSERVED = f"{LABEL}observed"
"""Beginning of the keys of columns that hold what was observed, numbers or words."""

_FILE = "motion.record"
_PLAIN = {
    "file": _FILE,
    "motion.file": _FILE,
    "label": f"{LABEL}label",
    "observed": OBSERVED,
}
"""Names of columns that are no columns of the lane table -> key."""


def swept_columns(table: pd.DataFrame, source: str) -> dict[str, list[Any]]:
    """A [[sweep]] entry whose lanes are the rows of a table.

    Args:
        table: One row a lane, with columns as above.
        source: What errors name as their source.

    Returns:
        Values by key, in the order of the columns.

    Raises:
        InputError: A column that is no key, two columns for one key, an empty cell, or no row.
    """
    found = key_columns(table, source)
    return {
        key: list(values_of(table, name, key, unit, source)) for key, (name, unit) in found.items()
    }


def key_columns(
    table: pd.DataFrame, source: str, leave_out: Collection[str] = ()
) -> dict[str, tuple[str, str]]:
    """The keys that the columns of a table are of, each with the column's name and unit.

    Args:
        table: One row a lane.
        source: What errors name as their source.
        leave_out: Names of columns, or keys, that are not asked for.

    Raises:
        InputError: A column that is no key, two columns for one key, or no row.
    """
    if not len(table):
        raise InputError(source, "", Said("0 rows"), "must have at least one row: each is a lane")
    found: dict[str, tuple[str, str]] = {}
    for name in map(str, table.columns):
        if name in leave_out:
            continue
        key, unit = _key_of(name, source)
        if key in leave_out:
            continue
        if key in found:
            raise InputError(source, name, key, "must be there once")
        found[key] = name, unit
    return found


def _key_of(name: str, source: str) -> tuple[str, str]:
    """The key that a column is of, and the unit of its numbers."""
    match = _KEY_AND_UNIT.fullmatch(name)
    known = _keys_of_columns()
    if match is not None:
        key, unit = match[1], match[2] or ""
        if key.startswith("observed."):
            return f"{OBSERVED}_{key.removeprefix('observed.')}", ""
        key = _PLAIN.get(key, key)
        if key.startswith(LABEL) or general_key(key) in SWEEP_KEYS:
            return key, unit
        if unit and known.get(key, ("", "-"))[1] == "":
            return known[key][0], unit
    if name in known:
        return known[name]
    near = [*SWEEP_KEYS, *known]
    allowed = (
        "must be a key, such as block.height, or a column of the lane table, such as height_m "
        f"({list_allowed(name, near)}), label.NAME or observed.NAME, or stand in leave_out of the "
        f"sweep{did_you_mean(name, near)}"
    )
    raise InputError(source, name, Said("the column"), allowed)


def values_of(
    table: pd.DataFrame, name: str, key: str, unit: str, source: str, *, first_row: int = 0
) -> Iterator[Any]:
    """The values of a column as a case file holds them.

    Args:
        table: One row a lane.
        name: Name of the column.
        key: The key that it is of.
        unit: Unit of its bare numbers.
        source: What errors name as their source.
        first_row: What the first row is called.

    Raises:
        InputError: An empty cell.
    """
    number = isinstance(KEYS.get(general_key(key)), NumberKey)
    for row, value in enumerate(table[name].tolist(), first_row):
        if value is None or value != value:
            raise InputError(source, name, NOTHING, f"must be given in every row (row {row})")
        if isinstance(value, bool) or not number:
            yield value
        elif isinstance(value, str):
            bare = bare_number(value)
            yield f"{value} {unit}" if bare and unit else float(value) if bare else value
        else:
            yield f"{value!r} {unit}" if unit else value


@functools.cache
def _keys_of_columns() -> dict[str, tuple[str, str]]:
    """Key and unit by the name of a column of the lane table, in every unit of its kind."""
    found: dict[str, tuple[str, str]] = {}
    for general in SWEEP_KEYS:
        for key, number, direction in _instances(general):
            for column, unit in _columns(general):
                found.setdefault(column.named(number) + direction, (key, unit))
            shown = KEYS[general].column
            if shown is not None:
                found.setdefault(f"{shown.name}{number}{direction}", (key, ""))
    return found


def _instances(general: str) -> Iterator[tuple[str, str, str]]:
    """The keys that a key of `KEYS` stands for, and what their columns have in and behind it."""
    most = {"block.N": HIGHEST_STACK, "tie.N": MOST_TIES}.get(general.rpartition(".")[0])
    if most is not None:
        for number in range(1, most + 1):
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
