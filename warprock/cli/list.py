"""The command `list`: what there is to choose from."""

from __future__ import annotations

import click

from warprock.cli.options import json_option


@click.command("list")
@json_option
def list_command(as_json: bool) -> None:
    """The shipped cases and the engines."""
    from warprock.running.choices import list_all
    from warprock.tables.listing import print_listing
    from warprock.tables.terminal import print_json

    found = list_all()
    print_json(found) if as_json else print_listing(found)


COMMANDS = (list_command,)
