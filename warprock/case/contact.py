"""The table [contact]: what happens between blocks and base."""

from __future__ import annotations

from typing import Annotated, ClassVar

from warprock.case.validation import Table
from warprock.quantity import Column, FrictionKey, NumberKey

FRICTION = "0 to 100 or 0 deg to 89 deg"
"""Bounds of a friction coefficient and of a friction angle."""


class Contact(Table):
    """What happens between block and base."""

    place: ClassVar[str] = "contact"

    friction: Annotated[
        float,
        FrictionKey(
            "the friction coefficient or the friction angle; above 4/3 a block that slides may "
            "have no unique answer",
            FRICTION,
            swept=True,
            column=Column("friction", text="Coulomb friction coefficient"),
        ),
    ]
    angular_restitution: Annotated[
        float | None,
        NumberKey(
            "the ratio of angular velocities after and before an impact",
            "0 to 1",
            swept=True,
            column=Column("angular_restitution"),
        ),
    ] = None
