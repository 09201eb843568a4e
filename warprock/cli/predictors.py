"""The command `predictors`: which intensity measures predict best."""

from __future__ import annotations

import pathlib

import click

from warprock.cli.analysis import finish
from warprock.cli.completion import files
from warprock.cli.options import json_option, output_option
from warprock.cli.signatures import own_options


@click.command()
@click.argument("table", type=click.Path(path_type=pathlib.Path))
@own_options("analyses/predictors", "predictors", weights=files)
@output_option
@json_option
def predictors(
    table: pathlib.Path,
    im: tuple[str, ...],
    limit: str,
    max_doubt: float,
    weights: str | None,
    folder: pathlib.Path | None,
    as_json: bool,
) -> None:
    """Which intensity measures of TABLE predict best whether a limit state is reached.

    TABLE is the lane table of a run or of a merged sweep, or its folder. Each measure alone has its
    lognormal function, each two together a probability in both. How well they predict is told of
    records that a fit has not seen. Each measure is tested beside each other one: it is sufficient
    where the other adds nothing. -o writes the best two as slices for OpenQuake and pelicun.
    """
    from warprock.analysis.lane_tables import read_lanes
    from warprock.api.analyses.predictors import predictors_of
    from warprock.api.weights import weights_of

    found = predictors_of(read_lanes(table), str(table), im, limit, max_doubt, weights_of(weights))
    finish(found, folder, as_json=as_json)


COMMANDS = (predictors,)
