"""The command `capacity`: what single blocks bear by statics."""

from __future__ import annotations

import pathlib

import click

from warprock.cli.analysis import call, finish
from warprock.cli.options import case_argument, json_option, output_option, set_option
from warprock.cli.pages import on_case
from warprock.cli.signatures import help_of, read_function


@click.command(help=read_function("capacity", "capacity").text)
@case_argument
@click.option(
    "--dynamics", is_flag=True, default=False, help=help_of("capacity", "capacity", "dynamics")
)
@set_option
@output_option
@json_option
def capacity(
    case_name: str,
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    as_json: bool,
    dynamics: bool,
) -> None:
    """The command of `warprock.capacity`."""
    from warprock.api import capacity as api

    found, _engine = call(api.capacity, case_name, dynamics=dynamics, overrides=overrides)
    then = on_case("run", case_name, overrides, "-o", f"{folder}-run")
    finish(found, folder, as_json=as_json, then=then)


COMMANDS = (capacity,)
