"""Errors in the words of Python: arguments are named where the command line names its options."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from warprock.errors import InputError

_ARGUMENTS = {
    "-s": "overrides",
    "CASE": "case",
    "TABLE": "table",
    "--from": "lowest",
    "--to": "highest",
    "--im": "intensity",
    "--limit": "limits",
    "--limit-slide": "slides",
    "--max-doubt": "most_doubt",
    "--chunk": "chunk_lanes",
    "--output": "folder",
    "--history": "lane",
}
"""Options whose arguments have other names."""


@contextlib.contextmanager
def python_names() -> Iterator[None]:
    """Errors about options of the command line become errors about arguments.

    Raises:
        InputError: Something cannot be used.
    """
    try:
        yield
    except InputError as error:
        source = error.source
        if source.startswith("--"):
            source = source.removeprefix("--").replace("-", "_")
        source = _ARGUMENTS.get(error.source, source)
        raise InputError(source, error.key, error.got, error.allowed) from None
