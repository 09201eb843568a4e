"""Items that are made ahead of their use."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from warprock.sweeps.ahead import ahead


def test_one_item_is_made_while_another_is_in_use() -> None:
    made: list[int] = []
    second = threading.Event()

    def items() -> Iterator[int]:
        for item in range(4):
            made.append(item)
            if item == 1:
                second.set()
            yield item

    found = []
    for item in ahead(items()):
        assert second.wait(10.0), "the next item is not made before the first one is given back"
        found.append(item)
        # One item more at most is there.
        assert len(made) <= item + 2
    assert found == made == [0, 1, 2, 3]


def test_an_item_that_cannot_be_made_stops_whoever_asks_for_it() -> None:
    def items() -> Iterator[int]:
        yield 1
        raise ValueError("the second")

    each = ahead(items())
    assert next(each) == 1
    with pytest.raises(ValueError, match="the second"):
        next(each)
