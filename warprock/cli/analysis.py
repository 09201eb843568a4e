"""What the commands of analyses share: the case and its options, the wait, and what comes of it.

An analysis is computed in `warprock.analysis`; its module in `warprock.tables` makes a `Report` of
it, its module in `warprock.figures` draws it, and its command here hands one to the other.
"""

from __future__ import annotations

import contextlib
import dataclasses
import pathlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from warprock.cli.options import asked_options, engine_for, say_engine
from warprock.cli.pages import asked_command, leave, on_case

if TYPE_CHECKING:
    from warprock.figures.drawing import Drawing
    from warprock.running.case_run import CaseRun
    from warprock.running.options import RunOptions
    from warprock.running.work import Work
    from warprock.tables.report import Report


@contextlib.contextmanager
def running(work: Work, total: int | None) -> Iterator[RunOptions]:
    """Shows how far the block is, and says which engine ran once it is done.

    Args:
        work: The case that it runs.
        total: Lanes that it will run; None if that is not known.

    Yields:
        How lanes are run, with the progress to report.
    """
    from warprock.tables.terminal import lane_progress

    with lane_progress(work.case.name, total) as progress:
        yield dataclasses.replace(work.options, progress=progress)
    say_engine(work.choice)


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
) -> Work:
    """The case that `case_options` and `estimate_options` ask for.

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

    Raises:
        InputError: The case cannot be read, or an option is out of bounds.
    """
    from warprock.case.load import load_case
    from warprock.running.work import Work

    case = load_case(case_name, overrides)
    options = asked_options(precision, device, workers, tolerance=tolerance, estimate=estimate)
    return Work(case, engine_for(case, engine, factors), options)


def finish(
    report: Report,
    draw: Callable[[], Sequence[Drawing]],
    folder: pathlib.Path | None,
    *,
    as_json: bool,
    then: str = "",
    run: CaseRun | None = None,
    play: Callable[[], Mapping[str, Any] | None] | None = None,
) -> None:
    """Writes an analysis where a folder is given, and prints it.

    Args:
        report: What it has to show.
        draw: Draws its figures.
        folder: Where to write; None writes nothing.
        as_json: Whether to print one JSON object.
        then: The command to try next, once the results are in the folder.
        run: What it ran, of which its page plays lanes; None where that is no run of a case.
        play: What runs lanes for its page again in that case.
    """
    from warprock.report.scenes import scenes_of
    from warprock.running.results import write_results
    from warprock.tables.terminal import print_end, print_json, print_written

    files: list[pathlib.Path] = []
    if folder is not None:
        files = write_results(folder, report.tables, report.facts, report.texts)
        scenes: Mapping[str, Any] | None = None
        if run is not None:
            scenes = scenes_of(run)
        elif play is not None:
            scenes = play()
        files = leave(folder, files, drawings=draw(), scenes=scenes, beside=report.beside)
    if as_json:
        print_json({**report.json, "files": files})
    else:
        report.show()
        print_written(files)
        print_end(report.came_out, then if folder is not None else f"{asked_command()} -o results")


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
