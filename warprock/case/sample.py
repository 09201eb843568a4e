"""The [sample] table of a case: lanes whose inputs are drawn from distributions.

A sample is one more axis of the case, the fastest: every cell of the sweep has the same sample
(common random numbers). Unlike the members of an ensemble, which lie close about what a cell is,
its lanes are drawn from all that a study covers, each a lane of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from warprock.case.axes import Axis, Column, axis_keys, read_list
from warprock.case.keys import (
    KEYS,
    SWEEP_KEYS,
    SourceOf,
    general_key,
    read_choice,
    read_table,
    read_whole,
    refuse_unknown,
)
from warprock.case.sampling import (
    END_SCORE,
    MOST_POINTS,
    MOST_SEED,
    SAMPLINGS,
    Distribution,
    Sample,
    Shape,
)
from warprock.errors import InputError, did_you_mean, listed
from warprock.quantity import NOTHING, NumberKey, Said
from warprock.units import Quantity, format_quantity

_NAMES = ("lanes", "seed", "sampling", "over")
_KEYS_OF: dict[Shape, tuple[tuple[str, ...], tuple[str, ...]]] = {
    Shape.UNIFORM: (("from", "to"), ()),
    Shape.LOGUNIFORM: (("from", "to"), ()),
    Shape.LOGNORMAL: (("median", "dispersion"), ("from", "to")),
}
"""Keys that a distribution needs, and those it may have."""
_MOST_DISPERSION = 5.0


def read_sample(
    raw: Mapping[str, Any], axes: Sequence[Axis], source_of: SourceOf
) -> tuple[Axis, ...]:
    """The axis that a case's sample makes; none without a sample.

    Args:
        raw: The case.
        axes: Its sweep.
        source_of: Dotted key -> what an error about it names as its source.

    Raises:
        InputError: An ensemble beside it, an unknown key, a number out of bounds, a key that cannot
            be drawn or is swept as well, or a distribution that leaves the bounds of its key.
    """
    if "sample" not in raw:
        return ()
    table = read_table(raw, "sample", _NAMES, source_of)
    if "ensemble" in raw:
        allowed = "must not be given beside [ensemble]: draw from wider distributions instead"
        raise InputError(source_of("sample"), "sample", Said("a table"), allowed)
    lanes = read_whole(table, "sample.lanes", (1, MOST_POINTS), source_of)
    seed = read_whole(table, "sample.seed", (0, MOST_SEED), source_of, 1)
    sampling = read_choice(table, "sample.sampling", SAMPLINGS, source_of)
    swept = {key for axis in axes for key in axis.columns}
    columns = dict(_read_over(table.get("over", {}), swept, source_of))
    if not columns:
        allowed = "must name at least one key and its distribution"
        raise InputError(source_of("sample.over"), "sample.over", NOTHING, allowed)
    sample = Sample(sampling, seed, lanes, len(columns))
    return (Axis(columns, lanes, sample),)


def _read_over(over: object, swept: set[str], source_of: SourceOf) -> Iterator[tuple[str, Column]]:
    """Keys and what each is drawn from, in the order of the case."""
    if not isinstance(over, Mapping):
        allowed = "must be a table of keys and distributions"
        raise InputError(source_of("sample.over"), "sample.over", over, allowed)
    for key, got in axis_keys(over).items():
        place = f"sample.over.{key}"
        source = source_of(place)
        if general_key(key) not in SWEEP_KEYS:
            allowed = f"unknown key (allowed: {listed(key, SWEEP_KEYS)})"
            raise InputError(source, place, got, allowed + did_you_mean(key, SWEEP_KEYS))
        if key in swept:
            raise InputError(source, place, got, "must be in [[sweep]] or in [sample], not in both")
        reader = KEYS[general_key(key)]
        if isinstance(got, list):
            yield key, read_list(reader, got, source, place)
        elif isinstance(got, Mapping) and isinstance(reader, NumberKey):
            yield key, _read_distribution(key, reader, got, place, source_of)
        else:
            one = "a distribution, { distribution, ... }, or " * isinstance(reader, NumberKey)
            raise InputError(source, place, got, f"must be {one}a list, of which each is as likely")


def _read_distribution(
    key: str, reader: NumberKey, table: Mapping[str, object], place: str, source_of: SourceOf
) -> Distribution:
    """One distribution; all of its values must lie within the bounds of its key."""
    source = source_of(place)
    name = table.get("distribution", NOTHING)
    if name not in tuple(Shape):
        allowed = f"must be one of {', '.join(Shape)}{did_you_mean(name, tuple(Shape))}"
        raise InputError(source, f"{place}.distribution", name, allowed)
    shape = Shape(str(name))
    needed, optional = _KEYS_OF[shape]
    refuse_unknown(table, place, ("distribution", *needed, *optional), source_of)
    for end in needed:
        if end not in table:
            allowed = f"must be given with distribution {shape}"
            raise InputError(source, f"{place}.{end}", NOTHING, allowed)
    read: dict[str, Quantity] = {}
    for end in (e for e in ("median", "from", "to") if e in table):
        try:
            read[end] = reader.read(table[end])
        except ValueError as error:
            raise InputError(source, f"{place}.{end}", table[end], str(error)) from None
    first = next(iter(read))
    dimension = read[first].dimension
    for end, quantity in read.items():
        if quantity.dimension is not dimension:
            allowed = f"must be of the kind of {first}, {dimension}"
            raise InputError(source, f"{place}.{end}", table[end], allowed)
        if shape is not Shape.UNIFORM and quantity.value <= 0.0:
            allowed = f"must be > 0 with distribution {shape}"
            raise InputError(source, f"{place}.{end}", table[end], allowed)
    low = read["from"].value if "from" in read else 0.0
    high = read["to"].value if "to" in read else math.inf
    if not low < high:
        raise InputError(source, f"{place}.to", table["to"], f"must be more than {table['from']}")
    if shape is not Shape.LOGNORMAL:
        return Distribution(shape, dimension, low, high, table["from"])
    found = Distribution(
        shape,
        dimension,
        low,
        high,
        table["median"],
        read["median"].value,
        _read_dispersion(table["dispersion"], source, f"{place}.dispersion"),
    )
    _judge_lognormal(key, reader, found, table, place, source)
    return found


def _read_dispersion(got: object, source: str, place: str) -> float:
    if isinstance(got, int | float) and not isinstance(got, bool) and 0 < got <= _MOST_DISPERSION:
        return float(got)
    allowed = (
        "must be a number, the standard deviation of the logarithm, more than 0 and at most "
        f"{_MOST_DISPERSION:g}"
    )
    raise InputError(source, place, got, allowed)


def _judge_lognormal(
    key: str,
    reader: NumberKey,
    found: Distribution,
    table: Mapping[str, object],
    place: str,
    source: str,
) -> None:
    """Refuses a tail that leaves the bounds of its key, and a median that is cut off."""
    if not found.low <= found.median <= found.high:
        allowed = "must lie between from and to"
        raise InputError(source, f"{place}.median", table["median"], allowed)
    reach = math.exp(END_SCORE * found.dispersion)
    for end, value in (
        ("from", max(found.low, found.median / reach)),
        ("to", min(found.high, found.median * reach)),
    ):
        try:
            reader.judge(Quantity(value, found.dimension))
        except ValueError as error:
            reached = format_quantity(value, found.dimension, None)
            allowed = f"must be given: {key} would reach {reached}, but {error}"
            raise InputError(source, f"{place}.{end}", NOTHING, allowed) from None
