"""A case file as a whole: its tables, and which of them belong together.

Each table is a file of this room: `block.py` declares the keys of [block], and so on. Values are
floats in SI units or rad.
"""

from __future__ import annotations

from typing import Annotated, Any, Self

import pydantic

from warprock.case.assembly import Assembly
from warprock.case.block import Block, Stack, read_block
from warprock.case.body import Body
from warprock.case.check import CheckSpec, read_check
from warprock.case.contact import Contact
from warprock.case.hold import Frame, Ground, Strip, Ties, TopLoad, TransverseWall, read_ties
from warprock.case.motion import Motion
from warprock.case.run import Run
from warprock.case.start import Start
from warprock.case.support import Support
from warprock.case.validation import KeyedError, Table
from warprock.case.value_kinds import ProseKey
from warprock.errors import NOTHING, Said
from warprock.quantity import TextKey

PLANAR, SPATIAL = "planar", "spatial"

MODEL_TEXT = (
    "planar or spatial: whether blocks move in the plane or in space; without it the scene says; "
    "planar keeps single blocks in the plane where the base moves upwards (motion.z)"
)

APART = ("sweep", "spectrum", "sample", "ensemble", "study")
"""Tables that are read before or after the others, each in a file of its own."""


class CaseFile(Table):
    """A case file.

    Attributes:
        model: Whether the blocks move in the plane of rocking or in space; None lets the scene say.
            A base that moves upwards makes it space, unless the plane is asked for.
    """

    title: Annotated[str, TextKey("text that says what the case is")]
    source: Annotated[str, ProseKey("where the numbers of the case come from")]
    model: Annotated[str | None, TextKey(MODEL_TEXT, (PLANAR, SPATIAL))] = None
    block: Annotated[Block | Stack | Body | None, pydantic.PlainValidator(read_block)] = None
    assembly: Assembly | None = None
    contact: Contact
    transverse_wall: TransverseWall | None = None
    tie: Annotated[Ties | None, pydantic.PlainValidator(read_ties)] = None
    top_load: TopLoad | None = None
    frame: Frame | None = None
    strip: Strip | None = None
    ground: Ground | None = None
    start: Start = pydantic.Field(default_factory=Start)
    motion: Motion | None = None
    support: Support | None = None
    run: Run
    engines: dict[str, dict[str, Any]] = pydantic.Field(default_factory=dict)
    peers: dict[str, dict[str, Any]] = pydantic.Field(default_factory=dict)
    check: tuple[Annotated[CheckSpec, pydantic.PlainValidator(read_check)], ...] = ()

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of all keys and tables of a case file."""
        return super().names() + APART

    @pydantic.model_validator(mode="after")
    def _block_or_assembly(self) -> Self:
        if self.block is None and self.assembly is None:
            raise KeyedError("block", NOTHING, "must be given, or an [assembly] of many")
        if self.block is not None and self.assembly is not None:
            raise KeyedError("block", Said("a table"), "must not be given beside [assembly]")
        return self

    @pydantic.model_validator(mode="after")
    def _keys_of_a_stack(self) -> Self:
        if self.stacked and self.start.model_fields_set:
            name = f"start.{min(self.start.model_fields_set)}"
            raise KeyedError(
                name, Said("a start"), "must not be given for a stack: each block has a rotation"
            )
        if self.stacked and self.contact.angular_restitution is not None:
            raise KeyedError(
                "contact.angular_restitution",
                self.contact.angular_restitution,
                "must not be given for a stack, which follows its contact laws",
            )
        return self

    @property
    def stacked(self) -> bool:
        """Whether the case has a stack of blocks."""
        return isinstance(self.block, Stack)

    @property
    def block_count(self) -> int:
        """Blocks in a lane."""
        return len(self.block.numbered) if isinstance(self.block, Stack) else 1

    def constant(self, key: str) -> Any:
        """Value of a dotted key, SI units or rad; None where the case does not give it."""
        found: Any = self
        for name in key.split("."):
            numbered = isinstance(found, Stack | Ties)
            found = found.numbered.get(name) if numbered else getattr(found, name, None)
        return found
