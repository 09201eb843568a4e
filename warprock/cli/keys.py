"""The command `keys`: what may be written in a case file."""

from __future__ import annotations

import click

from warprock.cli import completion
from warprock.cli.analysis import call, show
from warprock.cli.options import json_option
from warprock.cli.signatures import help_of, read_function

_WHICH = help_of("keys", "keys", "table")


@click.command(
    help=f"{read_function('keys', 'keys').text}\n\nTABLE is {_WHICH[0].lower()}{_WHICH[1:]}"
)
@click.argument("table", required=False, shell_complete=completion.tables)
@click.option("--markdown", is_flag=True, help="As a page of Markdown.")
@json_option
def keys(table: str | None, markdown: bool, as_json: bool) -> None:
    """The command of `warprock.keys`."""
    from warprock.api import keys as api

    found, _engine = call(api.keys, table)
    if markdown and not as_json:
        from warprock.case.reference import reference_page

        click.echo(reference_page(found.found))
        return
    show(found, as_json=as_json)


COMMANDS = (keys,)
