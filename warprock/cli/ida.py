"""The command `ida`: incremental dynamic analysis, the motion at which every lane first falls."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import call, finish, run_of
from warprock.cli.options import case_options, estimate_options, ladder_options
from warprock.cli.signatures import own_options


@click.command()
@case_options
@estimate_options
@ladder_options
@own_options("analyses/ida", "ida")
def ida(case_name: str, folder: pathlib.Path | None, as_json: bool, **asked: Any) -> None:
    """Incremental dynamic analysis of a CASE: the factor on its motion at which each lane falls.

    All lanes run at a ladder of factors; the bracket of each one's first fall is then halved. With
    -o every finished stage is kept, and the same command goes on behind the last one.
    """
    from warprock.api.analyses import ida as api

    found, engine = call(api.ida, case_name, folder=folder, **asked)
    then = run_of(engine, folder, case_name, asked["overrides"])
    finish(found, folder, as_json=as_json, then=then)


COMMANDS = (ida,)
