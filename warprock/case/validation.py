"""What every table of a case file has: known keys only, and refusals of one line.

A table is a pydantic model; each of its fields is annotated with the `Key` that declares it.
"""

from __future__ import annotations

import contextlib
import functools
import re
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, ClassVar, Self, TypeVar

import pydantic

from warprock.errors import GIVEN, NOTHING, InputError, did_you_mean, list_allowed
from warprock.quantity import InputKey, Key
from warprock.unmodelled import unmodelled_text

SourceOf = Callable[[str], str]
"""Dotted key -> what an error about it names as its source: the case file, or -s."""

Path = tuple[str | int, ...]
"""Where a value is: names of tables and of a key, positions in lists."""


class KeyedError(ValueError):
    """An error about one key of a table.

    Attributes:
        path: The key as seen from the table: its name, or more where the value lies deeper.
        got: Its value.
        allowed: What would be allowed.
    """

    def __init__(self, path: str | int | Path, got: object, allowed: str) -> None:
        super().__init__(allowed)
        self.path = path if isinstance(path, tuple) else (path,)
        self.got, self.allowed = got, allowed

    def below(self, *outer: str | int) -> KeyedError:
        """The same error as seen from further out."""
        return type(self)((*outer, *self.path), self.got, self.allowed)


_MISSING = "must be given"


class UnknownKeyError(KeyedError):
    """A key that a table does not have: it may be why another one is missing."""


def unknown_key(name: str, got: object, known: Iterable[str]) -> UnknownKeyError:
    """The error about an unknown key: those allowed, and the one perhaps meant."""
    known = tuple(known)
    near = unmodelled_text(name) or did_you_mean(name, known)
    allowed = f"unknown key (allowed: {list_allowed(name, known)}){near}"
    return UnknownKeyError(name, got, allowed)


def _marks(metadata: Iterable[Any], annotation: Any) -> Iterator[Any]:
    """What an annotation carries behind its type; that of the items of a list may carry it."""
    yield from metadata
    for inner in typing.get_args(annotation):
        yield from _marks(getattr(inner, "__metadata__", ()), inner)


class Table(pydantic.BaseModel):
    """A table that refuses keys it does not know and names those that it lacks.

    Attributes:
        place: Its dotted name in a case file.
    """

    model_config = pydantic.ConfigDict(
        extra="forbid", frozen=True, arbitrary_types_allowed=True, defer_build=True
    )
    place: ClassVar[str] = ""

    @classmethod
    @functools.cache
    def declared(cls) -> Mapping[str, Key]:
        """Keys that hold a value, by their names in the file."""
        found = {}
        for name, field in cls.model_fields.items():
            marks = [m for m in _marks(field.metadata, field.annotation) if isinstance(m, Key)]
            if marks:
                found[field.alias or name] = marks[0]
        return found

    @classmethod
    def needs_space(cls, place: str = "") -> dict[str, str]:
        """Dotted keys that only blocks in space have a use for, and what a case with them does."""
        return {
            f"{place or cls.place}.{name}": key.needs_space
            for name, key in cls.declared().items()
            if isinstance(key, InputKey) and key.needs_space
        }

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of all keys and inner tables in the file, in the order of the fields."""
        return tuple(field.alias or name for name, field in cls.model_fields.items())

    @classmethod
    def lacking(cls, name: str, _context: Any) -> str:
        """What is said where a key or a table is missing that must be given."""
        declared = cls.declared().get(name)
        return _MISSING if declared is None else declared.allowed

    @pydantic.model_validator(mode="wrap")
    @classmethod
    def _in_its_own_words(
        cls, table: Any, handler: Callable[[Any], Self], info: pydantic.ValidationInfo
    ) -> Self:
        """Names an unknown key before all else, and says what a missing one would be."""
        if isinstance(table, Mapping):
            names = cls.names()
            for name in table:
                if name not in names:
                    raise unknown_key(name, table[name], names)
        try:
            return handler(table)
        except pydantic.ValidationError as error:
            fault = _first_fault(error)
        if len(fault.path) == 1 and fault.got is NOTHING and fault.allowed == _MISSING:
            said = cls.lacking(str(fault.path[0]), info.context)
            fault = KeyedError(fault.path, NOTHING, said)
        raise fault

    @pydantic.model_validator(mode="after")
    def _one_of_two(self) -> Self:
        for name, key in self.declared().items():
            for other in key.others if isinstance(key, InputKey) else ():
                if {name, other} <= self.model_fields_set:
                    allowed = f"must not be given beside {self.place}.{other}"
                    raise KeyedError(name, GIVEN, allowed)
        return self


Model = TypeVar("Model", bound=pydantic.BaseModel)


def validated(model: type[Model], table: object, context: Any = None) -> Model:
    """A table as its model reads it.

    Args:
        model: What it may hold.
        table: What was written.
        context: What its keys are read by, where they do not say it themselves.

    Raises:
        KeyedError: Something in it cannot be used: the first such thing, but a mistyped key before
            what is missing because of it.
    """
    try:
        return model.model_validate(table, context=context)
    except pydantic.ValidationError as error:
        fault = _first_fault(error)
    raise fault


@contextlib.contextmanager
def refusing(source_of: SourceOf, elsewhere: Iterable[str] = ()) -> Iterator[None]:
    """Turns an error about a key into the one line that a user sees.

    Args:
        source_of: What errors name as their source.
        elsewhere: Dotted keys, of which one may be meant by a key that its table does not know.

    Raises:
        InputError: Something cannot be used.
    """
    try:
        yield
    except KeyedError as fault:
        key, allowed = dotted(fault.path), fault.allowed
        if isinstance(fault, UnknownKeyError) and allowed.endswith(")"):
            allowed += did_you_mean(key, elsewhere)
        raise InputError(source_of(key), key, fault.got, allowed) from None


@contextlib.contextmanager
def below(*outer: str | int) -> Iterator[None]:
    """Errors about keys of a table become errors as seen from further out."""
    try:
        yield
    except KeyedError as fault:
        raise fault.below(*outer) from None


def dotted(path: Iterable[str | int]) -> str:
    """A path as errors show it, such as `check[0].engine`."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


_A_TABLE = "must be a table"
_SAID_PLAINLY = {
    "model_type": _A_TABLE,
    "model_attributes_type": _A_TABLE,
    "dict_type": _A_TABLE,
    "tuple_type": "must be a list",
    "string_type": "must be text",
}
"""pydantic's kind of error -> what a writer of TOML calls it."""


def _first_fault(error: pydantic.ValidationError) -> KeyedError:
    """The first thing wrong; a mistyped key before what is missing because of it."""
    faults = list(_faults(error))
    return next((f for f in faults if isinstance(f, UnknownKeyError)), faults[0])


def _faults(error: pydantic.ValidationError) -> Iterator[KeyedError]:
    for detail in error.errors(include_url=False):
        path, fault = detail["loc"], detail.get("ctx", {}).get("error")
        if isinstance(fault, KeyedError):
            yield fault.below(*path)
        elif detail["type"] == "missing":
            yield KeyedError(path, NOTHING, _MISSING)
        else:
            said = str(fault or re.sub(r"^.*? should ", "must ", detail["msg"]))
            said = _SAID_PLAINLY.get(detail["type"], said)
            if said == _A_TABLE and isinstance(detail["input"], list):
                said = f"{_A_TABLE}, whose name stands in single brackets"
            yield KeyedError(path, detail["input"], said)
