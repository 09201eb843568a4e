"""The command `validate` as a function."""

from __future__ import annotations

import functools
import os
import pathlib
from collections.abc import Sequence

import pandas as pd

from warprock.api.case import AnyCase, any_case
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.progress import Shown, shown
from warprock.case.load import Overrides
from warprock.compare.validation import run_validation
from warprock.figures.validation import draw_validation
from warprock.run.engine_choice import choose_engine
from warprock.run.options import TOLERANCE, RunOptions
from warprock.tables.validation import validation_report


def validate(
    case: AnyCase,
    observed: pd.DataFrame | str | os.PathLike[str] | None = None,
    engines: Sequence[str] = (),
    *,
    column: str | None = None,
    group: str | None = None,
    overrides: Overrides = (),
    tolerance: float | None = TOLERANCE,
    precision: str = "float64",
    device: str = "cpu",
    workers: int | None = None,
    progress: Shown = True,
) -> Found:
    """Engines held to observed outcomes: how many tests do they say rightly?

    A test is a lane, or all members of an ensemble's cell or of a sample: the share of them that
    overturns is its probability. Thresholds on PGA and PGV stand beside the engines, each test by
    the other records.

    Args:
        case: The case, as in `run`.
        observed: A table with one row a test, or the path of a CSV or Parquet file: its outcome,
            and a label of the case, `record` or `lane` (of an ensemble or a sample `cell`); None
            takes the label `observed` of the case.
        engines: Names of engines and of programs; without, the one that the case has as a rule.
        column: Column of the outcome; None takes observed, overturned or outcome.
        group: Column of the table or of the lane table that says which tests share a ground motion;
            None takes the record.
        overrides: As in `run`.
        tolerance: As in `run`.
        precision: As in `run`.
        device: As in `run`.
        workers: As in `run`.
        progress: As in `run`.

    Returns:
        A `Found` with tables `validation`, one row a test and engine, and `scores.csv`.

    Raises:
        InputError: Something cannot be used, said before anything runs: a row that fits no test,
            or two rows of one.

    References:
        G. W. Brier (1950), Verification of forecasts expressed in terms of probability, *Monthly
        Weather Review* 78. Q. McNemar (1947), *Psychometrika* 12.

    Example:
        >>> import pandas as pd
        >>> import warprock as wr
        >>> fell = [False, False, False, False, True, True, True]
        >>> seen = pd.DataFrame({"lane": range(7), "observed": fell})
        >>> found = wr.validate("record-ridgecrest", seen, ["housner"], progress=False)
        >>> found.facts["sentence"]
        'housner says the outcome of 6 of 7 tests rightly (85.7 %).'
    """
    table: pd.DataFrame | pathlib.Path | None = None
    if observed is not None:
        table = observed if isinstance(observed, pd.DataFrame) else pathlib.Path(observed)
    with python_names():
        work = any_case(case, overrides).judged
        names = list(engines) or [choose_engine(work).engine]
        with shown(progress, work.name, len(names) * work.lane_count) as report:
            options = RunOptions(precision, device, workers, tolerance, report)
            found = run_validation(work, names, table, options, column=column, group=group)
    return Found(
        f"{work.name}: held to {found.tests.source}",
        found,
        functools.partial(validation_report, found),
        functools.partial(draw_validation, found),
    )
