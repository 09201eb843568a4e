"""Reads `run.json` and holds its content to declared shapes.

This file declares what every result may contain. The `Kind` of a finding declares what only its
results contain.

A file that was edited, damaged or written by another program is refused in one line. So those who
use its content need no checks of their own.
"""

from __future__ import annotations

import json
import math
import pathlib
from collections.abc import Mapping
from typing import Any

from warprock.errors import InputError, Said
from warprock.reading import read_bytes, reason
from warprock.running.refinement import (
    FIRST_STEPS,
    MET,
    MISSED,
    REFINED,
    SENSITIVE,
    TOTAL_STEPS,
    rename_counts,
)

Shape = Any
"""What a value may be: a type of `_NAMES`; a tuple of shapes, any of them; `[shape]`, a list of
them; `{...: shape}`, an object of any keys; `{"key": shape, "other?": shape}`, an object that has
`key`, may have `other`, and may have more."""

_NAMES = {str: "text", int: "a whole number", float: "a number", bool: "true or false",
          dict: "an object", list: "a list", None: "null"}  # fmt: skip
_MOST = 10**15
"""Whole numbers are counts: none is larger."""

RESOLVED = {
    "title?": str,
    "source?": str,
    "block?": {...: object},
    "sweep?": ([{"label?": {...: ([(str, float, bool)], str)}, ...: object}], {...: object}),
    "sample?": {
        "lanes?": int,
        "seed?": int,
        "sampling?": str,
        "over?": {...: object},
    },
    "ensemble?": {"members?": int, "spread?": {...: object}, ...: object},
    ...: object,
}
CASE = {
    "name": str,
    "title": str,
    "source?": (str, None),
    "file": str,
    "folder?": (str, None),
    "resolved": RESOLVED,
    "overridden?": [str],
    "tables?": [{"sweep": int, "file": str, "rows": int, "keys": [str], "labelled?": bool}],
    "drawings?": [{"file": str, "sha256": str, "blocks": int}],
}
ENGINE = {"name": str, "settings": {...: (float, str, bool, None, [(float, str)])}}
COUNTS = {...: int}
REFINEMENT = (MET, MISSED, SENSITIVE, REFINED, FIRST_STEPS, TOTAL_STEPS)
_RECORD = {"name": str, "sha256": str, "source": str, "licence": str}
COMMON: dict[Any, Shape] = {
    "case?": (CASE, str),
    "engine?": (ENGINE, str, None),
    "precision?": str,
    "device?": str,
    "versions?": {...: (str, None)},
    "kernel_sha256?": str,
    "machine?": {"cpu": str, "cores": int, "vector_flags": [str]},
    "records?": [_RECORD],
    "finished?": str,
    "lanes?": int,
    "status?": COUNTS,
    "outcome?": COUNTS,
    "estimate?": bool,
    "tolerance?": (float, None),
    "refinement?": (None, dict.fromkeys(REFINEMENT, int), {}),
    "rotation_error_rad?": (None, {"median": float, "largest": float}),
    "duration_s?": float,
    "shortest_duration_s?": float,
    "wall_time_s?": float,
    "limit_analysis?": {
        "row": int,
        "load_factor": (float, None),
        "coulomb_load_factor": (float, None),
        "upper_bound": bool,
    },
}
"""What results of any kind may say."""

OF_CASE = {"case": CASE, "engine": ENGINE, "lanes": int, "status": COUNTS, "outcome": COUNTS}
"""What an analysis says that runs the lanes of a case by one engine."""
RUN = {**OF_CASE, "precision": str, "device": str}
"""What a run says."""
ROWS = [{...: (str, float, bool, None, [object])}]


def with_band(*names: str) -> dict[str, Shape]:
    """Numbers, each with the ends of its band."""
    return {f"{name}{end}": (float, None) for name in names for end in ("", "_p05", "_p95")}


