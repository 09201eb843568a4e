"""What files of polygons have in common: outlines of blocks, as a file has them."""

from __future__ import annotations

import collections
import dataclasses
from collections.abc import Iterable, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from warprock.errors import NOTHING, InputError, Said

Array = npt.NDArray[np.float64]

MOST_OUTLINES = 20_000
"""Blocks of a file that is read: more than any engine takes."""


class Outline(NamedTuple):
    """A block as a file has it.

    Attributes:
        name: What the file calls it; empty if nothing.
        group: What the file calls the blocks that it is one of, such as a layer.
        corners: Corners of its outline in the plane, in units of the file, shape [corner, 2].
        fixed: Whether the file says that it is fixed.
    """

    name: str
    group: str
    corners: Array
    fixed: bool = False


class Solid(NamedTuple):
    """A convex body as a file has it.

    Attributes:
        name: As of an outline.
        group: As of an outline.
        corners: Its corners in space, in units of the file, shape [corner, 3].
        fixed: As of an outline.
    """

    name: str
    group: str
    corners: Array
    fixed: bool = False


AnyBlock = TypeVar("AnyBlock", Outline, Solid)


@dataclasses.dataclass(frozen=True, eq=False)
class Drawing:
    """The blocks of a file.

    Attributes:
        outlines: The blocks in the plane, no two of one name; none where they are bodies.
        solids: The blocks in space, likewise; none where they are outlines.
        unit: Length of one unit of the file [m]; None where the file does not say.
        left_out: What the file holds besides, in words; empty if nothing.
        sha256: Hash of its bytes.
    """

    outlines: tuple[Outline, ...]
    unit: float | None = None
    left_out: str = ""
    sha256: str = ""
    solids: tuple[Solid, ...] = ()

    @property
    def blocks(self) -> tuple[Outline, ...] | tuple[Solid, ...]:
        """The blocks, in the plane or in space."""
        return self.outlines or self.solids


def named_apart(outlines: Iterable[AnyBlock]) -> tuple[AnyBlock, ...]:
    """Blocks with names of their own: those of one name, or with none, are numbered from 1."""
    found = list(outlines)
    own = [each.name or each.group for each in found]
    several = {name for name, count in collections.Counter(own).items() if count > 1 or not name}
    counts = dict.fromkeys(several, 0)
    named = []
    for each, name in zip(found, own, strict=True):
        number = ""
        if name in counts:
            counts[name] += 1
            number = str(counts[name])
        named.append(each._replace(name=f"{name} {number}".strip()))
    return tuple(named)


def require_few(source: str, count: int) -> None:
    """Refuses a file of more blocks than `MOST_OUTLINES`, before more is done with it.

    Raises:
        InputError: It has more.
    """
    if count > MOST_OUTLINES:
        got = Said(f"more than {MOST_OUTLINES:,} blocks")
        raise InputError(source, "", got, f"must be at most {MOST_OUTLINES:,}")


def require_outlines(source: str, outlines: Sequence[Outline | Solid], holds: str) -> None:
    """Refuses a file without blocks, and numbers that are none.

    Args:
        source: The file, as errors name it.
        outlines: Its blocks.
        holds: What it must hold.

    Raises:
        InputError: There are none, one has less than 3 corners, or a coordinate is not finite.
    """
    if not outlines:
        raise InputError(source, "", NOTHING, f"must hold {holds}")
    for each in outlines:
        if len(each.corners) < 3 or not np.isfinite(each.corners).all():
            allowed = "must be at least 3 corners with finite coordinates"
            raise InputError(source, each.name, each.corners.tolist()[:3], allowed)
