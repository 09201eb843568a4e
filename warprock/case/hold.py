"""The tables [transverse_wall] and [[tie]]: what holds a single block besides its base."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import pydantic

from warprock.case.validation import KeyedError, Table
from warprock.model.hold import SIDES
from warprock.quantity import NOTHING, Column, NumberKey, TextKey
from warprock.units import Dimension, Quantity, parse_any

PLASTIC, THREE_IMPACTS = "plastic", "three-impacts"
"""What a block does that comes back on its wall: it stays; it rebounds by a formula."""

BY_FORMULA = -1.0
"""The value of a rebound that a formula gives."""

MOST_TIES = 9
"""Ties that a block may have."""


@dataclasses.dataclass(frozen=True)
class ReboundKey(NumberKey):
    """A ratio of angular velocities, or a word for what gives it."""

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        return f'must be {self.text}: "{PLASTIC}", "{THREE_IMPACTS}" or a number from 0 to 1'

    @property
    def bounds_text(self) -> str:
        """Both ends, and the words."""
        return f"{self.range}, {PLASTIC} or {THREE_IMPACTS}"

    def read(self, got: object) -> Quantity:
        """The ratio; `BY_FORMULA` where the slenderness angle gives it."""
        if got in (PLASTIC, THREE_IMPACTS):
            value = 0.0 if got == PLASTIC else BY_FORMULA
            return Quantity(value, Dimension.DIMENSIONLESS)
        try:
            quantity = parse_any(got, self.bounds)
        except ValueError:
            raise ValueError(self.allowed) from None
        self.judge(quantity)
        return quantity


class TransverseWall(Table):
    """A wall at one side of a single block: the block can rock to the other side alone."""

    place: ClassVar[str] = "transverse_wall"

    side: Annotated[
        str,
        TextKey(
            "the side of the block at which the wall stands, left at -x, right at +x",
            tuple(SIDES),
            swept=True,
            column=Column("wall_side", text="Side at which the transverse wall stands"),
        ),
    ]
    rebound: Annotated[
        float,
        ReboundKey(
            "the angular velocity of the block away from the wall, over that towards it before",
            "0 to 1",
            swept=True,
            column=Column("wall_rebound"),
        ),
    ]


class Tie(Table):
    """A tie of a single block, horizontal, to a point far away: N is its number, from 1."""

    place: ClassVar[str] = "tie.N"

    height: Annotated[
        float,
        NumberKey(
            "the height of the tie above the base of the block",
            "0 m to 1 km",
            low_open=True,
            swept=True,
            column=Column("tie_height"),
        ),
    ]
    side: Annotated[
        str,
        TextKey(
            "the side of the block that the tie pulls to, left to -x, right to +x",
            tuple(SIDES),
            swept=True,
            column=Column("tie_side", text="Side that the tie pulls to"),
        ),
    ]
    stiffness: Annotated[
        float,
        NumberKey(
            "the stiffness of the tie",
            "1e-3 N/m to 1e12 N/m",
            swept=True,
            column=Column("tie_stiffness"),
        ),
    ]
    slack: Annotated[
        float,
        NumberKey(
            "the elongation of the tie before it pulls",
            "0 m to 1 km",
            swept=True,
            column=Column("tie_slack", "mm"),
        ),
    ] = 0.0
    prestress: Annotated[
        float,
        NumberKey(
            "the force in the tie while the block rests",
            "0 N to 1e12 N",
            swept=True,
            instead_of="slack",
            column=Column("tie_prestress"),
        ),
    ] = 0.0
    yield_force: Annotated[
        float | None,
        NumberKey(
            "the force at which the tie yields",
            "0 N to 1e12 N",
            low_open=True,
            swept=True,
            column=Column("tie_yield_force"),
        ),
    ] = None
    ultimate_elongation: Annotated[
        float | None,
        NumberKey(
            "the elongation, beyond its slack and its prestress, at which the tie breaks",
            "0 m to 1 km",
            low_open=True,
            swept=True,
            column=Column("tie_ultimate_elongation", "mm"),
        ),
    ] = None
    acts: Annotated[
        str,
        TextKey(
            "whether the tie gives tension alone, or compression, too",
            ("tension", "both"),
            swept=True,
            column=Column("tie_acts", text="Whether the tie gives tension alone, or both"),
        ),
    ] = "tension"


class Ties(pydantic.RootModel[dict[str, Tie]]):
    """The ties of a block by number."""

    model_config = pydantic.ConfigDict(frozen=True)

    @pydantic.model_validator(mode="before")
    @classmethod
    def _numbered(cls, ties: Any) -> Any:
        """Judges the numbers of the ties before what is in them."""
        if not isinstance(ties, Mapping) or not ties:
            raise KeyedError((), ties, "must be [[tie]] tables")
        known = [str(number) for number in range(1, MOST_TIES + 1)]
        for name in ties:
            if name not in known:
                allowed = (
                    f"must be [[tie]] tables, at most {MOST_TIES}, or [tie.1], [tie.2] and so on"
                )
                raise KeyedError(name, ties[name], allowed)
        for number in known[: len(ties)]:
            if number not in ties:
                raise KeyedError(number, NOTHING, "must be given: ties are numbered from 1")
        return ties

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.root)


def number_ties(raw: dict[str, Any]) -> None:
    """Gives the [[tie]] tables of a case as written numbers from 1, by which keys name them."""
    ties = raw.get("tie")
    if isinstance(ties, list | tuple):
        raw["tie"] = {str(number): tie for number, tie in enumerate(ties, 1)}
