"""What the readers of strong-motion files share: lines with their numbers, and channels."""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
from collections.abc import Iterator, Sequence
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from warprock.errors import NOTHING, InputError, Said
from warprock.model.motion import Control

Array = npt.NDArray[np.float64]

NETWORK_GRAVITY = 9.80665
"""What a strong-motion network means by g [m/s^2]: the standard acceleration of gravity."""

SHOWN = 60
"""Characters of a line that an error quotes."""


@dataclasses.dataclass(frozen=True, eq=False)
class Channel:
    """One motion of a file.

    Attributes:
        label: What the file calls its direction, such as "90 Deg" or "N-S".
        quantity: What the samples are.
        interval: Time between samples [s].
        samples: [m/s^2, m/s or m], shape [sample].
        source: Event, station and direction, as the file has them.
        processing: What the network did, and how its unit was read.
        name: Name that the file gives the motion; empty if none.
        licence: As the file says; empty if it says nothing.
        original_sha256: Hash of the file that this one was made from, as it says.
    """

    label: str
    quantity: Control
    interval: float
    samples: Array
    source: str
    processing: str
    name: str = ""
    licence: str = ""
    original_sha256: str = ""


@dataclasses.dataclass(frozen=True)
class TextFile:
    """The lines of a file, which errors count from 1.

    Attributes:
        file: Its path.
        lines: Without their ends.
    """

    file: str
    lines: Sequence[str]

    def refusal(self, at: int, expected: str, got: str | Said | None = None) -> InputError:
        """An error that quotes a line.

        Args:
            at: Index of the line, from 0.
            expected: What it must be; begins with "must".
            got: What was found, if not the whole line.
        """
        if got is None:
            inside = at < len(self.lines)
            got = self.lines[at].strip()[:SHOWN] if inside else Said("the end of the file")
        return InputError(self.file, f"line {at + 1}", got or NOTHING, expected)

    def match(self, at: int, pattern: str, expected: str) -> re.Match[str]:
        """The match of a pattern somewhere in a line, letter case ignored.

        Raises:
            InputError: The line has no such thing.
        """
        line = self.lines[at] if at < len(self.lines) else ""
        found = re.search(pattern, line, re.IGNORECASE)
        if found is None:
            raise self.refusal(at, expected)
        return found

    def number(self, at: int, text: str, expected: str = "must be finite numbers") -> float:
        """A finite number that stands in a line.

        Raises:
            InputError: It is none.
        """
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.refusal(at, expected, text.strip()[:SHOWN] or NOTHING)
        return value

    def positive(self, at: int, text: str, allowed: str) -> float:
        """A number above zero that stands in a line.

        Raises:
            InputError: It is not above zero.
        """
        value = self.number(at, text, allowed)
        if value <= 0.0:
            raise self.refusal(at, allowed, text.strip())
        return value

    def interval(self, at: int, text: str) -> float:
        """A time between samples [s] that stands in a line."""
        return self.positive(at, text, "must have a time between samples > 0 s")

    def fixed(self, first: int, count: int, width: int, per_line: int) -> Array:
        """Numbers in fields of a fixed width, which need no blank between them.

        Args:
            first: Index of the first line.
            count: How many.
            width: Characters of a field.
            per_line: Fields of a line.

        Raises:
            InputError: A field is no number, the file ends too early, or the last line has more.
        """
        fields = self._fields(first, width, per_line)
        values = self._take(fields, first, count)
        last = first + (count - 1) // per_line
        for at, text in fields:
            if at > last or _is_no_number(text):
                break
            self._refuse_more(at, text, count)
        return values

    def require_end(self, first: int, count: int, per_line: int) -> None:
        """Refuses a line of numbers behind those of `fixed`.

        Raises:
            InputError: There is one.
        """
        at = first + -(-count // per_line)
        words = self.lines[at].split() if at < len(self.lines) else []
        if words and not any(_is_no_number(word) for word in words):
            self._refuse_more(at, words[0], count)

    def free(self, first: int, count: int) -> Array:
        """Numbers with blanks between them, or stuck together by a sign.

        Args:
            first: Index of the first line.
            count: How many.

        Raises:
            InputError: One is no number, the file ends too early, or has more of them.
        """
        words = self._words(first)
        values = self._take(words, first, count)
        for at, word in words:
            self._refuse_more(at, word, count)
        return values

    def _refuse_more(self, at: int, text: str, count: int) -> NoReturn:
        expected = f"must not follow the {count} samples of the header"
        raise self.refusal(at, expected, text.strip()[:SHOWN])

    def _fields(self, first: int, width: int, per_line: int) -> Iterator[tuple[int, str]]:
        for at in range(first, len(self.lines)):
            line = self.lines[at].rstrip()
            for column in range(0, min(len(line), width * per_line), width):
                yield at, line[column : column + width]

    def _words(self, first: int) -> Iterator[tuple[int, str]]:
        for at in range(first, len(self.lines)):
            for word in _STUCK.sub(r"\1 ", self.lines[at]).split():
                yield at, word

    def _take(self, fields: Iterator[tuple[int, str]], first: int, count: int) -> Array:
        values: list[float] = []
        for at, text in itertools.islice(fields, count):
            values.append(self.number(at, text))
        if len(values) < max(count, 2):
            got = Said(f"{len(values)} samples")
            allowed = f"must be followed by the {count} samples of its header, at least 2"
            raise self.refusal(max(first - 1, 0), allowed, got)
        return np.array(values)


def _is_no_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return True
    return False


_STUCK = re.compile(r"(\d)(?=-\.?\d)")
"""The end of a number that the sign of the next one follows at once; an exponent has its letter."""
