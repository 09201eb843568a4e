"""Says that kernels are compiled where somebody waits for it."""

from __future__ import annotations

import contextlib
import os
import pathlib
import sys
import threading
import time
from collections.abc import Callable, Iterator

PATIENCE = 2.0
"""Seconds of compiling after which it is said."""
TEXT = "compiling kernels: this takes a while the first time, and is kept for the next"

_GLANCE = 0.25
"""Seconds between two looks at the folder of the kernels."""


@contextlib.contextmanager
def saying_when_compiling(say: Callable[[str], None]) -> Iterator[None]:
    """Says, once, that kernels are compiled, where that takes long in the block.

    What runs a kernel for the first time compiles it, which may take a minute, and is silent
    meanwhile. Warp compiles in a folder beside the kernels that bears the number of the process;
    whether there is one tells a compiler at work from a kernel that is only loaded.

    Args:
        say: Called with the text, from another thread.
    """
    done = threading.Event()
    watcher = threading.Thread(target=_watch, args=(done, say), daemon=True)
    watcher.start()
    try:
        yield
    finally:
        done.set()


def _watch(done: threading.Event, say: Callable[[str], None]) -> None:
    since: float | None = None
    while not done.wait(_GLANCE):
        if not _compiling():
            since = None
            continue
        since = time.monotonic() if since is None else since
        if time.monotonic() - since >= PATIENCE:
            say(TEXT)
            return


def _compiling() -> bool:
    """Whether this process is compiling a kernel now."""
    warp = sys.modules.get("warp")
    folder = getattr(getattr(warp, "config", None), "kernel_cache_dir", None)
    if not folder:
        return False
    with contextlib.suppress(OSError):
        return any(pathlib.Path(folder).glob(f"*_p{os.getpid()}_t*"))
    return False
