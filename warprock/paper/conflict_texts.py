"""The words of the paper's conflicts, which are data, and the numbers that are put into them."""

from __future__ import annotations

import dataclasses
import functools
import importlib.resources
import re
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

E = TypeVar("E")

Numbers = Mapping[str, Any]
"""Names in a text -> a number, text, numbers of shape [n], or for `parts` a list of `Numbers`."""
Parts = Mapping[str, Numbers]
"""Key of a text that is said -> its numbers."""


@dataclasses.dataclass(frozen=True)
class Conflict:
    """One conflict.

    Attributes:
        item: Its number, the same in every target.
        title: What it is about.
        text: What is printed, what is right and how sure that is, in words and numbers.
    """

    item: int
    title: str
    text: str


def list_numbers(values: npt.ArrayLike, form: str = ".4f") -> str:
    """Numbers in one line, without the leading zero: `.1864 -.1366`."""
    texts = [format(value, form) for value in np.asarray(values, dtype=float)]
    return " ".join(re.sub(r"^(-?)0\.", r"\1.", text) for text in texts)


class _Listed:
    """Numbers that a text formats as one: `{name:.2f}`."""

    def __init__(self, values: npt.ArrayLike) -> None:
        self._values = values

    def __format__(self, form: str) -> str:
        return list_numbers(self._values, form or ".4f")


@functools.cache
def _texts() -> dict[str, dict[str, Any]]:
    file = importlib.resources.files("warprock.cases") / "paper" / "conflicts.toml"
    return tomllib.loads(file.read_text(encoding="utf-8"))


def _fill_in(text: str, numbers: Numbers, each: str) -> str:
    """A text with its numbers; line breaks are spaces."""
    values = dict(numbers)
    if "parts" in values:
        values["parts"] = "; ".join(_fill_in(each, part, "") for part in values["parts"])
    shown = {name: _Listed(v) if np.ndim(v) else v for name, v in values.items()}
    return " ".join(text.split()).format(**shown)


def conflict(name: str, parts: Parts) -> Conflict:
    """A conflict in words.

    Args:
        name: Its table in `cases/paper/conflicts.toml`.
        parts: The texts of that table that are said, and their numbers.
    """
    table = _texts()[name]
    texts = [_fill_in(table[key], numbers, table.get("each", "")) for key, numbers in parts.items()]
    return Conflict(table["item"], table["title"], " ".join(texts))


def conflicts_about(
    targets: Collection[str], items: Sequence[tuple[str, Callable[[E], Parts]]], evidence: E
) -> list[Conflict]:
    """The conflicts that concern one of the targets.

    Args:
        targets: What is reproduced.
        items: Name of each conflict, and what finds its numbers.
        evidence: What the runs found.
    """
    chosen = [row for row in items if not set(targets).isdisjoint(_texts()[row[0]]["targets"])]
    return [conflict(name, numbers(evidence)) for name, numbers in chosen]
