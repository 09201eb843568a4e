"""The command `compare` as a function, and what it finds."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

import pandas as pd

from warprock.api.case import AnyCase, any_case
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.progress import Shown, shown
from warprock.case.case import Case
from warprock.case.load import Overrides
from warprock.compare.checks import compare as compare_engines
from warprock.figures.drawing import Drawing
from warprock.figures.poses import draw_poses
from warprock.tables.cells import print_cell_comparison
from warprock.tables.compare import print_comparison
from warprock.tables.peers import print_costs
from warprock.tables.poses import print_pose_comparison
from warprock.tables.report import Report
from warprock.tables.stack import print_stack_comparison


def compare(
    case: AnyCase,
    engines: Sequence[str],
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
        engines: Names of engines and of programs beside them; settings of one run come behind its
            name: "event@time_step=1e-3".
        overrides: As in `run`.
        workers: As in `run`.
        progress: As in `run`.

    Returns:
        A `Found` whose table has one row a lane and engine, with its errors.

    Raises:
        InputError: An unknown engine, a program that is not installed, or a single engine for an
            ensemble.

    Example:
        >>> import warprock as wr
        >>> found = wr.compare("free-b0", ["housner", "event"], progress=False)
        >>> [float(f"{error:.0e}") for error in found.table["error_5s_ratio"]]
        [0.0, 0.0, 2e-05, 2e-05]
    """
    with python_names():
        work = any_case(case, overrides).judged
        with shown(progress, work.name, None) as report:
            found = compare_engines(work, list(engines), workers, report)
    title = f"{work.name}: {', '.join(engines)}"
    draw: Callable[[], list[Drawing]] = list
    if "observed" in found:
        draw = functools.partial(draw_poses, found)
    return Comparison(title, found, functools.partial(_report, work, found), draw)


class Comparison(Found):
    """Engines side by side: tables, without a page; figures beside observed poses alone."""

    _saves_page = False

    def report(self, folder: str | os.PathLike[str] | None = None) -> NoReturn:
        """A comparison has no page.

        Args:
            folder: Of no use.

        Raises:
            ValueError: Always.
        """
        raise ValueError(f"{self.title}: a comparison has no page")


def _report(case: Case, found: dict[str, Any]) -> Report:
    tables = {"comparison": pd.DataFrame(found["rows"])}
    if found["costs"]:
        tables["costs"] = pd.DataFrame(found["costs"])
    return Report(found, tables, found, functools.partial(_show, case, found))


def _show(case: Case, found: dict[str, Any]) -> None:
    if case.ensemble is not None:
        print_cell_comparison(case, found)
    elif "observed" in found:
        print_pose_comparison(found)
    elif found["stacked"] or found["spatial"]:
        print_stack_comparison(found)
    else:
        print_comparison(found)
    print_costs(found)
