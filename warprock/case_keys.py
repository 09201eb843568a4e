"""Every value that a lane of a case may have: its key, what it measures, its bounds.

One table serves the case file, its sweeps and the overrides, so that a value is judged the same
way wherever it is written.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from warprock.errors import InputError, is_plain, listed
from warprock.motion import Control, Waveform
from warprock.units import Dimension, Quantity, allowed_text, parse_any, parse_quantity


class Said(str):
    """Text that an error shows as it is, without quotes: "nothing", "3 and 2 values"."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


NOTHING = Said("nothing")

SourceOf = Callable[[str], str]
"""Dotted key -> what an error about it names as its source."""


@dataclasses.dataclass(frozen=True)
class NumberKey:
    """A key whose value is a number, mostly with a unit.

    Attributes:
        bounds: Least and greatest value as a user would write them, by dimension allowed.
        text: Meaning.
        low_open: Whether the least value itself is excluded.
        high_open: Whether the greatest value itself is excluded.
    """

    bounds: Mapping[Dimension, tuple[str, str]]
    text: str
    low_open: bool = False
    high_open: bool = False

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        return f"must be {self.text}: {allowed_text(self.bounds)}"

    def read(self, got: object) -> Quantity:
        """The value in SI units or rad.

        Raises:
            ValueError: Not a quantity of an allowed dimension, or outside its bounds.
        """
        quantity = parse_any(got, self.bounds)
        self.judge(quantity)
        return quantity

    def judge(self, quantity: Quantity) -> None:
        """Refuses a value outside the bounds of its dimension.

        Raises:
            ValueError: It is outside.
        """
        low_text, high_text = self.bounds[quantity.dimension]
        low, high = (parse_quantity(t, quantity.dimension) for t in (low_text, high_text))
        below = quantity.value < low or (self.low_open and quantity.value == low)
        above = quantity.value > high or (self.high_open and quantity.value == high)
        if below or above:
            more = f"more than {low_text}" if self.low_open else f"at least {low_text}"
            less = f"less than {high_text}" if self.high_open else f"at most {high_text}"
            raise ValueError(f"must be {self.text}, {more} and {less}")

    def read_number(self, got: object) -> float:
        """The value in SI units or rad, without its dimension."""
        return self.read(got).value


@dataclasses.dataclass(frozen=True)
class FrictionKey(NumberKey):
    """A friction coefficient, which may also be written as a friction angle."""

    def read(self, got: object) -> Quantity:
        """The friction coefficient."""
        quantity = super().read(got)
        if quantity.dimension is Dimension.ANGLE:
            return Quantity(math.tan(quantity.value), Dimension.DIMENSIONLESS)
        return quantity


@dataclasses.dataclass(frozen=True)
class TextKey:
    """A key whose value is one line of text, one of some choices if it has any.

    Attributes:
        text: Meaning.
        choices: What it may be; anything where there are none.
        most: Characters that it may have.
    """

    text: str
    choices: tuple[str, ...] = ()
    most: int = 300

    @property
    def allowed(self) -> str:
        """What may be written, as the end of an error message."""
        return f"must be {self.text}" + (f": {', '.join(self.choices)}" if self.choices else "")

    def read(self, got: object) -> str:
        """The text.

        Raises:
            ValueError: Not text, empty, or not one of the choices.
        """
        if (
            not isinstance(got, str)
            or not got.strip()
            or (self.choices and got not in self.choices)
        ):
            raise ValueError(self.allowed + did_you_mean(got, self.choices))
        if len(got) > self.most or not is_plain(got):
            raise ValueError(
                f"{self.allowed}, one line of at most {self.most} characters without control "
                "characters"
            )
        return got


_FRICTION_BOUNDS = {Dimension.DIMENSIONLESS: ("0", "100"), Dimension.ANGLE: ("0 deg", "89 deg")}


def _length(text: str) -> NumberKey:
    return NumberKey({Dimension.LENGTH: ("1 mm", "1 km")}, text)


def _shift(text: str) -> NumberKey:
    return NumberKey({Dimension.LENGTH: ("-1 km", "1 km")}, f"the distance {text}")


def _yaw(text: str) -> NumberKey:
    return NumberKey({Dimension.ANGLE: ("-180 deg", "180 deg")}, text)


def _ratio(low: str, high: str, text: str, **ends: bool) -> NumberKey:
    return NumberKey({Dimension.DIMENSIONLESS: (low, high)}, text, **ends)


PLANAR, SPATIAL = "planar", "spatial"

