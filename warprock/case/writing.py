"""Writes a case as the text of a case file, which reads as the same case again.

Tables of a case become tables of TOML, `[block.1]` and `[motion.y]` too; keys of a sweep, a sample
or a spread are dotted, `block.height = [...]`, and a grid or a distribution stands in one line.
Order is kept wherever it numbers lanes. Comments are not part of a case.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

WIDTH = 100
"""Characters of a line, where a list can be broken."""

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_UNWRITABLE = re.compile(r"[\x00-\x08\x0b-\x1f\x7f]")
"""Characters that TOML wants escaped in text of several lines."""
_IN_ONE_LINE = ("from", "distribution")
"""Keys that tell a grid or a distribution from a table."""


def toml_text(tables: Mapping[str, Any]) -> str:
    """The text of a case file.

    Args:
        tables: What the file is to hold: texts, numbers, booleans, lists and tables, as
            `Case.raw`.

    Returns:
        TOML that `tomllib.loads` reads as an equal mapping.
    """
    return "\n".join(_table((), tables)) + "\n"


def _table(path: tuple[str, ...], table: Mapping[str, Any]) -> Iterator[str]:
    """Lines of a table: its own keys first, as TOML wants it, then the tables inside."""
    inner = {k: v for k, v in table.items() if len(path) < 2 and _is_table(v)}
    lists = {k: v for k, v in table.items() if not path and _is_list_of_tables(v)}
    own = {k: v for k, v in table.items() if k not in inner and k not in lists}
    if path and (own or not inner):
        yield from ("", f"[{_name(path)}]")
    yield from _keys((), own)
    for name, value in inner.items():
        yield from _table((*path, name), value)
    for name, values in lists.items():
        for value in values:
            yield from ("", f"[[{_name((name,))}]]")
            yield from _keys((), value)


def _keys(path: tuple[str, ...], table: Mapping[str, Any]) -> Iterator[str]:
    """Lines `a.b = value`, in the order of the table."""
    for name, value in table.items():
        place = (*path, name)
        if _is_table(value) and value:
            yield from _keys(place, value)
        else:
            head = f"{_name(place)} = "
            yield head + _value(value, len(head))


def _is_table(value: object) -> bool:
    """Whether a value is written as a table, not in one line."""
    return isinstance(value, Mapping) and not any(key in value for key in _IN_ONE_LINE)


def _is_list_of_tables(value: object) -> bool:
    return (
        isinstance(value, Sequence)
        and len(value) > 0
        and all(isinstance(each, Mapping) for each in value)
    )


def _name(path: tuple[str, ...]) -> str:
    return ".".join(each if _BARE.fullmatch(each) else _text(each) for each in path)


def _value(value: Any, column: int | None = None) -> str:
    """A value.

    Args:
        value: The value.
        column: Characters in front of it, where its lines may be broken; None keeps it in one.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        lines = column is not None and "\n" in value
        return _lines_of_text(value) if lines else _text(value)
    if isinstance(value, Mapping):
        items = ", ".join(f"{_name((k,))} = {_value(v)}" for k, v in value.items())
        return f"{{ {items} }}" if value else "{}"
    if isinstance(value, Sequence):
        parts = [_value(each) for each in value]
        line = f"[{', '.join(parts)}]"
        fits = column is None or column + len(line) <= WIDTH
        return line if fits else _break_list(parts)
    return repr(value)


def _break_list(parts: Sequence[str]) -> str:
    """A list in lines that are as long as may be."""
    lines, line = [], " "
    for part in parts:
        if len(line) + len(part) + 2 > WIDTH and line != " ":
            lines.append(line)
            line = " "
        line += f" {part},"
    return "\n".join(["[", *lines, line, "]"])


def _text(text: str) -> str:
    """Text in quotes."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _lines_of_text(text: str) -> str:
    """Text of several lines, as it reads."""
    escaped = text.replace("\\", "\\\\").replace('"""', '""\\"')
    if escaped.endswith('"'):
        escaped = escaped[:-1] + '\\"'
    escaped = _UNWRITABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", escaped)
    return f'"""\n{escaped}"""'
