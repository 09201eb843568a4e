"""Drawings of assemblies by the path of their file."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import os
import pathlib
from collections.abc import Callable

from warprock.drawings import compas, dxf, obj
from warprock.drawings.outline import Drawing
from warprock.errors import InputError
from warprock.reading import read_bytes, reason

MOST_BYTES = 256 * 2**20
"""Bytes of a drawing."""

FORMATS: dict[str, Callable[[bytes, str], Drawing]] = {
    ".dxf": dxf.read,
    ".json": compas.read,
    ".obj": obj.read,
}
"""End of a file's name -> what reads blocks in the plane from it."""

SOLIDS = FORMATS | {".json": compas.read_solids, ".obj": obj.read_solids}
"""End of a file's name -> what reads blocks in space from it, or those in a plane."""


def load_drawing(
    file: str, relative_to: pathlib.Path | None = None, *, in_space: bool = False
) -> Drawing:
    """Reads a drawing.

    Args:
        file: Path of a file that ends in .dxf, .json or .obj.
        relative_to: Folder that a relative path starts from; the working folder by default.
        in_space: Whether its blocks may be bodies in space.

    Raises:
        InputError: The file is of another form or cannot be read, with the key `file`; or what is
            in it cannot be used.
    """
    path = (pathlib.Path() if relative_to is None else relative_to) / file
    if path.suffix.lower() not in FORMATS:
        allowed = f"must end in {', '.join(FORMATS)}: a drawing, blocks of COMPAS, or faces"
        raise InputError("", "file", file, allowed)
    try:
        changed = os.stat(path).st_mtime_ns
        return _load(path, changed, in_space)
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        why = reason(error) if isinstance(error, OSError) else str(error)
        raise InputError("", "file", file, f"must be a file to read ({why})") from None


@functools.lru_cache(maxsize=64)
def _load(path: pathlib.Path, _changed: int, in_space: bool) -> Drawing:
    content = read_bytes(path, MOST_BYTES)
    formats = SOLIDS if in_space else FORMATS
    found = formats[path.suffix.lower()](content, str(path))
    return dataclasses.replace(found, sha256=hashlib.sha256(content).hexdigest())
