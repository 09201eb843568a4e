"""The command `capacity` as a function."""

from __future__ import annotations

import functools

from warprock.analysis.statics import Statics, run_statics
from warprock.analysis.statics_beside import Beside, run_beside
from warprock.api.case import AnyCase, any_case
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.arguments import at_the_door
from warprock.case.load import Overrides
from warprock.figures.capacity import draw_beside, draw_capacity
from warprock.figures.drawing import Drawing
from warprock.findings.capacity import find_capacity


@at_the_door
def capacity(case: AnyCase, *, dynamics: bool = False, overrides: Overrides = ()) -> Found:
    """What single blocks bear by statics: multiplier, rotation, displacement, work.

    Each block is led outwards about an edge of its base, to each side to which it can turn, with
    what holds it: its ties as they tighten, yield and break, the load on its top, its frame. The
    moment that resists gives the base acceleration that starts rocking, the largest on the way,
    and where nothing resists any more; its area is the work that overturns the block.

    Args:
        case: The case, as in `run`, of single boxes in the plane.
        dynamics: Run the lanes under their motions, too, with `housner`, and set what became of
            them beside the static answers.
        overrides: As in `run`.

    Returns:
        A `Found` whose table has one row a lane and side; its figure has the moment over the
        rotation, and the capacity of the equivalent system of one degree; with `dynamics` another
        one sets statics against dynamics.

    Raises:
        InputError: The case cannot be used, its blocks are no single boxes in the plane, or it has
            no motion where `dynamics` asks for one.

    Example:
        >>> import warprock as wr
        >>> found = wr.capacity("free-b0")
        >>> found.table["multiplier"].round(4).tolist()
        [0.2, 0.1818]
    """
    with python_names():
        found = run_statics(any_case(case, overrides).judged)
        beside = run_beside(found) if dynamics else None
        return Found(
            f"{found.case.name}: capacity by statics",
            found,
            functools.partial(find_capacity, found, beside),
            functools.partial(_draw, found, beside),
        )


def _draw(found: Statics, beside: Beside | None, title: str) -> list[Drawing]:
    drawings = draw_capacity(found, title)
    return drawings if beside is None else [*drawings, draw_beside(found, beside, title)]
