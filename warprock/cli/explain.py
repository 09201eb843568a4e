"""The command `explain`: what a case asks for."""

from __future__ import annotations

import click

from warprock.cli.analysis import call, show
from warprock.cli.options import case_argument, json_option, set_option
from warprock.cli.pages import on_case
from warprock.cli.signatures import read_function


@click.command(help=read_function("explanation", "explain").text)
@case_argument
@set_option
@json_option
def explain(case_name: str, overrides: tuple[str, ...], as_json: bool) -> None:
    """The command of `warprock.explain`."""
    from warprock.api import explanation as api

    found, _engine = call(api.explain, case_name, overrides=overrides)
    then = on_case("run", case_name, overrides, "-o", "results")
    show(found, then, as_json=as_json)


COMMANDS = (explain,)
