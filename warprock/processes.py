"""Worker processes that end when the work does, also when that is interrupted."""

from __future__ import annotations

import concurrent.futures
import contextlib
import multiprocessing
import signal
from collections.abc import Iterator


@contextlib.contextmanager
def worker_processes(
    count: int, start: str | None = None
) -> Iterator[concurrent.futures.ProcessPoolExecutor]:
    """Worker processes for independent tasks.

    Ctrl-C reaches every process of a command. A worker that it stops while it waits for its next
    task keeps the others from theirs for ever, so workers leave it to the process that started
    them: that drops the tasks not begun and waits for those begun.

    Args:
        count: How many.
        start: How `multiprocessing` starts them; None is its own choice.

    Yields:
        The pool of them.
    """
    context = multiprocessing.get_context(start)
    with concurrent.futures.ProcessPoolExecutor(
        count, mp_context=context, initializer=_leave_interrupts
    ) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def _leave_interrupts() -> None:
    """Lets Ctrl-C be for the process that started this one; SIGTERM ends a worker at once."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
