"""Who calls a function: in Python errors name arguments, on the command line its options."""

from __future__ import annotations

import contextlib
import contextvars
import dataclasses
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from warprock.errors import InputError

if TYPE_CHECKING:
    from warprock.running.engine_choice import EngineChoice

_ARGUMENTS = {
    "-s": "overrides",
    "--from": "from_",
    "--output": "folder",
    "--history": "lane",
    "--step": "steps",
}
"""Options whose arguments have other names."""

_PLACES = ("CASE", "TABLE", "MESH", "HISTORY")
"""What the command line has in a place of its own, not behind an option."""

_OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*[a-z]")


@dataclasses.dataclass
class Call:
    """A call of a function by the command of its name.

    Attributes:
        choice: The engine that the function took, and why; None before it took one.
    """

    choice: EngineChoice | None = None


_CALL: contextvars.ContextVar[Call | None] = contextvars.ContextVar("call", default=None)


@contextlib.contextmanager
def called_by_command() -> Iterator[Call]:
    """A function that is called in the block speaks of options, and tells which engine it took."""
    call = Call()
    token = _CALL.set(call)
    try:
        yield call
    finally:
        _CALL.reset(token)


def calling_command() -> Call | None:
    """The call of a command that runs now; None in Python."""
    return _CALL.get()


@contextlib.contextmanager
def python_names() -> Iterator[None]:
    """Errors about options become errors about arguments, unless a command calls.

    Raises:
        InputError: Something cannot be used.
    """
    if calling_command() is not None:
        yield
        return
    try:
        yield
    except InputError as error:
        source = error.source.lower() if error.source in _PLACES else _named(error.source)
        allowed = _OPTION.sub(lambda found: _named(found[0]), error.allowed)
        raise InputError(source, error.key, error.got, allowed) from None


def _named(option: str) -> str:
    """The argument of an option; what is no option stays."""
    if option in _ARGUMENTS or not option.startswith("--"):
        return _ARGUMENTS.get(option, option)
    return option.removeprefix("--").replace("-", "_")
