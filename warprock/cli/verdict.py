"""The command `verdict`: does a block stand under a motion, and by how much."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli import completion
from warprock.cli.analysis import case_work, finish
from warprock.cli.options import (
    engine_option,
    estimate_options,
    json_option,
    output_option,
    run_options,
    set_option,
)
from warprock.cli.signatures import own_options, read_function
from warprock.errors import InputError


@click.command(help=read_function("verdict", "verdict").text)
@click.argument("case_name", metavar="[CASE]", required=False, shell_complete=completion.cases)
@own_options("verdict", "verdict", body=completion.bodies, record=completion.records)
@engine_option
@set_option
@output_option
@run_options
@estimate_options
@json_option
def verdict(
    case_name: str | None,
    body: str | None,
    record: str | None,
    margin: float,
    neighbours: int,
    spread_size: float,
    spread_friction: float,
    spread_motion: float,
    folder: pathlib.Path | None,
    as_json: bool,
    **asked: Any,
) -> None:
    """The command of `warprock.verdict`."""
    from warprock.analysis.verdict import Spread
    from warprock.api.verdict import verdict_of
    from warprock.case.template import case_of_record

    made = None
    if case_name is None:
        made = case_of_record(body, record)
    elif body is not None or record is not None:
        option = "--body" if body is not None else "--record"
        raise InputError(option, "", body or record, "must be left out where a CASE is given")
    with case_work(case_name or "", made=made, factors=(0.1, 1.0, 10.0), **asked) as work:
        spread = Spread(spread_size, spread_friction, spread_motion)
        found = verdict_of(work, margin, neighbours, spread)
    finish(found, folder, as_json=as_json)


COMMANDS = (verdict,)
