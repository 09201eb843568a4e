"""What comes next, made while what is there is in use."""

from __future__ import annotations

import concurrent.futures
from collections.abc import Iterable, Iterator
from typing import TypeVar

Item = TypeVar("Item")


def ahead(items: Iterable[Item]) -> Iterator[Item]:
    """The same items; a thread makes the next one while the last one is in use.

    Where making one or using it leaves the interpreter's lock alone, as Arrow and launches do, both
    go on side by side. One item more is held in memory.
    """
    source = iter(items)

    def following() -> list[Item]:
        for item in source:
            return [item]
        return []

    with concurrent.futures.ThreadPoolExecutor(1) as maker:
        coming = maker.submit(following)
        while found := coming.result():
            coming = maker.submit(following)
            yield found.pop()
