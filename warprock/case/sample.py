"""The table [sample] of a case: lanes whose inputs are drawn from distributions.

A sample is one more axis of the case, the fastest: every cell of the sweep has the same sample
(common random numbers). Unlike the members of an ensemble, which lie close about what a cell is,
its lanes are drawn from all that a study covers, each a lane of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Self

import pydantic

from warprock.case.axes import Axis, Column
from warprock.case.keys import DRAWN_KEYS, KEYS, general_key
from warprock.case.sampling import (
    END_SCORE,
    MOST_POINTS,
    SAMPLING,
    SEED,
    Distribution,
    Sample,
    Shape,
)
from warprock.case.sweep import OwnKey, Written, axis_keys, read_list
from warprock.case.validation import KeyedError, Table, below, unknown_key, validated
from warprock.case.value_kinds import ChoiceKey, OtherKey, WholeKey
from warprock.errors import NOTHING, Said, did_you_mean
from warprock.quantity import NumberKey, TextKey
from warprock.settings.setting import SettingKey
from warprock.units import Quantity, format_quantity


class _Drawn(Table):
    """What every distribution has: its shape."""

    place: ClassVar[str] = "sample.over.KEY"
    shape: ClassVar[Shape]

    distribution: Annotated[Shape, ChoiceKey("the shape of the distribution", tuple(Shape))]

    @classmethod
    def lacking(cls, _name: str, _context: Any) -> str:
        """What is said where a key is missing that must be given."""
        return f"must be given with distribution {cls.shape}"

    def _refuse_misfits(self, numbers: Mapping[str, Written | None]) -> None:
        """Refuses numbers that do not fit together.

        Args:
            numbers: The numbers by their names in the file; None is not given.

        Raises:
            KeyedError: They are of several kinds, one is not above 0 that must be, or to is not
                above from.
        """
        given = {name: end for name, end in numbers.items() if end is not None}
        first, one = next(iter(given.items()))
        for name, end in given.items():
            if end.quantity.dimension is not one.quantity.dimension:
                allowed = f"must be of the kind of {first}, {one.quantity.dimension}"
                raise KeyedError(name, end.text, allowed)
            if self.shape is not Shape.UNIFORM and end.quantity.value <= 0.0:
                raise KeyedError(name, end.text, f"must be > 0 with distribution {self.shape}")
        if "from" in given and "to" in given:
            low, high = given["from"], given["to"]
            if not low.quantity.value < high.quantity.value:
                raise KeyedError("to", high.text, f"must be more than {low.text}")


class Uniform(_Drawn):
    """A uniform distribution between two ends."""

    shape: ClassVar[Shape] = Shape.UNIFORM

    low: Annotated[Written, OwnKey("the least value"), pydantic.Field(alias="from")]
    high: Annotated[Written, OwnKey("the greatest value"), pydantic.Field(alias="to")]

    @pydantic.model_validator(mode="after")
    def _judge(self) -> Self:
        self._refuse_misfits({"from": self.low, "to": self.high})
        return self

    def read(self) -> Distribution:
        """The distribution."""
        low, high = self.low.quantity, self.high.quantity
        return Distribution(self.shape, low.dimension, low.value, high.value, self.low.text)


class Loguniform(Uniform):
    """A log-uniform distribution between two ends."""

    shape: ClassVar[Shape] = Shape.LOGUNIFORM


class Lognormal(_Drawn):
    """A number whose logarithm is normal; its tails may be cut."""

    shape: ClassVar[Shape] = Shape.LOGNORMAL

    median: Annotated[Written, OwnKey("the median before the tails are cut")]
    dispersion: Annotated[
        float, SettingKey("the standard deviation of the logarithm", 0.0, 5.0, low_open=True)
    ]
    low: Annotated[
        Written | None, OwnKey("where the lower tail is cut"), pydantic.Field(alias="from")
    ] = None
    high: Annotated[
        Written | None, OwnKey("where the upper tail is cut"), pydantic.Field(alias="to")
    ] = None

    @pydantic.model_validator(mode="after")
    def _judge(self) -> Self:
        self._refuse_misfits({"median": self.median, "from": self.low, "to": self.high})
        return self

    def judge(self, key: str, declared: NumberKey) -> None:
        """Refuses a tail that leaves the bounds of its key, and a median that is cut off.

        Raises:
            KeyedError: It does.
        """
        found = self.read()
        if not found.low <= found.median <= found.high:
            raise KeyedError("median", self.median.text, "must lie between from and to")
        reach = math.exp(END_SCORE * self.dispersion)
        for end, value in (
            ("from", max(found.low, found.median / reach)),
            ("to", min(found.high, found.median * reach)),
        ):
            try:
                declared.judge(Quantity(value, found.dimension))
            except ValueError as error:
                reached = format_quantity(value, found.dimension, None)
                allowed = f"must be given: {key} would reach {reached}, but {error}"
                raise KeyedError(end, NOTHING, allowed) from None

    def read(self) -> Distribution:
        """The distribution."""
        median = self.median.quantity
        return Distribution(
            self.shape,
            median.dimension,
            self.low.quantity.value if self.low else 0.0,
            self.high.quantity.value if self.high else math.inf,
            self.median.text,
            median.value,
            self.dispersion,
        )


DISTRIBUTIONS: dict[Shape, type[Uniform] | type[Lognormal]] = {
    each.shape: each for each in (Uniform, Loguniform, Lognormal)
}
"""Shape -> what a table of that distribution holds."""


def _read_over(over: object) -> dict[str, Column]:
    """Keys and what each is drawn from, in the order of the case."""
    if not isinstance(over, Mapping):
        raise KeyedError((), over, "must be a table of keys and distributions")
    found: dict[str, Column] = {}
    for key, got in axis_keys(over).items():
        if general_key(key) not in DRAWN_KEYS:
            raise unknown_key(key, got, DRAWN_KEYS)
        declared = KEYS[general_key(key)]
        with below(key):
            found[key] = _read_column(key, declared, got)
    return found


def _read_column(key: str, declared: NumberKey | TextKey, got: object) -> Column:
    """What one key is drawn from."""
    if isinstance(got, list):
        return read_list(declared, got)
    if isinstance(got, Mapping) and isinstance(declared, NumberKey):
        return _read_distribution(key, declared, got)
    one = "a distribution, { distribution, ... }, or " * isinstance(declared, NumberKey)
    raise KeyedError((), got, f"must be {one}a list, of which each is as likely")


def _read_distribution(key: str, declared: NumberKey, table: Mapping[str, object]) -> Distribution:
    """One distribution; all of its values must lie within the bounds of its key."""
    name = table.get("distribution", NOTHING)
    if not isinstance(name, str) or name not in tuple(Shape):
        allowed = f"must be one of {', '.join(Shape)}{did_you_mean(name, tuple(Shape))}"
        raise KeyedError("distribution", name, allowed)
    found = validated(DISTRIBUTIONS[Shape(name)], table, declared)
    if isinstance(found, Lognormal):
        found.judge(key, declared)
    return found.read()


class SampleTable(Table):
    """How many lanes are drawn, and from what."""

    place: ClassVar[str] = "sample"

    lanes: Annotated[int, WholeKey("lanes that each cell of the sweep has", 1, MOST_POINTS)]
    seed: Annotated[int, SEED] = 1
    sampling: Annotated[str, SAMPLING] = "sobol"
    over: Annotated[
        dict[str, Any],
        OtherKey(
            "the keys that are drawn, each from a distribution or a list",
            "table of keys that may be swept",
            _read_over,
        ),
    ] = pydantic.Field(default_factory=dict)

    @pydantic.field_validator("over", mode="before")
    @classmethod
    def _not_swept(cls, over: object, info: pydantic.ValidationInfo) -> object:
        """Refuses a key that is in `info.context`, the keys that are swept."""
        for key, got in axis_keys(over).items() if isinstance(over, Mapping) else ():
            if key in (info.context or ()):
                allowed = "must be in [[sweep]] or in [sample], not in both"
                raise KeyedError(key, got, allowed)
        return over

    @pydantic.model_validator(mode="after")
    def _draws_something(self) -> Self:
        if not self.over:
            raise KeyedError("over", NOTHING, "must name at least one key and its distribution")
        return self


def read_sample(raw: Mapping[str, Any], axes: Sequence[Axis]) -> tuple[Axis, ...]:
    """The axis that a case's sample makes; none without a sample.

    Args:
        raw: The case.
        axes: Its sweep.

    Raises:
        KeyedError: An ensemble beside it, an unknown key, a number out of bounds, a key that cannot
            be drawn or is swept as well, or a distribution that leaves the bounds of its key.
    """
    if "sample" not in raw:
        return ()
    with below("sample"):
        if "ensemble" in raw:
            allowed = "must not be given beside [ensemble]: draw from wider distributions instead"
            raise KeyedError((), Said("a table"), allowed)
        table = validated(
            SampleTable, raw["sample"], {key for axis in axes for key in axis.columns}
        )
    sample = Sample(table.sampling, table.seed, table.lanes, len(table.over))
    return (Axis(table.over, table.lanes, sample),)
