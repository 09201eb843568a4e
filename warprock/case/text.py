"""The text of a case: where it is found, how it becomes tables, and what overrides change in it."""

from __future__ import annotations

import contextlib
import importlib.resources
import pathlib
import re
import tomllib
from collections.abc import Iterator, Mapping
from importlib.resources.abc import Traversable
from typing import Any, NamedTuple

from warprock.errors import InputError, Said, did_you_mean, list_allowed
from warprock.reading import read_bytes, reason
from warprock.unmodelled import unmodelled_text

CASE_FILE = "case.toml"
OVERRIDE = "-s"
"""What errors name as the source of an override."""
MOST_DEPTH = 16
"""Tables and lists inside one another, at most; no case needs half as many."""
MOST_CASE_BYTES = 2**26
"""Bytes of a case file: a sweep that lists some million values."""

_KEY_PART = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*"""
_LONG_KEY = re.compile(
    rf"(?:^|[{{,])[ \t]*(?:\[{{1,2}}[ \t]*)?(?:{_KEY_PART}){{{MOST_DEPTH}}}", re.MULTILINE
)
"""A dotted key of so many parts that it would take long to be read."""

_TOO_DEEP = f"must have at most {MOST_DEPTH} tables or lists inside one another"


class CaseText(NamedTuple):
    """A case as it was found.

    Attributes:
        name: Name of the shipped case, or of the folder (or file) it was read from.
        file: The case file, as errors name it.
        folder: Folder that relative paths in the case start from; None for a shipped case.
        text: What the file holds.
    """

    name: str
    file: str
    folder: pathlib.Path | None
    text: str


def case_names() -> list[str]:
    """Names of the shipped cases, sorted.

    Example:
        >>> import warprock as wr
        >>> wr.case_names()[:3]
        ['cube-tosses', 'fragility-fema-p695', 'fragility-five-blocks']
    """
    return sorted(entry.name for entry in _shipped_cases().iterdir() if _is_shipped(entry.name))


def _is_shipped(name: str) -> bool:
    """Whether a shipped case has this name, which may be any text that a user gave."""
    is_name = bool(name) and pathlib.PurePath(name).name == name and "\0" not in name
    # A name that is too long for a file system is an error there.
    with contextlib.suppress(OSError):
        return is_name and _shipped_cases().joinpath(name, CASE_FILE).is_file()
    return False


def data_folder(name: str, folder: pathlib.Path | None) -> pathlib.Path | None:
    """Folder of the tables that belong to a case: its own, also where it is a shipped one.

    Args:
        name: Name of the case.
        folder: Its folder; None for a shipped case, and for one that has no file.
    """
    if folder is None and _is_shipped(name):
        return pathlib.Path(str(_shipped_cases().joinpath(name)))
    return folder


def template_kinds() -> list[str]:
    """Kinds of commented case files that `template_text` knows, sorted."""
    names = (entry.name for entry in _shipped_cases().joinpath("templates").iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def template_text(kind: str) -> str:
    """A commented case file to start from.

    Args:
        kind: One of `template_kinds()`.

    Raises:
        InputError: There is no such kind.
    """
    kinds = template_kinds()
    if kind not in kinds:
        raise InputError(
            "KIND", "", kind, f"must be one of {', '.join(kinds)}{did_you_mean(kind, kinds)}"
        )
    return _shipped_cases().joinpath("templates", f"{kind}.toml").read_text(encoding="utf-8")


def find_case(text: str) -> CaseText:
    """A case by the name of a shipped one, or by the path of its file or folder.

    Raises:
        InputError: There is no such case, or its file cannot be read.
    """
    if _is_shipped(text):
        file = _shipped_cases().joinpath(text, CASE_FILE)
        return CaseText(text, f"{text}/{CASE_FILE}", None, file.read_text(encoding="utf-8"))
    path = pathlib.Path(text)
    try:
        path = path / CASE_FILE if path.is_dir() else path
        content = read_bytes(path, MOST_CASE_BYTES).decode("utf-8-sig")
    except (FileNotFoundError, NotADirectoryError):
        names = case_names()
        shipped = f"a shipped case ({list_allowed(text, names)}: warprock list)"
        near = unmodelled_text(text) or did_you_mean(text, names)
        raise InputError(
            "CASE", "", text, f"must be {shipped} or the path of a case file{near}"
        ) from None
    except OSError as error:
        allowed = f"must be a case file that can be read ({reason(error)})"
        raise InputError("CASE", "", str(path), allowed) from None
    except UnicodeDecodeError as error:
        got = Said(f"byte {error.start}: not UTF-8")
        raise InputError(str(path), "", got, "must be a readable UTF-8 file") from None
    folder = path.resolve().parent
    name = folder.name if path.name == CASE_FILE else path.stem
    return CaseText(name, str(path), folder, content)


def parse_case(text: str, file: str) -> dict[str, Any]:
    """The tables of a case file as they are written.

    Raises:
        InputError: It is no TOML, or its tables and lists lie too deep inside one another.
    """
    bare = re.search(r"\r(?!\n)", text)
    if bare is not None:
        got = Said(f"a carriage return alone (character {bare.start()})")
        raise InputError(file, "", got, "must end its lines as TOML says: with LF or CRLF")
    deep = _LONG_KEY.search(text)
    if deep is not None:
        raise InputError(
            file, deep[0].strip(" \n[{,."), Said("a key of that many parts"), _TOO_DEEP
        )
    try:
        tables = tomllib.loads(text)
    except ValueError as error:
        why = str(error)
        line = re.search(r"at line (\d+)", why)
        lines = text.split("\n")
        at = int(line[1]) if line else 0
        said = lines[at - 1].strip() if 1 <= at <= len(lines) else ""
        raise InputError(file, "", said or Said("the text"), f"must be TOML: {why}") from None
    except RecursionError:
        raise InputError(file, "", Said("the text"), _TOO_DEEP) from None
    require_shallow(tables, file)
    return tables


def require_shallow(tables: Mapping[str, Any], file: str) -> None:
    """Refuses tables and lists that lie too deep inside one another to be looked through.

    Args:
        tables: What a file holds, of TOML or JSON.
        file: The file, as errors name it.

    Raises:
        InputError: They do.
    """
    level: list[tuple[str, Any]] = [("", tables)]
    for _ in range(MOST_DEPTH + 1):
        level = [
            (top or str(name), inner)
            for top, outer in level
            for name, inner in (
                outer.items() if isinstance(outer, Mapping) else ((top, each) for each in outer)
            )
            if isinstance(inner, (Mapping, list))
        ]
        if not level:
            return
    raise InputError(file, level[0][0], Said("what lies in it"), _TOO_DEEP)


def override(raw: dict[str, Any], text: str) -> str:
    """Puts one `key=value` into a case.

    Args:
        raw: The case as written; changed in place.
        text: The key and the value.

    Returns:
        The key.

    Raises:
        InputError: It is not of that form, or lies below what is no table.
    """
    key, value = read_override(text, OVERRIDE)
    put(raw, key, value, text.partition("=")[2].strip())
    return key


def read_override(text: str, option: str) -> tuple[str, Any]:
    """Key and value of one `key=value`, as a case file holds it.

    Raises:
        InputError: It is not of that form; the error names the option.
    """
    key, equals, value = (part.strip() for part in text.partition("="))
    if not (key and equals and value) or not _is_unicode(text):
        raise InputError(option, "", text, 'must be KEY=VALUE, such as block.height="5.5 m"')
    return key, _override_value(key, value)


def put(raw: dict[str, Any], key: str, value: Any, written: object) -> None:
    """Puts a value into a case; other keys that say the same thing are taken out.

    Args:
        raw: The case as written; changed in place.
        key: The dotted key.
        value: Its value, as a case file holds it.
        written: The same as the user wrote it.

    Raises:
        InputError: The key has too many parts, or lies below what is no table.
    """
    from warprock.case.keys import rivals

    *path, last = key.split(".")
    if len(path) >= MOST_DEPTH:
        raise InputError(OVERRIDE, key, written, _TOO_DEEP)
    table: Any = raw
    for name in path:
        table = table.setdefault(name, {})
        if not isinstance(table, dict):
            allowed = f"must not lie below {name}, which is not a table"
            raise InputError(OVERRIDE, key, written, allowed)
    table[last] = value
    for other in rivals(key):
        table.pop(other.rpartition(".")[2], None)


def _is_unicode(text: str) -> bool:
    """Whether text can be written as UTF-8: a shell may hand on bytes that are no text."""
    return not any("\ud800" <= character <= "\udfff" for character in text)


def _override_value(key: str, text: str) -> Any:
    """A TOML value, or the text itself where it is none, such as 5.5 m without quotes."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except RecursionError:
        raise InputError(OVERRIDE, key, text, _TOO_DEEP) from None
    except ValueError:
        return text
    if len(parsed) != 1:
        return text
    require_shallow({key: parsed["value"]}, OVERRIDE)
    return parsed["value"]


