"""The command `trade`, and what `run --cheapest` makes of its table."""

from __future__ import annotations

import pathlib
from typing import TYPE_CHECKING

import click

from warprock.cli.analysis import call, finish
from warprock.cli.options import json_option, output_to
from warprock.cli.signatures import own_options, read_function
from warprock.errors import InputError

if TYPE_CHECKING:
    from warprock.case.case import Case
    from warprock.measure.trade_choice import Choice
    from warprock.running.options import RunOptions


@click.command(help=read_function("trade", "trade").text)
@click.option("-e", "--engine", "engines", multiple=True, help="Only this engine; repeat for more.")
@own_options("trade", "trade")
@output_to(
    "Folder of the table; rows that it has from this machine are kept.",
    default="results",
    show_default=True,
)
@json_option
def trade(
    engines: tuple[str, ...], scene: tuple[str, ...], folder: pathlib.Path, as_json: bool
) -> None:
    """The command of `warprock.trade`."""
    from warprock.api import trade as api

    found, _engine = call(api.trade, engines, scene=scene, folder=folder)
    finish(found, folder, as_json=as_json, then=found.finding.then)


def choose_for(
    case_name: str,
    overrides: tuple[str, ...],
    tolerance: float | None,
    *,
    engine: str | None,
    precision: str | None,
    options: RunOptions,
) -> tuple[Case, Choice]:
    """A case with the cheapest settings within a tolerance, and the choice.

    Args:
        case_name: The case asked for.
        overrides: The overrides asked for.
        tolerance: The tolerance asked for; None where no estimate is wanted.
        engine: The engine asked for; None if none was.
        precision: The precision asked for; None if none was.
        options: How the tests of the choice are run, but for their precision.

    Raises:
        InputError: Settings, or no estimates, were asked for as well, or nothing met the tolerance.
    """
    from warprock.case.load import load_case
    from warprock.measure.trade_choice import OPTION, choose

    if tolerance is None:
        raise InputError("--no-estimate", "", "given", f"must be left out with {OPTION}")
    for override in overrides:
        if override.startswith("engines."):
            allowed = f"chooses the settings itself, without {override}"
            raise InputError(OPTION, "", "given", allowed)
    case = load_case(case_name, overrides)
    choice = choose(case, tolerance, engine=engine, precision=precision, options=options)
    return load_case(case_name, (*overrides, *choice.overrides)), choice


COMMANDS = (trade,)
