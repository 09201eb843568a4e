"""Incremental dynamic analysis: the function, which the command of its name calls."""

from __future__ import annotations

import functools
import os
import pathlib
from collections.abc import Sequence
from typing import Unpack

from warprock.analysis.capacities import INTENSITIES, capacities, require_columns
from warprock.analysis.incremental import plan_analysis, run_analysis
from warprock.analysis.lane_tables import measure_named
from warprock.api.asked import LadderAsked, LadderHow, ladder_of, taken
from warprock.api.case import AnyCase
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.values import Column
from warprock.api.work import HowHeld, working
from warprock.arguments import at_the_door, listing, several
from warprock.figures.incremental import draw_analysis, plot_analysis
from warprock.findings.incremental import find_ida
from warprock.report.chosen import played_of_analysis


@listing(ladder_of, working)
@at_the_door
def ida(
    case: AnyCase,
    engine: str | None = None,
    *,
    accuracy: float = 0.01,
    im: Column = "peak_acceleration_m_s2",
    by: Column | Sequence[Column] = (),
    folder: str | os.PathLike[str] | None = None,
    **asked: Unpack[LadderHow],
) -> Found:
    """Incremental dynamic analysis: the factor on its motion at which each lane first falls.

    All lanes run at a ladder of factors; the bracket of each one's first fall is then halved.

    Args:
        case: The case, as in `run`.
        engine: Name of the engine, as in `run`.
        accuracy: Width of a bracket over its least factor at which it is narrow enough [-].
        im: Intensity measure, or PGA; or normalised_acceleration, scale, factor.
        by: Column of groups; or several.
        folder: Where finished stages are kept, so that the same call goes on behind the last one;
            None keeps none.
        **asked: from_, to and count, the factors on a motion; overrides, tolerance, precision,
            device, workers and progress, as in `run`.

    Returns:
        A `Found` whose tables have the capacities of the lanes and of their groups, and every run.

    Raises:
        InputError: Something cannot be used, said before anything runs.

    References:
        D. Vamvatsikos and C. A. Cornell (2002), Incremental dynamic analysis, *Earthquake
        Engineering and Structural Dynamics* 31(3).

    Example:
        >>> import warprock as wr
        >>> shorter = {"motion.scale": 1.0, "run.duration": "20 s"}
        >>> asked = {"from_": 0.2, "to": 2.0, "count": 5, "accuracy": 0.1, "progress": False}
        >>> found = wr.ida("record-ridgecrest", "housner", **asked, overrides=shorter)
        >>> found.table["overturning_factor"].round(3).tolist()
        [1.299]
    """
    with python_names():
        ladder = ladder_of(accuracy, **taken(asked, LadderAsked))
    groups_by = several(by)
    factors, how = ladder.factors.tolist(), taken(asked, HowHeld)
    with working(case, engine, runs=0, factors=factors, **how) as work:
        case, options, intensity = work.case, work.options, measure_named(im, INTENSITIES)
        plan = plan_analysis(case, work.engine, ladder, options)
        require_columns(case, intensity, groups_by)
        kept = None if folder is None else pathlib.Path(folder)
        found = run_analysis(
            case, plan, ladder, kept, workers=options.workers, progress=options.progress
        )
        groups = capacities(found, intensity=intensity, by=groups_by)
        draw = functools.partial(plot_analysis, found=found, groups=groups, intensity=intensity)
        return Found(
            f"{case.name}: incremental dynamic analysis with {work.engine}",
            found,
            functools.partial(find_ida, found, case, groups, intensity),
            functools.partial(draw_analysis, found, groups, intensity),
            (len(groups), draw),
            functools.partial(
                played_of_analysis, case, work.engine, options.without_progress(), found
            ),
        )
