"""Kinds of values that only tables of a case have: words, counts, percentages, lists and tables."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from warprock.errors import did_you_mean
from warprock.quantity import Key


@dataclasses.dataclass(frozen=True)
class ProseKey(Key):
    """A key whose value is text of any length."""

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        return "must be given"

    @property
    def bounds_text(self) -> str:
        """The least that there must be."""
        return "text"

    def value(self, got: object) -> str:
        """The text."""
        if not isinstance(got, str):
            raise ValueError("must be text")
        if not got:
            raise ValueError("must have at least 1 character")
        return got


@dataclasses.dataclass(frozen=True)
class ChoiceKey(Key):
    """A key whose value is one of a few words.

    Attributes:
        choices: The words.
    """

    choices: tuple[str, ...]

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        *first, last = self.choices
        return f"must be {', '.join(first)} or {last}"

    @property
    def bounds_text(self) -> str:
        """The words."""
        return ", ".join(self.choices)

    def value(self, got: object) -> str:
        """The word."""
        if not isinstance(got, str) or got not in self.choices:
            raise ValueError(self.allowed + did_you_mean(got, self.choices))
        return got


@dataclasses.dataclass(frozen=True)
class WholeKey(Key):
    """A key whose value is a whole number.

    Attributes:
        low: The least that it may be.
        high: The most that it may be.
    """

    low: int
    high: int

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        return f"must be a whole number from {self.low} to {self.high}"

    @property
    def bounds_text(self) -> str:
        """Both ends."""
        return f"whole number, {self.low} to {self.high}"

    def value(self, got: object) -> int:
        """The number."""
        if isinstance(got, bool) or not isinstance(got, int) or not self.low <= got <= self.high:
            raise ValueError(self.allowed)
        return got


def _as_written(got: Any) -> Any:
    return got


@dataclasses.dataclass(frozen=True)
class OtherKey(Key):
    """A key whose value is a list or a table, read by a function of its own.

    Attributes:
        holds: What it holds, in a few words.
        read: Reads it, before pydantic does; raises ValueError where it cannot be used.
        must: What is said where it is missing.
    """

    holds: str
    read: Callable[[Any], Any] = _as_written
    must: str = "must be given"

    @property
    def allowed(self) -> str:
        """What is said where it is missing."""
        return self.must

    @property
    def bounds_text(self) -> str:
        """What it holds."""
        return self.holds

    def value(self, got: object) -> Any:
        """What its function reads."""
        return self.read(got)
