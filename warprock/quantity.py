"""Kinds of values that a key may hold, each with its bounds, its unit and its meaning.

A key is declared once, as the annotation of a field:

    height: Annotated[float, NumberKey("the full height of the block", "1 mm to 1 km")]

pydantic reads the field by it, and `warprock keys`, sweeps, overrides and the lane table ask the
same object. A value is judged the same way wherever it is written: in a case file, a sweep, an
override, the header of a record. Bare numbers are in `settings/setting.py`, kinds that only tables
of a case have in `case/value_kinds.py`.
"""

from __future__ import annotations

import abc
import dataclasses
import functools
import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from warprock.errors import InputError, did_you_mean, is_plain
from warprock.units import (
    UNITS,
    Dimension,
    Quantity,
    allowed_text,
    ending,
    parse_any,
    parse_quantity,
)

if TYPE_CHECKING:
    from pydantic_core import CoreSchema


class Column(NamedTuple):
    """A column of the lane table.

    Attributes:
        name: Its name without the unit and without the number of a block in a stack.
        unit: Unit that its numbers are written in; empty in a key: the SI unit.
        text: What it holds; empty in a key: the key's meaning.
    """

    name: str
    unit: str = ""
    text: str = ""

    def named(self, number: str = "") -> str:
        """Its full name, such as `chamfer_2_mm` for the number "_2"."""
        return f"{self.name}{number}{ending(self.unit)}"


@dataclasses.dataclass(frozen=True)
class Key(abc.ABC):
    """A key and what it may hold.

    Attributes:
        text: Meaning.
    """

    text: str

    @property
    @abc.abstractmethod
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""

    @property
    @abc.abstractmethod
    def bounds_text(self) -> str:
        """Bounds or choices in a few words."""

    @property
    def unit(self) -> str:
        """What its values measure, or their unit; "-" where they have none."""
        return "-"

    @abc.abstractmethod
    def value(self, got: object) -> Any:
        """What a table holds for what was written.

        Raises:
            ValueError: It cannot be used; the message says what may be written.
        """

    def __get_pydantic_core_schema__(
        self, source: Any, handler: Callable[[Any], CoreSchema]
    ) -> CoreSchema:
        """How pydantic reads a field with this key in its annotation."""
        from pydantic_core import core_schema

        return core_schema.no_info_before_validator_function(self.value, handler(source))


@dataclasses.dataclass(frozen=True)
class InputKey(Key):
    """A key whose value a lane may have of its own.

    Attributes:
        swept: Whether it may differ from lane to lane.
        column: Column of the lane table that shows it.
        instead_of: Keys of the same table, blanks between them, that say the same thing: none of
            them may be given beside it.
        needs_space: What a case with it does that only blocks in space can do; empty for most keys.
    """

    _: dataclasses.KW_ONLY
    swept: bool = False
    column: Column | None = None
    instead_of: str = ""
    needs_space: str = ""

    @property
    def others(self) -> tuple[str, ...]:
        """The keys that may not be given beside it."""
        return tuple(self.instead_of.split())

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns that can show it, one for each thing that it may measure."""
        return () if self.column is None else (self._meaning(self.column),)

    def _meaning(self, column: Column) -> Column:
        """A column with its meaning, which is the key's own unless it is given."""
        plain = self.text.removeprefix("the ")
        return column._replace(text=column.text or plain[:1].upper() + plain[1:])


