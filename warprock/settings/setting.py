"""The kind of value that a setting of an engine or of a program is: a bare number with bounds."""

from __future__ import annotations

import dataclasses
import math
import sys

from warprock.quantity import Key


@dataclasses.dataclass(frozen=True)
class SettingKey(Key):
    """A key whose value is a bare number in a unit that the key has; whole where its bounds are.

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
        """The number."""
        if isinstance(got, bool) or not isinstance(got, int if self.whole else (int, float)):
            raise ValueError(f"{self.allowed}, a {'whole ' * self.whole}number")
        inside = self.low <= got <= min(self.high, sys.float_info.max)
        if not inside or (self.low_open and got == self.low):
            raise ValueError(self.allowed)
        return int(got) if self.whole else float(got)
