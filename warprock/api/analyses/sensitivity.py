"""Sobol' indices: the function, which the command of its name calls."""

from __future__ import annotations

import functools
from typing import Unpack

from warprock.analysis.sensitivity import run_sensitivity
from warprock.api.case import AnyCase
from warprock.api.found import Found
from warprock.api.values import Column
from warprock.api.work import HowHeld, working
from warprock.arguments import at_the_door, listing, require_within
from warprock.figures.sensitivity import draw_sensitivity, plot_sensitivity
from warprock.findings.sensitivity import find_sensitivity
from warprock.report.scenes import scenes_of


@listing(working)
@at_the_door
def sensitivity(
    case: AnyCase,
    engine: str | None = None,
    *,
    of: Column = "peak_rotation_ratio",
    resamples: int = 200,
    **how: Unpack[HowHeld],
) -> Found:
    """Sobol' indices: which inputs of a `case` with a [sample] explain the variance of a result.

    sample.lanes, a power of 2, is the size of the two samples that are compared; with d inputs
    (d + 2) times as many lanes run. Axes of the sweep, each with a label, make panels.

    Args:
        case: The case, as in `run`, with a `Sample`.
        engine: Name of the engine, as in `run`.
        of: Result of the lane table, or overturned.
        resamples: Samples for the bands of the indices, from 10 to 10,000.
        **how: overrides, tolerance, precision, device, workers and progress, as in `run`.

    Returns:
        A `Found` whose table has one row a group and input.

    Raises:
        InputError: Something cannot be used, said before anything runs.

    References:
        A. Saltelli et al. (2010), Variance based sensitivity analysis of model output, *Computer
        Physics Communications* 181.

    Example:
        >>> import warprock as wr
        >>> fewer = {"overrides": {"sample.lanes": 16}, "progress": False}
        >>> found = wr.sensitivity("sobol-single-block", "housner", resamples=10, **fewer)
        >>> len(found.table)
        12
    """
    with working(case, engine, runs=0, **how) as work:
        require_within("--resamples", resamples, 10, 10_000)
        found = run_sensitivity(work.case, work.engine, work.options, of=of, resamples=resamples)
        return Found(
            f"{work.case.name}: Sobol' indices of {of} with {work.engine}",
            found,
            functools.partial(find_sensitivity, found),
            functools.partial(draw_sensitivity, found),
            (len(found.groups), functools.partial(plot_sensitivity, found=found)),
            functools.partial(scenes_of, found.run),
        )
