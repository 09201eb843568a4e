"""The command `measures`: what lowers the yearly chance that a block falls."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import case_work, finish
from warprock.cli.completion import hazards, overrides
from warprock.cli.options import case_options, estimate_options
from warprock.cli.signatures import own_options


@click.command()
@case_options
@estimate_options
@own_options("measures", "measures", hazard=hazards, measure=overrides)
def measures(
    folder: pathlib.Path | None,
    hazard: str | None,
    k0: float | None,
    k: float | None,
    at: str,
    im: str | None,
    measure: tuple[str, ...],
    target: float | None,
    from_: float,
    to: float,
    count: int,
    accuracy: float,
    max_outside: float,
    as_json: bool,
    **asked: Any,
) -> None:
    """What lowers the yearly chance that a block falls most: each measure as a factor on its rate.

    CASE is one block under several records, a lane each. It goes through an incremental dynamic
    analysis as it is and with each measure: a wider base, ballast at its foot, straps, an isolator,
    another floor, less or more friction, or measures of yours. The hazard is that of warprock risk.
    """
    from warprock.analysis.incremental import Ladder
    from warprock.api.analyses.risk import read_asked
    from warprock.api.measures import measures_of

    ladder = Ladder(from_, to, count, accuracy)
    ladder.judge()
    power = None if k0 is None and k is None else (k0, k, at)
    wanted = read_asked(hazard, power, im)
    with case_work(**asked, factors=ladder.factors.tolist()) as work:
        found = measures_of(work, wanted, measure, target, ladder, max_outside)
    finish(found, folder, as_json=as_json)


COMMANDS = (measures,)
