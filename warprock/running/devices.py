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
    write_quick_text()


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
    share_headers()


def share_headers() -> None:
    """Lets kernels whose flags differ in the optimiser alone share one precompiled header.

    Warp names a header after all flags. Those of the optimiser (`-mllvm`) are not among those that
    it makes the header with, so that it made the same bytes again, 1.7 s for each set. Headers lie
    in a folder for the other flags now, and one that is there is linked to the name of each set.
    Where Warp names them in another way, no link is found, and it makes them anew.
    """
    import warp as wp

    build: Any = getattr(getattr(wp, "_src", None), "build", None)
    compile_cpu = getattr(build, "build_cpu", None)
    if compile_cpu is None:
        return

    def compile_with_header(*places: Any, extra_flags: str = "", **options: Any) -> None:
        if options.get("pch_dir"):
            options["pch_dir"] = header_folder(options["pch_dir"], extra_flags.split())
        compile_cpu(*places, extra_flags=extra_flags, **options)

    build.build_cpu = compile_with_header


def header_folder(folder: str, flags: list[str]) -> str:
    """The folder of the header for some compiler flags, where it has their name if it is there."""
    seen = " ".join(flag for flag in flags if not flag.startswith("-mllvm="))
    place = pathlib.Path(folder, hashlib.sha256(seen.encode()).hexdigest()[:12])
    # Warp's name for the flags: the hash FNV-1a of all of them.
    name = 0xCBF29CE484222325
    for byte in b"".join(flag.encode() + b"\0" for flag in flags):
        name = (name ^ byte) * 0x100000001B3 % 2**64
    with contextlib.suppress(OSError):
        place.mkdir(parents=True, exist_ok=True)
        for header in place.glob("*_f*.pch"):
            link = place / f"{header.name.rpartition('_f')[0]}_f{name:016x}.pch"
            if not link.exists():
                os.link(header, link)
    return str(place)


def write_quick_text() -> None:
    """Lets the compiler take less time for the same kernel, by two words in the text that it reads.

    Warp 1.19 writes a sum and an atomic sum for every struct, which only derivatives use, as
    functions that other modules could call. The compiler then makes machine code of all of them: up
    to an eighth of its time. What is `static` and not called, it leaves out.

    It also writes the kernel as a function that one other function calls. The compiler simplifies
    the kernel, puts it into the other one and simplifies it again there: a tenth of its time. A
    kernel that stays a function (`noinline`) is called once a thread.

    Warp has no setting for this; where its text is another one, that text stays.
    """
    import warp as wp

    codegen: Any = getattr(getattr(wp, "_src", None), "codegen", None)
    for template, before, after in (
        ("struct_template", "\nCUDA_CALLABLE ", "\nstatic CUDA_CALLABLE "),
        ("cpu_kernel_template_forward", "\nstatic void ", "\n[[gnu::noinline]] static void "),
    ):
        text = getattr(codegen, template, None)
        if isinstance(text, str):
            setattr(codegen, template, text.replace(before, after))


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
