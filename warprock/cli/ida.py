"""The command `ida`: incremental dynamic analysis, the motion at which every lane first falls."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import case_work, finish, run_of
from warprock.cli.options import case_options, estimate_options
from warprock.cli.signatures import own_options


@click.command()
@case_options
@estimate_options
@own_options("analyses/ida", "ida")
def ida(
    folder: pathlib.Path | None,
    im: str,
    by: tuple[str, ...],
    from_: float,
    to: float,
    count: int,
    accuracy: float,
    as_json: bool,
    **asked: Any,
) -> None:
    """Incremental dynamic analysis of a CASE: the factor on its motion at which each lane falls.

    All lanes run at a ladder of factors; the bracket of each one's first fall is then halved. With
    -o every finished stage is kept, and the same command goes on behind the last one.
    """
    from warprock.analysis.incremental import Ladder
    from warprock.api.analyses.ida import ida_of

    ladder = Ladder(from_, to, count, accuracy)
    ladder.judge()
    with case_work(**asked, factors=ladder.factors.tolist()) as work:
        found = ida_of(work, ladder, im, by, folder)
    finish(found, folder, as_json=as_json, then=run_of(work.engine, folder, **asked))


COMMANDS = (ida,)
