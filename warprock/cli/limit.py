"""The command `limit`: the sideways load at which an assembly collapses."""

from __future__ import annotations

import pathlib

import click

from warprock.cli.analysis import call, finish
from warprock.cli.options import case_argument, json_option, output_to, set_option
from warprock.cli.pages import on_case
from warprock.cli.signatures import read_function


@click.command(help=read_function("limit", "limit").text.replace("`case`", "CASE"))
@case_argument
@set_option
@output_to("Folder for the table, the figure and a page.")
@json_option
def limit(
    case_name: str, overrides: tuple[str, ...], folder: pathlib.Path | None, as_json: bool
) -> None:
    """The command of `warprock.limit`."""
    from warprock.api import limit as api

    found, _engine = call(api.limit, case_name, overrides=overrides)
    then = on_case("explain", case_name, overrides)
    finish(found, folder, as_json=as_json, then=then)


COMMANDS = (limit,)
