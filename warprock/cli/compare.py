"""The commands `check` and `compare`: what cases expect, and engines beside one another."""

from __future__ import annotations

import dataclasses
import pathlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from warprock.cli import completion
from warprock.cli.exits import EXIT_CHECK
from warprock.cli.options import case_argument, json_option, output_option, set_option
from warprock.cli.pages import leave

if TYPE_CHECKING:
    from warprock.case.case import Case


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
    from warprock.case.load import load_case
    from warprock.compare import checks
    from warprock.figures.poses import draw_poses
    from warprock.run.files import require_writable
    from warprock.run.results import write_results
    from warprock.tables.comparison import comparison_report
    from warprock.tables.terminal import lane_progress, print_end, print_json, print_written

    if folder is not None:
        require_writable(folder)

    case = load_case(case_name, overrides)
    with lane_progress(case.name, None) as progress:
        found = checks.compare(case, list(engines), progress=progress)
    report, files = comparison_report(case, found), []
    if folder is not None:
        files = write_results(folder, report.tables, report.facts)
        drawings = draw_poses(found) if "observed" in found else []
        files = leave(folder, files, drawings=drawings, scenes=_play(case, found))
    if as_json:
        print_json({**found, "files": files} if files else found)
        return
    report.show()
    print_written(files)
    if report.came_out:
        print_end(report.came_out, report.then)


def _play(case: Case, found: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """The lane in which engines differ most, and the first, with every engine of ours."""
    from warprock.case.lanes import expand_lanes
    from warprock.compare.lane_names import lane_name
    from warprock.compare.settings import case_asked, plain_name
    from warprock.report.replays import Replay, played
    from warprock.report.scenes import SOME
    from warprock.run.options import RunOptions
    from warprock.settings.engines import SETTINGS

    if case.ensemble is not None:
        return None
    lane_set, worst = expand_lanes(case), _worst(found, case.tables.block_count)
    ours = [engine for engine in found["engines"] if plain_name(engine) in SETTINGS][:SOME]
    lanes = list(dict.fromkeys((worst, 0)))[: SOME // max(1, len(ours)) or 1]
    replays = [
        Replay(
            lane_set.alone(lane),
            plain_name(engine),
            case_asked(case, engine).engine_settings(plain_name(engine)),
            f"{engine}, lane {lane} ({lane_name(lane_set, lane)})",
            "engines differ most here" if lane == worst else "the first lane",
        )
        for lane in lanes
        for engine in ours
    ]
    note = "The lane in which the engines differ most, and the first, each engine by itself."
    return played(case, RunOptions(tolerance=None), replays, note)


_OFF = ("error_run_ratio", "difference_run_ratio", "position_error_mm")
"""How far a lane is from Housner, from the engine named first, or from what was observed."""


def _worst(found: Mapping[str, Any], blocks: int) -> int:
    """The lane in which an engine is farthest from what it was held against."""
    most, worst = 0.0, 0
    for engine in found["engines"]:
        mine = [row for row in found["rows"] if row["engine"] == engine]
        for place, row in enumerate(mine):
            off = next((row[name] for name in _OFF if row.get(name) is not None), 0.0)
            if off > most:
                most, worst = off, place // blocks
    return worst


COMMANDS = (check, compare)
