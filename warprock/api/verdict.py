"""Verdicts: the function, which the command of its name calls."""

from __future__ import annotations

import functools
from typing import Unpack

from warprock.analysis.verdict import Spread, run_verdict
from warprock.api.case import AnyCase, Case
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.values import Share
from warprock.api.work import HowHeld, working
from warprock.arguments import at_the_door, listing
from warprock.case.template import case_of_record
from warprock.errors import InputError
from warprock.figures.verdict import draw_verdict, plot_verdict
from warprock.findings.verdict import find_verdict


@listing(working)
@at_the_door
def verdict(
    case: AnyCase | None = None,
    engine: str | None = None,
    *,
    body: str | None = None,
    record: str | None = None,
    margin: float = 1.5,
    neighbours: int = 256,
    spread_size: Share = 0.02,
    spread_friction: Share = 0.1,
    spread_motion: Share = 0.1,
    **how: Unpack[HowHeld],
) -> Found:
    """Does a block stand under a motion, and by how much.

    Whether it stands, how far it rocks and slides, from which factor on the motion it first falls,
    how many of its neighbours fall, which differ a little in size, friction and strength of the
    motion, and how wide it must be to bear a stronger one.

    Args:
        case: One block under one motion, as in `run`; None where `body` and `record` say both.
        engine: Name of the engine, as in `run`.
        body: In the place of a case: bookcase, cabinet, statue ..., or sizes: "WIDTH x HEIGHT x
            DEPTH", "DIAMETER x HEIGHT".
        record: The motion of this body: a shipped record, or a file.
        margin: Factor on the motion for which the width is asked [-].
        neighbours: How many neighbours run.
        spread_size: How far width and height of neighbours differ, as a share of them [-].
        spread_friction: How far the friction of neighbours differs [-].
        spread_motion: How far the strength of the motion of neighbours differs [-].
        **how: overrides, tolerance, precision, device, workers and progress, as in `run`.

    Returns:
        A `Found` whose facts have the answers, `facts["verdict"]`; `found` is the verdict.

    Raises:
        InputError: Several lanes, no motion, or something that cannot be used, said before
            anything runs.

    Example:
        >>> import warprock as wr
        >>> shorter = {"motion.scale": 0.5, "run.duration": "20 s"}
        >>> asked = {"neighbours": 16, "overrides": shorter, "progress": False}
        >>> found = wr.verdict("record-ridgecrest", "housner", **asked)
        >>> found.facts["verdict"]["outcome"]
        'rocking'
    """
    with python_names():
        asked = Case.of(case_of_record(body, record)) if case is None else case
        if case is not None and (body is not None or record is not None):
            option = "--body" if body is not None else "--record"
            raise InputError(option, "", body or record, "must be left out where a case is given")
    spread = Spread(spread_size, spread_friction, spread_motion)
    with working(asked, engine, runs=0, factors=[0.1, 1.0, 10.0], **how) as work:
        found = run_verdict(
            work.case,
            work.engine,
            work.options,
            spread=spread,
            neighbours=neighbours,
            margin=margin,
        )
        return Found(
            f"{work.case.name}: verdict with {work.engine}",
            found,
            functools.partial(find_verdict, found),
            functools.partial(draw_verdict, found),
            (1, functools.partial(plot_verdict, found=found)),
        )
