"""Measures: the function, which the command of its name calls."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Unpack

from warprock.analysis.measures import Question, own_measure, run_measures
from warprock.api.asked import HazardAsked, HazardLadder, LadderAsked, hazard_of, ladder_of, taken
from warprock.api.case import AnyCase
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.values import Share
from warprock.api.work import HowHeld, working
from warprock.arguments import at_the_door, listing, require_within, several
from warprock.figures.measures import draw_measures, plot_measures
from warprock.findings.measures import find_measures


@listing(hazard_of, ladder_of, working)
@at_the_door
def measures(
    case: AnyCase,
    engine: str | None = None,
    *,
    measure: str | Sequence[str] = (),
    target: float | None = None,
    accuracy: float = 0.02,
    max_outside: Share = 0.1,
    **asked: Unpack[HazardLadder],
) -> Found:
    """What lowers most the yearly chance that a block falls: each measure as a factor on its rate.

    `case` is one block under several records, a lane each. It goes through an incremental dynamic
    analysis as it is and with each measure: a wider base, ballast at its foot, straps, an isolator,
    another floor, less or more friction, or measures of yours.

    Args:
        case: The case, as in `run`.
        engine: Name of the engine, as in `run`.
        measure: Measure: KEY=VALUE, or several keys separated by semicolons; or several [default:
            those that the block can have].
        target: Yearly rate at which the least width and the least straps are looked for.
        accuracy: Width of a bracket over its least factor at which it is narrow enough [-].
        max_outside: Share of a rate that may come from motions beyond an end of the hazard [-].
        **asked: hazard, k0, k, at and im, the hazard as in `risk`; from_, to and count, the factors
            as in `ida`; overrides, tolerance, precision, device, workers and progress, as in `run`.

    Returns:
        A `Found` whose table has one row a measure, the one that lowers the rate most first.

    Raises:
        InputError: Something cannot be used, or the block has no rate as it is.

    Example:
        >>> import warprock as wr
        >>> one = {"motion.scale": 1.0, "block.width": "0.5 m", "run.duration": "30 s"}
        >>> asked = {"k0": 1e-3, "k": 2.0, "count": 9, "accuracy": 0.1, "progress": False}
        >>> wider = {"measure": "block.width=0.6 m", "overrides": one, **asked}
        >>> found = wr.measures("fragility-five-blocks", "housner", **wider)
        >>> bool(found.table["factor"].iloc[0] < 1.0)
        True
    """
    with python_names():
        require_within("--max-outside", max_outside, 0.0, 1.0)
        question = Question(
            hazard_of(**taken(asked, HazardAsked)),
            ladder_of(accuracy, **taken(asked, LadderAsked)),
            [own_measure(text) for text in several(measure)],
            target,
            max_outside,
        )
    factors, how = question.ladder.factors.tolist(), taken(asked, HowHeld)
    with working(case, engine, runs=0, factors=factors, **how) as work:
        found = run_measures(work.case, work.engine, work.options, question)
        return Found(
            f"{work.case.name}: measures with {work.engine}",
            found,
            functools.partial(find_measures, found, question.ladder),
            functools.partial(draw_measures, found),
            (1, functools.partial(plot_measures, found=found)),
        )
