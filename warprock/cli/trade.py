"""The command `trade`."""

from __future__ import annotations

import pathlib

import click

from warprock.cli.analysis import call, finish
from warprock.cli.options import json_option, output_to
from warprock.cli.signatures import own_options, read_function


@click.command(help=read_function("trade", "trade").text)
@click.option("-e", "--engine", "engines", multiple=True, help="Only this engine; repeat for more.")
@own_options("trade", "trade")
@output_to(
    "Folder of the table; rows that it has from this machine are kept.",
    default="results",
    show_default=True,
)
@json_option
def trade(
    engines: tuple[str, ...], scene: tuple[str, ...], folder: pathlib.Path, as_json: bool
) -> None:
    """The command of `warprock.trade`."""
    from warprock.api import trade as api

    found, _engine = call(api.trade, engines, scene=scene, folder=folder)
    finish(found, folder, as_json=as_json, then=found.finding.then)


COMMANDS = (trade,)
