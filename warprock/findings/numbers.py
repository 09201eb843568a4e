"""Numbers as a reader wants them: three digits, with a unit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

Item = TypeVar("Item")

MISSING = "-"
_NO_VALUE = ("<NA>", "NaT")
"""What pandas' missing values are as text; to ask pandas itself would import it for `keys`."""

_MOST_DIGITS = 6
"""Digits behind the point that anyone reads."""


def three(value: Any) -> str:
    """A number with three digits; counts and words as they are, a dash where there is nothing.

    >>> three(0.12345), three(123456), three(1299790.0), three(3.2e-7), three(float("nan"))
    ('0.123', '123,456', '1.30e6', '3.20e-7', '-')
    """
    if value is None:
        return MISSING
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (int, np.integer)):
        return f"{value:,}"
    if isinstance(value, (float, np.floating)):
        return _three(float(value))
    text = str(value)
    return MISSING if text in _NO_VALUE else text


def _three(value: float) -> str:
    if math.isnan(value):
        return MISSING
    if math.isinf(value):
        return "infinite" if value > 0 else "-infinite"
    size = abs(value)
    if value == round(value) and size < 1e4:
        return f"{value:.0f}"
    if 1e-3 <= size < 9.995e4:
        digits = max(0, 2 - math.floor(math.log10(size) + 1e-9))
        return f"{value:,.{digits}f}"
    mantissa, exponent = f"{value:.2e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def about(ratio: float | None) -> str:
    """A ratio of two costs to one digit, or two after a leading 1: times are no better known."""
    if ratio is None or not math.isfinite(ratio) or ratio <= 0.0:
        return "-"
    leading = math.floor(math.log10(ratio))
    digits = 1 - leading if ratio < 1.95 * 10.0**leading else -leading
    return f"{round(ratio, digits):,.{max(digits, 0)}f}"


def with_error(value: float, error: float) -> str:
    """A value and its standard error, two digits of that; a value without one alone.

    >>> with_error(0.91176, 0.00042), with_error(0.911764706, 1.6e-9), with_error(0.25, 0.0)
    ('0.91176 ± 0.00042', '0.911765 ± 1.6e-9', '0.250')
    """
    if not error > 0.0:
        return three(value)
    digits = max(0, 1 - math.floor(math.log10(error)))
    if digits <= _MOST_DIGITS:
        return f"{value:.{digits}f} ± {error:.{digits}f}"
    mantissa, exponent = f"{error:.1e}".split("e")
    return f"{value:.{_MOST_DIGITS}f} ± {mantissa}e{int(exponent)}"


def counted(count: int, thing: str, plural: str = "") -> str:
    """A count and what is counted.

    >>> counted(1, "lane"), counted(2000, "lane")
    ('1 lane', '2,000 lanes')
    """
    return f"{count:,} {thing if count == 1 else plural or thing + 's'}"


def even_selection(items: Sequence[Item], most: int) -> list[Item]:
    """At most so many of some items, the first and the last among them, evenly apart.

    >>> even_selection("abcdefg", 4)
    ['a', 'c', 'e', 'g']
    """
    last = len(items) - 1
    places = np.unique(np.linspace(0, last, min(most, last + 1)).astype(int))
    return [items[place] for place in places]


def listed(texts: list[str]) -> str:
    """Texts in one sentence.

    >>> listed(["a"]), listed(["a", "b", "c"])
    ('a', 'a, b and c')
    """
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"
