"""The commands `list`, `explain` and `init`: what there is, what a case asks for, a new case."""

from __future__ import annotations

import pathlib

import click

from warprock.cli import completion
from warprock.cli.options import case_argument, json_option, set_option


@click.command("list")
@json_option
def list_command(as_json: bool) -> None:
    """The shipped cases and the engines."""
    from warprock.run.catalogue import list_all
    from warprock.tables.listing import print_listing
    from warprock.tables.terminal import print_json

    found = list_all()
    print_json(found) if as_json else print_listing(found)


@click.command()
@case_argument
@set_option
@json_option
def explain(case_name: str, overrides: tuple[str, ...], as_json: bool) -> None:
    """What a case requires, and which kernels can run it."""
    from warprock.case.load import load_case
    from warprock.run.catalogue import explain_case
    from warprock.tables.listing import print_explanation
    from warprock.tables.terminal import print_json

    found = explain_case(load_case(case_name, overrides))
    print_json(found) if as_json else print_explanation(found)


@click.command()
@click.argument("kind", shell_complete=completion.kinds)
@click.argument("path", required=False, type=click.Path(path_type=pathlib.Path))
def init(kind: str, path: pathlib.Path | None) -> None:
    """Write a commented case file of a KIND to start from; an unknown KIND lists them all."""
    from warprock.run.catalogue import write_template

    click.echo(write_template(kind, path or pathlib.Path("case.toml")))


COMMANDS = (list_command, explain, init)
