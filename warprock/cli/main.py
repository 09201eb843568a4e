"""The command line: each command calls the functions of its module and prints what they return.

Heavy modules are imported inside the commands, so that `warprock --help` answers at once.
Results go to stdout, progress and errors to stderr.
"""

from __future__ import annotations

import gc
import os
import pathlib
import shlex
import signal
import sys
import time
from typing import TYPE_CHECKING, Any

import click

import warprock
from warprock.cli import completion
from warprock.cli.analysis import call, finish
from warprock.cli.exits import EXIT_BAD_LANES, EXIT_INTERRUPTED, EXIT_RESUMABLE
from warprock.cli.options import (
    case_argument,
    engine_option,
    estimate_options,
    json_option,
    max_bad_option,
    output_option,
    output_to,
    run_options,
    set_option,
    workers_option,
)
from warprock.cli.pages import add_page, asked_command, on_case
from warprock.cli.sections import Main
from warprock.cli.signatures import help_of
from warprock.cli.study import run_study_of
from warprock.errors import InputError, written_as

if TYPE_CHECKING:
    from warprock.figures.drawing import Drawing
    from warprock.running.case_run import CaseRun


def _say_version(ctx: click.Context, _option: click.Parameter, asked: bool) -> None:
    """Prints the version, which is looked up only here."""
    if asked and not ctx.resilient_parsing:
        click.echo(f"warprock, version {warprock.__version__}")
        ctx.exit()


@click.group(cls=Main, context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_say_version,
    help="Show the version and exit.",
)
def main() -> None:
    """Rocking of rigid blocks under ground motion, many inputs at once.

    A case (a folder with a case.toml, or the name of a shipped one) becomes lanes, one for each
    set of inputs; an engine answers for all lanes at once.

    First steps: warprock run free-b0 -o results; warprock init record mine/case.toml; warprock
    run mine -o results/mine.
    """


@main.command()
@case_argument
@engine_option
@set_option
@output_option
@run_options
@click.option("--history", "lanes", type=int, multiple=True, help="Lane whose history to write.")
@estimate_options
@click.option("--cheapest", is_flag=True, help=help_of("run", "run", "cheapest"))
@max_bad_option
@json_option
@click.pass_context
def run(
    ctx: click.Context,
    /,
    case_name: str,
    engine: str | None,
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    lanes: tuple[int, ...],
    tolerance: float | None,
    estimate: bool,
    cheapest: bool,
    max_bad: float | None,
    as_json: bool,
    **how: Any,
) -> None:
    """Run every lane of a CASE with one engine; a study, with all of its engines and settings.

    Every lane runs at half the step, and again, until its rotations are within the tolerance by
    their estimate; lanes that do not get there say so.
    """
    from warprock.api import run as api
    from warprock.case.load import load_case
    from warprock.running.case_run import require_histories

    case = load_case(case_name, overrides)
    if case.study is not None:
        refused = {
            "--history": lanes or None,
            "--cheapest": cheapest or None,
            "--tolerance": tolerance,
        }
        refused |= {"--max-bad": max_bad, "--estimate": estimate and not _is_default("estimate")}
        return run_study_of(case, engine, folder, refused, as_json=as_json, **how)
    require_histories(case, lanes)
    if lanes and folder is None:
        raise InputError("--history", "", list(lanes), "needs -o/--output, the folder to write to")
    if cheapest and not estimate:
        raise InputError("--no-estimate", "", "given", "must be left out with --cheapest")
    found, _engine = call(
        api.run,
        case,
        engine=engine,
        tolerance=tolerance,
        estimate=estimate,
        cheapest=cheapest,
        **how | ({"precision": None} if _is_default("precision") else {}),
    )
    assert isinstance(found, api.Run)
    found.kept, case_run, choice = lanes, found.found, found.cheapest
    if choice is not None and not as_json:
        click.echo(f"{choice.why}\n{choice.test}\n{choice.advice}")
    then = _after_run(case_run, case_name, overrides, folder)
    finish(found, folder, as_json=as_json, then=then)
    _end(ctx, case_run, max_bad)