NO_SHAPES: Mapping[str, Shape] = {}


def read_facts(path: pathlib.Path, shapes: Mapping[str, Shape] = NO_SHAPES) -> dict[str, Any]:
    """What `run.json` holds.

    Args:
        path: The file.
        shapes: What results of each kind say, by the key that only they have.

    Raises:
        InputError: It cannot be read, holds no object, or is not as a command wrote it.
    """
    facts = rename_counts(read_object(path))
    kind = next((name for name in shapes if name in facts), "")
    require_shape(facts, {**COMMON, **shapes.get(kind, {})}, str(path))
    return facts


def read_object(path: pathlib.Path) -> dict[str, Any]:
    """The object in a JSON file.

    Raises:
        InputError: It cannot be read, or holds no object.
    """
    try:
        found = json.loads(read_bytes(path))
        # Half of a surrogate pair, which no file of text can hold, is no text.
        json.dumps(found, ensure_ascii=False).encode()
    except (OSError, ValueError, RecursionError) as error:
        why = reason(error) if isinstance(error, OSError) else str(error)
        raise InputError(
            str(path), "", Said("the file"), f"must be readable JSON ({why})"
        ) from None
    if not isinstance(found, dict):
        raise InputError(str(path), "", Said("the file"), "must hold a JSON object")
    return found


def require_shape(value: object, shape: Shape, source: str, key: str = "") -> None:
    """Refuses a value that is not of a shape.

    Args:
        value: What was read.
        shape: What it must be.
        source: File that holds it.
        key: Its dotted key there.

    Raises:
        InputError: It is not; the error names the first key that is wrong.
    """
    if isinstance(shape, tuple):
        fitting = [each for each in shape if _is_kind(value, each)]
        # An object without keys is one of its own kind.
        fitting.sort(key=lambda each: each != {})
        if not fitting:
            allowed = f"must be {' or '.join(dict.fromkeys(map(_name, shape)))}"
            raise InputError(source, key, value, allowed)
        require_shape(value, fitting[0], source, key)
    elif not _is_kind(value, shape):
        raise InputError(source, key, value, f"must be {_name(shape)}")
    elif isinstance(shape, list):
        assert isinstance(value, list)
        for number, each in enumerate(value):
            require_shape(each, shape[0], source, f"{key}.{number}")
    elif isinstance(shape, Mapping):
        assert isinstance(value, dict)
        _require_keys(value, shape, source, key)


def _require_keys(value: dict[str, Any], shape: Shape, source: str, key: str) -> None:
    """Refuses an object that lacks a key, or has a wrong value at one."""
    inside = f"{key}." if key else ""
    known = {name: each for name, each in shape.items() if name is not ...}
    for name, each in known.items():
        bare = name.removesuffix("?")
        if bare in value:
            require_shape(value[bare], each, source, inside + bare)
        elif bare == name:
            what = "must be there: warprock writes it"
            raise InputError(source, inside + bare, Said("nothing"), what)
    if ... in shape:
        for name in value.keys() - {name.removesuffix("?") for name in known}:
            require_shape(value[name], shape[...], source, inside + name)


def _is_kind(value: object, shape: Shape) -> bool:
    """Whether a value is of the outermost kind of a shape."""
    if shape is object:
        return True
    if shape is None:
        return value is None
    if isinstance(shape, list):
        return isinstance(value, list)
    if isinstance(shape, Mapping):
        return isinstance(value, dict) and (bool(shape) or not value)
    if shape in (int, float):
        if isinstance(value, bool) or not isinstance(value, (int, shape)):
            return False
        return math.isfinite(value) if isinstance(value, float) else abs(value) <= _MOST
    return isinstance(value, shape)


def _name(shape: Shape) -> str:
    if isinstance(shape, Mapping):
        return _NAMES[dict] if shape else "an empty object"
    return _NAMES[list] if isinstance(shape, list) else _NAMES[shape]
