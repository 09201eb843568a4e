"""How far a command is: a bar in a notebook, a bar on a terminal, or a function of one's own."""

from __future__ import annotations

import contextlib
import html
import sys
from collections.abc import Iterator
from typing import Any

from warprock.api.names import calling_command
from warprock.running.options import Progress
from warprock.running.waiting import saying_what_takes_long

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
    if calling_command() is not None:
        # What takes long a command says itself.
        with _on_terminal(text, total) as report:
            yield report
    elif callable(progress):
        yield progress
    elif not progress:
        yield lambda _: None
    elif (display := _notebook_display()) is not None:
        with _notebook_bar(display, text, total) as bar, saying_what_takes_long(bar.say):
            yield bar
    else:
        with _on_terminal(text, total) as report, saying_what_takes_long(_say):
            yield report


def _on_terminal(text: str, total: int | None) -> contextlib.AbstractContextManager[Progress]:
    from warprock.tables.terminal import lane_progress

    return lane_progress(text, total)


def _say(text: str) -> None:
    """Says something on the terminal, where there is one."""
    if sys.stderr.isatty():
        print(text, file=sys.stderr)


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
def _notebook_bar(display: Any, text: str, total: int | None) -> Iterator[_Bar]:
    """A bar below the cell, which goes when the block ends."""
    bar = _Bar(text, total)
    bar.handle = display(bar, display_id=True)
    try:
        yield bar
    finally:
        bar.text = ""
        bar.handle.update(bar)


class _Bar:
    """A bar as a notebook shows it; it is called with the number of lanes finished so far."""

    handle: Any

    def __init__(self, text: str, total: int | None) -> None:
        self.text, self.total, self.done, self.note = text, total, 0, ""

    def __call__(self, done: int) -> None:
        self.done, self.note = done, ""
        self.handle.update(self)

    def say(self, note: str) -> None:
        """Shows a note beside the bar, until it moves on."""
        self.note = f"; {note}"
        self.handle.update(self)

    def __repr__(self) -> str:
        return f"{self.text}: {self.done:,} lanes{self.note}" if self.text else ""

    def _repr_html_(self) -> str:
        if not self.text or self.total is None:
            return html.escape(repr(self))
        name = html.escape(self.text)
        bar = f'<progress value="{self.done}" max="{self.total}" aria-label="{name}"></progress>'
        return f"{name} {bar} {self.done:,} of {self.total:,} lanes{self.note}"
