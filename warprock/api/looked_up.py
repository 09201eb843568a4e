"""What a command looked up: nothing ran, so that there is nothing to draw."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from warprock.api.found import Found
from warprock.findings.finding import Finding

if TYPE_CHECKING:
    from warprock.figures.drawing import Drawing


class LookedUp(Found):
    """What a command looked up; it has tables and no figure, and `save` leaves no page."""

    _saves_page = False

    def __init__(self, title: str, found: Any, find: Callable[[], Finding]) -> None:
        super().__init__(title, found, find, _undrawn)

    def report(self, folder: str | os.PathLike[str] | None = None) -> pathlib.Path:
        """Raises an error, since a page tells what ran.

        Args:
            folder: As in `Found.report`.

        Raises:
            ValueError: Always.
        """
        raise ValueError(f"{self.title}: has no page")


def _undrawn(_said: str) -> Sequence[Drawing]:
    return ()
