"""The command `capacity` as a function."""

from __future__ import annotations

import functools

from warprock.analysis.statics import run_statics
from warprock.api.case import AnyCase, any_case
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.arguments import at_the_door
from warprock.case.case import Case
from warprock.case.load import Overrides
from warprock.figures.capacity import draw_capacity
from warprock.findings.capacity import find_capacity


@at_the_door
def capacity(case: AnyCase, *, overrides: Overrides = ()) -> Found:
    """What single blocks bear by statics: multiplier, rotation, displacement, work.

    Each block is led outwards about an edge of its base, to each side to which it can turn, with
    what holds it: its ties as they tighten, yield and break, the load on its top, its frame. The
    moment that resists gives the base acceleration that starts rocking, the largest on the way,
    and where nothing resists any more; its area is the work that overturns the block.

    Args:
        case: The case, as in `run`, of single boxes in the plane; its motion does not matter.
        overrides: As in `run`.

    Returns:
        A `Found` whose table has one row a lane and side; its figure has the moment over the
        rotation, and the capacity of the equivalent system of one degree.

    Raises:
        InputError: The case cannot be used, or its blocks are no single boxes in the plane.

    Example:
        >>> import warprock as wr
        >>> found = wr.capacity("free-b0")
        >>> found.table["multiplier"].round(4).tolist()
        [0.2, 0.1818]
    """
    with python_names():
        return capacity_of(any_case(case, overrides).judged)


def capacity_of(case: Case) -> Found:
    """What the blocks of a case bear."""
    found = run_statics(case)
    return Found(
        f"{case.name}: capacity by statics",
        found,
        functools.partial(find_capacity, found),
        functools.partial(draw_capacity, found),
    )
