"""The command `compare` as a function, and what it finds."""

from __future__ import annotations

import functools
from collections.abc import Sequence

from warprock.api.case import AnyCase, any_case
from warprock.api.found import Found, untitled
from warprock.api.names import python_names
from warprock.api.progress import Shown, shown
from warprock.arguments import at_the_door, several
from warprock.case.load import Overrides
from warprock.figures.poses import draw_poses
from warprock.findings.comparison import find_compare
from warprock.report.chosen import played_of_comparison
from warprock.tables.comparison import print_any_comparison
from warprock.verification.checks import compare as compare_engines


@at_the_door
def compare(
    case: AnyCase,
    engine: str | Sequence[str],
    *,
    overrides: Overrides = (),
    workers: int | None = None,
    progress: Shown = True,
) -> Found:
    """Engines side by side on one case, lane by lane, held against Housner's solution.

    Stacks and blocks in space are held against the engine that is named first; ensembles, too, cell
    by cell. Of a case with a check of poses that were observed, all are held against those.

    Args:
        case: The case, as in `run`.
        engine: Names, one or several, of engines and of programs beside them; settings of one run
            come behind its name: "event@time_step=1e-3".
        overrides: As in `run`.
        workers: As in `run`.
        progress: As in `run`.

    Returns:
        A `Found` whose table has one row a lane and engine, with its errors.

    Raises:
        InputError: No engine, an unknown one, a program that is not installed, or a single engine
            for an ensemble.

    Example:
        >>> import warprock as wr
        >>> found = wr.compare("free-b0", ["housner", "event"], progress=False)
        >>> bool((found.table["error_5s_ratio"] < 1e-9).all())
        True
    """
    with python_names():
        work = any_case(case, overrides).judged
        engines = several(engine)
        with shown(progress, work.name, None) as report:
            found = compare_engines(work, engines, workers, report)
        printed = functools.partial(print_any_comparison, work, found)
        return Comparison(
            f"{work.name}: {', '.join(engines)}",
            found,
            functools.partial(find_compare, work, found, printed),
            functools.partial(
                untitled, functools.partial(draw_poses, found) if "observed" in found else list
            ),
            play=functools.partial(played_of_comparison, work, found),
        )


class Comparison(Found):
    """Engines side by side: tables and a page; figures beside observed poses alone."""
