"""Histories of a rotation: a table with a column of time and one of an angle.

    time_s,rotation_deg
    0.00,5.000
    0.01,4.998
    ...

It is a table as `column_file` reads them, and so is the history of a lane that a run writes. Times
grow; they need not be evenly spaced.
"""

from __future__ import annotations

import os
import pathlib
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.errors import NOTHING, InputError, Said
from warprock.reading import read_bytes, reason
from warprock.recordings.column_file import Column, Table, read_head, recognises
from warprock.recordings.text_file import TextFile
from warprock.units import UNITS, Dimension, parse_quantity

Array = npt.NDArray[np.float64]

UNIT_NAMES = ", ".join(UNITS[Dimension.ANGLE])


class Rotations(NamedTuple):
    """A history of a rotation, shape [sample] each.

    Attributes:
        times: [s], growing.
        rotations: [rad].
        column: Its column, as the file names it.
    """

    times: Array
    rotations: Array
    column: str


def read_rotations(
    path: str | os.PathLike[str], column: str | None = None, unit: str | None = None
) -> Rotations:
    """The history in a file.

    Args:
        path: The file.
        column: Name or number, from 1, of the column of the rotation; may be left out where one
            alone has a unit of an angle.
        unit: Its unit, where its header has none.

    Raises:
        InputError: It cannot be read, has no time or no such column, no unit, a cell that is no
            finite number, or times that do not grow.
    """
    file = str(pathlib.Path(path))
    try:
        lines = read_bytes(path).decode("utf-8-sig").splitlines()
    except OSError as error:
        raise InputError("HISTORY", "", file, f"must be a table ({reason(error)})") from None
    except UnicodeDecodeError as error:
        got = Said(f"byte {error.start}: not UTF-8")
        raise InputError(file, "", got, "must be a text file, one sample a line") from None
    text = TextFile(file, lines)
    if not recognises(text):
        raise text.refusal(0, "must begin a table with named columns such as time_s,rotation_deg")
    table = read_head(text, (Dimension.ANGLE,))
    chosen = _rotation_of(file, table, column)
    size = _unit_of(file, chosen, unit)
    if table.time is None:
        raise InputError(file, "time", NOTHING, "must be a column named time")
    values = table.values(text, [chosen])
    times = (
        parse_quantity(f"1 {table.time.unit or 's'}", Dimension.TIME) * values[table.time.number]
    )
    back = np.diff(times) <= 0.0
    if back.any():
        at = int(np.argmax(back)) + 1
        raise InputError(file, table.time.header, float(times[at]), f"must grow (sample {at})")
    return Rotations(times, size * values[chosen.number], chosen.header)


def _rotation_of(file: str, table: Table, column: str | None) -> Column:
    """The column of the rotation."""
    if column is not None:
        return table.called(file, column)
    others = table.others
    angles = [each for each in others if each.unit in UNITS[Dimension.ANGLE]]
    found = angles or others
    if len(found) == 1:
        return found[0]
    names = ", ".join(each.header for each in found)
    raise InputError(file, "rotation", Said(f"columns {names}"), "must be one of them: --column")


def _unit_of(file: str, column: Column, unit: str | None) -> float:
    """The size of the unit of the rotation [rad]."""
    given = unit or column.unit
    if not given:
        allowed = f"must be said, in the header or by --unit: {UNIT_NAMES}"
        raise InputError(file, column.header, Said("no unit"), allowed)
    try:
        return parse_quantity(f"1 {given}", Dimension.ANGLE)
    except ValueError:
        where = "--unit" if unit else file
        key = "" if unit else column.header
        raise InputError(where, key, given, f"must be a unit of an angle: {UNIT_NAMES}") from None
