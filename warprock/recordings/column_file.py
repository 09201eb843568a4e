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
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.errors import NOTHING, InputError, Said, list_allowed
from warprock.model.motion import Control
from warprock.recordings.record import CONTROL_OF
from warprock.recordings.rows import plain_columns
from warprock.recordings.text_file import Channel, TextFile
from warprock.units import Dimension, Quantity, parse_any, parse_quantity

Array = npt.NDArray[np.float64]

UNEVEN = 0.02
"""How far a sample may lie from an even spacing, over the time between samples: times are written
with few digits."""

MOTION_UNITS = "g, m/s^2, cm/s^2, gal, m/s, cm/s, m, cm or mm"
"""Units that an error names."""

_COMMANDS = "`warprock records import` or `warprock init --record`"
"""Commands that can say of a table what its header does not."""
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


class Column(NamedTuple):
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
    table = read_head(text, CONTROL_OF)
    chosen = [_motions(text.file, table, asked) for asked in readings]
    values = table.values(text, [column for each in chosen for column, *_ in each])
    times = None if table.time is None else values[table.time.number]
    said = {key: _comment(text, key) for key in ("source", "licence", "processing")}
    found = []
    for asked, each in zip(readings, chosen, strict=True):
        interval = _interval(text.file, asked, table.time, times)
        found.append([_channel(asked, motion, interval, values, said) for motion in each])
    return found


def _channel(
    asked: Reading,
    motion: tuple[Column, Control, float],
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


class Table(NamedTuple):
    """A table by its header.

    Attributes:
        columns: Its columns.
        time: That of time; None without one.
        first: Line of its first row, from 0.
        separator: What stands between columns; None for blanks.
    """

    columns: Sequence[Column]
    time: Column | None
    first: int
    separator: str | None

    @property
    def others(self) -> Sequence[Column]:
        """All columns but that of time."""
        return [column for column in self.columns if column is not self.time]

    def called(self, file: str, text: str) -> Column:
        """The column that a text means, besides that of time.

        Raises:
            InputError: There is none.
        """
        wanted = next((column for column in self.others if column.called(text)), None)
        if wanted is None:
            known = list_allowed(text, [column.header for column in self.others])
            raise InputError("--column", "", text, f"must be a column of {file}: {known}")
        return wanted

    def values(self, text: TextFile, wanted: Sequence[Column]) -> Mapping[int, Array]:
        """The numbers in some columns and in that of time, by the number of the column.

        Raises:
            InputError: A cell is no finite number, or there are fewer than two rows.
        """
        time = [] if self.time is None else [self.time.number]
        numbers = list(dict.fromkeys([*(column.number for column in wanted), *time]))
        rows = _values(text, self.first, self.separator, len(self.columns), numbers)
        return dict(zip(numbers, rows.T, strict=True))


def read_head(text: TextFile, dimensions: Iterable[Dimension]) -> Table:
    """The columns of a table, and where its rows begin.

    Args:
        text: The file.
        dimensions: What columns besides that of time measure.
    """
    at, separator = _layout(text)
    head = _fields(text.lines[at], separator) if text.lines else []
    named = not all(map(_is_number, head))
    known = (*dimensions, Dimension.TIME)
    columns = [_column(n, name if named else "", known) for n, name in enumerate(head, 1)]
    time = next((c for c in columns if c.name.casefold() in _TIMES), None)
    return Table(columns, time, at + named, separator)


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


def _column(number: int, header: str, dimensions: Iterable[Dimension]) -> Column:
    """A column from its header: `acc_g`, `acc [g]`, `acc (g)` and `acc g` are the name acc in g."""
    bare = header or str(number)
    found = re.fullmatch(r"(.+?)\s*[\[(]\s*([^\])]*?)\s*[\])]", bare)
    if found and _is_unit(found[2], dimensions):
        return Column(number, bare, found[1], found[2])
    for unit, written in _WRITTEN.items():
        if bare.lower().endswith(f"_{unit}"):
            return Column(number, bare, bare[: -len(unit) - 1], written)
    found = re.fullmatch(r"(.+)[_\s]([^_\s]+)", bare)
    if found and _is_unit(found[2], dimensions):
        return Column(number, bare, found[1], found[2])
    return Column(number, bare, bare, "")


def _is_unit(text: str, dimensions: Iterable[Dimension]) -> bool:
    """Whether a text is a unit of something."""
    try:
        parse_any(f"1 {text}", dimensions)
    except ValueError:
        return False
    return bool(text)


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


def _interval(file: str, asked: Reading, time: Column | None, values: Array | None) -> float:
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


def _motions(file: str, table: Table, asked: Reading) -> list[tuple[Column, Control, float]]:
    """The columns of motions, what they are, and the size of their units in SI units."""
    others = list(table.others)
    if asked.column is not None:
        others = [table.called(file, asked.column)]
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
    columns: Sequence[Column], asked: Reading
) -> Iterator[tuple[Column, Control, float]]:
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
