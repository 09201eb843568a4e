"""Python values as a case file holds them: texts, numbers, booleans, lists and tables."""

from __future__ import annotations

import enum
import os
from collections.abc import Iterable, Mapping
from typing import Any

from warprock.arguments import at_the_door
from warprock.errors import InputError
from warprock.units import ALIASES, UNITS

_LISTS = (list, tuple, range, set, frozenset)


def plain(value: Any) -> Any:
    """A value as a case file holds it.

    Arrays, series and tuples become lists, objects of this room tables, paths text. What is no such
    value stays, and the case refuses it.
    """
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items() if inner is not None}
    if hasattr(value, "tolist"):
        # Of NumPy and pandas: arrays, series, indices and single numbers.
        value = value.tolist()
    if isinstance(value, _LISTS):
        return [plain(each) for each in value]
    if isinstance(value, enum.Enum):
        return plain(value.value)
    return os.fspath(value) if isinstance(value, os.PathLike) else value


@at_the_door
def with_unit(values: Any, unit: str) -> Any:
    """Numbers with a unit, as cases want them.

    Args:
        values: A number, or numbers of any shape with one axis: a list, an array, a series.
        unit: Their unit, such as "mm", "g", "Hz" or "deg".

    Returns:
        Text such as "8 mm"; a list of them, same length, for several numbers.

    Raises:
        InputError: There is no such unit.

    Example:
        >>> import numpy as np
        >>> import warprock as wr
        >>> wr.with_unit(0.35, "g")
        '0.35 g'
        >>> wr.with_unit(np.linspace(1.0, 2.0, 3), "m")
        ['1.0 m', '1.5 m', '2.0 m']
    """
    known = [name for units in UNITS.values() for name in units if name]
    if unit not in known and unit not in ALIASES:
        raise InputError("with_unit", "unit", unit, f"must be one of {', '.join(known)}")
    found = plain(values)
    if isinstance(found, Iterable) and not isinstance(found, str):
        return [f"{each!r} {unit}" for each in found]
    return f"{found!r} {unit}"
