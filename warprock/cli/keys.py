"""The command `keys`: what may be written in a case file."""

from __future__ import annotations

import click

from warprock.cli import completion
from warprock.cli.options import json_option


@click.command()
@click.argument("table", required=False, shell_complete=completion.tables)
@click.option("--markdown", is_flag=True, help="As a page of Markdown.")
@json_option
def keys(table: str | None, markdown: bool, as_json: bool) -> None:
    """Keys of a case file: bounds, units, meaning, whether they may be swept, their columns.

    TABLE is a table, such as `block` or `engines.dem`, or a key, such as `block.height`; all
    without it.
    """
    from warprock.case.reference import find_sections, reference_page
    from warprock.tables.keys import print_keys
    from warprock.tables.terminal import print_json

    found = find_sections(table)
    if as_json:
        print_json({"tables": [section.as_json() for section in found]})
    elif markdown:
        click.echo(reference_page(found))
    else:
        print_keys(found)


COMMANDS = (keys,)
