"""Engines and programs with settings of their own: `event@time_step=1e-3` beside `event`.

So one comparison can hold the same engine with several steps against the one named first.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection

from warprock.case.case import Case
from warprock.case.settings import ENGINES, PEERS
from warprock.errors import NOTHING, InputError, list_allowed
from warprock.settings.engines import SETTINGS, judged_settings
from warprock.settings.programs import PEER_SETTINGS

OPTION = "--engine"
_MARK = "@"


def plain_name(asked: str) -> str:
    """Name of the engine or program, without its settings."""
    return asked.partition(_MARK)[0]


def require_known(asked: Collection[str], known: Collection[str]) -> None:
    """Refuses unknown names, and none.

    Args:
        asked: Names, with settings or without.
        known: Those that there are.

    Raises:
        InputError: One is not known, or there is none.
    """
    if not asked:
        allowed = f"must be given, once for each that is compared: {', '.join(known)}"
        raise InputError(OPTION, "", NOTHING, allowed)
    for each in asked:
        if plain_name(each) not in known:
            raise InputError(OPTION, "", each, f"allowed: {list_allowed(plain_name(each), known)}")


def case_asked(case: Case, asked: str) -> Case:
    """The case with the settings that come behind the name of an engine or a program.

    Args:
        case: The case, whose other settings stay.
        asked: A known name, or `NAME@SETTING=VALUE,SETTING=VALUE`, values in the settings' units.

    Raises:
        InputError: Not of that form, an unknown setting, or a value out of its bounds.
    """
    name, mark, text = asked.partition(_MARK)
    if not mark:
        return case
    kind = PEERS if name in PEER_SETTINGS else ENGINES
    known = (PEER_SETTINGS if kind == PEERS else SETTINGS).get(name)
    if known is None:
        raise InputError(OPTION, "", asked, f"must be {name} alone: it has no settings")
    given: dict[str, int | float | str] = {}
    for part in text.split(","):
        key, value = _setting(asked, part)
        if key in given:
            raise InputError(OPTION, key, part, f"must be given once in {asked}")
        given[key] = value
    judged_settings(known, name, given, OPTION)
    tables = getattr(case.tables, kind)
    changed = {**tables, name: {**tables.get(name, {}), **given}}
    return dataclasses.replace(case, tables=case.tables.model_copy(update={kind: changed}))


def _setting(asked: str, part: str) -> tuple[str, int | float | str]:
    """Name and value of one setting, which may have a unit."""
    key, _, text = (each.strip() for each in part.partition("="))
    for kind in (int, float):
        try:
            return key, kind(text)
        except ValueError:
            continue
    if text[:1].isdigit():
        return key, text
    allowed = f"must be NAME{_MARK}SETTING=NUMBER, such as event{_MARK}time_step=1e-3"
    raise InputError(OPTION, "", asked, allowed)
