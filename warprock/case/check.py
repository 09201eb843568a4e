"""The tables [[check]]: what a case states about its own results, and why."""

from __future__ import annotations

import math
import typing
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

import pydantic

from warprock.case.validation import KeyedError, Table, validated
from warprock.case.value_kinds import OtherKey, ProseKey
from warprock.errors import NOTHING
from warprock.model.runnable import HIGHEST_STACK
from warprock.quantity import NumberKey, TextKey
from warprock.settings.engines import SETTINGS
from warprock.settings.setting import SettingKey


def _more_than_0(text: str) -> SettingKey:
    return SettingKey(text, 0.0, math.inf, low_open=True)


class Check(Table):
    """What every check has."""

    place: ClassVar[str] = "check"

    engine: Annotated[str, TextKey("an engine", tuple(SETTINGS))]
    because: Annotated[
        str, ProseKey("why the numbers are right and where the tolerance comes from")
    ]
    where: Annotated[
        dict[str, str],
        OtherKey("the lanes that are checked; all without it", "table of labels and values"),
    ] = pydantic.Field(default_factory=dict)


class PeaksCheck(Check):
    """Peak rotations / slenderness angle of the selected lanes, in lane order."""

    kind: Literal["peaks"]
    block: Annotated[
        int | None,
        SettingKey("number of the block in a stack, whose own angle counts", 1, HIGHEST_STACK),
    ] = None
    values: Annotated[
        tuple[Annotated[float, SettingKey("ratios that are expected", 0.0, math.inf)], ...],
        pydantic.Field(min_length=1),
    ]
    tolerance: Annotated[float, _more_than_0("the largest absolute difference of a ratio")]


class HousnerCheck(Check):
    """Rotation histories against the engine `housner`, where Housner's assumptions hold."""

    kind: Literal["housner"]
    limit_5s: Annotated[
        float,
        _more_than_0("the largest |rotation - reference| / slenderness angle in the first 5 s"),
    ]
    limit_run: Annotated[
        float | None,
        _more_than_0(
            "the largest |rotation - reference| / slenderness angle in the whole run; without it "
            "only the first 5 s count"
        ),
    ] = None


class BoundariesCheck(Check):
    """Strengths of a pulse at which a map of overturning changes its mode, weakest first."""

    kind: Literal["boundaries"]
    frequency_ratio: Annotated[
        float,
        _more_than_0("the angular frequency of the pulse / frequency parameter of the block"),
    ]
    values: Annotated[
        tuple[
            Annotated[float, _more_than_0("peak accelerations / (g tan(slenderness angle))")], ...
        ],
        pydantic.Field(min_length=1),
    ]
    tolerance: Annotated[float, _more_than_0("the largest absolute difference of a value")]


class PosesCheck(Check):
    """Where the blocks of the selected lanes are, against where they were seen."""

    kind: Literal["poses"]
    file: Annotated[
        str, TextKey("the path of a CSV file with the poses that were observed", most=4096)
    ]
    position: Annotated[
        float,
        NumberKey("the largest mean error of the position", "0 m to 1 km", low_open=True),
    ]
    rotation: Annotated[
        float,
        NumberKey("the largest mean error of the rotation", "0 deg to 180 deg", low_open=True),
    ]


class OutcomesCheck(Check):
    """What becomes of blocks against what tests showed, as `warprock validate` counts it."""

    kind: Literal["outcomes"]
    observed: Annotated[
        str | None,
        TextKey("file with one row a test, from the folder of the case; else the label observed"),
    ] = None
    limit_wrong: Annotated[
        float, SettingKey("the largest share of tests that may be said wrongly", 0.0, 1.0)
    ]
    limit_brier: Annotated[
        float | None,
        SettingKey("the largest Brier score, which is not checked without it", 0.0, 1.0),
    ] = None


CheckSpec = PeaksCheck | HousnerCheck | BoundariesCheck | OutcomesCheck | PosesCheck


def kind_of(check: type[Check]) -> str:
    """The word under `kind` that makes a check one of this type."""
    return str(typing.get_args(check.model_fields["kind"].annotation)[0])


CHECKS: dict[str, type[CheckSpec]] = {
    kind_of(check): check
    for check in (PeaksCheck, HousnerCheck, BoundariesCheck, OutcomesCheck, PosesCheck)
}
"""Kind of a check -> its keys."""


def read_check(table: Any) -> CheckSpec:
    """A check of the kind that it says it is."""
    if not isinstance(table, Mapping):
        raise KeyedError((), table, "must be a table")
    kind = table.get("kind", NOTHING)
    if not isinstance(kind, str) or kind not in CHECKS:
        *first, last = CHECKS
        raise KeyedError("kind", kind, f"must be {', '.join(first)} or {last}")
    return validated(CHECKS[kind], table)
