"""Options that several commands share."""

from __future__ import annotations

import pathlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import click

from warprock.errors import InputError

if TYPE_CHECKING:
    from warprock.case import Case
    from warprock.engine_choice import EngineChoice

LEAST_SAMPLES, MOST_SAMPLES = 10, 100_000
"""Bootstrap samples that may be asked for."""

Command = TypeVar("Command", bound=Callable[..., Any])


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
        help='Change a key of the case, such as -s block.height="5.5 m".',
    )(command)


def workers_option(command: Command) -> Command:
    """`--workers`."""
    return click.option("--workers", type=int, help="Worker threads; the cores at hand without.")(
        command
    )


def device_options(command: Command) -> Command:
    """`--precision` and `--device`."""
    device = click.option("--device", default="cpu", show_default=True, help="Warp device.")
    precision = click.option(
        "--precision", default="float64", show_default=True, help="Or float32."
    )
    return precision(device(command))


def run_options(command: Command) -> Command:
    """`--precision`, `--device` and `--workers`."""
    return device_options(workers_option(command))


def output_to(meaning: str, **more: Any) -> Callable[[Command], Command]:
    """`-o`, as `folder`, which can be written to.

    Args:
        meaning: What the folder is for.
        more: What else Click is to know of the option.
    """
    return click.option(
        "-o",
        "--output",
        "folder",
        type=click.Path(path_type=pathlib.Path),
        callback=_writable,
        help=meaning,
        **more,
    )


def _writable(
    _context: click.Context, _option: click.Parameter, folder: pathlib.Path | None
) -> pathlib.Path | None:
    """A folder, refused before anything runs where nothing could be written to it."""
    if folder is not None:
        from warprock.files import require_writable

        require_writable(folder)
    return folder


output_option = output_to("Folder for the results; made if it does not exist.")
"""`-o`, as `folder`, None where none is given."""


def engine_option(command: Command) -> Command:
    """`-e`, None where none is named."""
    return click.option(
        "-e",
        "--engine",
        help="Engine; without, housner for one block that it can follow, else event.",
    )(command)


def engine_for(case: Case, engine: str | None, factors: Sequence[float] = (1.0,)) -> EngineChoice:
    """The engine named, or the one that the rule of `engine_choice` gives.

    Args:
        case: The case.
        engine: Name of the engine; None where none is named.
        factors: On the motion of the case: those at which it will run.
    """
    from warprock.engine_choice import EngineChoice, choose_engine

    return choose_engine(case, factors) if engine is None else EngineChoice(engine, named=True)


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
    return click.argument("case_name", metavar="CASE")(command)


def fit_options(command: Command) -> Command:
    """`--by`, `--samples` and `--seed` of fits and their bands over records."""
    options = (
        click.option("--by", multiple=True, metavar="COLUMN", help="Column of groups; repeat."),
        click.option(
            "--samples", default=1000, show_default=True, help="Bootstrap samples, over records."
        ),
        click.option("--seed", default=1, show_default=True, help="Seed of the samples."),
    )
    for option in reversed(options):
        command = option(command)
    return command


def require_samples(samples: int, seed: int) -> None:
    """Refuses bootstrap samples and a seed that are out of bounds.

    Raises:
        InputError: One of them is.
    """
    from warprock.sampling import MOST_SEED

    require_within("--samples", samples, LEAST_SAMPLES, MOST_SAMPLES)
    require_within("--seed", seed, 0, MOST_SEED)


def require_within(option: str, value: float, least: float, most: float) -> None:
    """Refuses a number that is out of bounds, or none.

    Raises:
        InputError: It is.
    """
    if not least <= value <= most:
        raise InputError(option, "", value, f"must be from {least} to {most}")
