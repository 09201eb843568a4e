"""The command `fragility`: fragility functions from a lane table."""

from __future__ import annotations

import pathlib

import click

from warprock.cli_options import (
    fit_options,
    json_option,
    list_written,
    output_option,
    require_samples,
)


@click.command()
@click.argument("table", type=click.Path(path_type=pathlib.Path))
@click.option(
    "--im",
    "intensity",
    default="peak_acceleration_m_s2",
    show_default=True,
    metavar="COLUMN",
    help="Column of the intensity measure.",
)
@click.option(
    "--limit",
    "limits",
    multiple=True,
    help="Limit state: uplift, overturning or a peak rotation / slenderness angle; repeat for each "
    "[default: uplift, 0.15, 0.35, overturning].",
)
@fit_options
@output_option
@json_option
def fragility(
    table: pathlib.Path,
    intensity: str,
    limits: tuple[str, ...],
    by: tuple[str, ...],
    samples: int,
    seed: int,
    folder: pathlib.Path | None,
    as_json: bool,
) -> None:
    """Fragility functions from TABLE, the lane table of a run or of a merged sweep, or its folder.

    For each group of lanes and limit state: the lognormal function of greatest likelihood, with a
    band from resampled records, or why there is none.
    """
    from warprock import fragility as module
    from warprock.fragility_table import read_lanes
    from warprock.report import console, plots_fragility, tables_fragility

    require_samples(samples, seed)
    chosen = module.read_limits(limits or module.DEFAULT_LIMITS)
    lanes = read_lanes(table)
    curves = module.fragility_curves(
        lanes,
        source=str(table),
        intensity=intensity,
        limits=chosen,
        by=by,
        samples=samples,
        seed=seed,
    )
    rows = module.curve_rows(curves)
    files: list[pathlib.Path] = []
    if folder is not None:
        files = tables_fragility.write_tables(curves, intensity, folder)
        files.append(plots_fragility.draw_curves(folder / "fragility.png", curves, intensity))
        list_written(folder, files, beside=True)
    if as_json:
        found = {
            "table": str(table),
            "intensity": intensity,
            "curves": rows.to_dict("records"),
            "files": files,
        }
        console.print_json(found)
    else:
        tables_fragility.print_curves(rows, intensity, files)
