"""The table [support]: a floor or an isolator between the ground motion and the block."""

from __future__ import annotations

from typing import Annotated, ClassVar

from warprock.case.validation import Table
from warprock.quantity import Column, NumberKey


class Support(Table):
    """A floor of a building or an isolator under the block: a linear oscillator along x and y."""

    place: ClassVar[str] = "support"

    frequency: Annotated[
        float,
        NumberKey(
            "the natural frequency of the support",
            "1e-2 Hz to 1000 Hz",
            swept=True,
            column=Column("support_frequency"),
        ),
    ]
    damping: Annotated[
        float,
        NumberKey(
            "the damping ratio of the support",
            "0 to 0.99",
            swept=True,
            column=Column("support_damping"),
        ),
    ]
    height_factor: Annotated[
        float,
        NumberKey(
            "the displacement of the support over that of the oscillator: its participation factor "
            "times its mode at the floor, 1 for an isolator",
            "0 to 10",
            swept=True,
            column=Column("support_height_factor"),
        ),
    ] = 1.0
