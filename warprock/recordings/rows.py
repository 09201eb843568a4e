"""Numbers in lines of text, read fast where they are plain.

What is not plain (a decimal comma, quotes, a cell that is no finite number, rows of unequal length)
is left to whoever asks, who reads line by line and says which one cannot be used.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

_END, _BLANK = 10, 32
"""The bytes that end a line, and up to which they are blanks."""


def plain_column(lines: Sequence[str]) -> Array | None:
    """Numbers that stand one on a line, shape [sample]; None where some are not plain.

    Args:
        lines: The lines; empty ones are passed over.
    """
    values = _numbers(lines)
    return None if values is None or values.shape[1] != 1 else values[:, 0]


def plain_columns(
    lines: Sequence[str], separator: str | None, count: int, wanted: Sequence[int]
) -> Array | None:
    """Some columns of a table of numbers, shape [row, wanted]; None where some are not plain.

    Args:
        lines: The rows; empty ones at the end are passed over.
        separator: What stands between cells; None for blanks.
        count: Cells of every row.
        wanted: Numbers of the columns, from 1.
    """
    # Tabs at the end of a row are blanks, not empty cells: some programs write one.
    rows = [line.strip() for line in lines] if separator == "\t" else list(lines)
    while rows and not rows[-1].strip():
        rows.pop()
    if not rows or not _all_have(rows, separator, count):
        return None
    return _numbers(rows, separator, [number - 1 for number in wanted])


def _numbers(
    rows: Sequence[str], separator: str | None = None, places: Sequence[int] | None = None
) -> Array | None:
    """The numbers of rows, of all columns or some; None where one is not finite, or no number."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = np.loadtxt(rows, delimiter=separator, comments=None, usecols=places, ndmin=2)
    except (ValueError, Warning):
        return None
    return found if np.isfinite(found).all() else None


def _all_have(rows: Sequence[str], separator: str | None, count: int) -> bool:
    """Whether every row has a number of cells."""
    letters = np.frombuffer("\n".join(["", *rows]).encode(), np.uint8)
    if separator is None:
        filled = letters > _BLANK
        cells = np.flatnonzero(filled[1:] > filled[:-1])  # the blanks before them
    else:
        cells = np.flatnonzero(letters == ord(separator))
        count -= 1
    starts = np.flatnonzero(letters == _END)
    if len(cells) != count * len(starts):
        return False
    if count == 0:
        return True
    # The first cell of each row must lie in it, and so must the last one.
    return bool(
        (cells[::count] >= starts).all() and (cells[count - 1 :: count][:-1] < starts[1:]).all()
    )
