"""Measures: the function, which the command of its name calls."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Unpack

from warprock.analysis.incremental import read_ladder
from warprock.analysis.measures import Question, own_measure, run_measures
from warprock.api.analyses.risk import File, read_asked
from warprock.api.case import AnyCase
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.values import Column, Quantity, Share
from warprock.api.work import HowHeld, listing_how, working
from warprock.arguments import at_the_door, require_within, several
from warprock.figures.measures import draw_measures, plot_measures
from warprock.findings.mitigation import find_measures


@listing_how
@at_the_door
def measures(
    case: AnyCase,
    engine: str | None = None,
    *,
    hazard: File | None = None,
    k0: float | None = None,
    k: float | None = None,
    at: Quantity = "1 g",
    im: Column | None = None,
    measure: str | Sequence[str] = (),
    target: float | None = None,
    from_: float = 0.1,
    to: float = 10.0,
    count: int = 21,
    accuracy: float = 0.02,
    max_outside: Share = 0.1,
    **how: Unpack[HowHeld],
) -> Found:
    """What lowers most the yearly chance that a block falls: each measure as a factor on its rate.

    `case` is one block under several records, a lane each. It goes through an incremental dynamic
    analysis as it is and with each measure: a wider base, ballast at its foot, straps, an isolator,
    another floor, less or more friction, or measures of yours.

    Args:
        case: The case, as in `run`.
        engine: Name of the engine, as in `run`.
        hazard: Hazard curve, as in `risk`.
        k0: How often in a year the intensity `at` is exceeded.
        k: Exponent of a hazard that is a power law [-].
        at: Intensity of `k0`, with its unit.
        im: Column of the hazard's intensity measure, or PGA, PGV [default: what the file says].
        measure: Measure: KEY=VALUE, or several keys parted by semicolons; or several [default:
            those that the block can have].
        target: Yearly rate at which the least width and the least straps are looked for.
        from_: Least factor on a motion [-].
        to: Greatest factor [-].
        count: Factors of the first stage.
        accuracy: Width of a bracket over its least factor at which it is narrow enough [-].
        max_outside: Share of a rate that may come from motions beyond an end of the hazard [-].
        **how: overrides, tolerance, precision, device, workers and progress, as in `run`.

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
            read_asked(hazard, k0, k, at, im),
            read_ladder(from_, to, count, accuracy),
            [own_measure(text) for text in several(measure)],
            target,
            max_outside,
        )
    factors = question.ladder.factors.tolist()
    with working(case, engine, runs=0, factors=factors, **how) as work:
        found = run_measures(work.case, work.engine, work.options, question)
        return Found(
            f"{work.case.name}: measures with {work.engine}",
            found,
            functools.partial(find_measures, found, question.ladder),
            functools.partial(draw_measures, found),
            (1, functools.partial(plot_measures, found=found)),
        )
