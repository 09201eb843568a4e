"""The [[check]] tables of a case: what it states about its own results, and why."""

from __future__ import annotations

from typing import Annotated, Literal

import pydantic

from warprock.case.table import Table
from warprock.quantity import TextKey
from warprock.settings.engines import SETTINGS

_Positive = Annotated[float, pydantic.Field(gt=0.0, allow_inf_nan=False)]


class Check(Table):
    """What every check has.

    Attributes:
        engine: Engine that is checked.
        because: Why the numbers are right and where the tolerance comes from.
        where: Label -> value that selects lanes; empty selects all.
    """

    engine: str
    because: Annotated[str, pydantic.Field(min_length=1)]
    where: dict[str, str] = pydantic.Field(default_factory=dict)

    @pydantic.field_validator("engine")
    @classmethod
    def _known_engine(cls, engine: str) -> str:
        return TextKey("an engine", tuple(SETTINGS)).read(engine)


class PeaksCheck(Check):
    """Peak rotations / slenderness angle of the selected lanes, in lane order.

    Attributes:
        block: Number of the block in a stack, whose own slenderness angle counts.
        values: Expected ratios.
        tolerance: Largest absolute difference of a ratio.
    """

    kind: Literal["peaks"]
    block: Annotated[int, pydantic.Field(ge=1)] | None = None
    values: Annotated[
        tuple[Annotated[float, pydantic.Field(ge=0.0, allow_inf_nan=False)], ...],
        pydantic.Field(min_length=1),
    ]
    tolerance: _Positive


class HousnerCheck(Check):
    """Rotation histories against the engine `housner`, where Housner's assumptions hold.

    Attributes:
        limit_5s: Largest |rotation - reference| / slenderness angle over the first 5 s.
        limit_run: The same over the whole run; None does not check it.
    """

    kind: Literal["housner"]
    limit_5s: _Positive
    limit_run: _Positive | None = None


class BoundariesCheck(Check):
    """Strengths of a pulse at which a map of overturning changes its mode, weakest first.

    Attributes:
        frequency_ratio: Angular frequency of the pulse / frequency parameter of the block.
        values: Peak accelerations / (g tan(slenderness angle)).
        tolerance: Largest absolute difference of a value.
    """

    kind: Literal["boundaries"]
    frequency_ratio: _Positive
    values: Annotated[tuple[_Positive, ...], pydantic.Field(min_length=1)]
    tolerance: _Positive


CheckSpec = PeaksCheck | HousnerCheck | BoundariesCheck
