"""The tables [[sweep]]: each is one axis of the case, its keys zipped.

A key of an axis lists its values, or lays a grid: `{ from = "1 m", to = "2 m", count = 5 }`. It is
any key that may be swept, or `label.NAME`, whose texts name lanes and change nothing in them. Or
an axis is the rows of a file, `table = "tests.csv"` (see `sweep_file`).

An override may sweep a key, too: as a list or a grid in TOML, or in words, "1 m, 1.5 m, 2 m" and
"0.1 g to 2 g, 20" (or "0.1 g to 2 g, 20 log").
"""

from __future__ import annotations

import dataclasses
import pathlib
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, Self, TypeVar

import numpy as np
import numpy.typing as npt
import pydantic

from warprock.case.axes import LABEL, Axis, Numbers, TableSource, Texts
from warprock.case.keys import KEYS, SWEEP_KEYS, general_key
from warprock.case.sweep_file import LEAVE_OUT, TABLE, read_table_sweep
from warprock.case.sweep_file_columns import OBSERVED
from warprock.case.validation import KeyedError, Table, below, validated
from warprock.case.value_kinds import ChoiceKey, WholeKey
from warprock.errors import InputError, Said, did_you_mean, list_allowed
from warprock.quantity import Key, NumberKey, TextKey
from warprock.units import Dimension, Quantity

if TYPE_CHECKING:
    from pydantic_core import CoreSchema

_LABEL_NAME = re.compile(r"[a-z][a-z0-9_]*")
_LABEL_KEY = TextKey("text that names lanes", most=100)
_OBSERVED_KEY = NumberKey("what was observed", "-1e30 to 1e30")
_MOST_VALUES = 100_000_000

LIST, LIST_OR_GRID = "must be a list", "must be a list or a grid { from, to, count, spacing }"

_GRID_TEXT = re.compile(
    r"(?P<first>\S.*?) to (?P<last>\S.*?) ?(?:, ?(?P<count>\d+))?(?: (?P<spacing>log|linear))?"
)
"""A grid in words, with single spaces between them."""

Value = TypeVar("Value")


class Written(NamedTuple):
    """A number as it was written, and what it means."""

    text: object
    quantity: Quantity


@dataclasses.dataclass(frozen=True)
class OwnKey(Key):
    """A value of the key that a grid or a distribution is of, within the bounds of that key."""

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        return "must be given"

    @property
    def bounds_text(self) -> str:
        """Whose bounds they are."""
        return "bounds of the key"

    @property
    def unit(self) -> str:
        """Whose unit it is."""
        return "as the key"

    def value(self, got: object) -> object:
        """What was written, which the key reads."""
        return got

    def __get_pydantic_core_schema__(
        self, _source: Any, _handler: Callable[[Any], CoreSchema]
    ) -> CoreSchema:
        """Has the key read it that is the context of the validation."""
        from pydantic_core import core_schema

        return core_schema.with_info_plain_validator_function(
            lambda got, info: Written(got, info.context.read(got))
        )


class Grid(Table):
    """Values from a first to a last one, evenly or logarithmically spaced."""

    place: ClassVar[str] = "sweep.KEY"

    first: Annotated[Written, OwnKey("the first value"), pydantic.Field(alias="from")]
    last: Annotated[Written, OwnKey("the last value"), pydantic.Field(alias="to")]
    count: Annotated[int, WholeKey("how many values", 1, _MOST_VALUES)]
    spacing: Annotated[str, ChoiceKey("how they are spaced", ("linear", "log"))] = "linear"

    @classmethod
    def lacking(cls, name: str, context: Any) -> str:
        """What is said where a key is missing that must be given."""
        own = isinstance(cls.declared()[name], OwnKey)
        return str(context.allowed) if own else super().lacking(name, context)

    @pydantic.model_validator(mode="after")
    def _ends_that_fit(self) -> Self:
        low, high = self.first.quantity, self.last.quantity
        if low.dimension is not high.dimension:
            allowed = f"must be of the kind of from, {low.dimension}"
            raise KeyedError("to", self.last.text, allowed)
        if self.spacing == "log" and not (low.value > 0.0 and high.value > 0.0):
            allowed = "must be > 0, as to, for spacing log"
            raise KeyedError("from", self.first.text, allowed)
        return self

    def numbers(self) -> Numbers:
        """Its values."""
        low, high = self.first.quantity, self.last.quantity
        spaced = np.geomspace if self.spacing == "log" else np.linspace
        values = spaced(low.value, high.value, self.count)
        return Numbers(values, low.dimension, self.first.text)


