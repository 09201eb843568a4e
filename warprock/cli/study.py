"""What `run` makes of a case with a study."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from warprock.cli.analysis import call, finish
from warprock.errors import InputError

if TYPE_CHECKING:
    from warprock.case.case import Case


def run_study_of(
    case: Case,
    engine: str | None,
    folder: pathlib.Path | None,
    refused: Mapping[str, object],
    *,
    as_json: bool,
    **how: Any,
) -> None:
    """Calls `warprock.study`, writes what it finds where a folder is given, and prints it.

    Args:
        case: A case with a study.
        engine: The only engine to run; None runs all of the study.
        folder: Where to write; None writes nothing.
        refused: Options of `run` that a study has no use for, and what was given for each.
        as_json: Whether to print one JSON object.
        **how: precision, device and workers, as in `warprock.study`.

    Raises:
        InputError: An option that a study has no use for, or another than those allowed.
    """
    from warprock.api import study as api

    for option, given in refused.items():
        if given is not None and given is not False:
            allowed = "must not be given for a case with a [study], which is many runs"
            got = list(given) if isinstance(given, tuple) else given
            raise InputError(option, "", got, allowed)
    found, _engine = call(api.study, case, engine=engine, **how)
    finish(found, folder, as_json=as_json, then="warprock trade")
