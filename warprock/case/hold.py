"""The tables [transverse_wall], [[tie]], [top_load], [frame], [strip]: what a block is held by."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from warprock.case.validation import KeyedError, Table, below, validated
from warprock.errors import NOTHING
from warprock.model.hold import SIDES
from warprock.quantity import Column, NumberKey, TextKey
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
            "the elongation of the tie before it pulls; of one that acts both ways 0",
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


MOVES, STAYS = "moves", "stays"
"""What the point does at which a load presses: it moves with the block, or stays where it is."""


class TopLoad(Table):
    """A load on the top of a single block: forces without inertia, of a roof or a floor."""

    place: ClassVar[str] = "top_load"

    weight: Annotated[
        float,
        NumberKey(
            "the weight on top of the block",
            "0 N to 1e12 N",
            swept=True,
            column=Column("load_weight"),
        ),
    ] = 0.0
    eccentricity: Annotated[
        float,
        NumberKey(
            "the distance of the weight from the middle of the top, towards +x",
            "-1 km to 1 km",
            swept=True,
            column=Column("load_eccentricity", "mm"),
        ),
    ] = 0.0
    point: Annotated[
        str,
        TextKey(
            "whether the point at which the weight presses moves with the block, or stays",
            (MOVES, STAYS),
            swept=True,
            column=Column("load_point", text="Whether the point of the weight moves or stays"),
        ),
    ] = MOVES
    thrust: Annotated[
        float,
        NumberKey(
            "the thrust on top of the block, towards +x",
            "-1e12 N to 1e12 N",
            swept=True,
            column=Column("load_thrust"),
        ),
    ] = 0.0


class Frame(Table):
    """A frame of equal columns, each the block of the case, capped by a beam."""

    place: ClassVar[str] = "frame"

    columns: Annotated[
        float,
        NumberKey("the number of columns", "1 to 1000", swept=True, column=Column("frame_columns")),
    ]
    beam_mass: Annotated[
        float,
        NumberKey(
            "the mass of the beam on the columns",
            "0 kg to 1e9 kg",
            swept=True,
            column=Column("beam_mass"),
        ),
    ]


class Strip(Table):
    """A strip of wall between two floors: the block, in two pieces with a hinge between them."""

    place: ClassVar[str] = "strip"

    hinge_height: Annotated[
        float,
        NumberKey(
            "the height of the hinge over the height of the strip",
            "0.1 to 0.9",
            swept=True,
            column=Column("hinge_height"),
        ),
    ]
    weight: Annotated[
        float,
        NumberKey(
            "the weight that the floor above lays on the strip",
            "0 N to 1e12 N",
            swept=True,
            column=Column("floor_weight"),
        ),
    ] = 0.0
    eccentricity: Annotated[
        float | None,
        NumberKey(
            "the distance, towards +x, of the point that the floor above bears on from the middle "
            "of the top; without it that is the edge that rises",
            "-1 km to 1 km",
            swept=True,
            column=Column("floor_eccentricity", "mm"),
        ),
    ] = None


class Ground(Table):
    """Compliant ground below a single block: springs and dampers that press and do not pull."""

    place: ClassVar[str] = "ground"

    stiffness: Annotated[
        float,
        NumberKey(
            "the stiffness of the ground below the base, a unit of area",
            "1e4 N/m^3 to 1e13 N/m^3",
            swept=True,
            column=Column("ground_stiffness"),
        ),
    ]
    damping: Annotated[
        float,
        NumberKey(
            "the damping of the ground below the base, a unit of area",
            "0 N s/m^3 to 1e12 N s/m^3",
            swept=True,
            column=Column("ground_damping"),
        ),
    ] = 0.0


@dataclasses.dataclass(frozen=True)
class Ties:
    """The ties of a block.

    Attributes:
        numbered: Each tie by its number.
    """

    numbered: Mapping[str, Tie]

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.numbered)


def read_ties(ties: object) -> Ties:
    """Reads the ties of a case: their numbers before what is in them."""
    if not isinstance(ties, Mapping) or not ties:
        raise KeyedError((), ties, "must be [[tie]] tables")
    known = [str(number) for number in range(1, MOST_TIES + 1)]
    for name in ties:
        if name not in known:
            allowed = f"must be [[tie]] tables, at most {MOST_TIES}, or [tie.1], [tie.2] and so on"
            if name in Tie.declared():
                allowed = f"must have the number of its tie, tie.1.{name}, or be in [[tie]]"
            raise KeyedError(name, ties[name], allowed)
    for number in known[: len(ties)]:
        if number not in ties:
            raise KeyedError(number, NOTHING, "must be given: ties are numbered from 1")
    found = {}
    for name, tie in ties.items():
        with below(name):
            found[name] = validated(Tie, tie)
    return Ties(found)


def number_ties(raw: dict[str, Any]) -> None:
    """Gives the [[tie]] tables of a case as written numbers from 1, by which keys name them."""
    ties = raw.get("tie")
    if isinstance(ties, list | tuple):
        raw["tie"] = {str(number): tie for number, tie in enumerate(ties, 1)}
