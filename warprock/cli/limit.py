"""The command `limit`: the sideways load at which an assembly collapses."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli import completion
from warprock.cli.analysis import call, finish
from warprock.cli.options import case_argument, json_option, output_to, set_option
from warprock.cli.pages import on_case
from warprock.cli.signatures import help_of, read_function

_TEXT = read_function("limit", "limit").text.replace("`case`", "CASE").replace("`push`", "--push")


@click.command(help=_TEXT)
@case_argument
@click.option("--direction", metavar="ANGLE", help=help_of("limit", "limit", "direction"))
@click.option("--push", is_flag=True, default=False, help=help_of("limit", "limit", "push"))
@click.option(
    "-e", "--engine", shell_complete=completion.engines, help=help_of("limit", "limit", "engine")
)
@set_option
@output_to("Folder for the table, the figure and a page.")
@json_option
def limit(
    case_name: str,
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    as_json: bool,
    **asked: Any,
) -> None:
    """The command of `warprock.limit`."""
    from warprock.api import limit as api

    found, _engine = call(api.limit, case_name, overrides=overrides, **asked)
    then = on_case("explain", case_name, overrides)
    finish(found, folder, as_json=as_json, then=then)


COMMANDS = (limit,)
