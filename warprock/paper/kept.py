"""Answers of the oracle that are kept between runs: it is the slowest part of a table of the paper.

They lie beside the compiled kernels and, like these, belong to what they were made of. The name of
a file is a hash of lanes, motions and times, of the sources that make the answer from them, and of
the versions of Python, NumPy and SciPy.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import hashlib
import importlib.metadata
import importlib.resources
import pathlib
import platform
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.running.files import replacing
from warprock.running.waiting import kernel_folder

Array = npt.NDArray[np.float64]

FOLDER = "references"
"""Where they lie in the folder of the kernels."""
SOURCES = ("warprock", "warprock.oracle", "warprock.model")
"""Packages whose own files make an answer from lanes, motions and times."""
PACKAGES = ("numpy", "scipy")
"""Packages of others whose results it has."""


def kept(make: Callable[[], Array], *made_of: Any) -> Array:
    """An answer that was kept; else a new one, which is kept where the folder can be written to.

    Args:
        make: Makes the answer, one number a lane, shape [lane].
        made_of: What decides it besides the sources: dataclasses of arrays, numbers and texts.
    """
    folder = kernel_folder()
    if folder is None:
        return make()
    file = pathlib.Path(folder, FOLDER, f"{_hash(made_of)}.npy")
    # A file that cannot be read, or holds no array, is made anew.
    with contextlib.suppress(OSError, ValueError, EOFError):
        found: Array = np.load(file, allow_pickle=False)
        return found
    answer = make()
    with contextlib.suppress(OSError):
        file.parent.mkdir(exist_ok=True)
        with replacing(file) as temporary, temporary.open("wb") as stream:
            np.save(stream, answer, allow_pickle=False)
    return answer


def _hash(made_of: Any) -> str:
    digest = hashlib.sha256(platform.python_version().encode())
    for name in PACKAGES:
        digest.update(importlib.metadata.version(name).encode())
    digest.update(_sources(SOURCES))
    _add(digest, made_of)
    return digest.hexdigest()


@functools.cache
def _sources(packages: tuple[str, ...]) -> bytes:
    """A hash of the files of packages, without those of packages in them."""
    digest = hashlib.sha256()
    for package in packages:
        files = importlib.resources.files(package).iterdir()
        for file in sorted(files, key=lambda each: each.name):
            if file.name.endswith(".py"):
                digest.update(file.name.encode() + file.read_bytes())
    return digest.digest()


def _add(digest: Any, value: Any) -> None:
    """Adds a value to a hash, with its type.

    Raises:
        TypeError: It has no bytes of its own.
    """
    digest.update(f"{type(value).__name__} ".encode())
    if dataclasses.is_dataclass(value):
        value = [getattr(value, field.name) for field in dataclasses.fields(value)]
    if isinstance(value, np.ndarray) and value.dtype != object:
        digest.update(f"{value.dtype} {value.shape} ".encode() + value.tobytes())
    elif isinstance(value, list | tuple):
        for each in value:
            _add(digest, each)
    elif value is None or isinstance(value, str | int | float):
        digest.update(repr(value).encode())
    else:
        raise TypeError(f"no bytes of {type(value).__name__}")
