"""The command `fragility`: fragility functions from a lane table."""

from __future__ import annotations

import pathlib

import click

from warprock.errors import InputError


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
@click.option("--by", multiple=True, metavar="COLUMN", help="Column that makes groups; repeat.")
@click.option("--samples", default=1000, show_default=True, help="Bootstrap samples, over records.")
@click.option("--seed", default=1, show_default=True, help="Seed of the samples.")
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=pathlib.Path),
    help="Folder for tables and the figure; without, they are printed only.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
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
    from warprock import store
    from warprock.report import console, plots_fragility, tables_fragility

    for option, value, least, most in (("--samples", samples, 10, 100_000),):
        if not least <= value <= most:
            raise InputError(option, "", value, f"must be from {least} to {most}")
    if not 0 <= seed < 2**63:
        raise InputError("--seed", "", seed, "must be from 0 to 2^63 - 1")
    chosen = module.read_limits(limits or module.DEFAULT_LIMITS)
    if folder is not None:
        store.require_writable(folder)
    lanes = module.read_lanes(table)
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
    if as_json:
        found = {
            "table": str(table),
            "intensity": intensity,
            "curves": tables_fragility.json_rows(rows),
            "files": [str(path) for path in files],
        }
        console.print_json(found)
    else:
        tables_fragility.print_curves(rows, intensity, files)
