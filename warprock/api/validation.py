"""The command `validate` as a function."""

from __future__ import annotations

import functools
import os
import pathlib
from collections.abc import Sequence
from typing import Unpack

import pandas as pd

from warprock.api.case import AnyCase
from warprock.api.found import Found
from warprock.api.values import Column
from warprock.api.work import HowHeld, working
from warprock.arguments import at_the_door, listing, several
from warprock.figures.validation import draw_validation
from warprock.findings.validation import find_validate
from warprock.verification.validation import run_validation


@listing(working)
@at_the_door
def validate(
    case: AnyCase,
    observed: pd.DataFrame | str | os.PathLike[str] | None = None,
    engine: str | Sequence[str] = (),
    *,
    column: str | None = None,
    group: Column | None = None,
    **how: Unpack[HowHeld],
) -> Found:
    """Engines held to observed outcomes: how many tests they predict correctly.

    A test is a lane, or all members of an ensemble's cell or of a sample: the share of them that
    overturns is its probability. Thresholds on PGA and PGV stand beside the engines, each test by
    the other records.

    Args:
        case: The case, as in `run`.
        observed: A table with one row a test, or the path of a CSV or Parquet file: its outcome,
            and a label of the case, `record` or `lane` (of an ensemble or a sample `cell`); None
            takes the label `observed` of the case.
        engine: Names, one or several, of engines and of programs; without, the one that the case
            has as a rule.
        column: Column of the outcome [default: observed, overturned or outcome].
        group: Column of the file or of the lane table that says which tests share a ground motion
            [default: record].
        **how: overrides, tolerance, precision, device, workers and progress, as in `run`.

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
        'housner predicts the outcome of 6 of 7 tests correctly (85.7 %).'
    """
    table: pd.DataFrame | pathlib.Path | None = None
    if observed is not None:
        table = observed if isinstance(observed, pd.DataFrame) else pathlib.Path(observed)
    engines = several(engine)
    with working(case, engines[0] if engines else None, runs=max(1, len(engines)), **how) as work:
        found = run_validation(
            work.case, engines or [work.engine], table, work.options, column=column, group=group
        )
        return Found(
            f"{work.case.name}: held to {found.tests.source}",
            found,
            functools.partial(find_validate, found),
            functools.partial(draw_validation, found),
        )