def _after_run(
    case_run: CaseRun, case_name: str, overrides: tuple[str, ...], folder: pathlib.Path | None
) -> str:
    """The command to try after a run."""
    if folder is None:
        return f"{asked_command()} -o results"
    from warprock.analysis.bands import LEAST_RECORDS
    from warprock.analysis.fragility import INTENSITY, MOST_DOUBT
    from warprock.analysis.groups import record_numbers
    from warprock.running.companions import find_fallen
    from warprock.running.engine_choice import another_engine

    ran = case_run.response.engine
    fell = int(find_fallen(case_run.response).sum())
    if 0 < fell < case_run.response.lane_count and case_run.case.tables.motion is not None:
        inputs = case_run.lane_set.inputs
        enough = int(record_numbers(inputs).max()) + 1 >= LEAST_RECORDS
        # A function of the intensity needs more than one.
        enough &= inputs[INTENSITY].nunique() > 1
        if enough and _doubted(case_run) <= MOST_DOUBT:
            return shlex.join(["warprock", "fragility", str(folder)])
        if (inputs[INTENSITY] > 0.0).all():
            return on_case("ida", case_name, overrides, "-e", ran, "-o", f"{folder}-ida")
    another = another_engine(ran, case_run.lane_set.scene)
    if case_run.case.sample_times.interval is not None or another is None:
        return shlex.join(["warprock", "animate", str(folder), "--lane", "0"])
    return on_case("compare", case_name, overrides, "-e", ran, "-e", another)


def _doubted(case_run: CaseRun) -> float:
    """Share of the lanes of which a fragility function would be in doubt."""
    from warprock.model.response import SOUND
    from warprock.model.undecided import undecided
    from warprock.settings.engines import on_springs

    lane_set, response = case_run.lane_set, case_run.response
    springs = on_springs(response.engine)
    goes_on = undecided(response, lane_set.lanes, lane_set.motions, lane_set.ends, springs=springs)
    unsound = [int(status) not in map(int, SOUND) for status in response["status"]]
    return float((goes_on | unsound).mean())


def _end(ctx: click.Context, case_run: CaseRun, max_bad: float | None) -> None:
    """Ends a run with an exit code of its own where more lanes are bad than were allowed."""
    from warprock.running.provenance import bad_lanes

    if max_bad is not None and bad_lanes(case_run) > max_bad * case_run.case.lane_count:
        ctx.exit(EXIT_BAD_LANES)


def _is_default(option: str) -> bool:
    """Whether an option of the command that runs was left out."""
    source = click.get_current_context().get_parameter_source(option)
    return source is click.core.ParameterSource.DEFAULT


@main.command()
@click.argument("target", shell_complete=completion.targets)
@output_to(
    "Folder for the results; made if it does not exist.", default="results", show_default=True
)
@workers_option
@click.option(
    "--full",
    is_flag=True,
    help="All members that the ensembles of the cases have; 2 to 16 times fewer otherwise.",
)
@click.option("--verbose", is_flag=True, help="Also print what each part took.")
@json_option
def reproduce(
    target: str,
    folder: pathlib.Path,
    workers: int | None,
    full: bool,
    verbose: bool,
    as_json: bool,
) -> None:
    """Recompute the seed paper's TARGET: table6, table7, fig4, ... or all.

    An unknown TARGET lists them all. Its numbers are printed beside ours for every reading of the
    paper, with the conflicts in the paper.
    """
    from warprock.paper import reproduce as paper
    from warprock.paper.page import keep
    from warprock.paper.print_tables import print_reproduction
    from warprock.running.case_run import require_choice
    from warprock.tables.terminal import lane_progress, print_json

    target = written_as(target, paper.TARGETS)
    require_choice("reproduce", target, tuple(paper.TARGETS))
    drawings: list[Drawing] = []
    with lane_progress(f"reproduce {target}", None) as progress:
        found = paper.reproduce(
            target, folder, workers=workers, progress=progress, full=full, drawings=drawings
        )
    kept = keep(found, folder)
    begin = time.perf_counter()
    found["files"] += [str(kept), str(add_page(folder, drawings=drawings))]
    found["seconds"]["page"] = time.perf_counter() - begin
    print_json(found) if as_json else print_reproduction(found, verbose=verbose)


def entry() -> None:
    """The command line as a process: on Ctrl-C it ends at once, and on SIGTERM as on Ctrl-C.

    A launch in a worker thread cannot be stopped, and Python would wait for it.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    # Else pydantic looks for plug-ins of its own in every package that is installed.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # Else NumPy starts a thread of OpenBLAS for each core, at every start. Lanes have threads of
    # their own, and what a product of matrices sums first must not depend on the machine.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Else a tenth of the start of a command goes into looks for garbage among what it imports; Warp
    # alone makes more than 100,000 objects that stay.
    gc.set_threshold(200_000)
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
    finally:
        # Else Python looks for garbage among all that was imported before it ends: a third of a
        # short run.
        gc.freeze()
