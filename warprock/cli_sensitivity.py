"""The command `sensitivity`: which inputs of a case explain the variance of a result."""

from __future__ import annotations

import pathlib

import click

from warprock.errors import InputError


@click.command()
@click.argument("case_name", metavar="CASE")
@click.option("-e", "--engine", help="Engine; without, housner for one block, event for a stack.")
@click.option(
    "-s",
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change a key of the case, such as -s sample.lanes=4096.",
)
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=pathlib.Path),
    help="Folder for the table and the figure; without, the indices are printed only.",
)
@click.option(
    "--of",
    default="peak_rotation_ratio",
    show_default=True,
    metavar="COLUMN",
    help="Result of the lane table, or overturned.",
)
@click.option("--resamples", default=200, show_default=True, help="Samples for the bands.")
@click.option("--precision", default="float64", show_default=True, help="Or float32.")
@click.option("--device", default="cpu", show_default=True, help="Warp device.")
@click.option("--workers", type=int, help="Worker threads; the cores at hand without.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
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
        facts = {"case": case.name, **tables_sensitivity.sensitivity_facts(found)}
        facts["rows"] = found.rows.to_dict("records")
        console.print_json(facts | {"files": [str(path) for path in files]})
    else:
        tables_sensitivity.print_sensitivity(found, files)
