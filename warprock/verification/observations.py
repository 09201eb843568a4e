"""What tests showed: a table with one row a test, and the lanes of a case that it belongs to.

    record,observed,peak_rotation_deg
    test011.csv,stood,2.1
    test012.csv,overturned,

A row names its test by any of the labels of the case, by `record`, or by `lane` (of an ensemble or
a sample, whose members are one test together, by `cell`); of several columns all must fit. Records
are told by the names of their files, with folder and ending or without. An empty outcome is a test
that nobody saw.
"""

from __future__ import annotations

import dataclasses
import pathlib
import re
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.case.case import Case
from warprock.case.lanes import LaneSet
from warprock.case.sweep_file import PARQUET, csv_texts, parquet_table
from warprock.errors import NOTHING, InputError, Said, did_you_mean, list_allowed
from warprock.reading import read_bytes, reason
from warprock.units import Dimension, allowed_text, parse_quantity

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]
Source = pathlib.Path | pd.DataFrame | None
"""Where outcomes are: a file, a table, or the labels of the case."""

OBSERVED = "observed"
"""Column of the outcome; of the labels of a case that begin with it, no test is named by one."""
OPTION = "--observed"
RECORD, LANE, CELL = "record", "lane", "cell"
TRUE = ("1", "true", "yes", "overturned", "fell", "fallen", "toppled", "overturn")
FALSE = ("0", "false", "no", "stood", "standing", "stand", "at rest", "rocking", "not overturned")
"""Words of an outcome, in any case; a _ is a blank."""
UNSEEN = ("", "nan", "na", "n/a", "none", "-")
"""Words of a test that nobody saw."""
MEASURED = {
    "peak_rotation": Dimension.ANGLE,
    "peak_slide": Dimension.LENGTH,
    "peak_displacement": Dimension.LENGTH,
}
"""What may have been measured besides, and its kind; the unit is in the heading, and of a stack
before it the number of the block: `peak_rotation_2_deg`."""

_QUANTITY = rf"(?P<what>{'|'.join(MEASURED)})(?:_(?P<block>[1-9]))?"
_HEADING = re.compile(rf"(?:observed_)?{_QUANTITY}(?:(?:_|\s*[\[(])\s*(?P<unit>\w+)\s*[\])]?)?")


@dataclasses.dataclass(frozen=True)
class ObservedTests:
    """Observed tests, each with its lanes.

    Attributes:
        names: What each test is called, shape [test].
        overturned: Whether its block overturned, shape [test].
        lanes: Numbers of its lanes, shape [test, member].
        measured: Largest rotation [rad], slide [m] and displacement [m] that were measured, each of
            shape [test]; NaN where nobody did. By the name of `MEASURED`, with the number of the
            block of a stack where one is meant.
        table: What the file says of each test, as texts, one row a test.
        unobserved: Tests of the case without an observed outcome.
        source: File or table that they are from.
    """

    names: tuple[str, ...]
    overturned: npt.NDArray[np.bool_]
    lanes: Places
    measured: dict[str, Array]
    table: pd.DataFrame
    unobserved: int
    source: str


def read_tests(
    case: Case, lane_set: LaneSet, observed: Source, column: str | None = None
) -> ObservedTests:
    """The tests of a case that somebody observed.

    Args:
        case: The case.
        lane_set: Its lanes.
        observed: CSV or Parquet file with one row a test, or the same as a table; None takes the
            labels of the case itself.
        column: Column of the outcome; None takes `observed`, or the only one that there is.

    Raises:
        InputError: A file that cannot be read, no outcome, a word that is none, a row that fits no
            test of the case or several, or two rows of one test.
    """
    tests = _tests_of(case, lane_set)
    members = lane_set.lanes.lane_count // len(tests)
    keys: list[str] = []
    if observed is None:
        table = lane_set.inputs.iloc[::members][list(lane_set.labels)]
        table, source = _texts(table), case.file
        name = _own_column(list(lane_set.labels), column, source)
        places = np.arange(len(tests), dtype=np.intp)
    else:
        table, source = _read_table(observed)
        name = column or _outcome_column(table, source)
        if name not in table:
            names = [str(each) for each in table.columns]
            allowed = f"must be a column of {source}: {list_allowed(name, names)}"
            raise InputError("--column", "", name, allowed)
        keys = [key for key in tests.columns if key in table and key != name]
        places = _join(table, tests, keys, source)
    outcome = [_outcome(text, source, name, row) for row, text in enumerate(table[name], 1)]
    seen = np.array([each is not None for each in outcome], dtype=np.bool_)
    if not seen.any():
        raise InputError(source, name, Said("no outcome"), "must say of a test whether it fell")
    shown = tests.iloc[places[seen]][keys or [*tests.columns[:-1]] or [tests.columns[-1]]]
    return ObservedTests(
        names=tuple(" ".join(row) for row in shown.itertuples(index=False)),
        overturned=np.array([each for each in outcome if each is not None], dtype=np.bool_),
        lanes=places[seen][:, None] * members + np.arange(members),
        measured={
            what: values[seen] for what, values in _read_measured(table, lane_set, source).items()
        },
        table=table[seen].reset_index(drop=True),
        unobserved=len(tests) - int(seen.sum()),
        source=source,
    )