def axis_keys(entry: Mapping[str, object]) -> dict[str, object]:
    """Dotted keys of a [[sweep]] entry, whether written `a.b = ...` or `"a.b" = ...`."""
    keys: dict[str, object] = {}
    for name, value in entry.items():
        if "." not in name and isinstance(value, Mapping):
            for tail, inner in value.items():
                deeper = tail.isdecimal() or tail in ("y", "z")
                if deeper and isinstance(inner, Mapping):
                    keys.update({f"{name}.{tail}.{end}": last for end, last in inner.items()})
                else:
                    keys[f"{name}.{tail}"] = inner
        else:
            keys[name] = value
    return keys


def fix_keys(raw: dict[str, Any], fixed: AbstractSet[str]) -> None:
    """Drops from a case the axes on which keys lie that are now fixed, and draws them no more.

    Args:
        raw: The case as written; changed in place.
        fixed: The dotted keys, or "sweep" or "sample" where those tables were given anew.
    """
    entries, sample = sweep_entries(raw), raw.get("sample", {})
    if isinstance(entries, list) and "sweep" not in fixed:
        kept = [e for e in entries if not (isinstance(e, Mapping) and fixed & axis_keys(e).keys())]
        kept = [_without(e, fixed) if isinstance(e, Mapping) and TABLE in e else e for e in kept]
        if kept != entries:
            raw["sweep"] = kept
    if isinstance(sample, Mapping) and "sample" not in fixed:
        over = sample.get("over")
        if isinstance(over, Mapping):
            drawn = {key: value for key, value in axis_keys(over).items() if key not in fixed}
            raw["sample"] = {**sample, "over": drawn}


def sweep_entries(raw: Mapping[str, Any]) -> Any:
    """The [[sweep]] tables of a case as written; one [sweep] is a list of one."""
    entries = raw.get("sweep", [])
    return [entries] if isinstance(entries, Mapping) else entries


def _without(entry: Mapping[str, Any], fixed: AbstractSet[str]) -> dict[str, Any]:
    """The rows of a file without the columns of some keys, which every lane has alike."""
    keys = sorted(key for key in fixed if general_key(key) in SWEEP_KEYS)
    left = entry.get(LEAVE_OUT, [])
    return {**entry, LEAVE_OUT: [*left, *keys]} if keys and isinstance(left, list) else {**entry}


def sweep_overrides(raw: dict[str, Any], keys: Iterable[str]) -> None:
    """Makes an axis of every key to which an override gave several values.

    Args:
        raw: The case as written, overrides included; changed in place.
        keys: The dotted keys that overrides gave, in their order.

    Raises:
        KeyedError: A grid in words that has no count.
    """
    for key in dict.fromkeys(keys):
        declared = KEYS.get(general_key(key))
        if declared is None or not declared.swept:
            continue
        *path, name = key.split(".")
        table: Any = raw
        for part in path:
            table = table[part]
        if name not in table:
            continue  # a later override says the same thing otherwise
        with below(key):
            values = several_values(table[name], words=isinstance(declared, NumberKey))
        if values is not None:
            del table[name]
            raw["sweep"] = [*sweep_entries(raw), {key: values}]


def several_values(got: object, *, words: bool) -> list[object] | Mapping[str, object] | None:
    """The list or the grid that was written for a key; None where it is one value.

    Args:
        got: What was written.
        words: Whether it may be written in words: "1 m, 2 m" or "1 m to 2 m, 5".

    Raises:
        KeyedError: A grid in words that has no count.
    """
    if isinstance(got, list | Mapping):
        return got
    if not words or not isinstance(got, str):
        return None
    grid = _GRID_TEXT.fullmatch(" ".join(got.split()))
    if grid is not None:
        if grid["count"] is None:
            allowed = 'must say how many values: "FROM to TO, COUNT", such as "0.1 g to 2 g, 20"'
            raise KeyedError((), got, allowed)
        ends = {"from": grid["first"], "to": grid["last"], "count": int(grid["count"])}
        return ends | ({"spacing": grid["spacing"]} if grid["spacing"] else {})
    return [part.strip() for part in got.split(",")] if "," in got else None


def read_axes(raw: Mapping[str, Any], folder: pathlib.Path | None = None) -> tuple[Axis, ...]:
    """The axes that the [[sweep]] tables of a case make.

    Args:
        raw: The case as written.
        folder: Folder that relative paths of tables start from; the working folder where None.

    Raises:
        KeyedError: Unknown key, a value out of bounds, an empty list or grid, zipped lists of
            different length, or a key in two axes.
        InputError: A table that cannot be read, or a cell of it that cannot be used.
    """
    entries = sweep_entries(raw)
    if not isinstance(entries, list) or not all(isinstance(e, Mapping) for e in entries):
        raise KeyedError("sweep", entries, "must be [[sweep]] tables")
    axes: list[Axis] = []
    seen: dict[str, int] = {}
    for number, entry in enumerate(entries):
        with below("sweep", number):
            if TABLE in entry:
                columns, source = _table_columns(entry, folder)
            else:
                columns, source = _listed_columns(entry), None
            for key in columns:
                if key in seen:
                    also = f"must be in one axis only; sweep[{seen[key]}] has it too"
                    raise KeyedError(key, Said("the key again"), also)
                seen[key] = number
            axes.append(Axis(columns, _common_length(columns), source=source))
    return tuple(axes)


