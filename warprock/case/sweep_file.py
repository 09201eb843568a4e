"""A sweep from a file: `[sweep] table = "tests.csv"`, one row a lane.

A CSV file has a header, then a row for every lane; a Parquet file has the same columns with types
of their own. Columns are named as in `sweep_file_columns`. Rows are counted from 1, without the
header.
"""

from __future__ import annotations

import hashlib
import io
import pathlib
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple

import pydantic

from warprock.case.axes import TableSource
from warprock.case.sweep_file_columns import OBSERVED, key_columns, values_of
from warprock.case.validation import Table, validated
from warprock.case.value_kinds import OtherKey
from warprock.errors import InputError, Said
from warprock.quantity import TextKey
from warprock.reading import read_bytes, reason
from warprock.units import bare_number

if TYPE_CHECKING:
    import pandas as pd

TABLE = "table"
"""Key of a [[sweep]] entry that names its file."""
LEAVE_OUT = "leave_out"
"""Key of such an entry that names columns, or keys, which are not read."""

MOST_ROWS = 100_000_000
"""Rows of a table, at most, as of a list."""

PARQUET = b"PAR1"
"""What a Parquet file begins with."""

_SEPARATORS = (",", ";", "\t")


def _names(got: object) -> tuple[str, ...]:
    if not isinstance(got, list) or not all(isinstance(name, str) for name in got):
        raise ValueError("must be a list of names of columns")
    return tuple(got)


class TableEntry(Table):
    """A sweep whose lanes are the rows of a file."""

    place: ClassVar[str] = "sweep"

    table: Annotated[str, TextKey("the path of a CSV or Parquet file, one row a lane", most=4096)]
    leave_out: Annotated[
        tuple[str, ...], OtherKey("columns, or keys, that are not read", "list of names", _names)
    ] = pydantic.Field(default_factory=tuple)


class TableSweep(NamedTuple):
    """What a file sweeps.

    Attributes:
        source: The file.
        columns: Key -> name of its column.
        values: Key -> its values as a case holds them, in the order of the rows.
    """

    source: TableSource
    columns: dict[str, str]
    values: dict[str, list[Any]]


def read_table_sweep(entry: Mapping[str, object], folder: pathlib.Path | None) -> TableSweep:
    """The columns of the file that a [[sweep]] entry names.

    Args:
        entry: The entry, with `table`.
        folder: Folder that a relative path starts from; the working folder where None.

    Raises:
        KeyedError: A key of the entry that cannot be used.
        InputError: A file that cannot be read, a column that is no key, an empty cell, or no row.
    """
    asked = validated(TableEntry, entry)
    path = (folder or pathlib.Path()) / asked.table
    try:
        content = read_bytes(path)
    except OSError as error:
        allowed = f"must be a file to read ({reason(error)})"
        raise InputError(str(path), TABLE, asked.table, allowed) from None
    source, parquet = str(path), content.startswith(PARQUET)
    frame = parquet_table(content, source) if parquet else csv_texts(content, source)
    if len(frame) > MOST_ROWS:
        raise InputError(source, "", Said(f"{len(frame):,} rows"), f"must be <= {MOST_ROWS:,}")
    found = key_columns(frame, source, asked.leave_out)
    values = {
        key: list(values_of(frame, name, key, unit, source, first_row=1))
        for key, (name, unit) in found.items()
    }
    if not parquet:
        values = {key: _read_numbers(key, each) for key, each in values.items()}
    digest = hashlib.sha256(content).hexdigest()
    names = {key: name for key, (name, _) in found.items()}
    return TableSweep(TableSource(asked.table, source, digest), names, values)


def _read_numbers(key: str, values: list[Any]) -> list[Any]:
    """What was observed, as numbers where every cell of the text is one."""
    if key.startswith(OBSERVED) and all(map(bare_number, values)):
        return [float(value) for value in values]
    return values


def parquet_table(content: bytes, file: str) -> pd.DataFrame:
    """A table from the bytes of a Parquet file.

    Raises:
        InputError: They are none.
    """
    import pandas as pd

    try:
        return pd.read_parquet(io.BytesIO(content))
    except (ValueError, OSError) as error:
        why = str(error).splitlines()[0]
        raise InputError(file, "", Said("the file"), f"must be whole Parquet: {why}") from None


def csv_texts(content: bytes, file: str) -> pd.DataFrame:
    """A table of text from the bytes of a CSV file, an empty cell as it is missing.

    Raises:
        InputError: They are none, or have nothing, or rows of another length than the header.
    """
    import pandas as pd

    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        got = Said(f"byte {error.start}: not UTF-8")
        raise InputError(file, "", got, "must be CSV in UTF-8, or Parquet") from None
    head = next((line for line in text.splitlines() if line.strip()), "")
    separator = next((mark for mark in _SEPARATORS if mark in head), ",")
    try:
        cells = pd.read_csv(
            io.StringIO(text),
            sep=separator,
            header=None,
            dtype=str,
            keep_default_na=False,
            na_values=[""],
            skipinitialspace=True,
        )
    except pd.errors.EmptyDataError:
        raise InputError(file, "", Said("nothing"), "must have a header and rows") from None
    except pd.errors.ParserError as error:
        raise _unequal(file, str(error)) from None
    names = cells.iloc[0]
    if names.isna().any():
        at = int(names.isna().argmax()) + 1
        raise InputError(file, f"column {at}", Said("no name"), "must have a name in the header")
    return cells.iloc[1:].set_axis(names.str.strip(), axis=1)


def _unequal(file: str, why: str) -> InputError:
    """The refusal of rows that do not have as many cells as the header."""
    found = re.search(r"Expected (\d+) fields in line (\d+), saw (\d+)", why)
    if found is None:
        return InputError(file, "", Said("the text"), f"must be CSV: {why.strip()}")
    allowed = f"must have {found[1]}, as the header"
    return InputError(file, f"line {found[2]}", Said(f"{found[3]} cells"), allowed)