def _tests_of(case: Case, lane_set: LaneSet) -> pd.DataFrame:
    """What names the tests of a case: labels, records, and their numbers, one row a test."""
    last = case.axes[-1] if case.axes else None
    members = case.members * (last.length if last is not None and last.sample is not None else 1)
    first = lane_set.inputs.iloc[::members].reset_index(drop=True)
    names = [name for name in lane_set.labels if not name.startswith(OBSERVED)]
    if RECORD in first and (members == 1 or _same_within(lane_set.inputs[RECORD], members)):
        names.append(RECORD)
    found = first[names].astype(str)
    found[CELL if members > 1 else LANE] = np.arange(len(first)).astype(str)
    return found


def _same_within(column: pd.Series, members: int) -> bool:
    """Whether all members of each test share a value."""
    codes = pd.factorize(column)[0].reshape(-1, members)
    return bool((codes == codes[:, :1]).all())


def _read_table(observed: pathlib.Path | pd.DataFrame) -> tuple[pd.DataFrame, str]:
    """A table of texts, empty where a cell is, and what errors call it."""
    if isinstance(observed, pd.DataFrame):
        return _require_table(_texts(observed), "observed")
    file = str(observed)
    try:
        content = read_bytes(observed)
    except OSError as error:
        allowed = f"must be a CSV or Parquet file with one row a test ({reason(error)})"
        raise InputError(OPTION, "", file, allowed) from None
    read = parquet_table if content.startswith(PARQUET) else csv_texts
    return _require_table(_texts(read(content, file)), file)


def _texts(table: pd.DataFrame) -> pd.DataFrame:
    """A table as texts."""
    return table.astype(object).where(table.notna(), "").astype(str).reset_index(drop=True)


def _require_table(texts: pd.DataFrame, source: str) -> tuple[pd.DataFrame, str]:
    """A table with rows and with columns that can be told apart."""
    texts.columns = pd.Index([str(name).strip() for name in texts.columns])
    for name in texts.columns[texts.columns.duplicated()]:
        raise InputError(source, str(name), Said("the column again"), "must be there once")
    if texts.empty:
        raise InputError(source, "", Said("0 rows"), "must have at least one row")
    return texts, source


def _own_column(labels: Sequence[str], asked: str | None, source: str) -> str:
    """The label of the outcome among those of a case."""
    own = [name for name in labels if name.startswith(OBSERVED) and not _HEADING.fullmatch(name)]
    if asked is not None:
        wanted = asked.replace(f"{OBSERVED}.", f"{OBSERVED}_")
        for name in (wanted, f"{OBSERVED}_{wanted}"):
            if name in labels:
                return name
        allowed = (
            f"must be a label of the case: {list_allowed(asked, own or labels) or 'it has none'}"
        )
        raise InputError("--column", "", asked, allowed)
    if OBSERVED in own:
        return OBSERVED
    if len(own) == 1:
        return own[0]
    if own:
        allowed = f"must say which outcome is meant: {list_allowed('', own)}"
        raise InputError("--column", "", NOTHING, allowed)
    allowed = "must say the outcomes of its tests, where no --observed FILE does"
    raise InputError(source, f"label.{OBSERVED}", NOTHING, allowed)


def _outcome_column(table: pd.DataFrame, source: str) -> str:
    """The column of the outcome, where none is named."""
    known = (OBSERVED, "overturned", "outcome")
    for name in known:
        if name in table:
            return name
    names = [str(name) for name in table.columns]
    allowed = (
        f"must be the column of the outcome (or --column NAME: {', '.join(names[:8])})"
        f"{did_you_mean(OBSERVED, names)}"
    )
    raise InputError(source, OBSERVED, NOTHING, allowed)


def _outcome(text: str, source: str, column: str, row: int) -> bool | None:
    """An outcome; None where nobody saw it."""
    word = " ".join(text.lower().replace("_", " ").split())
    if word in UNSEEN:
        return None
    if word.endswith(".0"):
        word = word[:-2]  # what a table of numbers with gaps writes for a whole number
    if word in TRUE or word in FALSE:
        return word in TRUE
    allowed = f"must be {', '.join(TRUE[:5])} or {', '.join(FALSE[:5])} (row {row})"
    raise InputError(source, column, text, allowed)


