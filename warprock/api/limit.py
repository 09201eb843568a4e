"""Limit analysis: the function, which the command of its name calls."""

from __future__ import annotations

import functools
import math

from warprock.analysis.load_limit import run_limits
from warprock.analysis.pushing import run_pushes
from warprock.api.case import AnyCase, any_case
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.progress import Shown, shown
from warprock.api.values import Angle
from warprock.api.work import working
from warprock.arguments import at_the_door
from warprock.case.load import Overrides
from warprock.errors import InputError
from warprock.figures.limit import draw_limit
from warprock.findings.limit import find_limit
from warprock.units import Dimension, parse_quantity


@at_the_door
def limit(
    case: AnyCase,
    engine: str | None = None,
    *,
    direction: Angle | None = None,
    push: bool = False,
    overrides: Overrides = (),
    progress: Shown = True,
) -> Found:
    """At which sideways load an assembly collapses, or tilt, and by which mechanism.

    Limit analysis by linear programme, without a simulation: blocks are rigid, joints have no
    tension, and Coulomb's friction. The load is a sideways acceleration of all blocks, over g. Each
    lane of the case is judged to both sides, in space in all directions; the weakest one is told.
    Where joints slide the load is an upper bound.

    With `push` each assembly is pushed, too, by simulation: a sideways load rises slowly and stays,
    and is halved until the load that brings the assembly down is known to a thousandth.

    Args:
        case: The case, as in `run`, with an `Assembly`. Its motion plays no part.
        direction: To which the load acts, from +x about the vertical towards +y, such as "90 deg";
            in the plane 0 deg or 180 deg. None takes the weakest one.
        engine: Name of the engine that pushes; None takes the one that the case has as a rule.
        push: Push each assembly slowly, and set the load at which it collapses beside the others.
        overrides: As in `run`.
        progress: As in `run`.

    Returns:
        A `Found` whose table has one row a lane.

    Raises:
        InputError: The case has no assembly, something of it cannot be used, an engine is named
            and nothing is to be pushed, or assemblies in space are to be pushed.

    References:
        R. K. Livesley (1978), Limit analysis of structures formed from rigid blocks,
        *International Journal for Numerical Methods in Engineering* 12.

    Example:
        >>> import warprock as wr
        >>> drums = wr.Assembly(pattern="column", drum_width="1 m", drum_height="0.5 m", drums=12,
        ...                     density="2400 kg/m^3")
        >>> case = wr.Case(assembly=drums, contact=wr.Contact(friction=0.7),
        ...                run=wr.Times(duration="1 s"))
        >>> wr.limit(case, progress=False).table["load_factor"].round(4).tolist()
        [0.1667]
        >>> found = wr.limit(case, push=True, progress=False)
        >>> found.table["pushed_load_factor"].round(3).tolist()
        [0.167]
    """
    with python_names():
        judged = any_case(case, overrides).judged
        if engine is not None and not push:
            raise InputError("--engine", "", engine, "must be left out without --push")
        with shown(progress, judged.name, judged.lane_count) as report:
            found = run_limits(judged, report, _angle(direction))
        pushes = None
        if push:
            with working(judged, engine, runs=0, progress=progress) as work:
                pushes = run_pushes(found, work.engine, work.options)
        return Found(
            f"{judged.name}: limit analysis",
            found,
            functools.partial(find_limit, found, pushes),
            functools.partial(draw_limit, found, pushes),
        )


def _angle(text: Angle | None) -> float | None:
    """A direction from 0 to 2 pi [rad].

    Raises:
        InputError: It is no angle.
    """
    if text is None:
        return None
    try:
        return parse_quantity(text, Dimension.ANGLE) % (2.0 * math.pi)
    except ValueError as error:
        raise InputError("--direction", "", text, str(error)) from None