def _listed_columns(entry: Mapping[str, object]) -> dict[str, Numbers | Texts]:
    """The values that an entry lists by key."""
    columns: dict[str, Numbers | Texts] = {}
    for key, value in axis_keys(entry).items():
        with below(key):
            columns[key] = _read_column(key, value)
    return columns


def _table_columns(
    entry: Mapping[str, object], folder: pathlib.Path | None
) -> tuple[dict[str, Numbers | Texts], TableSource]:
    """The values of the rows of a file by key."""
    found = read_table_sweep(entry, folder)
    columns: dict[str, Numbers | Texts] = {}
    for key, values in found.values.items():
        try:
            columns[key] = _read_column(key, values)
        except KeyedError as error:
            column, at = found.columns[key], error.path[:1]
            place = f"{column}, row {at[0] + 1}" if at and isinstance(at[0], int) else column
            raise InputError(found.source.file, place, error.got, error.allowed) from None
    return columns, found.source


def _common_length(columns: Mapping[str, Numbers | Texts]) -> int:
    """Length of the zipped columns of one axis."""
    if not columns:
        raise KeyedError((), Said("no keys"), "must list at least one key")
    lengths = {key: column.length for key, column in columns.items()}
    first, *rest = lengths
    for key in rest:
        if lengths[key] != lengths[first]:
            allowed = (
                f"must be as many as {first} beside it, {lengths[first]} (keys of one axis are "
                "zipped; write another [[sweep]] to cross them)"
            )
            raise KeyedError(
                key, Said("1 value" if lengths[key] == 1 else f"{lengths[key]} values"), allowed
            )
    return lengths[first]


def _read_column(key: str, value: object) -> Numbers | Texts:
    """The values of one key along its axis."""
    if key.startswith(LABEL):
        if not _LABEL_NAME.fullmatch(key.removeprefix(LABEL)):
            allowed = "must be label.NAME, a name of lower case letters, digits, _"
            raise KeyedError((), key, allowed)
        numbers = key.startswith(OBSERVED) and isinstance(value, list) and not _has_text(value)
        return read_values(_OBSERVED_KEY if numbers else _LABEL_KEY, value)
    if general_key(key) in SWEEP_KEYS:
        return read_values(KEYS[general_key(key)], value)
    if key in KEYS:
        raise KeyedError((), value, "must not be swept: it is the same for every lane")
    near = did_you_mean(key, SWEEP_KEYS)
    raise KeyedError((), key, f"must be label.NAME or one of {list_allowed(key, SWEEP_KEYS)}{near}")


def _has_text(values: Sequence[object]) -> bool:
    return any(isinstance(value, str) for value in values)


def read_values(declared: NumberKey | TextKey, value: object) -> Numbers | Texts:
    """The values of a list or of a grid; arguments and errors as in `read_list`."""
    if isinstance(value, Mapping) and isinstance(declared, NumberKey):
        return validated(Grid, value, declared).numbers()
    if not isinstance(value, list):
        raise KeyedError((), value, LIST_OR_GRID if isinstance(declared, NumberKey) else LIST)
    return read_list(declared, value)


def read_list(declared: NumberKey | TextKey, value: Sequence[object]) -> Numbers | Texts:
    """The values of a list.

    Args:
        declared: What each value may be.
        value: The list.

    Raises:
        KeyedError: An empty list, a value out of bounds, or values of several dimensions.
    """
    if not value:
        raise KeyedError((), value, "must be a list of at least one value")
    if isinstance(declared, TextKey):
        texts = [_read(index, declared.read, got) for index, got in enumerate(value)]
        distinct = {text: code for code, text in enumerate(dict.fromkeys(texts))}
        codes = np.fromiter((distinct[text] for text in texts), np.int32, len(texts))
        return Texts(tuple(distinct), codes)
    numbers: npt.NDArray[np.float64] = np.empty(len(value))
    dimension: Dimension | None = None
    for index, got in enumerate(value):
        quantity = _read(index, declared.read, got)
        dimension = dimension or quantity.dimension
        if quantity.dimension is not dimension:
            raise KeyedError(index, got, f"must be of the kind of the first, {dimension}")
        numbers[index] = quantity.value
    assert dimension is not None
    return Numbers(numbers, dimension, value[0])


def _read(index: int, read: Callable[[object], Value], got: object) -> Value:
    try:
        return read(got)
    except ValueError as error:
        raise KeyedError(index, got, str(error)) from None
