"""The commands `check` and `compare`: what cases expect, and engines beside one another."""

from __future__ import annotations

import dataclasses
import functools
import shlex
from collections.abc import Callable
from typing import Any

import click

from warprock.cli import completion
from warprock.cli.exits import EXIT_CHECK
from warprock.cli.options import case_argument, json_option, set_option


@click.command()
@click.argument("case_name", metavar="[CASE]", required=False, shell_complete=completion.cases)
@json_option
@click.pass_context
def check(ctx: click.Context, case_name: str | None, as_json: bool) -> None:
    """Run the checks that a CASE holds, or those of all shipped cases; exit 3 if one fails."""
    from warprock.case.load import load_case
    from warprock.case.text import case_names
    from warprock.compare import checks
    from warprock.tables.compare import print_checks
    from warprock.tables.terminal import print_json

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
    required=True,
    shell_complete=completion.compared,
    help="Repeat for each.",
)
@set_option
@json_option
def compare(
    case_name: str, engines: tuple[str, ...], overrides: tuple[str, ...], as_json: bool
) -> None:
    """Engines side by side on one CASE, lane by lane, held against Housner.

    Stacks and blocks in space are held against the engine that is named first; ensembles, too, cell
    by cell; a case with poses that were observed against those. Programs that we did not write
    (newton-xpbd, mujoco, bullet, blender, ...; `list` has them) run beside. Settings of one run
    come behind its name: `-e event@time_step=1e-3`.
    """
    from warprock.case.load import load_case
    from warprock.compare import checks
    from warprock.compare.settings import plain_name
    from warprock.tables.cells import print_cell_comparison
    from warprock.tables.compare import print_comparison
    from warprock.tables.peers import print_costs
    from warprock.tables.poses import print_pose_comparison
    from warprock.tables.stack import print_stack_comparison
    from warprock.tables.terminal import lane_progress, print_end, print_json

    case = load_case(case_name, overrides)
    with lane_progress(case.name, None) as progress:
        found = checks.compare(case, list(engines), progress=progress)
    show: Callable[[dict[str, Any]], None] = print_comparison
    if found["stacked"] or found.get("spatial"):
        show = print_stack_comparison
    if "observed" in found:
        show = print_pose_comparison
    if case.ensemble is not None:
        show = functools.partial(print_cell_comparison, case)
    if as_json:
        print_json(found)
        return
    show(found)
    print_costs(found)
    if show not in (print_comparison, print_pose_comparison):
        print_end(
            f"{len(engines)} engines were held against {engines[0]}.",
            f"warprock run {shlex.quote(case_name)} -e {plain_name(engines[0])} -o results",
        )


COMMANDS = (check, compare)