KEYS: dict[str, NumberKey | TextKey] = {
    "model": TextKey("the space that blocks move in", (PLANAR, SPATIAL)),
    "block.width": _length("the full width of the block in the plane of rocking"),
    "block.height": _length("the full height of the block"),
    "block.depth": _length("the full depth of the block across the plane of rocking"),
    "block.density": NumberKey(
        {Dimension.DENSITY: ("1e-3 kg/m^3", "1e5 kg/m^3")}, "the density of the block"
    ),
    "block.centre_offset_x": _shift("of the centre of mass from the middle, along the width"),
    "block.centre_offset_y": _shift("of the centre of mass from the middle, along the depth"),
    "contact.friction": FrictionKey(
        _FRICTION_BOUNDS,
        "the friction coefficient or the friction angle; above 4/3 a block that slides may have no "
        "unique answer",
    ),
    "contact.angular_restitution": _ratio(
        "0", "1", "the ratio of angular velocities after and before an impact", low_open=True
    ),
    "start.rotation": NumberKey(
        {Dimension.ANGLE: ("-90 deg", "90 deg")},
        "the rotation at the start",
        low_open=True,
        high_open=True,
    ),
    "start.rotation_ratio": _ratio(
        "-1",
        "1",
        "the rotation at the start divided by the slenderness angle",
        low_open=True,
        high_open=True,
    ),
    "start.rotation_across": NumberKey(
        {Dimension.ANGLE: ("-90 deg", "90 deg")},
        "the rotation across the plane of rocking at the start",
        low_open=True,
        high_open=True,
    ),
    "start.yaw": _yaw("the turn of the block about the vertical at the start"),
    "start.gap": NumberKey(
        {Dimension.LENGTH: ("0 m", "1 km")},
        "the height of the block's lowest corner above the base at the start",
    ),
    "motion.waveform": TextKey("a waveform", tuple(Waveform)),
    "motion.control": TextKey("the controlled quantity of the base", tuple(Control)),
    "motion.frequency": NumberKey(
        {Dimension.FREQUENCY: ("1e-4 Hz", "1e4 Hz")}, "the frequency of the waveform"
    ),
    "motion.amplitude": NumberKey(
        {
            Dimension.LENGTH: ("-100 m", "100 m"),
            Dimension.VELOCITY: ("-100 m/s", "100 m/s"),
            Dimension.ACCELERATION: ("-1000 m/s^2", "1000 m/s^2"),
        },
        "the amplitude of the waveform",
    ),
    "motion.start": NumberKey(
        {Dimension.TIME: ("0 s", "1e5 s")}, "the time at which the motion starts"
    ),
    "motion.cycles": _ratio("0", "1e7", "the number of cycles", low_open=True),
    "motion.phase": NumberKey(
        {Dimension.ANGLE: ("-360 deg", "360 deg")}, "the phase of a pulse in its middle"
    ),
    "motion.duration": NumberKey(
        {Dimension.TIME: ("0 s", "1e5 s")}, "the time from start to stop", low_open=True
    ),
    "motion.record": TextKey("the name of a record or the path of a file", most=4096),
    "motion.scale": _ratio("-1000", "1000", "the factor on the record"),
    "run.duration": NumberKey(
        {Dimension.TIME: ("0 s", "1e5 s")}, "the length of the run", low_open=True
    ),
    "run.sample_interval": NumberKey(
        {Dimension.TIME: ("0 s", "1e5 s")}, "the time between samples", low_open=True
    ),
    "block.N.width": _length("the full width of the block in the plane of rocking"),
    "block.N.height": _length("the full height of the block"),
    "block.N.depth": _length("the full depth of the block across the plane of rocking"),
    "block.N.density": NumberKey(
        {Dimension.DENSITY: ("1e-3 kg/m^3", "1e5 kg/m^3")}, "the density of the block"
    ),
    "block.N.chamfer": NumberKey(
        {Dimension.LENGTH: ("0 m", "1 km")}, "the width cut off each edge of the block"
    ),
    "block.N.offset": NumberKey(
        {Dimension.LENGTH: ("-1 km", "1 km")},
        "the distance of the block's centre to +x of the centre of the block below",
    ),
    "block.N.offset_across": _shift(
        "from the middle of the block below to the block's own, across the plane of rocking"
    ),
    "block.N.yaw": _yaw("the turn of the block about the vertical at the start"),
    "block.N.centre_offset_x": _shift("of the centre of mass from the middle, along the width"),
    "block.N.centre_offset_y": _shift("of the centre of mass from the middle, along the depth"),
    "block.N.friction": FrictionKey(
        _FRICTION_BOUNDS,
        "the friction coefficient or the friction angle of the face the block stands on",
    ),
    "block.N.rotation": NumberKey(
        {Dimension.ANGLE: ("-90 deg", "90 deg")},
        "the rotation of the block at the start",
        low_open=True,
        high_open=True,
    ),
}
"""Dotted key -> how its value is read; N stands for the number of a block in a stack."""

