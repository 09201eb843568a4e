"""The kind of value that a setting of an engine or of a program is: a number with bounds.

It is written bare, in the unit that the setting has, or with a unit of the same kind: 1e-3, "1e-3
s" and "1 ms" are one time step.
"""

from __future__ import annotations

import dataclasses
import decimal
import functools
import math
import re
import sys
from collections.abc import Mapping

from warprock.quantity import Key
from warprock.units import MOST_CHARACTERS, UNITS, Dimension

_PREFIXES = {"": "1", "k": "1e3", "M": "1e6", "G": "1e9"}
"""Of a newton in a compound unit, such as MN/m^3."""

_WITH_UNIT = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\s\d.+-].*?)\s*", re.ASCII
)


@functools.cache
def unit_sizes(unit: str) -> Mapping[str, str]:
    """Units that a setting may be written in, each with its size in the setting's own.

    Args:
        unit: The setting's own unit: one of SI, or made of several, such as "N/m^3".
    """
    if unit == "1/s":
        return {unit: "1", **UNITS[Dimension.FREQUENCY]}
    if unit.startswith("N"):
        return {prefix + unit: size for prefix, size in _PREFIXES.items()}
    for sizes in UNITS.values():
        if sizes.get(unit) == "1":
            return sizes
    return {} if unit == "-" else {unit: "1"}


@dataclasses.dataclass(frozen=True)
class SettingKey(Key):
    """A key whose value is a number, bare in the unit that the key has or with a unit.

    It is whole where its bounds are.

    Attributes:
        low: The least that it may be.
        high: The most that it may be; may be infinite, which its values may not.
        of: The unit.
        low_open: Whether the least value itself is excluded.
    """

    low: float | int
    high: float | int
    of: str = "-"
    _: dataclasses.KW_ONLY
    low_open: bool = False

    @property
    def unit(self) -> str:
        """Its unit."""
        return self.of

    @property
    def whole(self) -> bool:
        """Whether it must be a whole number."""
        return isinstance(self.low, int)

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        unit = "" if self.of == "-" else f" {self.of}"
        return f"must be {self._range('from ')}{unit}"

    @property
    def bounds_text(self) -> str:
        """Both ends."""
        return f"{'whole number, ' * self.whole}{self._range('')}"

    def _range(self, closed: str) -> str:
        """Both ends in words; with `closed` in front where neither is excluded."""
        low, high = f"{self.low:g}", f"{self.high:g}"
        if self.high < math.inf and not self.low_open:
            return f"{closed}{low} to {high}"
        least = f"{'more than' if self.low_open else 'at least'} {low}"
        return least if self.high == math.inf else f"{least} and at most {high}"

    def value(self, got: object) -> float | int:
        """The number, in the unit of the key."""
        got = self._without_unit(got)
        if isinstance(got, bool) or not isinstance(got, int if self.whole else (int, float)):
            raise ValueError(f"{self.allowed}, a {'whole ' * self.whole}number")
        inside = self.low <= got <= min(self.high, sys.float_info.max)
        if not inside or (self.low_open and got == self.low):
            raise ValueError(self.allowed)
        return int(got) if self.whole else float(got)

    def _without_unit(self, got: object) -> object:
        """What was written, as a bare number where it is one with a unit."""
        found = None
        if isinstance(got, str) and len(got) <= MOST_CHARACTERS:
            found = _WITH_UNIT.fullmatch(got)
        if found is None:
            return got
        sizes = unit_sizes(self.of)
        if found[2] not in sizes:
            known = f", in {', '.join(sizes)}" if sizes else ", without a unit"
            raise ValueError(f"{self.allowed}{known}")
        try:
            return float(decimal.Decimal(found[1]) * decimal.Decimal(sizes[found[2]]))
        except decimal.DecimalException:
            return math.nan
