"""The blocks of a case file: one block, or a stack of numbered ones."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import pydantic

from warprock.case.table import KeyedError, Table, number
from warprock.model.runnable import MOST_BLOCKS
from warprock.quantity import NOTHING, Said

SINGLE, STACK = "single", "stack"
"""What pydantic's place of an error says behind `block`."""


class Block(Table):
    """The block: full dimensions [m] and density [kg/m^3]."""

    width: Annotated[float, number("block.width")]
    height: Annotated[float, number("block.height")]
    depth: Annotated[float, number("block.depth")]
    density: Annotated[float, number("block.density")]
    centre_offset_x: Annotated[float, number("block.centre_offset_x")] | None = None
    centre_offset_y: Annotated[float, number("block.centre_offset_y")] | None = None


class StackedBlock(Table):
    """One block of a stack: full dimensions [m], density, and how it starts [m, rad]."""

    width: Annotated[float, number("block.N.width")]
    height: Annotated[float, number("block.N.height")]
    depth: Annotated[float, number("block.N.depth")]
    density: Annotated[float, number("block.N.density")]
    chamfer: Annotated[float, number("block.N.chamfer")] = 0.0
    offset: Annotated[float, number("block.N.offset")] = 0.0
    friction: Annotated[float, number("block.N.friction")] | None = None
    rotation: Annotated[float, number("block.N.rotation")] = 0.0
    offset_across: Annotated[float, number("block.N.offset_across")] | None = None
    yaw: Annotated[float, number("block.N.yaw")] | None = None
    centre_offset_x: Annotated[float, number("block.N.centre_offset_x")] | None = None
    centre_offset_y: Annotated[float, number("block.N.centre_offset_y")] | None = None


class Stack(pydantic.RootModel[dict[str, StackedBlock]]):
    """The blocks of a stack by number, 1 the lowest."""

    model_config = pydantic.ConfigDict(frozen=True)

    @pydantic.model_validator(mode="before")
    @classmethod
    def _numbered(cls, blocks: Any) -> Any:
        """Judges the numbers of the blocks before what is in them."""
        known = [str(number) for number in range(1, MOST_BLOCKS + 1)]
        numbered = "blocks are numbered from 1, the lowest"
        first = next(iter(blocks))
        for name in blocks:
            if str(name).isdecimal() != str(first).isdecimal():
                allowed = (
                    f"must not be beside block.{first}: a block has its own keys, and of a stack "
                )
                raise KeyedError(name, blocks[name], allowed + numbered)
        for name in blocks:
            if name not in known:
                allowed = (
                    f"must be from 1 to {MOST_BLOCKS}, at most {MOST_BLOCKS} blocks: {numbered}"
                )
                raise KeyedError(name, Said("a block of that number"), allowed)
        highest = max(blocks, key=known.index)
        for below in known[: known.index(highest)]:
            if below not in blocks:
                allowed = f"must be given below block.{highest}: {numbered}"
                raise KeyedError(below, NOTHING, allowed)
        return blocks


def single_or_stack(block: object) -> str:
    """Whether [block] is a block or holds [block.1], [block.2] and so on."""
    numbered = isinstance(block, Mapping) and any(str(name).isdecimal() for name in block)
    return STACK if numbered or isinstance(block, Stack) else SINGLE
