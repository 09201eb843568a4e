"""The command `map`: in which way a pulse overturns a block, and where that changes."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import case_work, finish, run_of
from warprock.cli.options import case_options
from warprock.cli.pages import on_case


@click.command("map")
@case_options
@click.option(
    "--accuracy",
    default=1e-4,
    show_default=True,
    help="Width of a boundary over its height at which it is narrow enough.",
)
def overturning_map(
    folder: pathlib.Path | None, accuracy: float, as_json: bool, **asked: Any
) -> None:
    """How pulses overturn a block: without an impact, with impacts, or not at all.

    CASE sweeps motion.frequency and motion.amplitude, the grid of the map; further axes, each with
    a label, make panels. Every change of the mode in a column is halved down to the accuracy.
    """
    from warprock.api.analyses.map import map_of

    with case_work(**asked) as work:
        found = map_of(work, accuracy)
    then = run_of(work.engine, folder, **asked)
    longer = found.found.decided_after
    if longer is not None:
        kept = [text for text in asked["overrides"] if not text.startswith("run.duration")]
        kept.append(f'run.duration="{longer:g} s"')
        then = on_case("map", asked["case_name"], kept, "-e", work.engine, "-o", str(folder))
    finish(found, folder, as_json=as_json, then=then)


COMMANDS = (overturning_map,)
