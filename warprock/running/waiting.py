"""Says what somebody waits for: kernels that are compiled, and a run that takes minutes."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator

PATIENCE = 2.0
"""Seconds of compiling after which it is said."""
TEXT = "compiling kernels: this takes a while the first time, and is kept for the next"

LONG = 60.0
"""Time that a run takes from which on it is announced [s]."""

ENOUGH = 4
"""Parts of a run that have to be finished before its time is announced."""

_GLANCE = 0.25
"""Seconds between two looks at the folder of the kernels."""

_REST = 100.0
"""Pause after the names in that folder were read, in times that reading them took: a watcher costs
one part in so many of a core where other programs compile in a folder of thousands of kernels."""

_SAY: list[Callable[[str], None]] = []
"""What says something to whoever waits, the innermost last."""


@contextlib.contextmanager
def saying_what_takes_long(say: Callable[[str], None]) -> Iterator[None]:
    """Says, once each, that kernels are compiled and how long a run will take, where that is long.

    What runs a kernel for the first time compiles it, which may take a minute, and is silent
    meanwhile. Warp compiles in a folder beside the kernels that bears the number of the process;
    whether there is one tells a compiler at work from a kernel that is only loaded.

    Args:
        say: Called with the text, perhaps from another thread.
    """
    _SAY.append(say)
    done = threading.Event()
    watcher = threading.Thread(target=_watch, args=(done, say), daemon=True)
    watcher.start()
    try:
        yield
    finally:
        done.set()
        _SAY.remove(say)


class Forecast:
    """Counts the lanes of a run, and says how long it will take if that is long.

    The clock starts with the first lanes that are finished: kernels are compiled before.
    """

    def __init__(self, total: int, share: float = 1.0, more: str = "") -> None:
        """Nothing is finished yet.

        Args:
            total: Lanes of the run.
            share: Time of everything that is to be done over that of this run of all lanes.
            more: What is said besides.
        """
        self.total, self.share, self.more = total, share, more
        self._calls, self._first, self._begin = 0, 0, 0.0

    def __call__(self, done: int) -> None:
        """Is told the lanes finished so far."""
        self._calls += 1
        if self._calls == 1 or done <= self._first:  # the first, or of the next chunk the first
            self._calls, self._first, self._begin = 1, done, time.perf_counter()
        if self._calls != ENOUGH:
            return
        each = (time.perf_counter() - self._begin) / (done - self._first)
        left = each * (self.share * self.total - done)
        if left > LONG and _SAY:
            _SAY[-1](f"some {left / 60.0:.0f} minutes to go{self.more}")


def _watch(done: threading.Event, say: Callable[[str], None]) -> None:
    since: float | None = None
    changed, compiling, pause = -1, False, _GLANCE
    while not done.wait(pause):
        # A folder that has not changed is not read again: it may hold thousands of kernels.
        before, changed, pause = changed, _changed(), _GLANCE
        if changed != before:
            begin = time.thread_time()
            compiling = _compiling()
            pause = max(_GLANCE, _REST * (time.thread_time() - begin))
        if not compiling:
            since = None
            continue
        since = time.monotonic() if since is None else since
        if time.monotonic() - since >= PATIENCE:
            say(TEXT)
            return


def kernel_folder() -> str | None:
    """The folder of the kernels; None where Warp has not been asked for one."""
    return getattr(getattr(sys.modules.get("warp"), "config", None), "kernel_cache_dir", None)


def _changed() -> int:
    """When something was last made or removed in the folder of the kernels [ns]."""
    folder = kernel_folder()
    with contextlib.suppress(OSError):
        return os.stat(folder).st_mtime_ns if folder else 0
    return 0


def _compiling() -> bool:
    """Whether this process is compiling a kernel now."""
    folder, mark = kernel_folder(), f"_p{os.getpid()}_t"
    with contextlib.suppress(OSError):
        return folder is not None and any(mark in name for name in os.listdir(folder))
    return False
