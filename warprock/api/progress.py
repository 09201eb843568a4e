"""How far a command is: a bar in a notebook, a bar on a terminal, or a function of one's own."""

from __future__ import annotations

import contextlib
import html
import sys
from collections.abc import Iterator
from typing import Any

from warprock.run.options import Progress
from warprock.tables.terminal import lane_progress

Shown = bool | Progress
"""What a command takes as `progress`: whether to show it, or what to call instead."""


@contextlib.contextmanager
def shown(progress: Shown, text: str, total: int | None) -> Iterator[Progress]:
    """Shows how far the block is.

    Args:
        progress: True shows it where somebody looks, in a notebook or on a terminal; False does
            not; a function is called with the number of lanes finished so far.
        text: What is running.
        total: Number of lanes; None if it is not known.

    Yields:
        A function to call with the number of lanes finished so far.
    """
    if callable(progress):
        yield progress
    elif not progress:
        yield lambda _: None
    elif (display := _notebook_display()) is not None:
        with _notebook_bar(display, text, total) as bar:
            yield bar
    else:
        with lane_progress(text, total) as bar:
            yield bar


def _notebook_display() -> Any:
    """What shows HTML in a notebook; None where Python runs in none.

    In a notebook IPython has been imported, and its shell has a kernel.
    """
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    if getattr(shell, "kernel", None) is None:
        return None
    return sys.modules["IPython.display"].display


@contextlib.contextmanager
def _notebook_bar(display: Any, text: str, total: int | None) -> Iterator[Progress]:
    """A bar below the cell, which goes when the block ends."""
    handle = display(_Bar(text, total, 0), display_id=True)
    try:
        yield lambda done: handle.update(_Bar(text, total, done))
    finally:
        handle.update(_Bar("", None, 0))


class _Bar:
    """A bar as a notebook shows it."""

    def __init__(self, text: str, total: int | None, done: int) -> None:
        self.text, self.total, self.done = text, total, done

    def __repr__(self) -> str:
        return f"{self.text}: {self.done:,} lanes" if self.text else ""

    def _repr_html_(self) -> str:
        if not self.text:
            return ""
        name = html.escape(self.text)
        if self.total is None:
            return f"{name}: {self.done:,} lanes"
        bar = f'<progress value="{self.done}" max="{self.total}" aria-label="{name}"></progress>'
        return f"{name} {bar} {self.done:,} of {self.total:,} lanes"
