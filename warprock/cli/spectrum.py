"""The command `spectrum`: peak rotations of blocks of many sizes under one motion."""

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
    say_engine,
)


@click.command()
@case_options
@estimate_options
def spectrum(
    case_name: str,
    engine: str | None,
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    tolerance: float | None,
    estimate: bool,
    precision: str,
    device: str,
    workers: int | None,
    as_json: bool,
) -> None:
    """Rocking spectra: peak rotation / slenderness angle over 2 pi / p, a curve a slenderness.

    CASE has a [spectrum] table with the periods 2 pi / p and the slenderness angles; axes of its
    sweep, each with a label, make panels.
    """
    from warprock.analysis import spectrum as module
    from warprock.case.load import load_case
    from warprock.figures import spectrum as plots_spectrum
    from warprock.tables import console
    from warprock.tables import spectrum as tables_spectrum

    case = load_case(case_name, overrides)
    options = asked_options(precision, device, workers, tolerance=tolerance, estimate=estimate)
    choice = engine_for(case, engine)
    with console.lane_progress(case.name, case.lane_count) as progress:
        counted = dataclasses.replace(options, progress=progress)
        found = module.run_spectrum(case, choice.engine, counted)
    say_engine(choice)
    files: list[pathlib.Path] = []
    if folder is not None:
        files = tables_spectrum.write_spectrum(found, folder)
        files.append(plots_spectrum.draw_spectrum(folder / "spectrum.png", found))
        list_written(folder, files)
    if as_json:
        facts = tables_spectrum.spectrum_facts(found)
        console.print_rows_json(facts, tables_spectrum.spectrum_table(found), files)
    else:
        tables_spectrum.print_spectrum(found, files)
