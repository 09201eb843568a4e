"""Facts about the machine and the software that ran: what `run.json` and `doctor` print."""

from __future__ import annotations

import functools
import hashlib
import importlib.resources
import os
import pathlib
import platform
from collections.abc import Iterator
from importlib.resources.abc import Traversable

import warprock
from warprock.errors import InputError

CPU_INFO = pathlib.Path("/proc/cpuinfo")
VECTOR_FLAGS = ("sse4_2", "neon", "asimd", "avx", "avx2", "fma", "avx512f", "avx512dq")
"""Instruction sets that decide how wide the packed kernels run, as Linux names them."""
MOST_WORKERS = 1024
"""Worker threads: more than any machine has cores."""


def cpu_name() -> str:
    """Model name of the processor, as far as the system tells."""
    return _cpu_info("model name") or platform.processor() or platform.machine()


def cpu_vector_flags() -> list[str]:
    """Vector instruction sets of the processor; empty where the system does not list them."""
    present = set((_cpu_info("flags") or _cpu_info("Features")).split())
    return [flag for flag in VECTOR_FLAGS if flag in present]


def core_count() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def require_workers(workers: int | None) -> None:
    """Refuses a number of worker threads that is out of bounds.

    Raises:
        InputError: It is.
    """
    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise InputError("--workers", "", workers, f"must be at least 1 and at most {MOST_WORKERS}")


def package_versions(names: tuple[str, ...]) -> dict[str, str | None]:
    """Versions of Python, warprock and installed distributions; None for one that is missing."""
    import importlib.metadata

    found: dict[str, str | None] = {
        "python": platform.python_version(),
        "warprock": warprock.__version__,
    }
    for name in names:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = None
    return found


@functools.cache
def kernel_hash() -> str:
    """SHA-256 over the paths and the sources of all kernel files, as a process first finds them."""
    digest = hashlib.sha256()
    sources = dict(_sources(importlib.resources.files("warprock.kernels"), ""))
    for path in sorted(sources):
        digest.update(path.encode() + b"\0" + sources[path] + b"\0")
    return digest.hexdigest()


def _sources(folder: Traversable, path: str) -> Iterator[tuple[str, bytes]]:
    """Path and content of every Python file in a folder and below it."""
    for entry in folder.iterdir():
        if entry.is_dir():
            yield from _sources(entry, f"{path}{entry.name}/")
        elif entry.name.endswith(".py"):
            yield f"{path}{entry.name}", entry.read_bytes()


def _cpu_info(key: str) -> str:
    try:
        lines = CPU_INFO.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return ""
    for line in lines:
        name, _, value = line.partition(":")
        if name.strip() == key:
            return value.strip()
    return ""
