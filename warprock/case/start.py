"""The table [start]: how a single block is released.

Velocities are in the axes of the base: x in the plane of rocking, y across it, z upwards. About y,
towards +x, a block rocks; without a velocity of its centre a block that stands turns about the
edge or the corner that goes down. A block with an attitude is thrown: it may fall on any of its
faces.
"""

from __future__ import annotations

from typing import Annotated, ClassVar

from warprock.case.validation import Table
from warprock.quantity import Column, NumberKey

AXES = ("x", "y", "z")
"""Axes of the base."""
ATTITUDE = ("x", "y", "z", "w")
"""Parts of a quaternion, the real one last."""


def _velocity(axis: str, where: str) -> NumberKey:
    return NumberKey(
        f"the velocity of the block's centre at the start, {where}",
        "-1000 m/s to 1000 m/s",
        swept=True,
        column=Column(f"velocity_{axis}_start"),
        needs_space="starts with a velocity of its centre",
    )


def _spin(axis: str, where: str, needs_space: str = "") -> NumberKey:
    return NumberKey(
        f"the angular velocity at the start about {axis}, {where}",
        "-1000 rad/s to 1000 rad/s",
        swept=True,
        column=Column(f"angular_velocity_{axis}_start", "rad/s"),
        needs_space=needs_space,
    )


def _part(part: str, where: str) -> NumberKey:
    return NumberKey(
        f"the attitude of a thrown block, {where} of its quaternion",
        "-1 to 1",
        swept=True,
        column=Column(f"attitude_{part}_start"),
        instead_of="rotation rotation_ratio rotation_across yaw gap",
        needs_space="starts in any attitude",
    )


_ACROSS = "starts turning out of the plane of rocking"


class Start(Table):
    """How the block is released: its attitude [rad], the gap below it [m], its velocities.

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
    velocity_x: Annotated[float | None, _velocity("x", "along x, in the plane of rocking")] = None
    velocity_y: Annotated[float | None, _velocity("y", "along y, across that plane")] = None
    velocity_z: Annotated[float | None, _velocity("z", "upwards")] = None
    angular_velocity_x: Annotated[float | None, _spin("x", "from +y to upwards", _ACROSS)] = None
    angular_velocity_y: Annotated[
        float | None, _spin("y", "in the plane of rocking, towards +x")
    ] = None
    angular_velocity_z: Annotated[
        float | None, _spin("z", "the vertical, from +x to +y", _ACROSS)
    ] = None
    attitude_w: Annotated[float | None, _part("w", "real part")] = None
    attitude_x: Annotated[float | None, _part("x", "part x")] = None
    attitude_y: Annotated[float | None, _part("y", "part y")] = None
    attitude_z: Annotated[float | None, _part("z", "part z")] = None
    height: Annotated[
        float | None,
        NumberKey(
            "the height of the centre of a thrown block at the start",
            "0 m to 1 km",
            swept=True,
            column=Column("height_start"),
            instead_of="gap",
            needs_space="starts above its base",
        ),
    ] = None
