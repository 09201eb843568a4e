"""The command `validate`: engines held to what tests showed."""

from __future__ import annotations

import dataclasses
import functools
import pathlib
from typing import Any

import click

from warprock.cli import completion
from warprock.cli.analysis import finish
from warprock.cli.options import (
    asked_options,
    case_argument,
    engine_for,
    estimate_options,
    json_option,
    output_option,
    run_options,
    say_engine,
    set_option,
)


@click.command()
@case_argument
@click.option(
    "--observed",
    type=click.Path(path_type=pathlib.Path),
    help="CSV or Parquet file with one row a test: its outcome, and a label of the case, the "
    "record or the lane; without, the case's own label `observed` says the outcomes.",
)
@click.option(
    "--column",
    help="Column of the outcome [default: observed, overturned or outcome].",
)
@click.option(
    "--group",
    metavar="COLUMN",
    help="Column of the file or of the lane table that says which tests share a ground motion "
    "[default: record].",
)
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
    observed: pathlib.Path | None,
    column: str | None,
    group: str | None,
    engines: tuple[str, ...],
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    as_json: bool,
    **how: Any,
) -> None:
    """Hold engines to observed outcomes: how many tests of a CASE do they say rightly?

    A test is a lane, or all members of an ensemble's cell or of a sample: the share of them that
    overturns is its probability. Printed are accuracy, AUC and Brier score beside those of a
    threshold on PGA and on PGV, accuracy by status, fragility functions observed and predicted, and
    paired tests.

    Words of an outcome: overturned, fell, 1, true, yes, or stood, standing, 0, false, no; an empty
    cell was not seen. Columns such as peak_rotation_deg and peak_slide_mm are held against peaks.
    """
    from warprock.case.load import load_case
    from warprock.figures.validation import draw_validation
    from warprock.tables.terminal import lane_progress
    from warprock.tables.validation import validation_report
    from warprock.verification.validation import run_validation

    case, options = load_case(case_name, overrides), asked_options(**how)
    choice = engine_for(case, None) if not engines else None
    names = [choice.engine] if choice is not None else list(engines)
    with lane_progress(case.name, len(names) * case.lane_count) as progress:
        counted = dataclasses.replace(options, progress=progress)
        found = run_validation(case, names, observed, counted, column=column, group=group)
    if choice is not None:
        say_engine(choice)
    draw = functools.partial(draw_validation, found)
    finish(validation_report(found), draw, folder, as_json=as_json)


COMMANDS = (validate,)
