"""What this machine offers, and what is missing."""

from __future__ import annotations

import collections
import contextlib
import importlib
import os
import pathlib
import re
from typing import Any

import warp as wp

from warprock.engines import ENGINES, engine_class
from warprock.errors import InputError
from warprock.running import machine
from warprock.running.devices import start_warp

PACKAGES = (
    "warp-lang",
    "newton",
    "numpy",
    "scipy",
    "pandas",
    "matplotlib",
    "pyarrow",
    "pydantic",
    "click",
    "rich",
)

MODULE = re.compile(r"^wp_warprock\.kernels\.")
"""How the folder of a built kernel begins, in the cache that Warp keeps."""

EARLIER = "earlier versions"
"""Kernels of files that are not there any more."""


def examine() -> dict[str, Any]:
    """Versions, processor, Warp devices, kernel cache, engines, and what is missing.

    Returns:
        Ready for JSON; `missing` holds one sentence for each thing to mend, `notes` one for
        each thing that only costs speed.
    """
    versions = machine.package_versions(PACKAGES)
    flags = machine.cpu_vector_flags()
    trouble = []
    try:
        devices, cache = _warp_state()
    except InputError as error:
        devices = []
        cache = {"folder": str(error.got), "writable": False, "built_modules": 0}
        cache |= {"built_by_engine": {}, "bytes": 0}
        trouble.append(str(error))
    engines = {name: _engine_trouble(name) for name in ENGINES}
    missing = [f"package {name} is not installed" for name, found in versions.items() if not found]
    missing += _load_trouble()
    missing += [f"engine {name} does not load: {why}" for name, why in engines.items() if why]
    missing += trouble
    if not (trouble or cache["writable"]):
        missing.append(
            "the kernel cache cannot be written to: kernels that it lacks cannot be built; name "
            "another folder with WARP_CACHE_PATH"
        )
    return {
        "versions": versions,
        "cpu": machine.cpu_name(),
        "cores": machine.core_count(),
        "vector_flags": flags,
        "devices": devices,
        "kernel_cache": cache,
        "kernel_sha256": machine.kernel_hash(),
        "engines": {name: why or "ready" for name, why in engines.items()},
        "missing": missing,
        "notes": _notes(flags, devices, cache),
    }


def _warp_state() -> tuple[list[dict[str, Any]], dict[str, Any]]:
    start_warp()
    devices = [
        {"device": str(device.alias), "name": str(device.name), "cuda": bool(device.is_cuda)}
        for device in wp.get_devices()
    ]
    folder = pathlib.Path(str(wp.config.kernel_cache_dir))
    modules = [entry for entry in folder.iterdir() if MODULE.match(entry.name)]
    cache = {
        "folder": str(folder),
        "writable": os.access(folder, os.W_OK),
        "built_modules": len(modules),
        "built_by_engine": _by_engine(modules),
        "bytes": sum(_size(entry) for entry in modules),
    }
    return devices, cache


def _size(entry: pathlib.Path) -> int:
    """Bytes in a folder, which another process may be about to rename."""
    with contextlib.suppress(OSError):
        return sum(file.stat().st_size for file in os.scandir(entry))
    return 0


def _by_engine(modules: list[pathlib.Path]) -> dict[str, int]:
    """How many kernels are built of each engine, and under names that none of them has now."""
    found = collections.Counter[str]()
    for entry in modules:
        name = MODULE.sub("", entry.name).partition(".")[0].removesuffix("_space")
        engine = name.replace("_", "-")
        found[engine if engine in ENGINES else EARLIER] += 1
    return {name: found[name] for name in (*ENGINES, EARLIER) if found[name]}


def _load_trouble() -> list[str]:
    """Packages that are installed and do not load: pyarrow from 26 on with a NumPy before 2."""
    try:
        importlib.import_module("pyarrow")
    except ImportError as error:
        return [f"package pyarrow does not load: {error}"]
    return []


def _engine_trouble(name: str) -> str | None:
    try:
        engine_class(name)
    except (ImportError, AttributeError) as error:
        return str(error)
    return None


def _notes(flags: list[str], devices: list[dict[str, Any]], cache: dict[str, Any]) -> list[str]:
    notes = []
    if flags and "avx512f" not in flags:
        notes.append("no AVX-512: the packed kernels run at half their width or less")
    if not any(device["cuda"] for device in devices):
        notes.append("no CUDA device: runs are on the CPU")
    if not cache["built_modules"]:
        notes.append("no kernel is built yet: the first run takes some seconds longer")
    return notes
