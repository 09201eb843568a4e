"""A case with a study as a function: all of its engines and settings."""

from __future__ import annotations

import functools
from collections.abc import Sequence

from warprock.api.case import AnyCase, any_case
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.progress import Shown, shown
from warprock.arguments import at_the_door
from warprock.case.case import Case
from warprock.case.load import Overrides
from warprock.errors import NOTHING, InputError
from warprock.figures.drawing import Drawing
from warprock.figures.study import draw_histories, draw_study
from warprock.findings.study import find_study
from warprock.report.chosen import played_of_study
from warprock.running.options import Progress, RunOptions
from warprock.tables.study import print_study_run
from warprock.verification import study as studies


@at_the_door
def study(
    case: AnyCase,
    engine: str | None = None,
    *,
    overrides: Overrides = (),
    precision: str = "float64",
    device: str = "cpu",
    workers: int | None = None,
    progress: Shown = True,
) -> Found:
    """Runs a case with a study: every engine and setting of it, held against Housner's solution.

    The command for it is `warprock run`.

    Args:
        case: The case, as in `run`, with a `Study`.
        engine: The only engine to run; None runs all of the study.
        overrides: As in `run`.
        precision: As in `run`.
        device: As in `run`.
        workers: As in `run`.
        progress: As in `run`.

    Returns:
        A `Found` whose table has one row a lane, engine, setting and value.

    Raises:
        InputError: Something cannot be used, said before anything runs.

    Example:
        >>> import warprock as wr
        >>> shorter = {"run.duration": "1 s", "engines.direct.substeps": 10}
        >>> settings = {"study.engines": ["direct"], "study.vary": {"substeps": [10, 20]}}
        >>> found = wr.study("sensitivity-b0", overrides={**shorter, **settings}, progress=False)
        >>> found.table["value"].tolist()
        [10.0, 10.0, 20.0, 20.0]
    """
    with python_names():
        work = any_case(case, overrides).judged
        options = RunOptions(precision, device, workers, None)
        total = studies.run_count(work, engine) * work.lane_count if work.study else None
        with shown(progress, work.name, total) as report:
            return study_of(work, engine, options, report)


def study_of(case: Case, engine: str | None, options: RunOptions, progress: Progress) -> Found:
    """Runs the engines and settings of a study; progress is called with the lanes finished."""
    if case.study is None:
        raise InputError(case.file, "study", NOTHING, "must be given: what is varied")
    done = 0

    def finished(count: int) -> None:
        nonlocal done
        done += count
        progress(done)

    found = studies.run_study(case, engine, options, finished=finished)
    return Found(
        f"{case.name}: study",
        found,
        functools.partial(find_study, found, functools.partial(print_study_run, found)),
        functools.partial(_draw, found),
        play=functools.partial(played_of_study, found),
    )


def _draw(found: studies.StudyRun, said: str) -> Sequence[Drawing]:
    title, last = found.case.title, found.table["lane_name"].iloc[-1]
    duration, curves = found.case.sample_times.duration, (found.times, found.reference)
    return [
        draw_study("study", found.rows, title, duration, said),
        draw_histories("histories", f"{title}, {last}", *curves, found.histories),
    ]
