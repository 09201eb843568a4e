"""The command `sensitivity`: which inputs of a case explain the variance of a result."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import case_work, finish, run_of
from warprock.cli.options import case_options, estimate_options


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
    folder: pathlib.Path | None, of: str, resamples: int, as_json: bool, **asked: Any
) -> None:
    """Sobol' indices: which inputs of a CASE with a [sample] explain the variance of a result.

    sample.lanes, a power of 2, is the size of the two samples that are compared; with d inputs
    (d + 2) times as many lanes run. Axes of the sweep, each with a label, make panels.
    """
    from warprock.api.analyses.sensitivity import sensitivity_of

    with case_work(**asked) as work:
        found = sensitivity_of(work, of, resamples)
    finish(found, folder, as_json=as_json, then=run_of(work.engine, folder, **asked))


COMMANDS = (sensitivity,)
