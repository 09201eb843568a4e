"""The palette of all figures, which readers with any colour vision can tell apart."""

from __future__ import annotations

from typing import Any

from warprock.settings.engines import SETTINGS

BLACK, ORANGE, SKY, GREEN, VIOLET, BLUE, VERMILION, PURPLE = (
    "#000000",
    "#E69F00",
    "#56B4E9",
    "#009E73",
    "#7722CC",
    "#0072B2",
    "#D55E00",
    "#CC79A7",
)
"""Colours of Okabe and Ito (2008), with a violet for their yellow: white paper hides it, and who is
without red cones takes a darker one for orange."""
DARK, GREY, PALE = "#555555", "#999999", "#DDDDDD"
"""Greys of marks that explain, of lines behind curves, and of what has no colour."""

SERIES = (BLUE, ORANGE, GREEN, BLACK, VERMILION, SKY, PURPLE, VIOLET)
"""Colours of curves, in this order; `sheet.mplstyle` has the same."""
DASHES: tuple[Any, ...] = (
    "-",
    (0, (5, 1.5)),
    (0, (1.5, 1.0)),
    (0, (6, 1.5, 1.5, 1.5)),
    (0, (3, 1.0)),
    (0, (8, 2.0)),
)
"""Lines of curves, in this order: told apart without any colour, too."""
SCALE = "cividis"
"""Colours of a scale of numbers: rising in lightness, for all readers alike."""
FALLEN = VERMILION
"""Colour of what overturned."""

NAMED = {
    "black": BLACK,
    "orange": ORANGE,
    "sky": SKY,
    "green": GREEN,
    "violet": VIOLET,
    "blue": BLUE,
    "vermilion": VERMILION,
    "purple": PURPLE,
}
"""The colours by the names that settings of engines give (`drawn`)."""
ENGINE_MARKS: dict[str, tuple[str, str]] = {
    **{
        name: (NAMED[each.drawn[0]], each.drawn[1])
        for name, each in SETTINGS.items()
        if hasattr(each, "drawn")
    },
    "oracle": (BLUE, "*"),
}
"""Colour and marker of every engine, and of the oracle, in all figures that tell engines apart."""
OTHER_MARKS = ((SKY, "h"), (VIOLET, "p"))
"""Those of engines that name none."""


def engine_marks(engine: str) -> tuple[str, str]:
    """Colour and marker of an engine."""
    return ENGINE_MARKS.get(engine, OTHER_MARKS[len(engine) % len(OTHER_MARKS)])
