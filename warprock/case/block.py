"""The tables [block] and, of a stack, [block.1], [block.2] and so on: sizes and density."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self, TypeVar

import pydantic

from warprock.case.block_keys import FACE_FRICTION, HEIGHT, OFFSET, ROTATION_START
from warprock.case.body import Body, StackedBody
from warprock.case.validation import KeyedError, Table, below, validated
from warprock.errors import NOTHING, Said
from warprock.model.runnable import HIGHEST_STACK
from warprock.quantity import Column, NumberKey

ROUND_DEPTH = math.pi / 4.0
"""Depth over diameter of the box that stands for a round base: their areas are the same."""


def _centre_offset(axis: str, along: str) -> NumberKey:
    return NumberKey(
        f"the distance of the centre of mass from the middle, along the {along}",
        "-1 km to 1 km",
        swept=True,
        column=Column(f"centre_offset_{axis}", "mm"),
        needs_space="has a centre of mass beside the middle",
    )


_CENTRE_OFFSET_X, _CENTRE_OFFSET_Y = _centre_offset("x", "width"), _centre_offset("y", "depth")


class _Box(Table):
    """What every block has: full sizes [m] and density [kg/m^3]."""

    width: Annotated[
        float | None,
        NumberKey(
            "the full width of the block in the plane of rocking",
            "1 mm to 1 km",
            swept=True,
            column=Column("width"),
        ),
    ] = None
    height: Annotated[float, HEIGHT]
    depth: Annotated[
        float | None,
        NumberKey(
            "the full depth of the block across the plane of rocking",
            "1 mm to 1 km",
            swept=True,
            column=Column("depth"),
        ),
    ] = None
    diameter: Annotated[
        float | None,
        NumberKey(
            "the diameter of a round base: a cylinder or a drum, run as the box of the same mass, "
            "slenderness and height",
            "1 mm to 1 km",
            swept=True,
            instead_of="width depth",
            column=Column("diameter", text="Diameter of a round base"),
        ),
    ] = None
    density: Annotated[
        float,
        NumberKey(
            "the density of the block",
            "1e-3 kg/m^3 to 1e5 kg/m^3",
            swept=True,
            column=Column("density"),
        ),
    ]

    @pydantic.model_validator(mode="after")
    def _has_a_base(self) -> Self:
        for name in ("width", "depth"):
            if self.diameter is None and getattr(self, name) is None:
                raise KeyedError(name, NOTHING, self.declared()[name].allowed)
        return self


class Block(_Box):
    """The block of a case with one block in a lane."""

    place: ClassVar[str] = "block"

    centre_offset_x: Annotated[float | None, _CENTRE_OFFSET_X] = None
    centre_offset_y: Annotated[float | None, _CENTRE_OFFSET_Y] = None


class StackedBlock(_Box):
    """One block of a stack: N is its number, 1 the lowest, each on the one below."""

    place: ClassVar[str] = "block.N"

    chamfer: Annotated[
        float,
        NumberKey(
            "the width cut off each edge of the block",
            "0 m to 1 km",
            swept=True,
            column=Column("chamfer", "mm", "Width cut off each edge"),
        ),
    ] = 0.0
    offset: Annotated[float, OFFSET] = 0.0
    friction: Annotated[float | None, FACE_FRICTION] = None
    rotation: Annotated[float, ROTATION_START] = 0.0
    offset_across: Annotated[
        float | None,
        NumberKey(
            "the distance from the middle of the block below to the block's own, across the plane "
            "of rocking",
            "-1 km to 1 km",
            swept=True,
            column=Column("offset_across", "mm"),
            needs_space="has a block beside the plane of rocking",
        ),
    ] = None
    yaw: Annotated[
        float | None,
        NumberKey(
            "the turn of the block about the vertical at the start",
            "-180 deg to 180 deg",
            swept=True,
            column=Column("yaw_start"),
            needs_space="has a block turned about the vertical",
        ),
    ] = None
    centre_offset_x: Annotated[float | None, _CENTRE_OFFSET_X] = None
    centre_offset_y: Annotated[float | None, _CENTRE_OFFSET_Y] = None


@dataclasses.dataclass(frozen=True)
class Stack:
    """The blocks of a stack.

    Attributes:
        numbered: Each block by its number, 1 the lowest.
    """

    numbered: Mapping[str, StackedBlock | StackedBody]


OfBody = TypeVar("OfBody", bound=Table)
OfBox = TypeVar("OfBox", bound=Table)


def _read_stack(blocks: Mapping[Any, object]) -> Stack:
    """Reads a stack: the numbers of its blocks before what is in them."""
    known = [str(number) for number in range(1, HIGHEST_STACK + 1)]
    numbered = "blocks are numbered from 1, the lowest"
    first = next(iter(blocks))
    for name in blocks:
        if str(name).isdecimal() != str(first).isdecimal():
            allowed = f"must not be beside block.{first}: a block has its own keys, and of a stack "
            raise KeyedError(name, blocks[name], allowed + numbered)
    for name in blocks:
        if name not in known:
            allowed = (
                f"must be from 1 to {HIGHEST_STACK}, at most {HIGHEST_STACK} blocks: {numbered}"
            )
            raise KeyedError(name, Said("a block of that number"), allowed)
    highest = max(blocks, key=known.index)
    for lower in known[: known.index(highest)]:
        if lower not in blocks:
            allowed = f"must have block.{lower} below it: {numbered}"
            raise KeyedError(highest, Said("a block of that number"), allowed)
    found = {name: _read_stacked(name, table) for name, table in blocks.items()}
    for number in range(1, len(found)):
        block = found[str(number)]
        if isinstance(block, StackedBody) and block.top is None:
            allowed = f"must be given, [[x, z], [x, z]]: block.{number + 1} stands on it"
            raise KeyedError((str(number), "top"), NOTHING, allowed)
    return Stack(found)


def _read_stacked(number: str, table: object) -> StackedBlock | StackedBody:
    """A block of a stack as it is read: a body where it has a key that only bodies have."""
    with below(number):
        return validated(_kind(table, StackedBody, StackedBlock), table)


def _kind(table: object, body: type[OfBody], box: type[OfBox]) -> type[OfBody] | type[OfBox]:
    """What a table of a block is, by its keys.

    Raises:
        KeyedError: It has keys of both.
    """
    of_body = {*body.declared()} - {*box.declared()}
    given = of_body.intersection(table) if isinstance(table, Mapping) else set()
    if not given:
        return box
    assert isinstance(table, Mapping)
    for name in table:
        if name in box.declared() and name not in body.declared():
            allowed = f"must not be given beside {min(given)}: a body is no box"
            raise KeyedError(name, table[name], allowed)
    return body


def read_block(table: object) -> Block | Stack | Body:
    """[block] as one block, or as a stack where it has a key that is a number.

    A key that a body alone has, such as `base`, makes it a body.
    """
    if isinstance(table, Mapping) and any(str(name).isdecimal() for name in table):
        return _read_stack(table)
    return validated(_kind(table, Body, Block), table)
