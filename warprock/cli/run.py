"""The command `run`: every lane of a case with one engine, or the study of a case."""

from __future__ import annotations

import pathlib
import shlex
from typing import TYPE_CHECKING, Any

import click

from warprock.cli.analysis import call, finish
from warprock.cli.exits import EXIT_BAD_LANES
from warprock.cli.options import (
    case_argument,
    engine_option,
    estimate_options,
    json_option,
    max_bad_option,
    output_option,
    run_options,
    set_option,
)
from warprock.cli.pages import asked_command, on_case
from warprock.cli.signatures import help_of
from warprock.cli.study import run_study_of
from warprock.errors import InputError, Said

if TYPE_CHECKING:
    from warprock.running.case_run import CaseRun


@click.command()
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
        raise InputError("--no-estimate", "", Said("given"), "must be left out with --cheapest")
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


COMMANDS = (run,)
