"""The command `sensitivity`: which inputs of a case explain the variance of a result."""

from __future__ import annotations

import dataclasses
import pathlib

import click

from warprock.cli.options import (
    asked_options,
    case_options,
    engine_for,
    estimate_options,
    list_written,
    require_within,
    say_engine,
)


@click.command()
@case_options
@estimate_options
@click.option(
    "--of",
    default="peak_rotation_ratio",
    show_default=True,
    metavar="COLUMN",
    help="Result of the lane table, or overturned.",
)
@click.option("--resamples", default=200, show_default=True, help="Samples for the bands.")
def sensitivity(
    case_name: str,
    engine: str | None,
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    tolerance: float | None,
    estimate: bool,
    precision: str,
    device: str,
    workers: int | None,
    of: str,
    resamples: int,
    as_json: bool,
) -> None:
    """Sobol' indices: which inputs of a CASE with a [sample] explain the variance of a result.

    sample.lanes, a power of 2, is the size of the two samples that are compared; with d inputs
    (d + 2) times as many lanes run. Axes of the sweep, each with a label, make panels.
    """
    from warprock.analysis import sensitivity as module
    from warprock.case.load import load_case
    from warprock.figures import sensitivity as plots_sensitivity
    from warprock.tables import console
    from warprock.tables import sensitivity as tables_sensitivity

    require_within("--resamples", resamples, 10, 10_000)
    case = load_case(case_name, overrides)
    options = asked_options(precision, device, workers, tolerance=tolerance, estimate=estimate)
    choice = engine_for(case, engine)
    with console.lane_progress(case.name, None) as progress:
        counted = dataclasses.replace(options, progress=progress)
        found = module.run_sensitivity(case, choice.engine, counted, of=of, resamples=resamples)
    say_engine(choice)
    files: list[pathlib.Path] = []
    if folder is not None:
        files = tables_sensitivity.write_sensitivity(found, folder)
        files.append(plots_sensitivity.draw_sensitivity(folder / "sensitivity.png", found))
        list_written(folder, files)
    if as_json:
        facts = tables_sensitivity.sensitivity_facts(found)
        console.print_rows_json(facts, found.rows, files)
    else:
        tables_sensitivity.print_sensitivity(found, files)
