"""The table [spectrum] of a case: blocks of many sizes, curve by curve of one slenderness.

It is one more axis of the case: for every slenderness angle, slowest, the blocks whose 2 pi / p is
each of the periods. With p^2 = 3 g / (4 R) the half diagonal is R = 3 g T^2 / (16 pi^2), and the
full sizes are 2 R sin(alpha) and 2 R cos(alpha).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar

import numpy as np

from warprock.case.axes import LABEL, Axis, Numbers, Texts
from warprock.case.keys import KEYS
from warprock.case.sweep import LIST_OR_GRID, read_values
from warprock.case.validation import KeyedError, Table, below, validated
from warprock.case.value_kinds import OtherKey
from warprock.errors import Said
from warprock.quantity import NumberKey
from warprock.units import GRAVITY, Dimension, Quantity

SPECTRUM, SLENDERNESS = "spectrum", "slenderness"
"""Name of the table, and of the label that its lanes have."""

SIZES = ("block.width", "block.height")


def _series(text: str, bounds: str, *, high_open: bool = False) -> OtherKey:
    """A key that lists numbers or lays a grid of them."""
    each = NumberKey(text, bounds, high_open=high_open)
    holds = f"list or grid of values, {each.bounds_text}"
    return OtherKey(text, holds, lambda got: read_values(each, got), LIST_OR_GRID)


class SpectrumTable(Table):
    """Periods and slenderness angles of the blocks."""

    place: ClassVar[str] = SPECTRUM

    period: Annotated[
        Numbers, _series("2 pi / p, p the frequency parameter of the block", "0.05 s to 100 s")
    ]
    slenderness: Annotated[
        Numbers,
        _series("the slenderness angle of the block", "0.01 deg to 90 deg", high_open=True),
    ]


def read_spectrum(raw: Mapping[str, Any], axes: Sequence[Axis]) -> tuple[Axis, ...]:
    """The axis that a case's spectrum makes; none without one.

    Args:
        raw: The case.
        axes: Its sweep.

    Raises:
        KeyedError: An unknown key, a value out of bounds, a stack, or sizes of the block that are
            given in another place as well.
    """
    if SPECTRUM not in raw:
        return ()
    _refuse_sizes(raw, axes)
    with below(SPECTRUM):
        table = validated(SpectrumTable, raw[SPECTRUM])
    return (_axis(table.period, table.slenderness, raw[SPECTRUM][SLENDERNESS]),)


def _refuse_sizes(raw: Mapping[str, Any], axes: Sequence[Axis]) -> None:
    """Refuses sizes that the spectrum gives already, and blocks that have no one slenderness."""
    block = raw.get("block", {})
    given = [f"block.{name}" for name in block] if isinstance(block, Mapping) else []
    swept = [key for axis in axes for key in axis.columns]
    for key in (*given, *swept):
        if key in SIZES or key == LABEL + SLENDERNESS:
            allowed = "must not be given beside [spectrum], which makes it"
            raise KeyedError(key, Said("a value"), allowed)
        if key == "block.base":
            allowed = "must not be given beside [spectrum], whose blocks are boxes"
            raise KeyedError(key, Said("a body"), allowed)
        if key.removeprefix("block.").isdecimal():
            allowed = "must be one block, not a stack: it has one slenderness"
            raise KeyedError("block", Said("a stack"), allowed)


def _axis(period: Numbers, angle: Numbers, written: object) -> Axis:
    """Every period of the first angle, then those of the next."""
    names = [f"{number:.6g} deg" for number in np.rad2deg(angle.values)]
    if isinstance(written, list):
        names = [str(name) for name in written]
    if len(set(names)) < len(names):
        key = f"{SPECTRUM}.{SLENDERNESS}"
        raise KeyedError(key, written, "must not have a value twice")
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
                raise KeyedError(SPECTRUM, got, str(error)) from None
        columns[key] = Numbers(values, Dimension.LENGTH, f"{float(values[0])!r} m")
    return Axis(columns, periods * angles)
