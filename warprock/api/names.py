"""Errors in the words of Python: arguments are named where the command line names its options."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator

from warprock.errors import InputError

_ARGUMENTS = {
    "-s": "overrides",
    "--from": "from_",
    "--output": "folder",
    "--history": "lane",
}
"""Options whose arguments have other names."""

_PLACES = ("CASE", "TABLE", "MESH", "HISTORY")
"""What the command line has in a place of its own, not behind an option."""

_OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*[a-z]")


@contextlib.contextmanager
def python_names() -> Iterator[None]:
    """Errors about options of the command line become errors about arguments.

    Raises:
        InputError: Something cannot be used.
    """
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
