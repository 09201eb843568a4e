"""The command `brief`: one page for a decision about one object."""

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
@own_options("brief", "brief", hazard=hazards, measure=overrides)
def brief(
    folder: pathlib.Path | None,
    hazard: str | None,
    k0: float | None,
    k: float | None,
    at: str,
    im: str | None,
    measure: tuple[str, ...],
    target: float | None,
    clearance: str | None,
    from_: float,
    to: float,
    count: int,
    accuracy: float,
    max_outside: float,
    as_json: bool,
    **asked: Any,
) -> None:
    """One page for a decision about one object: how likely it falls, what it takes, what helps.

    CASE is one block under several records, a lane each. -o writes the page as brief.html, two
    printed sheets, and as brief.pdf where a browser is there that prints. The hazard is that of
    warprock risk, the measures those of warprock measures.
    """
    from warprock.analysis.incremental import Ladder
    from warprock.api.analyses.risk import read_asked
    from warprock.api.brief import brief_of, read_clearance

    ladder = Ladder(from_, to, count, accuracy)
    ladder.judge()
    power = None if k0 is None and k is None else (k0, k, at)
    wanted, far = read_asked(hazard, power, im), read_clearance(clearance)
    with case_work(**asked, factors=ladder.factors.tolist()) as work:
        found = brief_of(work, wanted, measure, target, far, ladder, max_outside)
    finish(found, folder, as_json=as_json)
    if folder is not None and found.unprinted:
        click.echo(f"note: {found.unprinted}", err=True)


COMMANDS = (brief,)
