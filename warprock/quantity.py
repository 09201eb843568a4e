"""Kinds of values that a key may hold, each with its bounds and its meaning.

A value is judged the same way wherever it is written: in a case file, a sweep, an override, the
header of a record.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

from warprock.errors import did_you_mean, is_plain
from warprock.units import Dimension, Quantity, allowed_text, parse_any, parse_quantity


class Said(str):
    """Text that an error shows as it is, without quotes: "nothing", "3 and 2 values"."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


NOTHING = Said("nothing")


@dataclasses.dataclass(frozen=True)
class NumberKey:
    """A key whose value is a number, mostly with a unit.

    Attributes:
        bounds: Least and greatest value as a user would write them, by dimension allowed.
        text: Meaning.
        low_open: Whether the least value itself is excluded.
        high_open: Whether the greatest value itself is excluded.
    """

    bounds: Mapping[Dimension, tuple[str, str]]
    text: str
    low_open: bool = False
    high_open: bool = False

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        return f"must be {self.text}: {allowed_text(self.bounds)}"

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
        low_text, high_text = self.bounds[quantity.dimension]
        low, high = (parse_quantity(t, quantity.dimension) for t in (low_text, high_text))
        below = quantity.value < low or (self.low_open and quantity.value == low)
        above = quantity.value > high or (self.high_open and quantity.value == high)
        if below or above:
            more = f"more than {low_text}" if self.low_open else f"at least {low_text}"
            less = f"less than {high_text}" if self.high_open else f"at most {high_text}"
            raise ValueError(f"must be {self.text}, {more} and {less}")

    def read_number(self, got: object) -> float:
        """The value in SI units or rad, without its dimension."""
        return self.read(got).value


@dataclasses.dataclass(frozen=True)
class FrictionKey(NumberKey):
    """A friction coefficient, which may also be written as a friction angle."""

    def read(self, got: object) -> Quantity:
        """The friction coefficient."""
        quantity = super().read(got)
        if quantity.dimension is Dimension.ANGLE:
            return Quantity(math.tan(quantity.value), Dimension.DIMENSIONLESS)
        return quantity


@dataclasses.dataclass(frozen=True)
class TextKey:
    """A key whose value is one line of text, one of some choices if it has any.

    Attributes:
        text: Meaning.
        choices: What it may be; anything where there are none.
        most: Characters that it may have.
    """

    text: str
    choices: tuple[str, ...] = ()
    most: int = 300

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        return f"must be {self.text}" + (f": {', '.join(self.choices)}" if self.choices else "")

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


AMPLITUDE = NumberKey(
    {
        Dimension.LENGTH: ("-100 m", "100 m"),
        Dimension.VELOCITY: ("-100 m/s", "100 m/s"),
        Dimension.ACCELERATION: ("-1000 m/s^2", "1000 m/s^2"),
    },
    "the amplitude of the waveform",
)
"""Amplitude of a ground motion, of a waveform as of a record."""
