"""The command `explain`: what a case asks for."""

from __future__ import annotations

import click

from warprock.cli.options import case_argument, json_option, set_option
from warprock.cli.pages import on_case


@click.command()
@case_argument
@set_option
@json_option
def explain(case_name: str, overrides: tuple[str, ...], as_json: bool) -> None:
    """What a case requires, and which kernels can run it."""
    from warprock.case.load import load_case
    from warprock.running.catalogue import explain_case
    from warprock.tables.listing import print_explanation
    from warprock.tables.terminal import print_json

    found = explain_case(load_case(case_name, overrides))
    then = on_case("run", case_name, overrides, "-o", "results")
    print_json(found) if as_json else print_explanation(found, then)


COMMANDS = (explain,)
