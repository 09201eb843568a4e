"""What `run` makes of a case with a study."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping
from typing import TYPE_CHECKING

from warprock.cli.analysis import finish
from warprock.errors import InputError

if TYPE_CHECKING:
    from warprock.case.case import Case
    from warprock.running.options import RunOptions


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
    from warprock.api.study import study_of
    from warprock.tables.terminal import lane_progress
    from warprock.verification.study import run_count

    for option, given in refused.items():
        if given is not None and given is not False:
            allowed = "must not be given for a case with a [study], which is many runs"
            got = list(given) if isinstance(given, tuple) else given
            raise InputError(option, "", got, allowed)
    with lane_progress(case.name, run_count(case, engine) * case.lane_count) as progress:
        found = study_of(case, engine, options, progress)
    finish(found, folder, as_json=as_json, then="warprock trade")