_BLOCK_NUMBER = re.compile(r"^block\.[1-9][0-9]*\.")
_DIRECTION = re.compile(r"^motion\.[yz]\.")


def general_key(key: str) -> str:
    """The key of `KEYS` that says how a key is read.

    block.2.width is an instance of block.N.width, motion.y.scale is read as motion.scale.
    """
    return _DIRECTION.sub("motion.", _BLOCK_NUMBER.sub("block.N.", key))


SWEEP_KEYS: tuple[str, ...] = tuple(
    key for key in KEYS if key != "model" and not key.startswith("run.")
)
"""Keys that may differ from lane to lane."""

EXCLUSIVE: dict[str, str] = {
    "start.rotation": "start.rotation_ratio",
    "start.rotation_ratio": "start.rotation",
    **{
        f"{table}.{name}": f"{table}.{other}"
        for table in ("motion", "motion.y", "motion.z")
        for name, other in (("cycles", "duration"), ("duration", "cycles"))
    },
}
"""Key -> the other key that says the same thing; only one of both may be given."""


def did_you_mean(got: object, known: Iterable[str]) -> str:
    """A suggestion for the end of an error message; empty if nothing is near.

    The last part of a dotted key counts more than the table in front of it.
    """
    known = tuple(known)
    tails = {key.rpartition(".")[2]: key for key in reversed(known)}
    near = difflib.get_close_matches(str(got).rpartition(".")[2], tails, 1)
    return f"; did you mean {tails[near[0]]}?" if near else ""


def read_table(
    raw: Mapping[str, Any], name: str, known: Iterable[str], source_of: SourceOf
) -> Mapping[str, Any]:
    """A table of a case, all of whose keys are known.

    Args:
        raw: The case, which has it.
        name: Its name.
        known: Keys that it may have.
        source_of: What errors name as their source.

    Raises:
        InputError: It is no table, or has another key.
    """
    table = raw[name]
    if not isinstance(table, Mapping):
        raise InputError(source_of(name), name, table, "must be a table")
    refuse_unknown(table, name, known, source_of)
    return table


def refuse_unknown(
    table: Mapping[str, object], place: str, known: Iterable[str], source_of: SourceOf
) -> None:
    """Refuses a key that a table cannot have, and suggests the one perhaps meant.

    Raises:
        InputError: There is one.
    """
    known = tuple(known)
    for name in table:
        if name not in known:
            key = f"{place}.{name}"
            allowed = f"unknown key (allowed: {listed(name, known)}){did_you_mean(name, known)}"
            raise InputError(source_of(key), key, table[name], allowed)


def read_whole(
    table: Mapping[str, Any],
    place: str,
    bounds: tuple[int, int],
    source_of: SourceOf,
    default: object = NOTHING,
) -> int:
    """A whole number of a table of a case.

    Args:
        table: The table.
        place: Its dotted key, the last part that in the table.
        bounds: The least and the most that it may be.
        source_of: What errors name as their source.
        default: What it is where the table does not say.

    Raises:
        InputError: It is no whole number, or out of bounds.
    """
    got, (low, high) = table.get(place.rpartition(".")[2], default), bounds
    if isinstance(got, bool) or not isinstance(got, int) or not low <= got <= high:
        raise InputError(
            source_of(place), place, got, f"must be a whole number from {low} to {high}"
        )
    return got


def read_choice(
    table: Mapping[str, Any], place: str, known: Sequence[str], source_of: SourceOf
) -> str:
    """One of some words in a table of a case, the first of them where it does not say.

    Args:
        table: The table.
        place: Its dotted key, the last part that in the table.
        known: The words.
        source_of: What errors name as their source.

    Raises:
        InputError: It is none of them.
    """
    got = table.get(place.rpartition(".")[2], known[0])
    if got not in known:
        allowed = f"must be {' or '.join(known)}{did_you_mean(got, known)}"
        raise InputError(source_of(place), place, got, allowed)
    return str(got)
