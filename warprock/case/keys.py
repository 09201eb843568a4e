"""Every value that a lane of a case may have: its key, what it measures, its bounds.

One table serves the case file, its sweeps and the overrides, so that a value is judged the same
way wherever it is written.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from warprock.errors import InputError, did_you_mean, listed
from warprock.model.motion import Control, Waveform
from warprock.quantity import AMPLITUDE, NOTHING, FrictionKey, NumberKey, TextKey
from warprock.units import Dimension

SourceOf = Callable[[str], str]
"""Dotted key -> what an error about it names as its source."""


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
    "motion.amplitude": AMPLITUDE,
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
