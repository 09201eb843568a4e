"""The command `map`: in which way a pulse overturns a block, and where that changes."""

from __future__ import annotations

import functools
import pathlib
from typing import Any

import click

from warprock.cli.analysis import case_work, finish, run_of, running
from warprock.cli.options import case_options
from warprock.cli.pages import on_case


@click.command("map")
@case_options
@click.option(
    "--tolerance",
    default=1e-4,
    show_default=True,
    help="Width of a boundary over its height at which it is narrow enough.",
)
def overturning_map(
    folder: pathlib.Path | None, tolerance: float, as_json: bool, **asked: Any
) -> None:
    """How pulses overturn a block: without an impact, with impacts, or not at all.

    CASE sweeps motion.frequency and motion.amplitude, the grid of the map; further axes, each with
    a label, make panels. Every change of the mode in a column is halved down to the tolerance.
    """
    from warprock.analysis.boundaries import refine, require_tolerance
    from warprock.analysis.overturning import run_grid
    from warprock.figures.overturning import draw_map
    from warprock.tables.overturning import map_report

    work = case_work(**asked)
    require_tolerance(tolerance)
    with running(work, None) as options:
        grid = run_grid(work.case, work.engine, work.options)
        found = refine(grid, tolerance, progress=options.progress)
    then = run_of(work.engine, folder, **asked)
    if found.decided_after is not None:
        longer = f'run.duration="{found.decided_after:g} s"'
        kept = [text for text in asked["overrides"] if not text.startswith("run.duration")]
        then = on_case(
            "map", asked["case_name"], [*kept, longer], "-e", work.engine, "-o", str(folder)
        )
    draw = functools.partial(draw_map, found=found)
    finish(map_report(found), draw, folder, as_json=as_json, then=then, run=found.run)


COMMANDS = (overturning_map,)
