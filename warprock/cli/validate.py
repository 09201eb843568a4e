"""The command `validate`: engines held to what tests showed."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli import completion
from warprock.cli.analysis import call, finish
from warprock.cli.options import (
    case_argument,
    estimate_options,
    json_option,
    output_option,
    run_options,
    set_option,
)
from warprock.cli.signatures import own_options


@click.command()
@case_argument
@click.option(
    "--observed",
    type=click.Path(path_type=pathlib.Path),
    help="CSV or Parquet file with one row a test: its outcome, and a label of the case, the "
    "record or the lane; without, the case's own label `observed` says the outcomes.",
)
@own_options("validation", "validate")
@click.option(
    "-e",
    "--engine",
    "engines",
    multiple=True,
    shell_complete=completion.compared,
    help="Engine or program; repeat for each. Without, the one that the case has as a rule.",
)
@set_option
@output_option
@run_options
@estimate_options
@json_option
def validate(
    case_name: str,
    engines: tuple[str, ...],
    folder: pathlib.Path | None,
    as_json: bool,
    **asked: Any,
) -> None:
    """Hold engines to observed outcomes: of how many tests of a CASE do they predict the outcome?

    A test is a lane, or all members of an ensemble's cell or of a sample: the share of them that
    overturns is its probability. The command prints accuracy, AUC and Brier score beside those of a
    threshold on PGA and on PGV, accuracy by status, fragility functions observed and predicted, and
    paired tests.

    An outcome is one of these words: overturned, fell, 1, true, yes, or stood, standing, 0, false,
    no; where nobody saw it, the cell is empty. Columns such as peak_rotation_deg and peak_slide_mm
    are held against peaks, peak_rotation_2_deg of block 2 of a stack, peak_displacement_mm of an
    assembly.
    """
    from warprock.api import validation as api

    found, _engine = call(api.validate, case_name, engine=engines, **asked)
    finish(found, folder, as_json=as_json, then=found.finding.then)


COMMANDS = (validate,)
