"""Lane tables as fragility functions take them: read from a file, and judged column by column."""

from __future__ import annotations

import enum
import pathlib
import re
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.analysis.groups import RECORD
from warprock.errors import NOTHING, InputError, Said, list_allowed, written_as
from warprock.model.response import USABLE_NAMES, Outcome, Status
from warprock.model.undecided import UNDECIDED
from warprock.reading import reason, require_plain
from warprock.running.lane_table import LANE_TABLE
from warprock.units import ENDINGS

PEAK_RATIO = re.compile(r"peak_rotation_ratio(_[1-9])?$")
"""Columns of the peak rotation / slenderness angle: one, or one for each block of a stack."""

MEASURES = {"pga": "peak_acceleration_m_s2", "pgv": "peak_velocity_m_s"}
"""Columns of intensity measures by the short names that the field has for them."""

_UPLIFT_TIME = "uplift_time_s"
_MEASURED = (*ENDINGS.values(), "_ratio")
"""Ends of names of columns that hold numbers."""
_WORDS: dict[str, type[enum.IntEnum]] = {"status": Status, "outcome": Outcome}


def read_lanes(path: pathlib.Path) -> pd.DataFrame:
    """A lane table, from its Parquet file or from the folder of a run or of a sweep.

    Raises:
        InputError: There is no such file, or it cannot be read.
    """
    allowed = f"must be a Parquet file, or a folder that holds {LANE_TABLE}"
    try:
        file = path / LANE_TABLE if path.is_dir() else path
        require_plain(file)
    except OSError as error:
        raise InputError("TABLE", "", str(path), f"{allowed} ({reason(error)})") from None
    try:
        return pd.read_parquet(file)
    except OSError as error:
        allowed = f"must be a Parquet file: {reason(error).splitlines()[0]}"
    except (ValueError, TypeError, KeyError, NotImplementedError) as error:
        # What pyarrow says of a file that is none, or of columns that pandas has no place for.
        allowed = f"must be a Parquet file: {(str(error).splitlines() or [''])[0]}"
    raise InputError("TABLE", "", str(file), allowed)


def measure_named(name: str, known: Iterable[str]) -> str:
    """The column of an intensity measure as somebody writes it: PGA, pgv, Peak-acceleration-m-s2.

    Args:
        name: What was written.
        known: Columns that there are.

    Returns:
        The column; the name itself where it is none, which is refused where it is used.
    """
    column = written_as(name, known)
    return MEASURES.get(column.strip().lower(), column)


def require_lane_table(table: pd.DataFrame, source: str, intensity: str, by: Sequence[str]) -> None:
    """Refuses a table that is no lane table, and columns that it does not have.

    Args:
        table: The table.
        source: What errors name as its source.
        intensity: Column of the intensity measure, above 0 in every lane.
        by: Columns that make groups.

    Raises:
        InputError: A column is missing, or holds what no run writes there.
    """
    names = [str(name) for name in table.columns]
    numbers = [str(name) for name in table.select_dtypes("number").columns]
    for option, asked, known in (("--by", by, names), ("--im", [intensity], numbers)):
        for name in asked:
            if name not in known:
                allowed = f"must be a column of {source}: {list_allowed(name, known)}"
                raise InputError(option, "", name, allowed)
    if table.empty:
        raise InputError(source, "", Said("0 rows"), "must have at least one lane")
    for name in names:
        if names.count(name) > 1:
            raise InputError(source, name, Said("the column again"), "must be there once")
    ratios = [name for name in names if PEAK_RATIO.match(name)]
    for name in (*_WORDS, _UPLIFT_TIME, *(ratios or ["peak_rotation_ratio"])):
        if name not in names:
            raise InputError(source, name, NOTHING, "must be a column: this is no lane table")
    for name, words in _WORDS.items():
        _require_words(table[name], words, source)
    for name in {*by, RECORD} & set(names):
        _require_groups(table[name], source)
    usable = table["status"].isin(USABLE_NAMES).to_numpy()
    values = _numbers(table, intensity, source)
    allowed = "must be above 0 and finite in every lane: it is the intensity measure"
    _require(np.isfinite(values) & (values > 0.0), table, intensity, source, allowed)
    for name in ratios:
        values = _numbers(table, name, source)
        allowed = "must be a finite number from 0 up where the status says that it may be used"
        _require(~usable | (np.isfinite(values) & (values >= 0.0)), table, name, source, allowed)
    for name in names:
        if name.endswith(_MEASURED) or name == UNDECIDED:
            _numbers(table, name, source)
    values = _numbers(table, _UPLIFT_TIME, source)
    allowed = "must be a time from 0 s up, or NaN where the block never lifted"
    _require(~usable | ~(np.isinf(values) | (values < 0.0)), table, _UPLIFT_TIME, source, allowed)


def _require_words(column: pd.Series, words: type[enum.IntEnum], source: str) -> None:
    """Refuses a column that holds other words than those of a field."""
    known = [code.name.lower() for code in words]
    good = np.array([isinstance(word, str) and word in known for word in column], dtype=np.bool_)
    if not good.all():
        at = int(np.argmin(good))
        allowed = f"must be one of {', '.join(known)} (row {at})"
        raise InputError(source, str(column.name), column.iloc[at], allowed)


def _require_groups(column: pd.Series, source: str) -> None:
    """Refuses a column whose values cannot be told apart, such as lists."""
    try:
        column.nunique()
    except TypeError:
        allowed = "must hold texts or numbers, which make groups of lanes"
        raise InputError(source, str(column.name), column.iloc[0], allowed) from None


def _numbers(table: pd.DataFrame, name: str, source: str) -> npt.NDArray[np.float64]:
    """The numbers of a column."""
    if not pd.api.types.is_numeric_dtype(table[name].dtype):
        raise InputError(source, name, table[name].iloc[0], "must be a column of numbers")
    return table[name].to_numpy(dtype=np.float64, na_value=np.nan)


def _require(
    good: npt.NDArray[np.bool_], table: pd.DataFrame, name: str, source: str, allowed: str
) -> None:
    """Refuses the first row of a column that is not good."""
    if not good.all():
        at = int(np.argmin(good))
        raise InputError(source, name, float(table[name].iloc[at]), f"{allowed} (row {at})")
