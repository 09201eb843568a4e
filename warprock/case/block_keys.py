"""Keys of a block that boxes (`block`) and bodies (`body`) share, with their bounds."""

from __future__ import annotations

from warprock.case.contact import FRICTION
from warprock.quantity import Column, FrictionKey, NumberKey

HEIGHT = NumberKey(
    "the full height of the block", "1 mm to 1 km", swept=True, column=Column("height")
)
"""Full height; of a body for tables and pictures alone."""

OFFSET = NumberKey(
    "the distance of the middle of the face the block stands on to +x of the middle of the top of "
    "the block below",
    "-1 km to 1 km",
    swept=True,
    column=Column("offset", "mm"),
)
FACE_FRICTION = FrictionKey(
    "the friction coefficient or the friction angle of the face the block stands on",
    FRICTION,
    swept=True,
    column=Column("friction", text="Coulomb friction coefficient"),
)
ROTATION_START = NumberKey(
    "the rotation of the block at the start",
    "-90 deg to 90 deg",
    low_open=True,
    high_open=True,
    swept=True,
    column=Column("rotation_start"),
)
