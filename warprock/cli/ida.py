"""The command `ida`: incremental dynamic analysis, the motion at which every lane first falls."""

from __future__ import annotations

import functools
import pathlib
from typing import Any

import click

from warprock.cli.analysis import case_work, finish, run_of, running
from warprock.cli.options import by_option, case_options, estimate_options, intensity_option


@click.command()
@case_options
@estimate_options
@click.option("--from", "lowest", default=0.1, show_default=True, help="Least factor on a motion.")
@click.option("--to", "highest", default=10.0, show_default=True, help="Greatest factor.")
@click.option("--count", default=21, show_default=True, help="Factors of the first stage.")
@click.option("--accuracy", default=0.01, show_default=True, help="Width of a bracket, relatively.")
@intensity_option("Intensity measure, or PGA; or normalised_acceleration, scale, factor.")
@by_option
def ida(
    folder: pathlib.Path | None,
    intensity: str,
    by: tuple[str, ...],
    lowest: float,
    highest: float,
    count: int,
    accuracy: float,
    as_json: bool,
    **asked: Any,
) -> None:
    """Incremental dynamic analysis of a CASE: the factor on its motion at which each lane falls.

    All lanes run at a ladder of factors; the bracket of each one's first fall is then halved. With
    -o every finished stage is kept, and the same command goes on behind the last one.
    """
    from warprock.analysis.capacities import INTENSITIES, capacities, require_columns
    from warprock.analysis.incremental import Ladder, plan_analysis, run_analysis
    from warprock.analysis.lane_tables import measure_named
    from warprock.figures.incremental import draw_analysis
    from warprock.report.chosen import played_of_analysis
    from warprock.tables.incremental import analysis_report

    intensity = measure_named(intensity, INTENSITIES)
    ladder = Ladder(lowest, highest, count, accuracy)
    ladder.judge()
    work = case_work(**asked, factors=ladder.factors.tolist())
    case, plan = work.case, plan_analysis(work.case, work.engine, ladder, work.options)
    require_columns(case, intensity, by)
    with running(work, None) as options:
        found = run_analysis(
            case, plan, ladder, folder, workers=options.workers, progress=options.progress
        )
        groups = capacities(found, intensity=intensity, by=by)
    report = analysis_report(found, case, groups, intensity)

    draw = functools.partial(draw_analysis, found, groups, intensity)
    play = functools.partial(played_of_analysis, case, work.engine, work.options, found)
    finish(
        report, draw, folder, as_json=as_json, then=run_of(work.engine, folder, **asked), play=play
    )


COMMANDS = (ida,)
