"""Settings that a case gives: of the engines, and of the programs that run beside them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warprock.case.validation import SourceOf
from warprock.errors import InputError, did_you_mean, list_allowed
from warprock.settings.engines import SETTINGS, judged_settings

ENGINES, PEERS = "engines", "peers"
"""Tables of a case that hold settings, each of them by name."""


def read_settings(
    kind: str,
    tables: Mapping[str, Mapping[str, object]],
    name: str,
    source_of: SourceOf,
) -> Any:
    """Settings of an engine or of a program: the case's own, defaults otherwise.

    Args:
        kind: `ENGINES` or `PEERS`.
        tables: What the case gives, by name.
        name: Name of the engine or the program.
        source_of: Dotted key -> what an error about it names as its source.

    Returns:
        Its settings dataclass.

    Raises:
        InputError: Nothing has that name, or its table is wrong.
    """
    known, place = _known(kind), f"{kind}.{name}"
    if name not in known:
        allowed = f"must be one of {list_allowed(name, known)}{did_you_mean(name, known)}"
        raise InputError(source_of(place), kind, name, allowed)
    return judged_settings(known[name], place, tables.get(name, {}), source_of(place))


def _known(kind: str) -> Mapping[str, type[Any]]:
    """Settings dataclasses by name; those of programs are loaded only where a case gives some."""
    if kind == ENGINES:
        return SETTINGS
    from warprock.settings.programs import PEER_SETTINGS

    return PEER_SETTINGS
