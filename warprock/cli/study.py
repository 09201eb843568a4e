"""What `run` makes of a case with a study."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping
from typing import TYPE_CHECKING

from warprock.cli.pages import leave
from warprock.errors import InputError

if TYPE_CHECKING:
    from warprock.case.case import Case
    from warprock.running.options import RunOptions
    from warprock.verification.study import StudyRun


def run_study_of(
    case: Case,
    engine: str | None,
    folder: pathlib.Path | None,
    refused: Mapping[str, object],
    options: RunOptions,
    *,
    as_json: bool,
) -> None:
    """Runs a study, writes it where a folder is given, and prints it.

    Args:
        case: A case with a study.
        engine: The only engine to run; None runs all of the study.
        folder: Where to write; None writes nothing.
        refused: Options of `run` that a study has no use for, and what was given for each.
        options: How its lanes are run.
        as_json: Whether to print one JSON object.

    Raises:
        InputError: An option that a study has no use for, or another than those allowed.
    """
    from warprock.tables.study import print_study_run
    from warprock.tables.terminal import lane_progress, print_json
    from warprock.verification import study

    for option, given in refused.items():
        if given is not None and given is not False:
            allowed = "must not be given for a case with a [study], which is many runs"
            got = list(given) if isinstance(given, tuple) else given
            raise InputError(option, "", got, allowed)
    total, done = study.run_count(case, engine) * case.lane_count, 0
    with lane_progress(case.name, total) as progress:

        def finished(count: int) -> None:
            nonlocal done
            done += count
            progress(done)

        found = study.run_study(case, engine, options, finished=finished)
    files = [] if folder is None else _write(found, folder)
    if as_json:
        summary = study.study_provenance(found) | {"rows": found.rows}
        print_json(summary | {"files": files})
    else:
        print_study_run(found.rows, case, found.wall_time, files)


def _write(found: StudyRun, folder: pathlib.Path) -> list[pathlib.Path]:
    """Writes the table, what ran, and the figures."""
    from warprock.figures.study import draw_histories, draw_study
    from warprock.report.chosen import played_of_study
    from warprock.verification.study import write_study

    case, last = found.case, found.table["lane_name"].iloc[-1]
    duration = case.sample_times.duration
    times, reference, histories = found.times, found.reference, found.histories
    drawings = [
        draw_study("study", found.rows, case.title, duration),
        draw_histories("histories", f"{case.title}, {last}", times, reference, histories),
    ]
    files = write_study(found, folder)
    return leave(folder, files, drawings=drawings, scenes=played_of_study(found))
