"""Errors that a user can mend, each said in one line."""

from __future__ import annotations

import difflib
import enum
import unicodedata
from collections.abc import Iterable

MOST_LISTED, NEAREST = 8, 5
"""Names that an error lists in full; of more than those, the nearest to what was written."""
MOST_SHOWN = 160
"""Characters of a key, a value or a source that an error shows."""

_UNSHOWN = ("Cc", "Cs", "Zl", "Zp")
"""Unicode's categories of control characters, surrogates and ends of lines."""


class InputError(ValueError):
    """Input that cannot be used, said in one line: file, key, value and bound.

    The command line prints it and exits with 2 before anything runs or is written.

    Example:
        >>> import warprock as wr
        >>> try:
        ...     wr.load_case("free-b0", {"contact.friction": -1})
        ... except wr.InputError as error:
        ...     print(error.key, error.got)
        contact.friction -1
    """

    def __init__(self, source: str, key: str, got: object, allowed: str) -> None:
        """Says what is wrong.

        Args:
            source: File or option that holds the input.
            key: Dotted key inside it; may be empty.
            got: The value as the user wrote it.
            allowed: What would be allowed, with its unit.
        """
        self.source, self.key, self.got, self.allowed = source, key, got, allowed
        place = f"{shorten(source)}: {shorten(key)}" if key else shorten(source)
        super().__init__(f"{place}: got {_quote(got)}, {one_line(allowed)}")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, object, str]]:
        """Makes the error picklable, so that a worker process can hand it on."""
        return type(self), (self.source, self.key, self.got, self.allowed)


class Said(str):
    """Text that an error shows as it is, without quotes: "nothing", "3 and 2 values"."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


NOTHING = Said("nothing")
GIVEN = Said("a value")
"""What was got of a key that must not be given: its value is known in other units than it had."""


class DeclinedError(ValueError):
    """A scene that a program of others cannot do; the text is why."""


def one_line(text: str) -> str:
    """Text without line breaks and other characters that no screen shows: they are escaped."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def is_plain(text: str) -> bool:
    """Whether text is one line without control characters, which a figure or a screen cannot show.

    Half of a surrogate pair, which no file of text can hold, is none either.
    """
    return not any(unicodedata.category(character) in _UNSHOWN for character in text)


def shorten(text: str) -> str:
    """Text in one line, its middle left out where it is long."""
    text = one_line(text[: MOST_SHOWN * 10]) + text[MOST_SHOWN * 10 :]
    if len(text) <= MOST_SHOWN:
        return text
    half = (MOST_SHOWN - 5) // 2
    return f"{text[:half]} ... {one_line(text[-half:])}"


def _quote(got: object) -> str:
    """A value as it was written, shortened."""
    try:
        return shorten(repr(got.value if isinstance(got, enum.Enum) else got))
    except (RecursionError, ValueError):
        # Nested too deep, or a whole number of too many digits, to be written out.
        return f"a {type(got).__name__} that cannot be shown"


def list_allowed(got: object, known: Iterable[str]) -> str:
    """Names that are allowed: all if they are few, else those nearest to what was written."""
    names = list(dict.fromkeys(known))
    if len(names) <= MOST_LISTED:
        return ", ".join(names)
    wanted = str(got)[:MOST_SHOWN].lower()
    likeness = difflib.SequenceMatcher(b=wanted.rpartition(".")[2])

    def distance(name: str) -> float:
        likeness.set_seq1(name.rpartition(".")[2].lower())
        same_table = name.rpartition(".")[0] == wanted.rpartition(".")[0]
        return -likeness.ratio() - 0.1 * same_table

    near = sorted(names, key=distance)[:NEAREST]
    return f"{', '.join(near)} and {len(names) - len(near)} more"


def written_as(text: str, known: Iterable[str]) -> str:
    """The known name that a text is but for capitals, spaces, - and _; else the text."""
    known = tuple(known)
    if text in known:
        return text
    return next((name for name in known if _bare(name) == _bare(text)), text)


def _bare(name: str) -> str:
    """A name without what people write in different ways."""
    return "".join(letter for letter in name.casefold() if letter.isalnum())


def did_you_mean(got: object, known: Iterable[str]) -> str:
    """A suggestion for the end of an error message; empty if nothing is near.

    The last part of a dotted key counts more than the table in front of it. Where a table is there
    by itself, as `block`, keys of its numbered ones, as `block.N.friction`, are not meant.
    """
    wanted, known = str(got)[:MOST_SHOWN], list(known)
    tails: dict[str, list[str]] = {}
    for key in known:
        tails.setdefault(key.rpartition(".")[2], []).append(key)
    near = difflib.get_close_matches(wanted.rpartition(".")[2], tails, 1)
    if not near:
        return ""
    likeness = difflib.SequenceMatcher(b=wanted)

    table = wanted.partition(".")[0]
    alone = any(key.startswith(f"{table}.") and ".N." not in key for key in known)

    def alike(key: str) -> tuple[bool, float]:
        likeness.set_seq1(key)
        numbered = alone and key.startswith(f"{table}.N.")
        return not numbered, likeness.ratio()

    return f"; did you mean {max(tails[near[0]], key=alike)}?"
