"""The command `ida`: incremental dynamic analysis, the motion at which every lane first falls."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import case_work, finish, run_of
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
    from warprock.analysis.incremental import Ladder
    from warprock.api.analyses.ida import ida_of

    ladder = Ladder(lowest, highest, count, accuracy)
    ladder.judge()
    with case_work(**asked, factors=ladder.factors.tolist()) as work:
        found = ida_of(work, ladder, intensity, by, folder)
    finish(found, folder, as_json=as_json, then=run_of(work.engine, folder, **asked))


COMMANDS = (ida,)