@dataclasses.dataclass(frozen=True)
class NumberKey(InputKey):
    """A key whose value is a number, mostly with a unit.

    Attributes:
        range: Least and greatest value as a user would write them: "1 mm to 1 km"; where several
            dimensions are allowed, one after the other: "0 to 100 or 0 deg to 89 deg".
        low_open: Whether the least value itself is excluded.
        high_open: Whether the greatest value itself is excluded.
    """

    range: str
    _: dataclasses.KW_ONLY
    low_open: bool = False
    high_open: bool = False

    @functools.cached_property
    def bounds(self) -> Mapping[Dimension, tuple[str, str]]:
        """Least and greatest value as a user would write them, by dimension allowed."""
        pairs = (pair.split(" to ") for pair in self.range.split(" or "))
        return {parse_any(low, Dimension).dimension: (low, high) for low, high in pairs}

    @functools.cached_property
    def _ends(self) -> Mapping[Dimension, tuple[float, float]]:
        """Least and greatest value in SI units or rad, by dimension allowed."""
        return {
            dimension: (parse_quantity(low, dimension), parse_quantity(high, dimension))
            for dimension, (low, high) in self.bounds.items()
        }

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        return f"must be {self.text}: {allowed_text(self.bounds)}"

    @property
    def bounds_text(self) -> str:
        """Both ends, in words where one is excluded."""
        if not (self.low_open or self.high_open):
            return self.range
        return " or ".join(self._between(dimension) for dimension in self.bounds)

    def _between(self, dimension: Dimension) -> str:
        """Both ends in words."""
        low, high = self.bounds[dimension]
        more = f"more than {low}" if self.low_open else f"at least {low}"
        less = f"less than {high}" if self.high_open else f"at most {high}"
        return f"{more} and {less}"

    @property
    def unit(self) -> str:
        """What it measures."""
        return " or ".join(d.replace(Dimension.DIMENSIONLESS, "number") for d in self.bounds)

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns that can show it, one for each thing that it may measure."""
        if self.column is None:
            return ()
        return tuple(self.column_of(dimension) for dimension in self.column_dimensions)

    @property
    def column_dimensions(self) -> tuple[Dimension, ...]:
        """What the numbers in its column may measure."""
        return tuple(self.bounds)

    def column_of(self, dimension: Dimension) -> Column:
        """The column that shows values of a dimension."""
        assert self.column is not None
        column = self._meaning(self.column)
        if column.unit not in UNITS[dimension]:
            column = column._replace(unit=next(iter(UNITS[dimension])))
        if len(self.column_dimensions) > 1:
            column = column._replace(text=f"{column.text}, {dimension}")
        return column._replace(unit=column.unit or "-")

    def read(self, got: object) -> Quantity:
        """The value in SI units or rad.

        Raises:
            ValueError: Not a quantity of an allowed dimension, or outside its bounds.
        """
        quantity = parse_any(got, self.bounds)
        self.judge(quantity)
        return quantity

    def judge(self, quantity: Quantity) -> None:
        """Refuses a value outside the bounds of its dimension.

        Raises:
            ValueError: It is outside.
        """
        low, high = self._ends[quantity.dimension]
        below = quantity.value < low or (self.low_open and quantity.value == low)
        above = quantity.value > high or (self.high_open and quantity.value == high)
        if below or above:
            raise ValueError(f"must be {self._between(quantity.dimension)}: {self.text}")

    def read_option(self, option: str, got: str | None) -> float | None:
        """The number of an option in SI units or rad; None where it is left out.

        Raises:
            InputError: As `read`.
        """
        if got is None:
            return None
        try:
            return self.read(got).value
        except ValueError as error:
            raise InputError(option, "", got, str(error)) from None

    def value(self, got: object) -> float | Quantity:
        """The number in SI units or rad; with its dimension where there is more than one."""
        quantity = self.read(got)
        return quantity if len(self.column_dimensions) > 1 else quantity.value


@dataclasses.dataclass(frozen=True)
class FrictionKey(NumberKey):
    """A friction coefficient, which may also be written as a friction angle."""

    @property
    def column_dimensions(self) -> tuple[Dimension, ...]:
        """A coefficient, however it was written."""
        return (Dimension.DIMENSIONLESS,)

    def read(self, got: object) -> Quantity:
        """The friction coefficient."""
        quantity = super().read(got)
        if quantity.dimension is Dimension.ANGLE:
            return Quantity(math.tan(quantity.value), Dimension.DIMENSIONLESS)
        return quantity


@dataclasses.dataclass(frozen=True)
class TextKey(InputKey):
    """A key whose value is one line of text, one of some choices if it has any.

    Attributes:
        choices: What it may be; anything where there are none.
        most: Characters that it may have.
    """

    choices: tuple[str, ...] = ()
    most: int = 300

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        return f"must be {self.text}" + (f": {', '.join(self.choices)}" if self.choices else "")

    @property
    def bounds_text(self) -> str:
        """The choices, or the most characters."""
        return ", ".join(self.choices) or f"one line of at most {self.most} characters"

    def read(self, got: object) -> str:
        """The text.

        Raises:
            ValueError: Not text, empty, or not one of the choices.
        """
        if (
            not isinstance(got, str)
            or not got.strip()
            or (self.choices and got not in self.choices)
        ):
            raise ValueError(self.allowed + did_you_mean(got, self.choices))
        if len(got) > self.most or not is_plain(got):
            raise ValueError(
                f"{self.allowed}, one line of at most {self.most} characters without control "
                "characters"
            )
        return got

    def value(self, got: object) -> str:
        """The text."""
        return self.read(got)


AMPLITUDE = NumberKey(
    "the amplitude of the waveform",
    "-100 m to 100 m or -100 m/s to 100 m/s or -1000 m/s^2 to 1000 m/s^2",
    swept=True,
    column=Column("amplitude", "mm"),
)
"""Amplitude of a ground motion, of a waveform as of a record."""
