"""The command `stability`: the atlas of extremes."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import call, finish
from warprock.cli.options import json_option, output_to, workers_option
from warprock.cli.signatures import own_options, read_function


@click.command(help=read_function("stability", "stability").text)
@click.option("-e", "--engine", "engines", multiple=True, help="Repeat for each; all without.")
@own_options("stability", "stability")
@output_to(
    "Folder for the results; what it holds already is not run again.",
    default="results/stability",
    show_default=True,
)
@workers_option
@json_option
def stability(engines: tuple[str, ...], folder: pathlib.Path, as_json: bool, **asked: Any) -> None:
    """The command of `warprock.stability`."""
    from warprock.api import stability as api

    found, _engine = call(api.stability, engines, folder=folder, **asked)
    finish(found, folder, as_json=as_json, then=found.finding.then)


COMMANDS = (stability,)
