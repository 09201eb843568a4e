"""The command `sensitivity`: which inputs of a case explain the variance of a result."""

from __future__ import annotations

import pathlib

import click

from warprock.cli_options import engine_option, json_option, output_option, run_options, set_option
from warprock.errors import InputError


@click.command()
@click.argument("case_name", metavar="CASE")
@engine_option
@set_option
@output_option
@click.option(
    "--of",
    default="peak_rotation_ratio",
    show_default=True,
    metavar="COLUMN",
    help="Result of the lane table, or overturned.",
)
@click.option("--resamples", default=200, show_default=True, help="Samples for the bands.")
@run_options
@json_option
def sensitivity(
    case_name: str,
    engine: str | None,
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    of: str,
    resamples: int,
    precision: str,
    device: str,
    workers: int | None,
    as_json: bool,
) -> None:
    """Sobol' indices: which inputs of a CASE with a [sample] explain the variance of a result.

    sample.lanes, a power of 2, is the size of the two samples that are compared; with d inputs
    (d + 2) times as many lanes run. Axes of the sweep, each with a label, make panels.
    """
    from warprock import runner, store
    from warprock import sensitivity as module
    from warprock.case import load_case
    from warprock.report import console, plots_sensitivity, tables_sensitivity

    if not 10 <= resamples <= 10_000:
        raise InputError("--resamples", "", resamples, "must be from 10 to 10000")
    case = load_case(case_name, overrides)
    if folder is not None:
        store.require_writable(folder)
    with console.lane_progress(case.name, None) as progress:
        found = module.run_sensitivity(
            case,
            engine or runner.default_engine(case),
            of=of,
            resamples=resamples,
            precision=precision,
            device=device,
            workers=workers,
            progress=progress,
        )
    files: list[pathlib.Path] = []
    if folder is not None:
        files = tables_sensitivity.write_sensitivity(found, folder)
        files.append(plots_sensitivity.draw_sensitivity(folder / "sensitivity.png", found))
    if as_json:
        facts = tables_sensitivity.sensitivity_facts(found)
        console.print_json(
            facts
            | {"rows": found.rows.to_dict("records")}
            | {"files": [str(path) for path in files]}
        )
    else:
        tables_sensitivity.print_sensitivity(found, files)
