"""Arguments of the functions of `import warprock`, judged at the door by their annotations.

What is of a kind that a function does not take is refused in one line before anything runs. The
annotation is the only place that says what an argument may be.
"""

from __future__ import annotations

import collections.abc
import enum
import functools
import inspect
import numbers
import os
import re
import sys
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeVar, cast

from warprock.errors import InputError, did_you_mean

Judged = TypeVar("Judged", bound=Callable[..., Any])

_WORDS: dict[Any, str] = {
    str: "text",
    int: "a whole number",
    float: "a number",
    bool: "True or False",
    types.NoneType: "None",
    collections.abc.Mapping: "a dict",
    collections.abc.Callable: "a function",
    os.PathLike: "a path",
}
"""What errors call a kind of value; others by the name of their class."""


_ENTRY = re.compile(r"^(?=    (\w+): )(    .+\n(?:     +.+\n)*)", re.MULTILINE)
"""What a docstring says of an argument, with its name."""


def at_the_door(function: Judged) -> Judged:
    """Makes a function refuse arguments of kinds that it does not take.

    A sequence of texts is no single text; True and False are no numbers, NumPy's numbers are.
    Annotations must be names that the module has when the function is first called, or `pd` for
    pandas, which none has to load for it.

    Raises:
        InputError: By the function: an argument that does not fit its annotation.
        TypeError: By the function, as by any: an argument that it does not have, or a missing one.
    """

    @functools.wraps(function)
    def door(*args: Any, **kwargs: Any) -> Any:
        signature, hints = _read_signature(function, "pandas" in sys.modules)
        try:
            given = signature.bind(*args, **kwargs).arguments
        except TypeError as error:
            raise TypeError(_refusal(function.__name__, error, signature, kwargs)) from None
        for name, value in given.items():
            if name in hints and not _fits(value, hints[name]):
                raise InputError(name, "", value, f"must be {_describe_kinds(hints[name])}")
        return function(*args, **kwargs)

    return cast("Judged", door)


def listing(*takers: Callable[..., Any]) -> Callable[[Judged], Judged]:
    """Shows the arguments that a function takes as a record, its last parameter, one by one.

    Its signature gets them with the defaults of the functions that take them, and its docstring
    what those say of them. What it does not have is refused in its name.

    Args:
        *takers: Functions that take the arguments of the record by name.
    """

    def decorate(function: Judged) -> Judged:
        own = inspect.signature(function)
        *first, last = own.parameters.values()
        record = typing.get_args(typing.get_type_hints(function)[last.name])[0]
        names = record.__annotations__
        listed = [
            each
            for taker in takers
            for name, each in inspect.signature(taker).parameters.items()
            if name in names
        ]
        whole = own.replace(parameters=[*first, *listed])

        @functools.wraps(function)
        def shown(*args: Any, **kwargs: Any) -> Any:
            try:
                whole.bind(*args, **kwargs)
            except TypeError as error:
                raise TypeError(_refusal(function.__name__, error, whole, kwargs)) from None
            return function(*args, **kwargs)

        shown.__signature__ = whole  # type: ignore[attr-defined]
        if function.__doc__:
            said = [_ENTRY.findall(f"{inspect.getdoc(taker)}\n") for taker in takers]
            entries = "".join(text for found in said for name, text in found if name in names)
            shown.__doc__ = re.sub(
                rf"    \*\*{last.name}: .+\n(?:     +.+\n)*",
                lambda _record: entries,
                inspect.cleandoc(function.__doc__),
            )
        return cast("Judged", shown)

    return decorate


def several(given: str | float | Sequence[Any] | None) -> list[Any]:
    """The values of an argument that takes one or several."""
    if given is None:
        return []
    if isinstance(given, str | float | numbers.Real):
        return [given]
    return list(given)


class DataFrame:
    """Stands for that of pandas in a process that has not loaded it: no value there is one."""


@functools.cache
def _read_signature(
    function: Callable[..., Any], with_pandas: bool
) -> tuple[inspect.Signature, dict[str, Any]]:
    """Signature of a function, and what its named arguments may be."""
    signature = inspect.signature(function)
    rest = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    named = [name for name, each in signature.parameters.items() if each.kind not in rest]
    written = inspect.get_annotations(inspect.unwrap(function))
    of_named = {name: written[name] for name in named if name in written}
    space = inspect.unwrap(function).__globals__
    frames = sys.modules["pandas"] if with_pandas else types.SimpleNamespace(DataFrame=DataFrame)
    return signature, typing.get_type_hints(
        types.SimpleNamespace(__annotations__=of_named), globalns={"pd": frames, **space}
    )


def _refusal(
    name: str, error: TypeError, signature: inspect.Signature, given: Mapping[str, Any]
) -> str:
    """What Python says of arguments that do not fit a signature, with what is near."""
    unknown = [each for each in given if each not in signature.parameters]
    near = did_you_mean(unknown[0], signature.parameters) if unknown else ""
    return f"{name}() {error}{near}"


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value is of the kind that an annotation says."""
    if hint is Any or isinstance(hint, TypeVar):
        return True
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return any(_fits(value, each) for each in inner)
    if origin is Literal:
        return value in inner
    kind = origin or hint
    if kind is collections.abc.Sequence:
        return _is_sequence(value) and all(_fits(each, inner[0]) for each in value)
    if kind is collections.abc.Mapping:
        return isinstance(value, Mapping)
    if kind in (int, float):
        number = numbers.Integral if kind is int else numbers.Real
        return isinstance(value, number) and not isinstance(value, bool)
    if kind is collections.abc.Callable:
        return callable(value)
    return isinstance(value, type(None) if kind is None else kind)


def _is_sequence(value: Any) -> bool:
    """Whether a value is a list, or what is like one: a tuple, an array or a series."""
    if isinstance(value, str | bytes):
        return False
    return isinstance(value, Sequence) or getattr(value, "ndim", None) == 1


def _describe_kinds(hint: Any) -> str:
    """The kinds of values that an annotation allows, in words."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        words = list(dict.fromkeys(_describe_kinds(each) for each in inner))
        return " or ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]
    if origin is Literal:
        return " or ".join(repr(each) for each in inner)
    kind = origin or hint
    if kind is collections.abc.Sequence:
        return f"a list of {_many(inner[0])}"
    if kind in _WORDS:
        return _WORDS[kind]
    if kind.__name__ == "ndarray":
        return "an array"
    article = "an" if kind.__name__[0] in "AEIOU" else "a"
    if issubclass(kind, enum.Enum):
        return f"one of {', '.join(f'{kind.__name__}.{each.name}' for each in kind)}"
    return f"{article} {kind.__name__}"


def _many(hint: Any) -> str:
    """What a list holds, in words."""
    return {str: "texts", float: "numbers", int: "whole numbers"}.get(hint) or (
        "values" if hint is Any else _describe_kinds(hint)
    )


def require_within(name: str, value: float, least: float, most: float) -> None:
    """Refuses a number that is out of bounds, or none.

    Raises:
        InputError: It is.
    """
    if not least <= value <= most:
        raise InputError(name, "", value, f"must be from {least} to {most}")
