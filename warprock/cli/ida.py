"""The command `ida`: incremental dynamic analysis, the motion at which every lane first falls."""

from __future__ import annotations

import pathlib
from typing import TYPE_CHECKING, Any

import click

from warprock.cli.options import (
    asked_options,
    by_option,
    case_options,
    engine_for,
    estimate_options,
    say_engine,
)

if TYPE_CHECKING:
    from warprock.analysis.capacities import Capacities
    from warprock.analysis.incremental import Analysis
    from warprock.case.case import Case


@click.command()
@case_options
@estimate_options
@click.option("--from", "lowest", default=0.1, show_default=True, help="Least factor on a motion.")
@click.option("--to", "highest", default=10.0, show_default=True, help="Greatest factor.")
@click.option("--count", default=21, show_default=True, help="Factors of the first stage.")
@click.option("--accuracy", default=0.01, show_default=True, help="Width of a bracket, relatively.")
@click.option(
    "--im",
    "intensity",
    default="peak_acceleration_m_s2",
    show_default=True,
    metavar="COLUMN",
    help="Intensity measure; or normalised_acceleration, scale, factor.",
)
@by_option
def ida(
    case_name: str,
    engine: str | None,
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    tolerance: float | None,
    estimate: bool,
    intensity: str,
    by: tuple[str, ...],
    precision: str,
    device: str,
    workers: int | None,
    as_json: bool,
    **factors: Any,
) -> None:
    """Incremental dynamic analysis of a CASE: the factor on its motion at which each lane falls.

    All lanes run at a ladder of factors; the bracket of each one's first fall is then halved. With
    -o every finished stage is kept, and the same command goes on behind the last one.
    """
    from warprock.analysis import capacities, incremental
    from warprock.case.load import load_case
    from warprock.tables import console

    case = load_case(case_name, overrides)
    ladder = incremental.Ladder(**factors)
    ladder.judge()
    choice = engine_for(case, engine, ladder.factors.tolist())
    options = asked_options(precision, device, workers, tolerance=tolerance, estimate=estimate)
    plan = incremental.plan_analysis(case, choice.engine, ladder, options)
    capacities.require_columns(case, intensity, by)
    with console.lane_progress(case.name, None) as progress:
        found = incremental.run_analysis(
            case, plan, ladder, folder, workers=workers, progress=progress
        )
    groups = capacities.capacities(found, intensity=intensity, by=by)
    say_engine(choice)
    _show(found, case, groups, intensity, folder, as_json=as_json)


def _show(
    found: Analysis,
    case: Case,
    groups: list[Capacities],
    intensity: str,
    folder: pathlib.Path | None,
    *,
    as_json: bool,
) -> None:
    """Writes an analysis where a folder is given, and prints it."""
    from warprock.analysis.capacities import capacity_rows
    from warprock.figures import incremental as plots_incremental
    from warprock.tables import console
    from warprock.tables import incremental as tables_incremental

    rows = capacity_rows(groups)
    files: list[pathlib.Path] = []
    if folder is not None:
        files = tables_incremental.write_analysis(found, case, rows, intensity, folder)
        figure = folder / "ida.png"
        files.append(plots_incremental.draw_analysis(figure, found, groups, intensity))
    if as_json:
        console.print_json(
            {
                "case": case.name,
                "intensity": intensity,
                **tables_incremental.analysis_facts(found),
                "groups": rows.to_dict("records"),
                "files": files,
            }
        )
    else:
        tables_incremental.print_analysis(found, rows, intensity, files)
