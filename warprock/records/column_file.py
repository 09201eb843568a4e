"""Tables with named columns: a header, then a row of numbers for every sample.

    time,acceleration_g
    0.00,0.0000
    0.01,0.0123
    ...

Columns stand apart by commas, semicolons, tabs or blanks. A unit stands behind the name of its
column: `acceleration_g`, `acc [m/s^2]`, `velocity (cm/s)`; every column with a unit of
acceleration, velocity or displacement is a channel. Where the header has no unit, whoever reads the
file gives it.
The time between samples comes from the column of time, in seconds unless its header has another
unit. Samples are evenly spaced.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.errors import InputError, list_allowed
from warprock.model.motion import Control
from warprock.quantity import NOTHING, Said
from warprock.records.record import CONTROL_OF
from warprock.records.rows import plain_columns
from warprock.records.text_file import Channel, TextFile
from warprock.units import Dimension, Quantity, parse_any, parse_quantity

Array = npt.NDArray[np.float64]

UNEVEN = 0.02
"""How far a sample may lie from an even spacing, over the time between samples: times are written
with few digits."""

MOTION_UNITS = "g, m/s^2, cm/s^2, gal, m/s, cm/s, m, cm or mm"
"""Units that an error names."""

_TIMES = ("time", "t", "times", "zeit", "tiempo", "temps")
_SEPARATORS = (",", ";", "\t", None)
_WRITTEN = {"m_s2": "m/s^2", "cm_s2": "cm/s^2", "mm_s2": "mm/s^2", "m_s": "m/s", "cm_s": "cm/s"}
"""Units as names of columns hold them."""


class Reading(NamedTuple):
    """What whoever reads a table says of it.

    Attributes:
        column: Name or number, from 1, of the column of the motion.
        unit: Unit of that column, where its header has none; or a number of them, "-1 g".
        interval: Time between samples, with its unit, where there is no column of time.
    """

    column: str | None = None
    unit: str | None = None
    interval: str | None = None


class _Column(NamedTuple):
    """A column by its number from 1, its header, its name and unit in it."""

    number: int
    header: str
    name: str
    unit: str

    def called(self, text: str) -> bool:
        """Whether a text means this column."""
        wanted = text.strip().casefold()
        return wanted in (self.header.casefold(), self.name.casefold(), str(self.number))


def recognises(text: TextFile) -> bool:
    """Whether a file begins as a table with several columns, or with one that has a name."""
    at, separator = _layout(text)
    if separator == "":
        return False
    head = _fields(text.lines[at], separator)
    row = next((line for line in text.lines[at + 1 :] if line.strip()), "")
    numbers = _fields(row, separator)
    if len(head) != len(numbers) or not all(map(_is_number, numbers)):
        return False
    return len(head) > 1 or not _is_number(head[0])


def read(text: TextFile, readings: Sequence[Reading]) -> list[list[Channel]]:
    """The motions of a table, one for every column that is asked for or has a unit.

    Args:
        text: The file; its rows are parsed once, whatever is asked for.
        readings: What is said of it, a list of motions each.

    Raises:
        InputError: No such column, no unit, no time between samples, a cell that is no finite
            number, or samples that are not evenly spaced.
    """
    at, separator = _layout(text)
    head = _fields(text.lines[at], separator)
    named = not all(map(_is_number, head))
    columns = [_column(n, name if named else "") for n, name in enumerate(head, 1)]
    time = next((c for c in columns if c.name.casefold() in _TIMES), None)
    chosen = [_motions(text.file, columns, time, asked) for asked in readings]
    wanted = [column.number for each in chosen for column, *_ in each]
    wanted = list(dict.fromkeys([*wanted, *([] if time is None else [time.number])]))
    rows = _values(text, at + named, separator, len(columns), wanted)
    values = dict(zip(wanted, rows.T, strict=True))
    times = None if time is None else values[time.number]
    said = {key: _comment(text, key) for key in ("source", "licence", "processing")}
    found = []
    for asked, each in zip(readings, chosen, strict=True):
        interval = _interval(text.file, asked, time, times)
        found.append([_channel(asked, motion, interval, values, said) for motion in each])
    return found


def _channel(
    asked: Reading,
    motion: tuple[_Column, Control, float],
    interval: float,
    values: Mapping[int, Array],
    said: Mapping[str, str],
) -> Channel:
    """The motion of a column, of the values of columns by number and what the file says."""
    column, quantity, size = motion
    return Channel(
        label=column.header,
        quantity=quantity,
        interval=interval,
        samples=size * values[column.number],
        source=said["source"],
        licence=said["licence"],
        processing=said["processing"]
        or f"column {column.header}, read as {asked.unit or column.unit}",
    )


def _layout(text: TextFile) -> tuple[int, str | None]:
    """The line of the header, or of the first row where there is none, and the separator.

    The separator is empty where the file is no table, None where blanks part the columns.
    """
    lines = ((at, line) for at, line in enumerate(text.lines) if line.strip())
    first = next(((at, line) for at, line in lines if not line.lstrip().startswith("#")), None)
    if first is None:
        return 0, ""
    at, line = first
    separator = next((s for s in _SEPARATORS if s is None or s in line), None)
    if separator == "\t" and all(map(_is_number, line.split())):
        separator = None  # rows of numbers may mix tabs and blanks
    fields = _fields(line, separator)
    above = text.lines[at - 1].lstrip("# ") if at else ""
    if all(map(_is_number, fields)) and len(fields) > 1:
        # A program may write its header as a comment: # time, acceleration_g
        names = _fields(above, separator)
        if len(names) == len(fields) and not any(map(_is_number, names)):
            return at - 1, separator
    return at, separator


def _fields(line: str, separator: str | None) -> list[str]:
    text = line.strip().lstrip("#") if line.lstrip().startswith("#") else line.strip()
    return [field.strip().strip("\"'") for field in text.split(separator)]


def _is_number(field: str) -> bool:
    try:
        float(field.replace(",", ".", 1))
    except ValueError:
        return False
    return True


def _column(number: int, header: str) -> _Column:
    """A column from its header: `acc_g`, `acc [g]`, `acc (g)` and `acc g` are the name acc in g."""
    bare = header or str(number)
    found = re.fullmatch(r"(.+?)\s*[\[(]\s*([^\])]*?)\s*[\])]", bare)
    if found and _unit(found[2]):
        return _Column(number, bare, found[1], found[2])
    for unit, written in _WRITTEN.items():
        if bare.lower().endswith(f"_{unit}"):
            return _Column(number, bare, bare[: -len(unit) - 1], written)
    found = re.fullmatch(r"(.+)[_\s]([^_\s]+)", bare)
    if found and _unit(found[2]):
        return _Column(number, bare, found[1], found[2])
    return _Column(number, bare, bare, "")


def _unit(text: str) -> Dimension | None:
    """What a unit measures; None where it is no unit of a motion or of time."""
    try:
        return parse_any(f"1 {text}", (*CONTROL_OF, Dimension.TIME)).dimension if text else None
    except ValueError:
        return None


def _values(
    text: TextFile, first: int, separator: str | None, count: int, wanted: Sequence[int]
) -> Array:
    """The numbers in some columns, shape [sample, wanted]; the decimal mark may be a comma."""
    plain = plain_columns(text.lines[first:], separator, count, wanted)
    if plain is not None and len(plain) > 1:
        return plain
    rows = []
    for at, line in enumerate(text.lines[first:], first):
        if not line.strip():
            continue
        fields = _fields(line, separator)
        if len(fields) != count:
            got = Said(f"{len(fields)} fields")
            raise text.refusal(at, f"must have {count} fields, as the rows above", got)
        rows.append([text.number(at, fields[n - 1].replace(",", ".", 1)) for n in wanted])
    if len(rows) < 2:
        raise InputError(
            text.file, "samples", Said(f"{len(rows)} samples"), "must be at least 2 samples"
        )
    return np.array(rows)


def _interval(file: str, asked: Reading, time: _Column | None, values: Array | None) -> float:
    """Time between samples [s], as said or from the values in the column of time."""
    if asked.interval is not None:
        try:
            interval = parse_quantity(asked.interval, Dimension.TIME)
        except ValueError as error:
            raise InputError("--interval", "", asked.interval, str(error)) from None
        if interval <= 0.0:
            raise InputError("--interval", "", asked.interval, "must be a time above 0 s")
        return interval
    if time is None or values is None:
        allowed = 'must be a column named time, or the time between samples: --interval "0.01 s"'
        raise InputError(file, "time", NOTHING, f"{allowed} of {_COMMANDS}")
    size = parse_quantity(f"1 {time.unit or 's'}", Dimension.TIME)
    times = size * values
    interval = float(f"{(times[-1] - times[0]) / (len(times) - 1):.12g}")
    even = times[0] + interval * np.arange(len(times))
    uneven = ~(np.abs(times - even) <= UNEVEN * interval)
    if interval <= 0.0 or uneven.any():
        at = int(np.argmax(uneven))
        got = Said(f"{times[at]:g} s at sample {at}")
        allowed = (
            f"must be evenly spaced, here {interval:g} s apart, to {UNEVEN:.0%} of that: resample "
            f'the motion, or say the spacing: --interval "0.01 s" of {_COMMANDS}'
        )
        raise InputError(file, time.header, got, allowed)
    return interval


_COMMANDS = "`warprock records import` or `warprock init --record`"


def _motions(
    file: str, columns: Sequence[_Column], time: _Column | None, asked: Reading
) -> list[tuple[_Column, Control, float]]:
    """The columns of motions, what they are, and the size of their units in SI units."""
    others = [column for column in columns if column is not time]
    if asked.column is not None:
        wanted = [column for column in others if column.called(asked.column)]
        if not wanted:
            known = list_allowed(asked.column, [column.header for column in others])
            raise InputError("--column", "", asked.column, f"must be a column of {file}: {known}")
        others = wanted[:1]
    found = list(_with_units(others, asked))
    if found:
        return found
    names = ", ".join(column.header for column in others) or "no other column"
    example = next((column.header for column in others), "acceleration")
    raise InputError(
        file,
        "unit",
        NOTHING,
        f"must be said of a column ({names}): in its header, as in {example}_g or {example} "
        f"[m/s^2], or by warprock records import {file} --column {example} --unit g -o record.csv, "
        f"whose file every command reads (units: {MOTION_UNITS})",
    )


def _with_units(
    columns: Sequence[_Column], asked: Reading
) -> Iterator[tuple[_Column, Control, float]]:
    for column in columns:
        unit = asked.unit or column.unit
        if not unit:
            continue
        try:
            size, dimension = _size(unit)
        except ValueError:
            if asked.unit:
                allowed = f'must be a unit of a motion: {MOTION_UNITS}, or a number of one, "-1 g"'
                raise InputError("--unit", "", asked.unit, allowed) from None
            continue
        yield column, CONTROL_OF[dimension], size


def _size(unit: str) -> Quantity:
    """The size of a unit, or of a number of them, such as "-1 g" where a sensor's sign is opposite.

    Raises:
        ValueError: It is no unit of a motion, or nothing of one.
    """
    found = parse_any(unit if unit[0] in "+-.0123456789" else f"1 {unit}", CONTROL_OF)
    if found.value == 0.0:
        raise ValueError("must not be 0")
    return found


def _comment(text: TextFile, key: str) -> str:
    """What a line `# key: ...` above the table says."""
    for line in text.lines:
        if not line.startswith("#"):
            return ""
        name, colon, value = line[1:].partition(":")
        if colon and name.strip().lower() == key:
            return value.strip()
    return ""
