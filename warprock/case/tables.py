"""The tables of a case file as pydantic models: which keys exist, and which belong together.

Values are floats in SI units or rad; bounds and units of each key are in `case_keys.KEYS`.
"""

from __future__ import annotations

import types
import typing
from collections.abc import Sequence
from typing import Annotated, Any, Self

import pydantic

from warprock.case.blocks import SINGLE, STACK, Block, Stack, StackedBlock, single_or_stack
from warprock.case.checks import Check, CheckSpec
from warprock.case.keys import KEYS
from warprock.case.table import KeyedError, Table, number
from warprock.model.motion import Control, Waveform
from warprock.quantity import NOTHING, Said, TextKey
from warprock.units import Quantity

APART = ("sweep", "spectrum", "sample", "ensemble", "study")
"""Tables of a case that have readers of their own."""


class Contact(Table):
    """What happens between block and base."""

    friction: Annotated[float, number("contact.friction")]
    angular_restitution: Annotated[float, number("contact.angular_restitution")] | None = None


class Start(Table):
    """How the block is released: its attitude [rad] and the gap below it [m].

    The rotation may be given as a part of the slenderness angle.
    """

    rotation: Annotated[float, number("start.rotation")] | None = None
    rotation_ratio: Annotated[float, number("start.rotation_ratio")] | None = None
    rotation_across: Annotated[float, number("start.rotation_across")] | None = None
    yaw: Annotated[float, number("start.yaw")] | None = None
    gap: Annotated[float, number("start.gap")] | None = None

    @pydantic.model_validator(mode="after")
    def _one_rotation(self) -> Self:
        if self.rotation is not None and self.rotation_ratio is not None:
            raise KeyedError(
                "rotation_ratio", self.rotation_ratio, "must not be given beside start.rotation"
            )
        return self


# Keys of [motion] by waveform: those it needs and those it may have.
_SINE_KEYS = (("control", "frequency", "amplitude"), ("start", "cycles", "duration"))
_MOTION_KEYS: dict[Waveform, tuple[tuple[str, ...], tuple[str, ...]]] = {
    Waveform.SINE: _SINE_KEYS,
    Waveform.COSINE: _SINE_KEYS,
    Waveform.RICKER: (("control", "frequency", "amplitude"), ("start",)),
    Waveform.MAVROEIDIS_PAPAGEORGIOU: (
        ("control", "frequency", "amplitude", "cycles"),
        ("start", "phase"),
    ),
    Waveform.RECORD: (("record",), ("scale", "start")),
}


class Direction(Table):
    """How the base moves along one axis: a waveform under a control, or a record times a scale."""

    waveform: Annotated[Waveform, pydantic.BeforeValidator(KEYS["motion.waveform"].read)]
    control: Annotated[Control, pydantic.BeforeValidator(KEYS["motion.control"].read)] | None = None
    frequency: Annotated[float, number("motion.frequency")] | None = None
    amplitude: (
        Annotated[Quantity, pydantic.PlainValidator(KEYS["motion.amplitude"].read)] | None
    ) = None
    start: Annotated[float, number("motion.start")] = 0.0
    cycles: Annotated[float, number("motion.cycles")] | None = None
    duration: Annotated[float, number("motion.duration")] | None = None
    phase: Annotated[float, number("motion.phase")] = 0.0
    record: Annotated[str, pydantic.BeforeValidator(KEYS["motion.record"].read)] | None = None
    scale: Annotated[float, number("motion.scale")] = 1.0

    def takes(self, name: str) -> bool:
        """Whether the waveform has a use for a key of this table."""
        return any(name in names for names in _MOTION_KEYS[self.waveform])

    @pydantic.model_validator(mode="after")
    def _keys_of_the_waveform(self) -> Self:
        needed, optional = _MOTION_KEYS[self.waveform]
        given = self.model_fields_set - {"waveform", "y", "z"}
        for name in Direction.model_fields:
            if name in given and name not in needed + optional:
                allowed = f"must not be given with waveform {self.waveform}"
                raise KeyedError(name, getattr(self, name), allowed)
        for name in needed:
            if name not in given:
                raise KeyedError(name, NOTHING, KEYS[f"motion.{name}"].allowed)
        if "cycles" in optional:
            if {"cycles", "duration"} <= given:
                raise KeyedError(
                    "duration", self.duration, "must not be given beside motion.cycles"
                )
            if not {"cycles", "duration"} & given:
                raise KeyedError("cycles", NOTHING, "must be given, or motion.duration")
        return self


