"""Options that several commands share."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from warprock.cli import completion
from warprock.cli.signatures import help_of, own_options
from warprock.errors import InputError

if TYPE_CHECKING:
    from warprock.case.case import Case
    from warprock.running.engine_choice import EngineChoice
    from warprock.running.options import RunOptions

Command = TypeVar("Command", bound=Callable[..., Any])


def case_argument(command: Command) -> Command:
    """CASE, as `case_name`."""
    return click.argument("case_name", metavar="CASE", shell_complete=completion.cases)(command)


def json_option(command: Command) -> Command:
    """`--json`, as `as_json`."""
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")(command)


def set_option(command: Command) -> Command:
    """`-s KEY=VALUE`, as `overrides`."""
    return click.option(
        "-s",
        "--set",
        "overrides",
        multiple=True,
        metavar="KEY=VALUE",
        shell_complete=completion.overrides,
        help='Change a key of the case, such as -s block.height="5.5 m", or sweep it: '
        '-s motion.amplitude="0.1 g to 2 g, 20", -s block.height="1 m, 2 m".',
    )(command)


def workers_option(command: Command) -> Command:
    """`--workers`."""
    return click.option(
        "--workers",
        type=int,
        callback=_workers,
        help=help_of("run", "run", "workers"),
    )(command)


def _workers(_context: click.Context, _option: click.Parameter, workers: int | None) -> int | None:
    """A number of worker threads, refused where it is out of bounds."""
    from warprock.running.machine import require_workers

    require_workers(workers)
    return workers


def device_options(command: Command) -> Command:
    """`--precision` and `--device`."""
    for name, default in (("device", "cpu"), ("precision", "float64")):
        text = help_of("run", "run", name)
        command = click.option(f"--{name}", default=default, show_default=True, help=text)(command)
    return command


def run_options(command: Command) -> Command:
    """`--precision`, `--device` and `--workers`; see `asked_options`."""
    return device_options(workers_option(command))


def asked_options(
    precision: str = "float64",
    device: str = "cpu",
    workers: int | None = None,
    *,
    tolerance: float | None = None,
    estimate: bool = True,
) -> RunOptions:
    """How lanes are to be run, from the options of `run_options` and of `estimate_options`.

    Args:
        precision: Of `--precision`.
        device: Of `--device`.
        workers: Of `--workers`.
        tolerance: Of `--tolerance`; None where it was left out.
        estimate: Whether errors are estimated at all.

    Raises:
        InputError: The tolerance is out of bounds, or given where no error is to be estimated.
    """
    from warprock.running.case_run import require_tolerance
    from warprock.running.options import TOLERANCE, RunOptions

    if tolerance is not None and not estimate:
        allowed = "must not be given with --no-estimate: it is held against the estimate"
        raise InputError("--tolerance", "", tolerance, allowed)
    if tolerance is not None:
        require_tolerance(tolerance)
    held = TOLERANCE if tolerance is None else tolerance
    return RunOptions(precision, device, workers, held if estimate else None)


def estimate_options(command: Command) -> Command:
    """`--tolerance`, None where it is left out, and `--no-estimate`, as `estimate`."""
    tolerance = click.option(
        "--tolerance",
        type=float,
        help=help_of("run", "run", "tolerance"),
    )
    estimate = click.option(
        "--estimate/--no-estimate",
        default=True,
        help="--no-estimate: every lane once, at the step of the case; nothing says how far off.",
    )
    return tolerance(estimate(command))


def max_bad_option(command: Command) -> Command:
    """`--max-bad`, None where none is given."""
    return click.option(
        "--max-bad",
        type=float,
        callback=_share,
        help="Share of the lanes, 0 to 1, whose numbers may be unusable or miss the tolerance: "
        "beyond it the exit code is 4.",
    )(command)


def _share(_context: click.Context, _option: click.Parameter, share: float | None) -> float | None:
    """A share, refused where it is none."""
    if share is not None and not 0.0 <= share <= 1.0:
        raise InputError("--max-bad", "", share, "must be a share of the lanes, from 0 to 1")
    return share


def output_to(meaning: str, **more: Any) -> Callable[[Command], Command]:
    """`-o`, as `folder`, which can be written to.

    Args:
        meaning: What the folder is for.
        more: What else Click is to know of the option.
    """
    return _output("folder", _writable_folder, meaning, more)


def output_file_to(name: str, meaning: str, **more: Any) -> Callable[[Command], Command]:
    """`-o`, a file that can be written, or a folder where the command takes one as well.

    Args:
        name: What it arrives as.
        meaning: What the file is for.
        more: What else Click is to know of the option.
    """
    return _output(name, _writable_path, meaning, more)


def _output(
    name: str, gate: Callable[..., Any], meaning: str, more: dict[str, Any]
) -> Callable[[Command], Command]:
    """`-o`: every one passes its gate before the command begins."""
    return click.option(
        "-o",
        "--output",
        name,
        type=click.Path(path_type=pathlib.Path),
        callback=gate,
        help=meaning,
        **more,
    )


def _writable_folder(
    _context: click.Context, _option: click.Parameter, folder: pathlib.Path | None
) -> pathlib.Path | None:
    """A folder, refused before anything runs where nothing could be written to it."""
    if folder is not None:
        from warprock.running.files import require_writable

        require_writable(folder)
    return folder


def _writable_path(
    _context: click.Context, _option: click.Parameter, path: pathlib.Path | None
) -> pathlib.Path | None:
    """A file, refused before anything runs where it could not be written.

    A folder is let by: the command knows whether it takes one.
    """
    if path is not None and not os.path.isdir(path):
        from warprock.running.files import require_writable_file

        require_writable_file(path)
    return path


def list_written(folder: pathlib.Path, files: list[pathlib.Path], *, beside: bool = False) -> None:
    """Lists what a command wrote, and says what it removed of commands before.

    Args:
        folder: Where it wrote to.
        files: What it wrote.
        beside: Whether that was made from the results in the folder, which stay.
    """
    from warprock.running.results import list_results

    removed = list_results(folder, files, beside=beside)
    if removed:
        text = f"removed from {folder}, where an earlier command wrote them: {', '.join(removed)}"
        click.echo(text, err=True)


output_option = output_to("Folder for the results; made if it does not exist.")
"""`-o`, as `folder`, None where none is given."""


def engine_option(command: Command) -> Command:
    """`-e`, None where none is named."""
    return click.option(
        "-e",
        "--engine",
        shell_complete=completion.engines,
        help=help_of("run", "run", "engine"),
    )(command)


def engine_for(case: Case, engine: str | None) -> EngineChoice:
    """The engine named, or the one that the rule of `engine_choice` gives.

    Args:
        case: The case.
        engine: Name of the engine; None where none is named.
    """
    from warprock.running.engine_choice import EngineChoice, choose_engine

    return choose_engine(case) if engine is None else EngineChoice(engine, named=True)


def say_engine(choice: EngineChoice) -> None:
    """Says on stderr where a single block was not run by the engine that it has as a rule.

    Called when the work is done, so that a command that is refused ends in one line.
    """
    if choice.surprises:
        click.echo(choice.text, err=True)


def case_options(command: Command) -> Command:
    """What every analysis of a case takes: CASE, `-e`, `-s`, `-o`, those of a run, and `--json`."""
    for option in (json_option, run_options, output_option, set_option, engine_option):
        command = option(command)
    return case_argument(command)


def hazard_options(command: Command) -> Command:
    """A hazard, `--hazard` to `--im`, under the names of the arguments of `hazard_of`."""
    return own_options("asked", "hazard_of", hazard=completion.hazards)(command)


def ladder_options(command: Command) -> Command:
    """A ladder, `--from` to `--count`, under the names of the arguments of `ladder_of`."""
    return own_options("asked", "ladder_of")(command)


def reading_options(command: Command) -> Command:
    """What is said of a table with named columns: `--column`, `--unit` and `--interval`.

    They arrive as `column`, `unit` and `interval`, None where they are left out.
    """
    return own_options("records", "reading_of")(command)
