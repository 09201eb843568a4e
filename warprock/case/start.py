"""The table [start]: how a single block is released."""

from __future__ import annotations

from typing import Annotated, ClassVar

from warprock.case.validation import Table
from warprock.quantity import Column, NumberKey


class Start(Table):
    """How the block is released: its attitude [rad] and the gap below it [m].

    The rotation may be given as a part of the slenderness angle.
    """

    place: ClassVar[str] = "start"

    rotation: Annotated[
        float | None,
        NumberKey(
            "the rotation at the start",
            "-90 deg to 90 deg",
            low_open=True,
            high_open=True,
            swept=True,
            column=Column("rotation_start"),
        ),
    ] = None
    rotation_ratio: Annotated[
        float | None,
        NumberKey(
            "the rotation at the start divided by the slenderness angle",
            "-1 to 1",
            low_open=True,
            high_open=True,
            swept=True,
            column=Column("rotation_ratio_start"),
            instead_of="rotation",
        ),
    ] = None
    rotation_across: Annotated[
        float | None,
        NumberKey(
            "the rotation across the plane of rocking at the start",
            "-90 deg to 90 deg",
            low_open=True,
            high_open=True,
            swept=True,
            column=Column("rotation_across_start"),
            needs_space="starts leaning across the plane of rocking",
        ),
    ] = None
    yaw: Annotated[
        float | None,
        NumberKey(
            "the turn of the block about the vertical at the start",
            "-180 deg to 180 deg",
            swept=True,
            column=Column("yaw_start"),
            needs_space="starts turned about the vertical",
        ),
    ] = None
    gap: Annotated[
        float | None,
        NumberKey(
            "the height of the block's lowest corner above the base at the start",
            "0 m to 1 km",
            swept=True,
            column=Column("gap_start", "mm"),
            needs_space="starts above its base",
        ),
    ] = None
