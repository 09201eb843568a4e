"""Overturning maps: the function, which the command of its name calls."""

from __future__ import annotations

import functools
from typing import Unpack

from warprock.analysis.boundaries import refine, require_accuracy
from warprock.analysis.overturning import run_grid
from warprock.api.case import AnyCase
from warprock.api.found import Found
from warprock.api.work import How, working
from warprock.arguments import at_the_door, listing
from warprock.figures.overturning import draw_map, plot_map
from warprock.findings.overturning import find_map
from warprock.report.scenes import scenes_of


@listing(working)
@at_the_door
def map(
    case: AnyCase,
    engine: str | None = None,
    *,
    accuracy: float = 1e-4,
    **how: Unpack[How],
) -> Found:
    """How pulses overturn a block: without an impact, with impacts, or not at all.

    `case` sweeps motion.frequency and motion.amplitude, the grid of the map; further axes, each
    with a label, make panels. Between neighbours in a column whose modes differ the boundary is
    bisected to `accuracy`.

    Args:
        case: The case, as in `run`.
        engine: Name of the engine, as in `run`.
        accuracy: Width of a boundary over its height at which it is narrow enough [-].
        **how: overrides, precision, device, workers and progress, as in `run`.

    Returns:
        A `Found` with the lanes of the grid and the boundaries between modes.

    Raises:
        InputError: Something cannot be used, said before anything runs.

    References:
        J. Zhang and N. Makris (2001), Rocking response of free-standing blocks under cycloidal
        pulses, *Journal of Engineering Mechanics* 127(5).

    Example:
        >>> import warprock as wr
        >>> grid = {"motion.frequency": ["1 Hz"], "motion.amplitude": ["0.01 g", "0.15 g"]}
        >>> grid |= {"motion.waveform": "sine", "motion.cycles": 1}
        >>> found = wr.map("overturning-map", "housner", overrides=grid, progress=False)
        >>> found.tables["boundaries"]["acceleration_ratio"].round(2).tolist()
        [1.23, 2.31, 2.35]
    """
    with working(case, engine, runs=0, **how) as work:
        require_accuracy(accuracy)
        grid = run_grid(work.case, work.engine, work.options)
        found = refine(grid, accuracy, progress=work.options.progress)
        return Found(
            f"{work.case.name}: overturning map with {work.engine}",
            found,
            functools.partial(find_map, found),
            functools.partial(draw_map, found),
            (len(found.groups), functools.partial(plot_map, found=found)),
            functools.partial(scenes_of, found.run),
        )
