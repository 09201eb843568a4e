"""The command `spectrum`: peak rotations of blocks of many sizes under one motion."""

from __future__ import annotations

import pathlib

import click


@click.command()
@click.argument("case_name", metavar="CASE")
@click.option("-e", "--engine", default="housner", show_default=True, help="Engine.")
@click.option(
    "-s",
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change a key of the case, such as -s contact.angular_restitution=0.9.",
)
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=pathlib.Path),
    help="Folder for the table and the figure; without, the curves are printed only.",
)
@click.option("--precision", default="float64", show_default=True, help="Or float32.")
@click.option("--device", default="cpu", show_default=True, help="Warp device.")
@click.option("--workers", type=int, help="Worker threads; the cores at hand without.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def spectrum(
    case_name: str,
    engine: str,
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    precision: str,
    device: str,
    workers: int | None,
    as_json: bool,
) -> None:
    """Rocking spectra: peak rotation / slenderness angle over 2 pi / p, a curve a slenderness.

    CASE has a [spectrum] table with the periods 2 pi / p and the slenderness angles; axes of its
    sweep, each with a label, make panels.
    """
    from warprock import spectrum as module
    from warprock import store
    from warprock.case import load_case
    from warprock.report import console, plots_spectrum, tables_spectrum

    case = load_case(case_name, overrides)
    if folder is not None:
        store.require_writable(folder)
    with console.lane_progress(case.name, case.lane_count) as progress:
        found = module.run_spectrum(
            case, engine, precision=precision, device=device, workers=workers, progress=progress
        )
    files: list[pathlib.Path] = []
    if folder is not None:
        files = tables_spectrum.write_spectrum(found, folder)
        files.append(plots_spectrum.draw_spectrum(folder / "spectrum.png", found))
    if as_json:
        rows = tables_spectrum.spectrum_table(found).to_dict("records")
        facts = {"case": case.name, **tables_spectrum.spectrum_facts(found), "rows": rows}
        console.print_json(facts | {"files": [str(path) for path in files]})
    else:
        tables_spectrum.print_spectrum(found, files)
