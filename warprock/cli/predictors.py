"""The command `predictors`: which intensity measures predict best."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import call, finish
from warprock.cli.completion import files
from warprock.cli.options import json_option, output_option
from warprock.cli.signatures import own_options


@click.command()
@click.argument("table", type=click.Path(path_type=pathlib.Path))
@own_options("analyses/predictors", "predictors", weights=files)
@output_option
@json_option
def predictors(
    table: pathlib.Path, folder: pathlib.Path | None, as_json: bool, **asked: Any
) -> None:
    """Which intensity measures of TABLE predict best whether a limit state is reached.

    TABLE is the lane table of a run or of a merged sweep, or its folder. Each measure alone has its
    lognormal function, each two together a probability in both. How well they predict is told of
    records that a fit has not seen. Each measure is tested beside each other one: it is sufficient
    where the other adds nothing. -o writes the best two as slices for OpenQuake and pelicun.
    """
    from warprock.api.analyses import predictors as api

    found, _engine = call(api.predictors, table, **asked)
    finish(found, folder, as_json=as_json)


COMMANDS = (predictors,)
