"""The command `stability`: the atlas of extremes."""

from __future__ import annotations

import pathlib

import click

from warprock.cli.analysis import finish
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
def stability(
    engines: tuple[str, ...],
    map: tuple[str, ...],
    points: int,
    steps: int,
    folder: pathlib.Path,
    workers: int | None,
    as_json: bool,
) -> None:
    """The command of `warprock.stability`."""
    from warprock.api.stability import Atlas
    from warprock.measure.atlas_lanes import AtlasSize
    from warprock.running.options import RunOptions
    from warprock.tables.terminal import lane_progress

    asked = Atlas(engines, map, AtlasSize(points=points, steps=steps), folder)
    with lane_progress("stability", asked.parts) as progress:
        found = asked.run(RunOptions(workers=workers, progress=progress))
    finish(found, folder, as_json=as_json, then=found.finding.then)


COMMANDS = (stability,)
