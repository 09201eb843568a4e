"""What the commands of analyses share: the case and its options, the wait, and what comes of it.

A command is the Python function of the same name: both call one function of `warprock.api`, which
gives a `Found`; here it is shown and saved.
"""

from __future__ import annotations

import contextlib
import dataclasses
import pathlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from warprock.cli.options import asked_options, engine_for, say_engine
from warprock.cli.pages import asked_command, leave, on_case

if TYPE_CHECKING:
    from warprock.api.found import Found
    from warprock.case.case import Case
    from warprock.running.work import Work


@contextlib.contextmanager
def case_work(
    case_name: str,
    engine: str | None,
    overrides: tuple[str, ...],
    precision: str,
    device: str,
    workers: int | None,
    tolerance: float | None = None,
    estimate: bool = True,
    factors: Sequence[float] = (1.0,),
    runs: int = 0,
    made: Case | None = None,
) -> Iterator[Work]:
    """The case that `case_options` and `estimate_options` ask for, and how far it is.

    Says which engine ran once the block is done.

    Args:
        case_name: The case asked for.
        engine: Of `-e`; None where none is named.
        overrides: Of `-s`.
        precision: Of `--precision`.
        device: Of `--device`.
        workers: Of `--workers`.
        tolerance: Of `--tolerance`; None where it was left out.
        estimate: Whether errors are estimated at all.
        factors: On the motion of the case: those at which it will run.
        runs: How often all lanes will run; 0 where that is not known.
        made: A case that is at hand, which the overrides change, in the place of the one asked for.

    Yields:
        The case, its engine, and how lanes are run, with the progress to report.

    Raises:
        InputError: The case cannot be read, or an option is out of bounds.
    """
    from warprock.case.load import changed, load_case
    from warprock.running.work import Work
    from warprock.tables.terminal import lane_progress

    case = load_case(case_name, overrides) if made is None else changed(made, overrides)
    options = asked_options(precision, device, workers, tolerance=tolerance, estimate=estimate)
    choice = engine_for(case, engine, factors)
    with lane_progress(case.name, runs * case.lane_count or None) as progress:
        yield Work(case, choice, dataclasses.replace(options, progress=progress))
    say_engine(choice)


def finish(
    found: Found,
    folder: pathlib.Path | None,
    *,
    as_json: bool,
    then: str = "",
    always: bool = False,
    output: str = "results",
    first: Sequence[pathlib.Path] = (),
) -> None:
    """Writes what a command found where a folder is given, and prints it.

    Args:
        found: What the command found.
        folder: Where to write; None writes nothing.
        as_json: Whether to print one JSON object.
        then: The command to try next, once the results are in the folder.
        always: Whether to try that next where there is no folder, too.
        output: The folder that a command to try next writes to where there is none.
        first: What the command has written before, which stays whatever comes after it.
    """
    from warprock.tables.finding import print_finding
    from warprock.tables.terminal import print_end, print_json, print_written

    finding, files = found.finding, list(first)
    if folder is not None:
        written, drawings = found.write(folder), found.figures()
        files += leave(
            folder,
            written,
            drawings=drawings,
            scenes=found.scenes(),
            beside=finding.beside,
            stays=finding.stays,
        )
    if as_json:
        print_json({**finding.json, "files": files})
    else:
        print_finding(finding)
        print_written(files)
        typed = then if folder is not None or always else f"{asked_command()} -o {output}"
        if finding.sentences[0]:
            print_end(finding.sentences[0], typed)


def run_of(
    engine: str,
    folder: pathlib.Path | None,
    /,
    case_name: str,
    overrides: tuple[str, ...],
    **_others: Any,
) -> str:
    """The command that runs the lanes of the case of an analysis, beside its folder.

    Args:
        engine: Name of the engine.
        folder: That of the analysis.
        case_name: The case asked for.
        overrides: Of `-s`.
    """
    return on_case("run", case_name, overrides, "-e", engine, "-o", f"{folder}-run")
