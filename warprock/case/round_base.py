"""Cylinders and drums: the box that stands for a block with a round base in the plane of rocking.

A cylinder of diameter D and height H that rocks in a plane turns about one point of its rim, then
about the opposite one. The box that is run in its place is D wide, H high and pi / 4 D deep, of the
same density. It keeps the mass, the area of the base, the height of the centre of mass and the
lever arm D / 2 of the weight, so also the slenderness angle a = arctan(D / H), the acceleration g
tan(a) that lifts it, and how far its ends slide. It does not keep the mass moment of inertia. About
a point of the rim, with R^2 = (D^2 + H^2) / 4,

    I_cylinder = m (3 D^2 / 4 + H^2) / 12 + m R^2 = 4/3 m R^2 (1 - sin^2(a) / 16),
    I_box      = m (D^2 + H^2) / 12 + m R^2       = 4/3 m R^2,

so that the box has I larger by 1 / (1 - sin^2(a) / 16) - 1, rocks slower by the root of that (its
frequency parameter is smaller by about sin^2(a) / 32), and keeps at an impact 1 - m D^2 / (2 I) of
its angular velocity: 1 - 1.5 sin^2(a), the cylinder 1 - 1.5 sin^2(a) / (1 - sin^2(a) / 16).

In space a cylinder rolls along its rim, which a box cannot do: such cases are refused.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from warprock.errors import InputError, Said

if TYPE_CHECKING:
    from warprock.case.columns import Table
    from warprock.case.values import LaneValues

_DIAMETER = re.compile(r"diameter(_\d)?_m")


def round_keys(values: LaneValues) -> dict[str, str]:
    """Keys of the diameters that a case gives, by the number of the block in a name: "", "_2"."""
    tables = values.case.tables
    if not tables.stacked:
        found = {"": "block.diameter"}
    else:
        found = {f"_{n}": f"block.{n}.diameter" for n in range(1, tables.block_count + 1)}
    return {number: key for number, key in found.items() if values.given(key)}


def refuse_in_space(values: LaneValues, why: str) -> None:
    """Refuses round bases of blocks in space.

    Args:
        values: Values of the case.
        why: What makes the case one of blocks in space.

    Raises:
        InputError: There is one.
    """
    for key in round_keys(values).values():
        raise InputError(
            values.case.source_of(key),
            key,
            Said("a round base"),
            f"must be left out in space, where a cylinder rolls along its rim (the case {why})",
        )


def round_base_note(table: Table) -> str:
    """What to say of the boxes that stand for cylinders; empty where there are none.

    Args:
        table: Inputs of the lanes, one row a lane.
    """
    parts = []
    for name in map(str, table):
        found = _DIAMETER.fullmatch(name)
        if found:
            diameter = np.asarray(table[name], dtype=float)
            height = np.asarray(table[f"height{found[1] or ''}_m"], dtype=float)
            parts.append(float(np.max(diameter**2 / (diameter**2 + height**2))))
    if not parts:
        return ""
    most = max(parts)
    inertia = 1.0 / (1.0 - most / 16.0)
    rate, kept = 1.0 - inertia**-0.5, 1.5 * most * (inertia - 1.0)
    return (
        "a round base is run as a box as wide as the diameter and pi / 4 of it deep: same mass, "
        "base area, slenderness angle and uplift; its moment of inertia about the rim is "
        f"{100.0 * (inertia - 1.0):.2g} % larger than the cylinder's, so it rocks "
        f"{100.0 * rate:.2g} % slower and keeps {kept:.2g} more of its angular velocity at an "
        "impact (at most, of the lanes here)"
    )
