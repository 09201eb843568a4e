"""The [ensemble] table of a case: every cell of its sweep many times over, its inputs a little off.

A cell is one combination of the sweep. Each of its members moves the inputs named under `spread` by
a part of their half-width, uniform over -1 to 1, and may run with a longer or shorter time step.
All cells use the same sample (common random numbers), so that cells differ by their own inputs.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Self

import numpy as np
import numpy.typing as npt
import pydantic

from warprock.case.axes import Axis, Numbers
from warprock.case.case_file import CaseFile
from warprock.case.keys import DRAWN_KEYS, KEYS, general_key
from warprock.case.sampling import SAMPLING, SEED, Sample
from warprock.case.sweep import axis_keys
from warprock.case.validation import KeyedError, Table, below, unknown_key, validated
from warprock.case.value_kinds import OtherKey, WholeKey
from warprock.errors import NOTHING
from warprock.quantity import FrictionKey, Key, NumberKey
from warprock.units import Dimension, Quantity, allowed_text, format_quantity, parse_any

Array = npt.NDArray[np.float64]

STEP_GROUPS = 8
"""Time steps that the members of an ensemble are dealt to."""

CELL_COLUMNS = ("cell", "members", "usable", "overturned", "overturned_low", "overturned_high")
"""Columns of the cell table that no label may hide."""

_MOST_MEMBERS = 10_000_000
_PERCENT = re.compile(r"\s*(\d+\.?\d*|\.\d+)(?:[eE]([+-]?\d+))?\s*%\s*", re.ASCII)


@dataclasses.dataclass(frozen=True)
class Spread:
    """Half-width of a uniform distribution about the value that a cell has.

    Attributes:
        half_width: In the SI unit of the key or rad; as a part of the value where `relative`.
        relative: Whether it is a part of the value; a cell whose value is 0 keeps it.
    """

    half_width: float
    relative: bool

    def of(self, values: Array) -> Array:
        """Half-widths about some values, same shape and unit."""
        return self.half_width * (np.abs(values) if self.relative else np.ones_like(values))


@dataclasses.dataclass(frozen=True)
class Ensemble:
    """What a case says about the members of its cells.

    Attributes:
        members: Lanes in a cell, >= 2.
        seed: Seed of the sample.
        sampling: One of the choices of `sampling.SAMPLING`.
        time_step: Half-width of the factor on an engine's time step; 0 leaves it alone.
        spread: Half-width by dotted key, in the order of the case.
    """

    members: int
    seed: int
    sampling: str
    time_step: float
    spread: Mapping[str, Spread]

    def points(self, members: npt.NDArray[np.intp]) -> Array:
        """Where some members lie, from 0 to 1, shape [lane, dimension].

        One dimension a spread key, and the last one for the time step where that is spread.

        Args:
            members: Number of every lane in its cell, shape [lane].
        """
        dimensions = len(self.spread) + (self.time_step > 0.0)
        return Sample(self.sampling, self.seed, self.members, dimensions).points(members)

    def moved(self, key: str, values: Array, points: Array) -> Array:
        """Values of a key with the members' part of its spread added.

        Args:
            key: A key of `spread`.
            values: Values that the cells have, shape [lane].
            points: Where the lanes' members lie, as `points` says.
        """
        at = points[:, list(self.spread).index(key)]
        return np.asarray(values + self.spread[key].of(values) * (2.0 * at - 1.0))

    def step_factors(self, members: npt.NDArray[np.intp]) -> Array | None:
        """Factor on the time step of every lane, shape [lane]; None where it is left alone.

        The range is cut into `STEP_GROUPS` equal parts; a lane takes the middle of its own part.
        """
        if self.time_step == 0.0:
            return None
        part = np.floor(STEP_GROUPS * self.points(members)[:, -1])
        return np.asarray(1.0 + self.time_step * ((2.0 * part + 1.0) / STEP_GROUPS - 1.0))


def _percent(got: object) -> float | None:
    """A percentage as a part of one; None where the value is none."""
    match = _PERCENT.fullmatch(got) if isinstance(got, str) else None
    return float(f"{match[1]}e{int(match[2] or 0) - 2}") if match else None


@dataclasses.dataclass(frozen=True)
class PercentKey(Key):
    """A key whose value is a percentage of something, more than none and less than all of it."""

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        return f'must be {self.bounds_text}, such as "10 %"'

    @property
    def bounds_text(self) -> str:
        """Both ends."""
        return "more than 0 % and less than 100 % of the time step"

    def value(self, got: object) -> float:
        """The part of one."""
        part = _percent(got)
        if part is None or not 0.0 < part < 1.0:
            raise ValueError(self.allowed)
        return part


def _read_spread(table: object) -> dict[str, object]:
    """Keys and half-widths as they were written."""
    if not isinstance(table, Mapping):
        raise KeyedError((), table, "must be a table of keys and half-widths")
    found = axis_keys(table)
    for key, got in found.items():
        if general_key(key) not in _SPREAD_KEYS:
            raise unknown_key(key, got, _SPREAD_KEYS)
    return found


_SPREAD_KEYS = [key for key in DRAWN_KEYS if isinstance(KEYS[key], NumberKey)]


class EnsembleTable(Table):
    """How many members a cell has, and what they differ by."""

    place: ClassVar[str] = "ensemble"

    members: Annotated[int, WholeKey("lanes in a cell of the sweep", 2, _MOST_MEMBERS)]
    seed: Annotated[int, SEED] = 1
    sampling: Annotated[str, SAMPLING] = "sobol"
    time_step: Annotated[
        float, PercentKey("the half-width of the factor on the time step of the engine")
    ] = 0.0
    spread: Annotated[
        dict[str, Any],
        OtherKey(
            'the half-width about the value of the cell, with a unit or as "5 %" of it',
            "table of numeric keys that may be swept",
            _read_spread,
        ),
    ] = pydantic.Field(default_factory=dict)

    @pydantic.model_validator(mode="after")
    def _something_varies(self) -> Self:
        if not (self.spread or self.time_step):
            allowed = "must name at least one key, where ensemble.time_step is not given"
            raise KeyedError("spread", NOTHING, allowed)
        return self


def read_ensemble(
    raw: Mapping[str, object], axes: Sequence[Axis], tables: CaseFile
) -> Ensemble | None:
    """The ensemble of a case; None where it has none.

    Args:
        raw: The case.
        axes: Its sweep.
        tables: Its other tables.

    Raises:
        KeyedError: Unknown key, a number out of bounds, a spread of a key that is no number, that
            the case does not give, or that would leave its bounds, or nothing that varies.
    """
    if "ensemble" not in raw:
        return None
    with below("ensemble"):
        table = validated(EnsembleTable, raw["ensemble"])
        with below("spread"):
            spread = dict(_half_widths(table.spread, axes, tables))
    return Ensemble(table.members, table.seed, table.sampling, table.time_step, spread)


def _half_widths(
    table: Mapping[str, object], axes: Sequence[Axis], tables: CaseFile
) -> Iterator[tuple[str, Spread]]:
    """Keys and half-widths, each held against every value that a cell may have."""
    columns = {key: column for axis in axes for key, column in axis.columns.items()}
    for key, got in table.items():
        declared = KEYS[general_key(key)]
        assert isinstance(declared, NumberKey)
        column, constant = columns.get(key), tables.constant(key)
        table_name, _, name = key.rpartition(".")
        if table_name == "motion" and tables.motion and not tables.motion.takes(name):
            allowed = f"must not be given with waveform {tables.motion.waveform}"
            raise KeyedError(key, got, allowed)
        if isinstance(column, Numbers):
            values, dimension = column.values, column.dimension
        elif isinstance(constant, Quantity):
            values, dimension = np.array([constant.value]), constant.dimension
        elif isinstance(constant, float):
            # A friction angle has become a coefficient by now.
            friction = isinstance(declared, FrictionKey)
            dimension = Dimension.DIMENSIONLESS if friction else next(iter(declared.bounds))
            values = np.array([constant])
        else:
            allowed = f"must be the spread of a key that the case gives: give {key} too"
            raise KeyedError(key, got, allowed)
        try:
            spread = _half_width(got, dimension)
            _judge(key, declared, spread, values, dimension)
        except ValueError as error:
            raise KeyedError(key, got, str(error)) from None
        yield key, spread


def _half_width(got: object, dimension: Dimension) -> Spread:
    """A half-width as it was written: a percentage, or a quantity of the key's dimension.

    Raises:
        ValueError: It is neither, or not above 0.
    """
    part = _percent(got)
    spread = Spread(part, relative=True) if part is not None else None
    if spread is None:
        try:
            spread = Spread(parse_any(got, (dimension,)).value, relative=False)
        except ValueError:
            allowed = f'must be "5 %" of the value or {allowed_text((dimension,))}'
            raise ValueError(allowed) from None
    if spread.half_width <= 0.0:
        raise ValueError("must be more than 0")
    return spread


def _judge(
    key: str, declared: NumberKey, spread: Spread, values: Array, dimension: Dimension
) -> None:
    """Refuses a spread that does nothing, or that takes a value out of the bounds of its key.

    Raises:
        ValueError: It does.
    """
    half = spread.of(values)
    if np.all(half == 0.0):
        allowed = allowed_text((dimension,))
        raise ValueError(f"must be {allowed}: {key} is 0, and a part of 0 is 0")
    for end in (float(np.min(values - half)), float(np.max(values + half))):
        try:
            declared.judge(Quantity(end, dimension))
        except ValueError as error:
            unit = "deg" if dimension is Dimension.ANGLE else None
            reached = format_quantity(end, dimension, unit)
            raise ValueError(f"must be less: {key} would reach {reached}, but {error}") from None
