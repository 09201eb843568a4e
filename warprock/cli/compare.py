"""The commands `check` and `compare`: what cases expect, and engines beside one another."""

from __future__ import annotations

import dataclasses
import pathlib
import shlex

import click

from warprock.cli import completion
from warprock.cli.analysis import call, finish
from warprock.cli.exits import EXIT_CHECK
from warprock.cli.options import case_argument, json_option, output_option, set_option


@click.command()
@click.argument("case_name", metavar="[CASE]", required=False, shell_complete=completion.cases)
@json_option
@click.pass_context
def check(ctx: click.Context, case_name: str | None, as_json: bool) -> None:
    """Run the checks that a CASE holds, or those of all shipped cases; exit 3 if one fails."""
    from warprock.case.load import load_case
    from warprock.case.text import case_names
    from warprock.tables.compare import print_checks
    from warprock.tables.terminal import print_json
    from warprock.verification import checks

    rows = []
    for name in case_names() if case_name is None else [case_name]:
        rows += checks.run_checks(load_case(name))
    if as_json:
        print_json({"rows": [dataclasses.asdict(row) for row in rows]})
    else:
        print_checks(rows)
    if not all(row.ok for row in rows):
        ctx.exit(EXIT_CHECK)


@click.command()
@case_argument
@click.option(
    "-e",
    "--engine",
    "engines",
    multiple=True,
    shell_complete=completion.compared,
    help="Repeat for each.",
)
@set_option
@output_option
@json_option
def compare(
    case_name: str,
    engines: tuple[str, ...],
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    as_json: bool,
) -> None:
    """Engines side by side on one CASE, lane by lane, held against Housner.

    Stacks and blocks in space are held against the engine that is named first; ensembles, too, cell
    by cell; a case with poses that were observed against those. Programs that we did not write
    (newton-xpbd, mujoco, bullet, blender, ...; `list` has them) run beside. Settings of one run
    come behind its name: `-e event@time_step=1e-3`.
    """
    from warprock.api import comparison as api
    from warprock.tables.terminal import print_json

    found, _engine = call(api.compare, case_name, engine=engines, overrides=overrides)
    settings = [part for text in overrides for part in ("-s", text)]
    if as_json and folder is None:
        print_json(found.finding.json)
    else:
        then = shlex.join([*shlex.split(found.finding.then), *settings])
        finish(found, folder, as_json=as_json, then=then, always=True)


COMMANDS = (check, compare)
