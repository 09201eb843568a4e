"""The [spectrum] table of a case: blocks of many sizes, curve by curve of one slenderness.

It is one more axis of the case: for every slenderness angle, slowest, the blocks whose 2 pi / p is
each of the periods. With p^2 = 3 g / (4 R) the half diagonal is R = 3 g T^2 / (16 pi^2), and the
full sizes are 2 R sin(alpha) and 2 R cos(alpha).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from warprock.case.axes import LABEL, Axis, Numbers, Texts, read_values
from warprock.case.keys import KEYS, SourceOf, read_table
from warprock.errors import InputError
from warprock.quantity import NOTHING, NumberKey, Said
from warprock.units import GRAVITY, Dimension, Quantity

SPECTRUM, SLENDERNESS = "spectrum", "slenderness"
"""Name of the table, and of the label that its lanes have."""

SIZES = ("block.width", "block.height")

PERIOD = NumberKey(
    {Dimension.TIME: ("0.05 s", "100 s")}, "2 pi / p, p the frequency parameter of the block"
)
ANGLE = NumberKey(
    {Dimension.ANGLE: ("0.01 deg", "90 deg")}, "the slenderness angle of the block", high_open=True
)
_READERS = {"period": PERIOD, SLENDERNESS: ANGLE}


def read_spectrum(
    raw: Mapping[str, Any], axes: Sequence[Axis], source_of: SourceOf
) -> tuple[Axis, ...]:
    """The axis that a case's spectrum makes; none without one.

    Args:
        raw: The case.
        axes: Its sweep.
        source_of: Dotted key -> what an error about it names as its source.

    Raises:
        InputError: An unknown key, a value out of bounds, a stack, or sizes of the block that are
            given in another place as well.
    """
    if SPECTRUM not in raw:
        return ()
    table = read_table(raw, SPECTRUM, _READERS, source_of)
    _refuse_sizes(raw, axes, source_of)
    found: dict[str, Numbers] = {}
    for name, reader in _READERS.items():
        key = f"{SPECTRUM}.{name}"
        column = read_values(reader, table.get(name, NOTHING), source_of(key), key)
        assert isinstance(column, Numbers)
        found[name] = column
    return (_axis(found["period"], found[SLENDERNESS], table[SLENDERNESS], source_of),)


def _refuse_sizes(raw: Mapping[str, Any], axes: Sequence[Axis], source_of: SourceOf) -> None:
    """Refuses sizes that the spectrum gives already, and blocks that have no one slenderness."""
    block = raw.get("block", {})
    given = [f"block.{name}" for name in block] if isinstance(block, Mapping) else []
    swept = [key for axis in axes for key in axis.columns]
    for key in (*given, *swept):
        if key in SIZES or key == LABEL + SLENDERNESS:
            allowed = "must not be given beside [spectrum], which makes it"
            raise InputError(source_of(key), key, Said("a value"), allowed)
        if key.removeprefix("block.").isdecimal():
            allowed = "must be one block, not a stack: it has one slenderness"
            raise InputError(source_of(SPECTRUM), "block", Said("a stack"), allowed)


def _axis(period: Numbers, angle: Numbers, written: object, source_of: SourceOf) -> Axis:
    """Every period of the first angle, then those of the next."""
    names = [f"{number:.6g} deg" for number in np.rad2deg(angle.values)]
    if isinstance(written, list):
        names = [str(name) for name in written]
    if len(set(names)) < len(names):
        key = f"{SPECTRUM}.{SLENDERNESS}"
        raise InputError(source_of(key), key, written, "must not have a value twice")
    periods, angles = len(period.values), len(angle.values)
    diagonal = np.tile(3.0 * GRAVITY * period.values**2 / (8.0 * np.pi**2), angles)
    turned = np.repeat(angle.values, periods)
    columns: dict[str, Numbers | Texts] = {
        LABEL + SLENDERNESS: Texts(
            tuple(names), np.repeat(np.arange(angles, dtype=np.int32), periods)
        )
    }
    sizes = (diagonal * np.sin(turned), diagonal * np.cos(turned))
    for key, values in zip(SIZES, sizes, strict=True):
        reader = KEYS[key]
        assert isinstance(reader, NumberKey)
        for end in (values.min(), values.max()):
            try:
                reader.judge(Quantity(float(end), Dimension.LENGTH))
            except ValueError as error:
                got = Said(f"{key} {end:.4g} m")
                raise InputError(source_of(SPECTRUM), SPECTRUM, got, str(error)) from None
        columns[key] = Numbers(values, Dimension.LENGTH, f"{float(values[0])!r} m")
    return Axis(columns, periods * angles)