def _join(table: pd.DataFrame, tests: pd.DataFrame, keys: Sequence[str], source: str) -> Places:
    """Number of the test of every row, shape [row].

    Raises:
        InputError: No column that names tests, a row that fits none or several, or a test twice.
    """
    if not keys:
        allowed = f"must be a column: {' or '.join(tests.columns)} says which test a row is of"
        raise InputError(source, str(tests.columns[0]), NOTHING, allowed)
    pairs = [_matching(key, table[key], tests[key]) for key in keys]
    mine, theirs = ([*zip(*(pair[side] for pair in pairs), strict=True)] for side in (0, 1))
    rows_of: dict[tuple[str, ...], list[int]] = {}
    for number, name in enumerate(theirs):
        rows_of.setdefault(name, []).append(number)
    places, taken = np.empty(len(table), dtype=np.intp), dict[int, int]()
    for row, name in enumerate(mine, 1):
        key, got = ", ".join(keys), ", ".join(str(table[each].iloc[row - 1]) for each in keys)
        fits = rows_of.get(name, [])
        if len(fits) != 1:
            allowed = "must fit a lane of the case"
            if fits:
                more = " or ".join(each for each in tests.columns if each not in keys)
                allowed = f"must fit one test, not {len(fits)}: a column {more} tells them apart"
            raise InputError(source, key, got, f"{allowed} (row {row})")
        if fits[0] in taken:
            allowed = f"must be there once, and is in row {taken[fits[0]]} too (row {row})"
            raise InputError(source, key, got, allowed)
        taken[fits[0]] = row
        places[row - 1] = fits[0]
    return places


def _matching(
    key: str, wanted: pd.Series[str], known: pd.Series[str]
) -> tuple[list[str], list[str]]:
    """The values of a key in the file and in the case, written alike.

    Names of records as they are, else without their folder, else without the ending as well.
    """
    texts, names = [text.strip() for text in wanted], list(known)
    if key != RECORD:
        whole = key in (LANE, CELL)
        return [text.removesuffix(".0") if whole else text for text in texts], names
    ways: tuple[Callable[[str], str], ...] = (
        str,
        lambda text: pathlib.PurePosixPath(text).name,
        lambda text: pathlib.PurePosixPath(text).stem,
    )
    for way in ways:
        if {way(text) for text in texts} <= {way(text) for text in names}:
            return [way(text) for text in texts], [way(text) for text in names]
    return texts, names


def _read_measured(table: pd.DataFrame, lane_set: LaneSet, source: str) -> dict[str, Array]:
    """Columns whose headings name a measured quantity, in SI units; NaN where a cell is empty."""
    found: dict[str, Array] = {}
    for heading in map(str, table.columns):
        match = _HEADING.fullmatch(heading)
        if match is None:
            continue
        name = match["what"] + (f"_{match['block']}" if match["block"] else "")
        _require_quantity(match["what"], match["block"], lane_set, source, heading)
        if name in found:
            raise InputError(source, heading, Said(f"{name} again"), "must be there once")
        dimension = MEASURED[match["what"]]
        try:
            size = parse_quantity(f"1 {match['unit'] or ''}".strip(), dimension)
        except ValueError:
            allowed = f"must have the unit behind it: {name} is {allowed_text([dimension])}"
            raise InputError(source, heading, NOTHING, allowed) from None
        found[name] = _numbers(table[heading], size, source, heading)
    return found


def _require_quantity(
    what: str, block: str | None, lane_set: LaneSet, source: str, heading: str
) -> None:
    """Refuses a quantity that lanes of this kind do not have."""
    none = "peak_slide" if lane_set.scene.assembly else "peak_displacement"
    if what == none:
        known = " or ".join(each for each in MEASURED if each != none)
        whose = "an assembly" if lane_set.scene.assembly else "a case without an assembly"
        raise InputError(source, heading, Said(what), f"must be {known}, of {whose}")
    blocks = lane_set.scene.block_count
    if block is None or (lane_set.scene.stacked and int(block) <= blocks):
        return
    allowed = "must have no number of a block: the case has no stack"
    if lane_set.scene.stacked:
        allowed = f"must be from 1, the lowest block, to {blocks}"
    raise InputError(source, heading, Said(f"block {block}"), allowed)


def _numbers(column: pd.Series[str], size: float, source: str, heading: str) -> Array:
    """Numbers from 0 up, times the size of their unit; NaN where there is none."""
    values = np.full(len(column), np.nan)
    for row, text in enumerate(column):
        try:
            values[row] = size * float(text) if text.strip() else np.nan
        except ValueError:
            values[row] = -1.0
        if values[row] < 0.0 or np.isinf(values[row]):
            allowed = f"must be a number from 0 up, or nothing (row {row + 1})"
            raise InputError(source, heading, text, allowed)
    return values
