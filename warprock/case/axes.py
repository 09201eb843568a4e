"""Sweep axes of a case: lists, grids and zipped keys, judged value by value, not lane by lane.

Each [[sweep]] entry of a case is one axis. Keys inside an axis are zipped; axes are crossed, the
first one slowest.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.case.keys import KEYS, SWEEP_KEYS, general_key
from warprock.case.sampling import Distribution, Sample
from warprock.errors import InputError, did_you_mean, listed
from warprock.quantity import NumberKey, Said, TextKey
from warprock.units import Dimension

LABEL = "label."
"""Prefix of an axis key that names lanes and changes nothing in them."""

_LABEL_NAME = re.compile(r"[a-z][a-z0-9_]*")
_LABEL_KEY = TextKey("text that names lanes", most=100)
_GRID_KEYS = ("from", "to", "count", "spacing")
_MOST_VALUES = 100_000_000


@dataclasses.dataclass(frozen=True)
class Numbers:
    """Numeric values along an axis.

    Attributes:
        values: SI units or rad, shape [axis].
        dimension: What they all measure.
        first: The first value as it was written.
    """

    values: npt.NDArray[np.float64]
    dimension: Dimension
    first: object


@dataclasses.dataclass(frozen=True)
class Texts:
    """Text values along an axis.

    Attributes:
        values: Distinct texts in order of their first appearance.
        codes: Index into `values`, shape [axis].
    """

    values: tuple[str, ...]
    codes: npt.NDArray[np.int32]

    @property
    def first(self) -> object:
        """The first value as it was written."""
        return self.values[int(self.codes[0])]


Column = Numbers | Texts | Distribution
"""What a key of an axis has: values, or a distribution that they are drawn from."""


@dataclasses.dataclass(frozen=True)
class Axis:
    """One axis: values by dotted key, all of the same length.

    Attributes:
        columns: Values by dotted key, in the order of the case file.
        length: Values along the axis, >= 1.
        sample: What draws the values of every column, one of a list with equal chances; None
            where the columns list them.
    """

    columns: Mapping[str, Column]
    length: int
    sample: Sample | None = None

    def places(self, positions: npt.NDArray[np.intp]) -> dict[str, npt.NDArray[Any]]:
        """Where each column has its values at some positions along the axis.

        Returns:
            By key, shape [position]: an index into a list, or the probability that the value of a
            distribution is not exceeded.
        """
        if self.sample is None:
            return dict.fromkeys(self.columns, positions)
        points = self.sample.points(positions).T
        return {
            key: drawn if isinstance(column, Distribution) else _dealt(drawn, column)
            for drawn, (key, column) in zip(points, self.columns.items(), strict=True)
        }


def _dealt(drawn: npt.NDArray[np.float64], column: Numbers | Texts) -> npt.NDArray[np.intp]:
    return np.floor(drawn * len(_positions(column))).astype(np.intp)


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
    entries, sample = raw.get("sweep"), raw.get("sample", {})
    if isinstance(entries, list) and "sweep" not in fixed:
        kept = [e for e in entries if not (isinstance(e, Mapping) and fixed & axis_keys(e).keys())]
        if len(kept) < len(entries):
            raw["sweep"] = kept
    if isinstance(sample, Mapping) and "sample" not in fixed:
        over = sample.get("over")
        if isinstance(over, Mapping):
            drawn = {key: value for key, value in axis_keys(over).items() if key not in fixed}
            raw["sample"] = {**sample, "over": drawn}


def read_axes(entries: object, source: str) -> tuple[Axis, ...]:
    """The axes of a case.

    Args:
        entries: What the case holds under `sweep`.
        source: The case file, for the error text.

    Raises:
        InputError: Unknown key, a value out of bounds, an empty list or grid, zipped lists of
            different length, or a key in two axes.
    """
    if not isinstance(entries, list) or not all(isinstance(e, Mapping) for e in entries):
        raise InputError(source, "sweep", entries, "must be [[sweep]] tables")
    axes: list[Axis] = []
    seen: dict[str, int] = {}
    for number, entry in enumerate(entries):
        place = f"sweep[{number}]"
        columns: dict[str, Numbers | Texts] = {}
        for key, value in axis_keys(entry).items():
            if key in seen:
                also = f"must be in one axis only; sweep[{seen[key]}] has it too"
                raise InputError(source, f"{place}.{key}", Said("the key again"), also)
            seen[key] = number
            columns[key] = _read_column(key, value, source, f"{place}.{key}")
        axes.append(Axis(columns, _common_length(columns, source, place)))
    return tuple(axes)


def _common_length(columns: Mapping[str, Numbers | Texts], source: str, place: str) -> int:
    """Length of the zipped columns of one axis."""
    if not columns:
        raise InputError(source, place, Said("no keys"), "must list at least one key")
    lengths = {key: len(_positions(column)) for key, column in columns.items()}
    first, *rest = lengths
    for key in rest:
        if lengths[key] != lengths[first]:
            raise InputError(
                source,
                f"{place}.{key}",
                Said(f"{lengths[key]} values"),
                f"must be as many as {first} beside it, {lengths[first]} (keys of one axis are "
                f"zipped; write another [[sweep]] to cross them)",
            )
    return lengths[first]


def _positions(column: Numbers | Texts) -> npt.NDArray[np.generic]:
    return column.values if isinstance(column, Numbers) else column.codes


def _read_column(key: str, value: object, source: str, place: str) -> Numbers | Texts:
    """The values of one key along its axis."""
    reader: NumberKey | TextKey
    if key.startswith(LABEL):
        if not _LABEL_NAME.fullmatch(key.removeprefix(LABEL)):
            raise InputError(
                source, place, key, "must be label.NAME, a name of lower case letters, digits, _"
            )
        reader = _LABEL_KEY
    elif general_key(key) in SWEEP_KEYS:
        reader = KEYS[general_key(key)]
    elif key in KEYS:
        raise InputError(source, place, value, "must not be swept: it is the same for every lane")
    else:
        near = did_you_mean(key, SWEEP_KEYS)
        raise InputError(
            source, place, key, f"must be label.NAME or one of {listed(key, SWEEP_KEYS)}{near}"
        )
    return read_values(reader, value, source, place)


def read_values(
    reader: NumberKey | TextKey, value: object, source: str, place: str
) -> Numbers | Texts:
    """The values of a list or of a grid; arguments and errors as in `read_list`."""
    if isinstance(value, Mapping) and isinstance(reader, NumberKey):
        return _read_grid(reader, value, source, place)
    if not isinstance(value, list):
        grid = "" if isinstance(reader, TextKey) else " or a grid { from, to, count, spacing }"
        raise InputError(source, place, value, f"must be a list{grid}")
    return read_list(reader, value, source, place)


def read_list(
    reader: NumberKey | TextKey, value: Sequence[object], source: str, place: str
) -> Numbers | Texts:
    """The values of a list.

    Args:
        reader: Their key.
        value: The list.
        source: The case file, for the error text.
        place: Where in it the list is, for the error text.

    Raises:
        InputError: An empty list, a value out of bounds, or values of several dimensions.
    """
    if not value:
        raise InputError(source, place, value, "must be a list of at least one value")
    if isinstance(reader, TextKey):
        texts = [_read(reader, got, source, f"{place}[{i}]") for i, got in enumerate(value)]
        distinct = {text: code for code, text in enumerate(dict.fromkeys(texts))}
        codes = np.fromiter((distinct[text] for text in texts), np.int32, len(texts))
        return Texts(tuple(distinct), codes)
    return _read_numbers(reader, value, source, place)


def _read(reader: TextKey, got: object, source: str, place: str) -> str:
    try:
        return reader.read(got)
    except ValueError as error:
        raise InputError(source, place, got, str(error)) from None


def _read_numbers(reader: NumberKey, value: Sequence[object], source: str, place: str) -> Numbers:
    """A list of quantities, all of one dimension."""
    numbers = np.empty(len(value))
    dimension: Dimension | None = None
    for index, got in enumerate(value):
        try:
            quantity = reader.read(got)
        except ValueError as error:
            raise InputError(source, f"{place}[{index}]", got, str(error)) from None
        dimension = dimension or quantity.dimension
        if quantity.dimension is not dimension:
            raise InputError(
                source, f"{place}[{index}]", got, f"must be of the kind of the first, {dimension}"
            )
        numbers[index] = quantity.value
    assert dimension is not None
    return Numbers(numbers, dimension, value[0])


def _read_grid(reader: NumberKey, grid: Mapping[str, object], source: str, place: str) -> Numbers:
    """A grid from a first to a last value, evenly or logarithmically spaced."""
    for name in grid:
        if name not in _GRID_KEYS:
            raise InputError(
                source,
                f"{place}.{name}",
                grid[name],
                f"unknown key (allowed: {', '.join(_GRID_KEYS)}){did_you_mean(name, _GRID_KEYS)}",
            )
    count = grid.get("count", Said("nothing"))
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= _MOST_VALUES:
        raise InputError(
            source, f"{place}.count", count, f"must be a whole number from 1 to {_MOST_VALUES}"
        )
    spacing = grid.get("spacing", "linear")
    if spacing not in ("linear", "log"):
        raise InputError(source, f"{place}.spacing", spacing, "must be linear or log")
    ends = []
    for name in ("from", "to"):
        got = grid.get(name, Said("nothing"))
        try:
            ends.append(reader.read(got))
        except ValueError as error:
            raise InputError(source, f"{place}.{name}", got, str(error)) from None
    low, high = ends
    if low.dimension is not high.dimension:
        raise InputError(
            source, f"{place}.to", grid["to"], f"must be of the kind of from, {low.dimension}"
        )
    if spacing == "log":
        if not (low.value > 0.0 and high.value > 0.0):
            raise InputError(
                source, f"{place}.from", grid["from"], "must be > 0, as to, for spacing log"
            )
        values = np.geomspace(low.value, high.value, count)
    else:
        values = np.linspace(low.value, high.value, count)
    return Numbers(values, low.dimension, grid["from"])


def crossed_labels(axes: Sequence[Axis], taken: AbstractSet[int], source: str) -> tuple[str, ...]:
    """Labels of every combination along some axes, first axis slowest; one text without any.

    Args:
        axes: All axes of a case.
        taken: Numbers of those that are left out.
        source: The case file, for the error text.

    Raises:
        InputError: One of the axes has no label to name its values by.
    """
    texts = [""]
    for number, axis in enumerate(axes):
        if number in taken:
            continue
        labels = [
            column
            for key, column in axis.columns.items()
            if key.startswith(LABEL) and isinstance(column, Texts)
        ]
        if not labels:
            allowed = "must have a label.NAME: each of its values is a panel of the figure"
            raise InputError(source, f"sweep[{number}]", Said("no label"), allowed)
        names = [
            ", ".join(label.values[label.codes[at]] for label in labels)
            for at in range(axis.length)
        ]
        texts = [", ".join(filter(None, (text, name))) for text in texts for name in names]
    return tuple(texts)


def axis_shape(axes: Sequence[Axis]) -> tuple[int, ...]:
    """Lengths of the axes, first one slowest; one lane has no axes."""
    return tuple(axis.length for axis in axes)


def lane_indices(shape: Sequence[int], lanes: range) -> list[npt.NDArray[np.intp]]:
    """Position along every axis of some lanes: the digits of a lane's number in mixed radix.

    Args:
        shape: Lengths of the axes, first one slowest.
        lanes: Lane numbers, each from 0 to the product of the lengths less one.

    Returns:
        One array a axis, shape [lane].

    Raises:
        ValueError: A lane number outside the grid.
    """
    total = math.prod(shape)
    if lanes and (min(lanes) < 0 or max(lanes) >= total):
        raise ValueError(f"lanes: got {lanes}, must lie in 0 to {total - 1}")
    left = np.arange(lanes.start, lanes.stop, lanes.step, dtype=np.intp)
    digits: list[npt.NDArray[np.intp]] = []
    for length in reversed(shape):
        left, digit = np.divmod(left, length)
        digits.append(digit)
    return digits[::-1]