class Motion(Direction):
    """How the base moves: along x, and in space also along y and z."""

    y: Direction | None = None
    z: Direction | None = None


MOST_SAMPLES = 1_000_000
"""Samples of a history that a case may ask for: more than a figure shows or a table is read for."""


class Run(Table):
    """Length of the run and time between samples of its histories [s]."""

    duration: Annotated[float, number("run.duration")]
    sample_interval: Annotated[float, number("run.sample_interval")] | None = None

    @pydantic.model_validator(mode="after")
    def _interval_inside(self) -> Self:
        if self.sample_interval is not None and self.sample_interval > self.duration:
            allowed = f"must be at most run.duration, {self.duration:g} s"
            raise KeyedError("sample_interval", f"{self.sample_interval:g} s", allowed)
        if (
            self.sample_interval is not None
            and self.duration >= MOST_SAMPLES * self.sample_interval
        ):
            count = self.duration / self.sample_interval
            allowed = (
                f"must make less than {MOST_SAMPLES:,} samples of {self.duration:g} s, not "
                f"{count:.3g}: a history of {8e-9 * count:.3g} GB"
            )
            raise KeyedError("sample_interval", f"{self.sample_interval:g} s", allowed)
        return self


TITLE = TextKey("text that says what the case is")


class CaseTables(Table):
    """A case file without its sweep.

    Attributes:
        title: One line that says what the case is.
        source: Where its numbers come from.
        model: Whether the blocks move in the plane of rocking or in space; None lets the scene say.
        engines: Settings by engine; `engines.settings.build_settings` judges them.
        peers: Settings by program beside the engines; `case_settings.read_settings` judges them.
    """

    title: Annotated[str, pydantic.BeforeValidator(TITLE.read)]
    source: Annotated[str, pydantic.Field(min_length=1)]
    model: Annotated[str, pydantic.BeforeValidator(KEYS["model"].read)] | None = None
    block: Annotated[
        Annotated[Block, pydantic.Tag(SINGLE)] | Annotated[Stack, pydantic.Tag(STACK)],
        pydantic.Discriminator(single_or_stack),
    ]
    contact: Contact
    start: Start = Start()
    motion: Motion | None = None
    run: Run
    engines: dict[str, dict[str, Any]] = pydantic.Field(default_factory=dict)
    peers: dict[str, dict[str, Any]] = pydantic.Field(default_factory=dict)
    check: tuple[Annotated[CheckSpec, pydantic.Field(discriminator="kind")], ...] = ()

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
        return len(self.block.root) if isinstance(self.block, Stack) else 1

    def constant(self, key: str) -> Any:
        """Value of a dotted key, SI units or rad; None where the case does not give it."""
        found: Any = self
        for name in key.split("."):
            stack = isinstance(found, Stack)
            found = found.root.get(name) if stack else getattr(found, name, None)
        return found


def known_keys(location: Sequence[int | str]) -> list[str]:
    """Dotted keys of the table that an unknown key was found in.

    Args:
        location: Path of the unknown key as pydantic gives it: with positions in lists and the
            kind of a check.
    """
    table: type[pydantic.BaseModel] = CaseTables
    path: list[str] = []
    for part in location[:-1]:
        if isinstance(part, int) or part == SINGLE:
            continue
        if part == STACK:
            table = StackedBlock
        elif str(part).isdecimal() and table is StackedBlock:
            path.append("N")
        elif part in table.model_fields:
            path.append(part)
            tables = list(_tables_in(table.model_fields[part].annotation))
            table = tables[0] if tables else table
        else:
            table = next(t for t in typing.get_args(CheckSpec) if part == _kind(t))
    names = list(table.model_fields) + (list(APART) if table is CaseTables else [])
    return [".".join([*path, name]) for name in names]


def _kind(check: type[Check]) -> str:
    return str(typing.get_args(check.model_fields["kind"].annotation)[0])


def _tables_in(annotation: Any) -> list[type[pydantic.BaseModel]]:
    """Models inside an annotation such as `Motion | None`."""
    if isinstance(annotation, type) and not isinstance(annotation, types.GenericAlias):
        return [annotation] if issubclass(annotation, pydantic.BaseModel) else []
    return [found for inner in typing.get_args(annotation) for found in _tables_in(inner)]
