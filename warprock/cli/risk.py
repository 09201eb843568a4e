"""The command `risk`: yearly rates of limit states under a hazard curve."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import call, finish
from warprock.cli.completion import files
from warprock.cli.options import hazard_options, json_option, output_option
from warprock.cli.signatures import own_options


@click.command()
@click.argument("folders", metavar="FOLDER...", nargs=-1, required=True)
@hazard_options
@own_options("analyses/risk", "risk", weights=files)
@output_option
@json_option
def risk(
    folders: tuple[str, ...], folder: pathlib.Path | None, as_json: bool, **asked: Any
) -> None:
    """How often in a year blocks reach a limit state, under a hazard curve of yours.

    Fragility functions are fitted to the lanes of each FOLDER, which a run, a sweep or an ida
    wrote, over the measure of the hazard; the rate is their integral over it, in closed form, with
    the band over records. A component table, FILE.csv, has functions that are known already, as
    medians and dispersions. The hazard is a file, or a power law: an intensity x is exceeded
    k0 (x / at)^-k times a year.
    """
    from warprock.api.analyses import risk as api

    found, _engine = call(api.risk, folders, **asked)
    finish(found, folder, as_json=as_json)


COMMANDS = (risk,)
