"""The check of kind "outcomes": how many tests an engine may say wrongly."""

from __future__ import annotations

import dataclasses
import pathlib

import numpy as np
import numpy.typing as npt

from warprock.case.case import Case
from warprock.case.check import OutcomesCheck
from warprock.case.lanes import LaneSet
from warprock.errors import InputError, Said
from warprock.model.response import Response, Status
from warprock.verification.check_row import CheckRow
from warprock.verification.observations import ObservedTests, read_tests
from warprock.verification.validation import Judged, judge


def outcome_rows(
    check: OutcomesCheck, case: Case, lane_set: LaneSet, response: Response, text: str
) -> list[CheckRow]:
    """What became of lanes against what tests showed: the share said wrongly, the Brier score.

    Args:
        check: The check.
        case: The case that holds it.
        lane_set: The lanes of the case.
        response: The answer of the engine for them.
        text: The lanes that are checked, in words.

    Raises:
        InputError: The tests cannot be read, fit no lanes, or none is among the lanes.
    """
    file = None if check.observed is None else pathlib.Path(case.folder or "") / check.observed
    tests = _within(read_tests(case, lane_set, file), lane_set.select(check.where))
    if not len(tests.names):
        got = Said("no test")
        raise InputError(case.file, "check.where", got, "must select lanes of at least one test")
    found = judge(response, check.engine, lane_set, tests, np.arange(len(tests.names)))
    wrong = 1.0 - found.scores.values["accuracy"]
    asked = [("share of tests said wrongly", wrong, check.limit_wrong)]
    if check.limit_brier is not None:
        asked.append(("Brier score", found.scores.values["brier"], check.limit_brier))
    return [
        CheckRow(
            case=case.name,
            name=name,
            engine=check.engine,
            lanes=text,
            value=value,
            limit=limit,
            ok=value <= limit,
            because=check.because,
            note=_note(found, tests),
            outside=response.count(Status.OUTSIDE_MODEL, tests.lanes.ravel()),
        )
        for name, value, limit in asked
    ]


def _within(tests: ObservedTests, lanes: npt.NDArray[np.intp]) -> ObservedTests:
    """The tests of which all lanes are among some lanes."""
    inside = np.flatnonzero(np.isin(tests.lanes, lanes).all(axis=1))
    return dataclasses.replace(
        tests,
        names=tuple(tests.names[number] for number in inside),
        overturned=tests.overturned[inside],
        lanes=tests.lanes[inside],
        measured={what: values[inside] for what, values in tests.measured.items()},
        table=tests.table.iloc[inside],
    )


def _note(found: Judged, tests: ObservedTests) -> str:
    """How many tests were predicted correctly, and how many have no lane with numbers."""
    scores = found.scores
    left = len(tests.names) - scores.tests
    text = f"{scores.right:,} of {scores.tests:,} tests predicted correctly"
    return f"{text}; {left:,} left out (no lane with numbers)" if left else text
