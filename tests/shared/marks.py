"""Which parameters of a test the ordinary run takes."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def all_but(thorough: Collection[str], values: Iterable[str]) -> list[Any]:
    """The values as parameters: those named, and no others, for `thorough`."""
    return [
        pytest.param(value, marks=pytest.mark.thorough if value in thorough else ())
        for value in values
    ]


def first(count: int, values: Iterable[Any]) -> list[Any]:
    """The values as parameters: the first few for the ordinary run, the others for `thorough`.

    A value is what one parameter takes, or a tuple of what several take.
    """
    return [
        pytest.param(
            *(value if isinstance(value, tuple) else (value,)),
            marks=() if place < count else pytest.mark.thorough,
        )
        for place, value in enumerate(values)
    ]
