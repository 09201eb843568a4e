"""The command line: each command calls the functions of its module and prints what they return.

Heavy modules are imported inside the commands, so that `warprock --help` answers at once.
Results go to stdout, progress and errors to stderr.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import os
import pathlib
import pkgutil
import signal
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

import warprock.cli
from warprock import __version__
from warprock.cli.exits import EXIT_CHECK, EXIT_FAILED, EXIT_INTERRUPTED, ExitCodes
from warprock.cli.options import (
    EXIT_BAD_LANES,
    asked_options,
    engine_for,
    engine_option,
    estimate_options,
    json_option,
    max_bad_option,
    output_option,
    output_to,
    require_within,
    run_options,
    say_engine,
    set_option,
    workers_option,
)
from warprock.cli.pages import leave
from warprock.cli.study import run_study_of
from warprock.cli.sweep import EXIT_RESUMABLE, bench_sweep
from warprock.cli.trade import choose_for, require_accuracy_alone
from warprock.errors import InputError

if TYPE_CHECKING:
    from warprock.measure.trade_choice import Choice
    from warprock.run.case_run import CaseRun


@click.group(cls=ExitCodes, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="warprock")
def main() -> None:
    """Batched simulation of rocking rigid blocks.

    A case (a folder with a case.toml, or the name of a shipped one) becomes lanes, one for each
    set of inputs; an engine answers for all lanes at once.
    """


@main.command("list")
@json_option
def list_command(as_json: bool) -> None:
    """The shipped cases and the engines."""
    from warprock.run.catalogue import list_all
    from warprock.tables.listing import print_listing
    from warprock.tables.terminal import print_json

    found = list_all()
    print_json(found) if as_json else print_listing(found)


@main.command()
@click.argument("case_name", metavar="CASE")
@set_option
@json_option
def explain(case_name: str, overrides: tuple[str, ...], as_json: bool) -> None:
    """What a case requires, and which kernels can run it."""
    from warprock.case.load import load_case
    from warprock.run.catalogue import explain_case
    from warprock.tables.listing import print_explanation
    from warprock.tables.terminal import print_json

    found = explain_case(load_case(case_name, overrides))
    print_json(found) if as_json else print_explanation(found)


@main.command()
@click.argument("kind")
@click.argument("path", required=False, type=click.Path(path_type=pathlib.Path))
def init(kind: str, path: pathlib.Path | None) -> None:
    """Write a commented case file of a KIND to start from; an unknown KIND lists them all."""
    from warprock.run.catalogue import write_template

    click.echo(write_template(kind, path or pathlib.Path("case.toml")))


@main.command()
@click.argument("case_name", metavar="CASE")
@engine_option
@set_option
@output_option
@run_options
@click.option("--history", "lanes", type=int, multiple=True, help="Lane whose history to write.")
@estimate_options
@click.option(
    "--accuracy",
    type=float,
    help="A --tolerance that also picks the cheapest engine and settings that met it in `warprock "
    "trade`, of --engine and --precision where given, and tests them.",
)
@max_bad_option
@json_option
@click.pass_context
def run(
    ctx: click.Context,
    case_name: str,
    engine: str | None,
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    precision: str,
    device: str,
    workers: int | None,
    lanes: tuple[int, ...],
    tolerance: float | None,
    estimate: bool,
    accuracy: float | None,
    max_bad: float | None,
    as_json: bool,
) -> None:
    """Run every lane of a CASE with one engine; a study, with all of its engines and settings.

    Every lane runs at half the step, and again, until its rotations are within the tolerance by
    their estimate; lanes that do not get there say so.
    """
    from warprock.case.lanes import require_room_for_lanes
    from warprock.case.load import load_case
    from warprock.run.case_run import require_histories, require_options, run_case
    from warprock.tables.terminal import lane_progress

    case, choice = load_case(case_name, overrides), None
    if case.study is not None:
        refused = {"--history": lanes or None, "--accuracy": accuracy, "--tolerance": tolerance}
        refused |= {"--max-bad": max_bad, "--estimate": estimate and not _is_default("estimate")}
        options = asked_options(precision, device, workers, estimate=False)
        return run_study_of(case, engine, folder, refused, options, as_json=as_json)
    if accuracy is not None:
        require_accuracy_alone(tolerance, estimate=estimate)
    options = asked_options(precision, device, workers, tolerance=tolerance, estimate=estimate)
    require_options(engine or "event", options)
    if accuracy is not None:
        fixed = None if _is_default("precision") else precision
        tests = asked_options(workers=workers)
        case, choice = choose_for(
            case_name, overrides, accuracy, engine=engine, precision=fixed, options=tests
        )
        engine = choice.engine
        options = dataclasses.replace(options, precision=choice.precision, tolerance=accuracy)
    require_room_for_lanes(case)
    require_histories(case, lanes)
    if lanes and folder is None:
        raise InputError("--history", "", list(lanes), "needs -o/--output, the folder to write to")
    taken = engine_for(case, engine)
    with lane_progress(case.name, case.lane_count) as progress:
        counted = dataclasses.replace(options, progress=progress)
        case_run = run_case(case, taken.engine, counted, histories=False)
    say_engine(taken)
    files = [] if folder is None else _write_run(case_run, folder, lanes)
    _show_run(case_run, files, choice, as_json)
    _end(ctx, case_run, max_bad)


def _end(ctx: click.Context, case_run: CaseRun, max_bad: float | None) -> None:
    """Ends a run with an exit code of its own where more lanes are bad than were allowed."""
    from warprock.run.provenance import bad_lanes

    if max_bad is not None and bad_lanes(case_run) > max_bad * case_run.case.lane_count:
        ctx.exit(EXIT_BAD_LANES)


def _write_run(
    case_run: CaseRun, folder: pathlib.Path, lanes: tuple[int, ...]
) -> list[pathlib.Path]:
    """Writes a run, with histories of some lanes, and its figures."""
    from warprock.figures.run import draw_run
    from warprock.report.scenes import scenes_of
    from warprock.run.case_run import run_lane
    from warprock.run.results import write_run

    histories = {lane: run_lane(case_run, lane) for lane in lanes}
    files: list[pathlib.Path] = write_run(case_run, folder, histories)
    drawings = draw_run(case_run)
    return leave(folder, files, drawings=drawings, scenes=scenes_of(case_run))


def _is_default(option: str) -> bool:
    """Whether an option of the command that runs was left out."""
    source = click.get_current_context().get_parameter_source(option)
    return source is click.core.ParameterSource.DEFAULT


def _show_run(
    case_run: CaseRun, files: list[pathlib.Path], choice: Choice | None, as_json: bool
) -> None:
    """Prints a run and, where an accuracy chose its engine, why."""
    from warprock.run.cells import cell_table
    from warprock.run.lane_table import lane_table
    from warprock.run.provenance import provenance
    from warprock.tables.cells import print_cells
    from warprock.tables.run import print_run
    from warprock.tables.terminal import print_json

    case = case_run.case
    if as_json:
        tabulate = lane_table if case.ensemble is None else cell_table
        table = tabulate(case_run.lane_set, case_run.response)
        summary = provenance(case_run) | {"rows": table.to_dict("records")}
        if choice is not None:
            summary["choice"] = dataclasses.asdict(choice)
        print_json(summary | {"files": files})
    else:
        show = print_run if case.ensemble is None else print_cells
        if choice is not None:
            click.echo(f"{choice.why}\n{choice.test}\n{choice.advice}")
        show(case_run, files)


@main.command()
@click.argument("target")
@output_to(
    "Folder for the results; made if it does not exist.", default="results", show_default=True
)
@workers_option
@json_option
def reproduce(target: str, folder: pathlib.Path, workers: int | None, as_json: bool) -> None:
    """Recompute the seed paper's TARGET: table6, table7, fig4, ... or all.

    An unknown TARGET lists them all. Its numbers are printed beside ours for every reading of the
    paper, with the conflicts in the paper.
    """
    from warprock.paper import reproduce as paper
    from warprock.paper.tables import print_reproduction
    from warprock.run.case_run import require_choice
    from warprock.tables.terminal import lane_progress, print_json

    require_choice("reproduce", target, tuple(paper.TARGETS))
    with lane_progress(f"reproduce {target}", None) as progress:
        found = paper.reproduce(target, folder, workers=workers, progress=progress)
    print_json(found) if as_json else print_reproduction(found)


@main.command()
@click.argument("case_name", metavar="[CASE]", required=False)
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


@main.command()
@click.argument("case_name", metavar="CASE")
@click.option("-e", "--engine", "engines", multiple=True, required=True, help="Repeat for each.")
@set_option
@json_option
def compare(
    case_name: str, engines: tuple[str, ...], overrides: tuple[str, ...], as_json: bool
) -> None:
    """Engines side by side on one CASE, lane by lane, held against Housner.

    Stacks and blocks in space are held against the engine that is named first; ensembles, too, cell
    by cell. Programs that we did not write (newton-xpbd, mujoco, bullet, blender, ...; `list` has
    them) run beside. Settings of one run come behind its name: `-e event@time_step=1e-3`.
    """
    from warprock.case.load import load_case
    from warprock.compare import checks
    from warprock.tables.cells import print_cell_comparison
    from warprock.tables.compare import print_comparison
    from warprock.tables.peers import print_costs
    from warprock.tables.stack import print_stack_comparison
    from warprock.tables.terminal import lane_progress, print_json

    case = load_case(case_name, overrides)
    with lane_progress(case.name, None) as progress:
        found = checks.compare(case, list(engines), progress=progress)
    show: Callable[[dict[str, Any]], None] = print_comparison
    if found["stacked"] or found.get("spatial"):
        show = print_stack_comparison
    if case.ensemble is not None:
        show = functools.partial(print_cell_comparison, case)
    print_json(found) if as_json else show(found)
    if not as_json:
        print_costs(found)


@main.command()
@json_option
@click.pass_context
def doctor(ctx: click.Context, as_json: bool) -> None:
    """Versions, cores, vector instructions, Warp devices, kernel cache, and what is missing."""
    from warprock.measure.doctor import examine
    from warprock.tables.machine import print_examination
    from warprock.tables.terminal import print_json

    found = examine()
    print_json(found) if as_json else print_examination(found)
    if found["missing"]:
        ctx.exit(EXIT_FAILED)


@main.group(invoke_without_command=True)
@click.option("--seconds", default=2.0, show_default=True, help="Time a measurement takes, about.")
@workers_option
@json_option
@click.pass_context
def bench(ctx: click.Context, seconds: float, workers: int | None, as_json: bool) -> None:
    """What every engine's steps and accuracy cost on this machine, beside peers where installed.

    The extras [mujoco] and [bullet] install peers; each runs the same block in the same run.
    """
    if ctx.invoked_subcommand is not None:
        return
    from warprock.measure import peers
    from warprock.measure.bench import run_bench
    from warprock.run.devices import start_warp
    from warprock.tables.machine import print_bench
    from warprock.tables.terminal import print_json

    require_within("--seconds", seconds, 0.0, 3600.0)
    start_warp()
    found = run_bench(seconds=seconds, workers=workers)
    found["peers"] = peers.compare(found["accuracy"], seconds)
    print_json(found) if as_json else print_bench(found)


bench.add_command(bench_sweep)
for module in pkgutil.iter_modules(warprock.cli.__path__, "warprock.cli."):
    # A file in this folder adds the commands that it names in `COMMANDS`.
    for command in getattr(importlib.import_module(module.name), "COMMANDS", ()):
        main.add_command(command)


def entry() -> None:
    """The command line as a process: on Ctrl-C it ends at once.

    A launch in a worker thread cannot be stopped, and Python would wait for it.
    """
    for name in ("stdout", "stderr"):
        # Closed by whoever started us; a result's file must not take its number.
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
    try:
        main()
    except SystemExit as end:
        try:
            sys.stdout.flush()
        except BrokenPipeError:
            # Nobody reads: what is left goes nowhere, or Python would say so at its end.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise SystemExit(1) from None
        if end.code not in (EXIT_INTERRUPTED, EXIT_RESUMABLE):
            raise
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        sys.stdout.flush()
        os._exit(int(end.code))
