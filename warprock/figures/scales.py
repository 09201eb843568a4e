"""Scales that are read at once: plain numbers at their ticks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SMALLEST, LARGEST = 1e-4, 1e5
"""Numbers between which all digits are written; others are powers of ten."""
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


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
