"""The command `verdict`: does a block stand under a motion, and by how much."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli import completion
from warprock.cli.analysis import call, finish
from warprock.cli.options import (
    engine_option,
    estimate_options,
    json_option,
    output_option,
    run_options,
    set_option,
)
from warprock.cli.signatures import own_options, read_function


@click.command(help=read_function("verdict", "verdict").text)
@click.argument("case_name", metavar="[CASE]", required=False, shell_complete=completion.cases)
@own_options("verdict", "verdict", body=completion.bodies, record=completion.records)
@engine_option
@set_option
@output_option
@run_options
@estimate_options
@json_option
def verdict(
    case_name: str | None, folder: pathlib.Path | None, as_json: bool, **asked: Any
) -> None:
    """The command of `warprock.verdict`."""
    from warprock.api import verdict as api

    found, _engine = call(api.verdict, case_name, **asked)
    finish(found, folder, as_json=as_json)


COMMANDS = (verdict,)
