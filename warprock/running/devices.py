"""The devices that Warp can run on here."""

from __future__ import annotations

import contextlib
import errno
import functools
import hashlib
import os
import pathlib
import sys
from collections.abc import Iterator
from typing import Any

from warprock.errors import InputError
from warprock.kernels.launch.instance import FOLDER
from warprock.running.machine import cpu_vector_flags

FULL = (errno.ENOSPC, errno.EDQUOT)
"""What the system says of a disk that is full; it names no file then."""

HEADERS = "headers"
"""Folder in that of the kernels for what is precompiled of Warp's header."""

STDERR = 2
"""File descriptor that the native library writes to."""


@contextlib.contextmanager
def keeping_kernels() -> Iterator[None]:
    """Turns errors of an unwritable kernel cache into advice.

    Raises:
        InputError: The folder of the kernels cannot be written to.
        OSError: Anything else that the system refused, such as a kernel file that is missing.
    """
    try:
        yield
    except OSError as error:
        place = error.filename and pathlib.Path(str(error.filename)).resolve()
        if error.errno not in FULL and (not place or place.is_relative_to(FOLDER)):
            raise
        allowed = f"must be in a folder that can be written to ({error.strerror}): name another one"
        raise InputError(
            "kernel cache", "", error.filename, f"{allowed} with WARP_CACHE_PATH"
        ) from error


@functools.cache
def start_warp() -> None:
    """Initialises Warp without its greeting, since stdout belongs to the results.

    On a machine without a GPU its library also warns on stderr, where each run would begin with
    a line that looks like trouble; `warprock doctor` says which devices there are instead.

    Raises:
        InputError: The folder of the kernels cannot be written to.
    """
    import warp as wp

    wp.config.log_level = max(wp.config.log_level, wp.LOG_WARNING)
    sys.stderr.flush()
    stderr = os.dup(STDERR)
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), STDERR)
        try:
            with keeping_kernels():
                wp.init()
        finally:
            os.dup2(stderr, STDERR)
            os.close(stderr)
    keep_headers()
    write_short_structs()


def keep_headers() -> None:
    """Keeps Warp's own header, once it is precompiled, beside the kernels for all processes.

    Warp precompiles it in every process and thread anew, for each set of compiler flags: 2 s before
    the first kernel of each. The compiler refuses a header that it did not make for these flags and
    this processor, and compiles without it; of one made of another file it also writes errors by
    the thousand, so that each installation of Warp has a folder of its own. Warp 1.19 has no
    setting for this; where it changes, its own way stays.
    """
    import warp as wp

    runtime: Any = getattr(getattr(getattr(wp, "_src", None), "context", None), "runtime", None)
    if not hasattr(runtime, "get_clang_pch_dir"):
        return
    made_of = hashlib.sha256(f"{wp.__version__} {pathlib.Path(wp.__file__).resolve()}".encode())
    name = "-".join((*cpu_vector_flags(), made_of.hexdigest()[:12]))
    folder = pathlib.Path(str(wp.config.kernel_cache_dir), HEADERS, name)
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        runtime.get_clang_pch_dir = lambda: str(folder)


def write_short_structs() -> None:
    """Lets the compiler leave out those functions of a struct that its module never calls.

    Warp 1.19 writes a sum and an atomic sum for every struct, which only derivatives use, as
    functions that other modules could call. The compiler then makes machine code of all of them: up
    to an eighth of its time. What is `static` and not called, it leaves out; no other instruction
    changes. Warp has no setting for this; where its text is another one, that text stays.
    """
    import warp as wp

    codegen: Any = getattr(getattr(wp, "_src", None), "codegen", None)
    text = getattr(codegen, "struct_template", None)
    if isinstance(text, str):
        codegen.struct_template = text.replace("\nCUDA_CALLABLE ", "\nstatic CUDA_CALLABLE ")


def device_names() -> tuple[str, ...]:
    """Names of the devices, such as "cpu" and "cuda:0"."""
    import warp as wp

    start_warp()
    return tuple(str(device.alias) for device in wp.get_devices())


def require_device(name: str) -> None:
    """Refuses a device that Warp does not have.

    Raises:
        InputError: Warp has no such device here.
    """
    names = device_names()
    if name not in names and not (name == "cuda" and "cuda:0" in names):
        raise InputError("--device", "", name, f"allowed here: {', '.join(names)}")
