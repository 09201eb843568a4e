"""The command `map`: in which way a pulse overturns a block, and where that changes."""

from __future__ import annotations

import pathlib

import click

from warprock.cli.options import (
    asked_options,
    case_options,
    engine_for,
    list_written,
    say_engine,
)


@click.command("map")
@case_options
@click.option(
    "--tolerance",
    default=1e-4,
    show_default=True,
    help="Width of a boundary over its height at which it is narrow enough.",
)
def overturning_map(
    case_name: str,
    engine: str | None,
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    tolerance: float,
    precision: str,
    device: str,
    workers: int | None,
    as_json: bool,
) -> None:
    """How pulses overturn a block: without an impact, with impacts, or not at all.

    CASE sweeps motion.frequency and motion.amplitude, the grid of the map; further axes, each with
    a label, make panels. Every change of the mode in a column is halved down to the tolerance.
    """
    from warprock.analysis import boundaries as overturning_boundaries
    from warprock.analysis import overturning
    from warprock.case.load import load_case
    from warprock.figures import overturning as plots_map
    from warprock.tables import console
    from warprock.tables import overturning as tables_map

    case = load_case(case_name, overrides)
    overturning_boundaries.require_tolerance(tolerance)
    options = asked_options(precision, device, workers)
    choice = engine_for(case, engine)
    with console.lane_progress(case.name, None) as progress:
        grid = overturning.run_grid(case, choice.engine, options)
        found = overturning_boundaries.refine(grid, tolerance, progress=progress)
    say_engine(choice)
    files: list[pathlib.Path] = []
    if folder is not None:
        files = tables_map.write_map(found, folder)
        files.append(plots_map.draw_map(folder / "map.png", found))
        list_written(folder, files)
    if as_json:
        console.print_rows_json(tables_map.map_facts(found), found.boundaries, files)
    else:
        tables_map.print_map(found, files)
