"""Scales that are read at once: plain numbers at their ticks, and units as engineers say them."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np

from warprock.case.input_columns import input_meaning
from warprock.units import GRAVITY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SMALLEST, LARGEST = 1e-4, 1e5
"""Numbers between which all digits are written; others are powers of ten."""
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

_READABLE = {"m/s^2": ("g", 1.0 / GRAVITY), "rad": ("deg", 180.0 / np.pi), "m/s": ("cm/s", 100.0)}
"""Unit of a column -> unit of a figure, and how many of them it is."""
_NAMES = {
    "factor": "factor on the motion",
    "peak_acceleration_m_s2": "peak base acceleration",
    "peak_velocity_m_s": "peak base velocity",
    "normalised_acceleration": "peak base acceleration / (g tan(slenderness angle))",
    "normalised_velocity": "p x peak base velocity / (g tan(slenderness angle))",
    "scale": "factor on the record",
}
"""Columns whose meaning is too long, or no name."""


@dataclasses.dataclass(frozen=True)
class Measure:
    """A column as a figure shows it.

    Attributes:
        name: What it is.
        unit: Its unit in the figure; "-" without.
        size: Values of the figure over values of the column.
    """

    name: str
    unit: str
    size: float

    @property
    def label(self) -> str:
        """Label of its axis."""
        return f"{self.name} [{self.unit}]"

    def text(self, value: float) -> str:
        """A value of the column with three digits and its unit."""
        number = f"{value * self.size:.3g}"
        return number if self.unit == "-" else f"{number} {self.unit}"


def measure(column: str) -> Measure:
    """How a figure shows an input column of the lane table: accelerations in g, angles in deg."""
    unit, text = input_meaning(column)
    unknown = text == input_meaning("")[1]
    name = _NAMES.get(column, column if unknown else text[:1].lower() + text[1:].split(",")[0])
    unit, size = _READABLE.get(unit, (unit, 1.0))
    return Measure(name, unit or "-", size)


def plain(value: float, *, power: bool = False) -> str:
    """A number without an exponent where digits do, else as a power of ten.

    Args:
        value: The number.
        power: Whether to write a power of ten where the number is one.
    """
    if value == 0.0 or (SMALLEST <= abs(value) < LARGEST and not power):
        return f"{value:.12g}"
    mantissa, exponent = f"{value:.6e}".split("e")
    ten = f"10{str(int(exponent)).translate(_SUPERSCRIPT)}"
    digits = float(mantissa)
    return ten if digits == 1.0 else f"{digits:g} x {ten}"


def three_digits(value: float) -> str:
    """A positive number with three digits, or that it is too small to matter."""
    return f"below {SMALLEST:.4f}" if 0.0 < value < SMALLEST else f"{value:.3g}"


def logarithmic(axis: Any) -> None:
    """Makes an axis of Matplotlib logarithmic, with a few plain numbers at its ticks.

    Args:
        axis: The axis across or that up, of panels of Matplotlib.
    """
    from matplotlib.ticker import Formatter, LogLocator, MaxNLocator, NullLocator

    class FewNumbers(LogLocator):
        def tick_values(self, vmin: float, vmax: float) -> list[float]:
            decades = np.log10(vmax / vmin) if vmin > 0.0 else 0.0
            if 0.0 < decades < 0.8:
                ticks = MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]).tick_values(vmin, vmax)
                return [float(tick) for tick in ticks if vmin <= tick <= vmax]
            self.set_params(subs=(1.0, 2.0, 5.0) if decades <= 2.2 else (1.0,), numticks=8)
            return [float(tick) for tick in super().tick_values(vmin, vmax)]

    class Plain(Formatter):
        def __call__(self, x: float, pos: int | None = None) -> str:
            return plain(x)

        def format_ticks(self, values: Any) -> list[str]:
            power = any(not SMALLEST <= value < LARGEST for value in values)
            return [plain(value, power=power) for value in values]

    getattr(axis.axes, f"set_{axis.axis_name}scale")("log")
    axis.set_major_locator(FewNumbers())
    axis.set_major_formatter(Plain())
    axis.set_minor_locator(NullLocator())


def at_least(axes: Axes, span: float) -> None:
    """Widens the scale upwards where all that is drawn differs by less than a span.

    What does not move would else fill its panel with round-off.
    """
    low, high = axes.get_ylim()
    if high - low < span:
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.5 * span, middle + 0.5 * span)