def _shipped_cases() -> Traversable:
    return importlib.resources.files("warprock.cases")


def source_name(key: str, file: str, raw: Mapping[str, Any], overridden: frozenset[str]) -> str:
    """The file, or -s where an override gave the key, a part of it, or all of its table.

    Args:
        key: Dotted key.
        file: The case file.
        raw: The case as written, with its overrides.
        overridden: Keys that these changed.
    """
    plain = re.sub(r"\[\d+\]", "", key)
    swept = plain.removeprefix("sweep.")
    if any(f"{swept}.".startswith(f"{o}.") for o in overridden):
        return OVERRIDE
    if any(f"{plain}.".startswith(f"{o}.") or o.startswith(f"{plain}.") for o in overridden):
        return OVERRIDE
    place = plain.rpartition(".")[0]
    table: Any = raw if place else None
    for name in filter(None, place.split(".")):
        table = table.get(name) if isinstance(table, Mapping) else None
    leaves = list(_leaves(table)) if isinstance(table, Mapping) else []
    if leaves:
        given = all(f"{place}.{name}" in overridden for name in leaves)
    else:
        # Its values are swept: they stand in [[sweep]].
        given = bool(place) and any(o.startswith(f"{place}.") for o in overridden)
    return OVERRIDE if given else file


def _leaves(table: Mapping[str, Any]) -> Iterator[str]:
    """Dotted keys of all values in a table and those in it."""
    for name, value in table.items():
        if isinstance(value, Mapping):
            yield from (f"{name}.{inner}" for inner in _leaves(value))
        else:
            yield name
