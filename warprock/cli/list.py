"""The command `list`: what there is to choose from."""

from __future__ import annotations

import click

from warprock.cli.analysis import call, show
from warprock.cli.options import json_option
from warprock.cli.signatures import read_function


@click.command("list", help=read_function("choices", "list").text)
@json_option
def list_command(as_json: bool) -> None:
    """The command of `warprock.list`."""
    from warprock.api import choices as api

    found, _engine = call(api.list)
    show(found, as_json=as_json)


COMMANDS = (list_command,)
